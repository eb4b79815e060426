"""Fragments: thin lines cover what they cover, once for each strand, whatever their radius and their joints."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering.shading.fragments import FAINT, OPAQUE, Cones, Surfaces

CAMERA = fl.Camera(origin=(0, 0, 10), target=(0, 0, 0), fov_degrees=10)
SIZE = 64
PIXEL = 2 * 10 * np.tan(np.radians(5)) / SIZE


def covered(lines, radius):
    """Return the fragments of all pixels."""
    tree = fl.build(lines)
    origins, directions = CAMERA.rays(SIZE, SIZE)
    cones = Cones(tree, radius, CAMERA.spread(SIZE), radius / PIXEL)
    return cones.find(origins, directions, 0.5)


@pytest.mark.parametrize("in_pixels", [0.02, 0.1, 0.25, 0.5, 1.5])
@pytest.mark.parametrize("turn", [0.0, 0.3, 0.785])
def test_a_line_covers_its_width_however_thin_it_is(in_pixels, turn):
    half = 20 * PIXEL * np.array([np.cos(turn), np.sin(turn), 0])
    shifts = PIXEL * np.linspace(0, 1, 10, endpoint=False)[:, None, None] * np.array([0, 1, 0])
    sums = [covered(np.array([[-half, half]]) + shift, in_pixels * PIXEL).opacity.sum() for shift in shifts]
    expected = 2 * in_pixels * 40 + np.pi * in_pixels**2  # with its round ends
    assert np.mean(sums) == pytest.approx(expected, rel=0.04)


@pytest.mark.parametrize("parts", [1, 7, 60])
def test_a_strand_counts_once_at_its_joints(parts):
    x = np.linspace(-20, 20, parts + 1) * PIXEL
    points = np.stack([x, 3 * PIXEL * np.sin(4 * x), 0 * x], axis=1)
    whole = np.stack([np.linspace(-20, 20, 2001) * PIXEL] * 3, axis=1) * [1, 0, 0]
    whole[:, 1] = np.interp(whole[:, 0], x, points[:, 1])
    length = np.sqrt((np.diff(whole, axis=0) ** 2).sum(axis=1)).sum() / PIXEL
    fragments = covered(fl.Lines.from_strands([points]), 0.1 * PIXEL)
    assert fragments.opacity.sum() == pytest.approx(0.2 * length, rel=0.06)
    assert fragments.weight.sum() == pytest.approx(fragments.opacity.sum(), rel=0.02)


def test_nearer_lines_hide_farther_ones():
    lines = [[[-1, 0, z], [1, 0, z]] for z in (0, 0.001, 0.002)]
    fragments = covered(lines, 2 * PIXEL)
    middle = fragments.ray == SIZE * (SIZE // 2) + SIZE // 2
    assert fragments.hits.prim[middle].tolist() == [2]
    assert fragments.opacity.max() <= 1 + 1e-6


def test_faint_fragments_are_kept_in_proportion():
    lines = [[[-1, y * PIXEL, z], [1, y * PIXEL, z]] for z in np.linspace(0, 0.1, 5) for y in np.arange(-30, 30, 0.37)]
    tree = fl.build(lines)
    origins, directions = CAMERA.rays(SIZE, SIZE)
    cones = Cones(tree, 0.02 * PIXEL, CAMERA.spread(SIZE), 0.02)
    places = np.random.default_rng(0).random(len(directions))
    sums = [cones.find(origins, directions, (places + offset) % 1).weight.sum() for offset in (0.0, 0.25, 0.5, 0.75)]
    assert np.ptp(sums) / np.mean(sums) < 0.01


def test_surfaces_have_normals_towards_the_eye():
    fragments = Surfaces(fl.build([[[-1, 0, 0], [1, 0, 0]]]), 0.2).find(*CAMERA.rays(SIZE, SIZE), 0.0)
    assert fragments.normals is not None
    assert ((fragments.normals * fragments.to_eye).sum(axis=1) > -1e-3).all()
    assert fragments.weight.min() == 1
    assert np.abs(fragments.tangents) == pytest.approx(np.broadcast_to([1.0, 0, 0], (len(fragments), 3)))


def integral(x):
    x = np.clip(x, -1, 1)
    return 0.5 + 0.75 * (x - x**3 / 3)


def comes_nearest(points, prim, u, origin, direction):
    """Whether a strand comes nearest at a hit, by the control points of its axes."""

    def begins_where_another_ends(i):
        return 0 < i < len(points) and (points[i, 0] == points[i - 1, -1]).all()

    if u <= 0:
        return not begins_where_another_ends(prim)
    if u < 1 or not begins_where_another_ends(prim + 1):
        return True
    way = points[prim, -1] - origin
    away = way - (way @ direction) * direction
    return away @ (points[prim + 1, 1] - points[prim + 1, 0]) >= 0


def wavy(n_strands=60, n_points=9):
    """Return strands whose joints are seen everywhere."""
    random = np.random.default_rng(3)
    steps = random.normal(size=(n_strands, n_points, 3)) * [0.05, 0.05, 0.02]
    return random.random((n_strands, 1, 3)) * 0.6 - 0.3 + np.cumsum(steps, axis=1)


@pytest.mark.parametrize(
    "lines",
    [
        fl.Lines.from_strands(wavy()),
        fl.Lines.from_strands(wavy(), radius=0.002 * np.random.default_rng(1).random((60, 9))),
        fl.Curves.from_strands(wavy(20, 10).reshape(-1, 3), [10] * 20, basis="catmull-rom"),
    ],
    ids=["lines", "own radius", "curves"],
)
def test_fragments_are_what_their_definition_says(lines):
    radius, chance = 0.2 * PIXEL, 0.3
    tree = fl.build(lines)
    origins, directions = CAMERA.rays(SIZE, SIZE)
    origins = np.broadcast_to(origins, directions.reshape(-1, 3).shape)
    directions = directions.reshape(-1, 3)
    cones = Cones(tree, radius, CAMERA.spread(SIZE), 0.2)
    found = cones.find(np.ascontiguousarray(origins), directions, chance)
    hits = tree.next_hits(origins, directions, radius, cones.k, spread=cones.spread)
    own = hits.sample("radius") if lines.max_radius else np.zeros(len(hits))
    points = lines.control_points.astype(np.float64)
    rows, weights, opacity = [], [], []
    for ray in range(len(directions)):
        passed, total, steps = 1.0, 0.0, chance
        for hit in range(hits.offsets[ray], hits.offsets[ray + 1]):
            if not comes_nearest(points, hits.prim[hit], hits.u[hit], origins[ray], directions[ray]):
                continue
            spot, width = cones.spread * hits.t[hit], radius + own[hit]
            cover = integral((hits.distance[hit] + width) / spot) - integral((hits.distance[hit] - width) / spot)
            weight = cover * passed if passed > 1 - OPAQUE else 0.0
            passed *= 1 - min(cover, 0.9999)
            total += weight
            before, steps = np.floor(steps), steps + min(weight, FAINT) / FAINT
            if weight >= FAINT or np.floor(steps) > before:
                rows.append(hit)
                weights.append(max(weight, FAINT))
        opacity.append(total)
    assert found.opacity == pytest.approx(opacity, abs=2e-5)
    # Rounding decides about a faint fragment now and then.
    key = hits.ray[rows] * 1_000_000 + hits.prim[rows]
    of_found = found.ray * 1_000_000 + found.hits.prim
    assert len(np.setxor1d(key, of_found)) <= 0.002 * len(key)
    same = np.isin(key, of_found)
    assert found.weight[np.isin(of_found, key)] == pytest.approx(np.array(weights)[same], abs=2e-5)
