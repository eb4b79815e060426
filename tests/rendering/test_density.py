"""The density of lines: how many light crosses on average, against counts."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering.shading.density_grid import LONGEST, DensityGrid
from fastlines.threads import num_threads

RANDOM = np.random.default_rng(5)


def mean_depth(grid, points, tangents, towards, far=np.inf, n_jitters=64):
    """Return the mean over many jittered points."""
    found = [
        grid.optical_depth(points, tangents, towards, RANDOM.random(points.shape, np.float32), far)
        for _ in range(n_jitters)
    ]
    return np.mean([all_ for all_, _ in found], axis=0), np.mean([far_ for _, far_ in found], axis=0)


def directions(n):
    vectors = RANDOM.normal(size=(n, 3))
    return (vectors / np.linalg.norm(vectors, axis=1, keepdims=True)).astype(np.float32)


def cloud(n, axis=None, length=0.1, radius=None):
    """Return short lines in a cube, in all directions or along one."""
    middle = RANDOM.random((n, 3))
    edge = length * (directions(n) if axis is None else np.broadcast_to(np.float32(axis), (n, 3)))
    return fl.Lines.from_segments(
        np.stack([middle - edge / 2, middle + edge / 2], axis=1).astype(np.float32), radius=radius
    )


@pytest.mark.parametrize("axis", [None, (0, 0, 1), (0.6, 0, 0.8)])
def test_optical_depths_are_those_that_a_query_counts(axis):
    lines, radius = cloud(20_000, axis, length=0.2), 0.0008  # thin, as counts include the round ends
    grid, tree = DensityGrid.of(lines, radius), fl.build(lines)
    points = (0.1 + 0.8 * RANDOM.random((4000, 3))).astype(np.float32)
    towards = directions(4000)
    # These points are on no line: one that is along the light takes no share of the density.
    found, _ = mean_depth(grid, points, towards, towards)
    counted = tree.count_hits(points, towards, radius)
    assert found.mean() == pytest.approx(counted.mean(), rel=0.06 if axis is None else 0.03)
    # For each ray, the counts scatter about the mean as those of independent lines.
    assert ((counted - found) ** 2).mean() == pytest.approx(found.mean(), rel=0.1)


def test_far_lines_are_a_part_of_all():
    lines = cloud(20_000)
    grid, tree = DensityGrid.of(lines, 0.002), fl.build(lines)
    points, towards = RANDOM.random((4000, 3)).astype(np.float32), directions(4000)
    found, far = mean_depth(grid, points, towards, towards, far=0.3)
    assert (far <= found + 1e-3).all()
    assert far.mean() == pytest.approx(tree.count_hits(points, towards, 0.002, t_min=0.3).mean(), rel=0.06)


@pytest.mark.parametrize("line", [[[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [1, 0.7, -0.4]], [[3, 3, 3], [3.4, 3.1, 2.9]]])
@pytest.mark.parametrize("radius", [1e-4, 2.5e-3])
def test_a_line_does_not_hide_itself(line, radius):
    lines = fl.lines([line])
    size = float(np.ptp(lines.segments, axis=(0, 1)).max())
    ends = lines.segments[0]
    u = np.linspace(0.2, 0.8, 200)[:, None]
    points = np.float32(ends[0] * (1 - u) + ends[1] * u)
    tangents = np.broadcast_to(np.float32((ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])), (200, 3)).copy()
    found, _ = mean_depth(DensityGrid.of(lines, radius * size), points, tangents, directions(200))
    assert np.abs(found).mean() < 0.5 * radius * LONGEST
    assert abs(found.mean()) < 0.4 * radius * LONGEST


def test_lines_in_a_plane_do_not_hide_each_other_from_above():
    flat = fl.lines([[[-1, y, 0], [1, y, 0]] for y in np.linspace(-1, 1, 300)])
    grid = DensityGrid.of(flat, 0.003)
    points = np.float32(
        np.stack([RANDOM.random(100), RANDOM.choice(np.linspace(-0.8, 0.8, 9), 100), 0 * np.ones(100)], 1)
    )
    along, up = (np.broadcast_to(np.float32(axis), (100, 3)).copy() for axis in ((1, 0, 0), (0, 0, 1)))
    assert np.abs(mean_depth(grid, points, along, up)[0]).max() < 0.01


def test_radii_of_lines_count_and_nothing_has_none():
    thick, thin = cloud(5000, radius=np.full(5000, 0.003)), cloud(5000)
    points, towards = RANDOM.random((3000, 3)).astype(np.float32), directions(3000)
    found = [
        mean_depth(grid, points, towards, towards)[0].mean() for grid in map(DensityGrid.of, (thick, thin), (0, 0.003))
    ]
    assert found[0] == pytest.approx(found[1], rel=0.1)
    empty = DensityGrid.of(fl.lines(np.zeros((0, 2, 3))), 0.1)
    assert not np.any(empty.optical_depth(points, towards, towards, points, 0.1))


@pytest.mark.parametrize("scale", [1e-8, 1e8])
def test_scale_and_place_change_nothing(scale):
    lines = cloud(2000)
    points, towards = RANDOM.random((500, 3)).astype(np.float32), directions(500)
    jitter = RANDOM.random((500, 3), np.float32)
    plain = DensityGrid.of(lines, 0.002).optical_depth(points, towards, towards, jitter, 0.1)
    larger = fl.lines(lines.segments * np.float32(scale))
    scaled = DensityGrid.of(larger, 0.002 * scale).optical_depth(
        points * np.float32(scale), towards, towards, jitter, 0.1 * scale
    )
    assert np.quantile(np.abs(scaled[0] - plain[0]), 0.95) < 0.02


def test_grids_do_not_depend_on_the_number_of_threads():
    lines = cloud(3000)
    grids = []
    for n in (1, 2, 7):
        with num_threads(n):
            grids.append(DensityGrid.of(lines, 0.002))
    for fine, coarse in (grid.tensors for grid in grids[1:]):
        assert (fine == grids[0].tensors[0]).all()
        assert (coarse == grids[0].tensors[1]).all()


def test_memory_is_bounded():
    assert sum(each.nbytes for each in DensityGrid.of(cloud(100), 0.01).tensors) <= 64 << 20


def test_a_direction_of_length_zero_ends():
    points = RANDOM.random((20, 3)).astype(np.float32)
    none = np.zeros_like(points)
    assert np.isfinite(DensityGrid.of(cloud(100), 0.01).optical_depth(points, none, none, points, 0.1)).all()
