"""Crossings of rays and curves: one hit each, with the closest approach of the curve, whatever its pieces are."""

from __future__ import annotations

from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.answers import assert_same
from support.curves import bernstein, random_curves

import fastlines as fl
from fastlines.query.backend import KERNELS

COLUMNS = ("t", "prim", "u", "distance", "t_out")


class Crossing(NamedTuple):
    t: float
    piece: int
    s: float
    distance: float
    t_out: float


def rays_across(n: int = 60, seed: int = 0) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    origins = rng.normal(0, 2, (n, 3))
    directions = random_curves(25)[0][rng.integers(0, 25, n), 2] + rng.normal(0, 0.3, (n, 3)) - origins
    t_min, t_max = rng.uniform(-1, 0.5, n), np.where(rng.random(n) < 0.3, rng.uniform(0.6, 2, n), np.inf)
    return {"origins": origins, "directions": directions, "t_min": t_min, "t_max": t_max}


def crossings_of(curves: fl.Curves, rays: dict[str, Any], at: str) -> list[list[Crossing]]:
    """Return the crossings of each ray by t, from their definition and the hits of all pieces."""
    lines, curve = curves.pieces.lines, curves.pieces.curve
    closest = fl.brute_force(lines, **rays, query="all_hits")
    surface = fl.brute_force(lines, **rays, query="all_hits", at="surface")
    entries = fl.brute_force(lines, **rays, query="all_hits", at="entry")
    entered = set(zip(entries.ray, entries.prim, strict=True))
    radius = np.zeros((len(lines), 2)) if lines.radius is None else lines.radius.astype(np.float64)
    found = []
    for ray in range(len(rays["origins"])):
        near = {closest.prim[i]: i for i in range(*closest.offsets[ray : ray + 2])}
        groups: list[list[int]] = []
        ends: list[float] = []
        for i in sorted(range(*surface.offsets[ray : ray + 2]), key=lambda i: (curve[surface.prim[i]], surface.t[i])):
            is_same = groups and curve[surface.prim[groups[-1][0]]] == curve[surface.prim[i]]
            if is_same and surface.t[i] <= ends[-1]:
                groups[-1].append(i)
                ends[-1] = max(ends[-1], surface.t_out[i])
            else:
                groups.append([i])
                ends.append(surface.t_out[i])
        of_ray = []
        for group, end in zip(groups, ends, strict=True):

            def gap(j: int) -> tuple[float, float, int]:
                r = radius[closest.prim[j]]
                return closest.distance[j] - (r[0] + closest.u[j] * (r[1] - r[0])), closest.t[j], closest.prim[j]

            best = min((near[surface.prim[i]] for i in group), key=gap)
            first = min(group, key=lambda i: (surface.t[i], surface.prim[i]))
            if at == "entry" and not all((ray, surface.prim[i]) in entered for i in group):
                continue
            which, i = (closest, best) if at == "closest" else (surface, first)
            of_ray.append(Crossing(which.t[i], which.prim[i], which.u[i], closest.distance[best], end))
        found.append(sorted(of_ray))
    return found


def assert_are(hits: Any, expected: list[list[Crossing]], curves: fl.Curves) -> None:
    assert hits.counts.tolist() == [len(of_ray) for of_ray in expected]
    flat = [crossing for of_ray in expected for crossing in of_ray]
    prim, u = curves.parameter([c.piece for c in flat], [c.s for c in flat])
    assert np.array_equal(hits.prim, prim)
    assert np.array_equal(hits.u, u)
    for name in ("t", "distance") + ("t_out",) * (hits.t_out is not None):
        assert np.array_equal(getattr(hits, name), np.array([getattr(c, name) for c in flat], np.float32)), name


@pytest.mark.parametrize("at", ["closest", "surface", "entry"])
@pytest.mark.parametrize("taper", [False, True])
@pytest.mark.parametrize("radius", [0.1, 0.5])
def test_crossings_are_those_of_their_definition(radius: float, taper: bool, at: str) -> None:
    control, radii = random_curves(25)
    curves = fl.Curves.from_bezier(control, radii if taper else None, tolerance=0.01)
    rays = rays_across() | {"radius": radius}
    tree, expected = fl.build(curves), crossings_of(curves, rays, at)
    assert sum(map(len, expected)) > 20
    assert_are(tree.all_hits(**rays, at=at), expected, curves)
    nearest = [sorted(of_ray, key=lambda c: (c.distance, c.t, c.piece)) for of_ray in expected]
    for k in (1, 3):
        assert_are(tree.next_hits(**rays, k=k, at=at), [of_ray[:k] for of_ray in expected], curves)
        assert_are(tree.next_hits(**rays, k=k, at=at, rank="distance"), [c[:k] for c in nearest], curves)


@pytest.mark.parametrize("case", ["lines", "round cones", "geometry", "spread", "ignore"])
def test_all_queries_agree(case: str) -> None:
    control, radii = random_curves(40)
    curves = fl.Curves.from_bezier(control, None if case == "lines" else radii)
    rays = rays_across(100) | {"radius": 0.4}
    geometry: Any = curves
    if case == "geometry":
        spheres = fl.Spheres.from_centres(control[::9, 2], radius=0.3)
        geometry = fl.Geometry([spheres, curves, fl.Curves.from_bezier(control[::2] + 0.3, 0.2)])
    if case == "spread":
        rays["spread"] = np.linspace(0, 0.2, 100)
    if case == "ignore":
        rays["ignore"] = np.arange(0, 40, 3)
    tree = fl.build(geometry)
    for at in ("closest",) if case == "spread" else ("closest", "surface", "entry"):
        every = fl.brute_force(geometry, **rays, at=at)
        assert (np.bincount(every.ray * len(geometry) + every.prim_number) > 1).any()  # curves that are crossed again
        first = fl.brute_force(geometry, **rays, at=at, query="first_hit")
        hit = first.hit
        assert np.array_equal(hit, every.counts > 0)
        for name in COLUMNS[:-1] if at == "closest" else COLUMNS:
            assert np.array_equal(getattr(first, name)[hit], getattr(every, name)[every.offsets[:-1][hit]]), name
        for kernel in KERNELS:
            assert_same(tree.all_hits(**rays, at=at, kernel=kernel), every)
            assert_same(tree.first_hit(**rays, at=at, kernel=kernel), first)
            assert np.array_equal(tree.count_hits(**rays, at=at, kernel=kernel), every.counts)
            assert np.array_equal(tree.any_hit(**rays, at=at, kernel=kernel), hit)
            for k, rank in product((1, 4), ("t", "distance")):
                asked = {**rays, "k": k, "at": at, "rank": rank}
                expected = fl.brute_force(geometry, **asked, query="next_hits")
                assert_same(tree.next_hits(**asked, kernel=kernel), expected)


@pytest.mark.parametrize("at", ["surface", "entry"])
def test_first_crossings_of_rays_that_start_in_overlapping_curves(at: str) -> None:
    """Rays leave curves of many pieces, and enter others of the same curve from within it."""
    control, _ = random_curves(60, seed=5)
    curves = fl.Curves.from_bezier(0.4 * control, 0.15)
    assert len(curves.pieces) > 16 * len(curves)
    rng = np.random.default_rng(6)
    curve, n = rng.integers(0, 60, 2000), 2000
    origins = curves.evaluate(curve, rng.random(n)).points + rng.normal(0, 0.1, (n, 3))
    directions = rng.normal(size=(n, 3))
    directions[::2] = curves.evaluate(curve[::2], rng.random(n // 2)).points - origins[::2]
    rays = origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)
    options: dict[str, Any] = {"t_min": np.where(rng.random(n) < 0.3, 0.05, 0), "at": at}
    tree, expected = fl.build(curves), fl.brute_force(curves, *rays, query="first_hit", **options)
    starts_inside = fl.brute_force(curves, *rays, query="first_hit", at="surface", t_min=options["t_min"])
    assert (starts_inside.t == options["t_min"]).sum() > n / 4
    for kernel in KERNELS:
        assert_same(tree.first_hit(*rays, kernel=kernel, **options), expected)
        assert np.array_equal(tree.any_hit(*rays, kernel=kernel, **options), expected.hit)
        surface = tree.first_surface(*rays, kernel=kernel, t_min=options["t_min"])
        for name in ("t", "prim", "u"):
            assert np.array_equal(getattr(surface, name), getattr(starts_inside, name)), name


def test_the_distance_of_a_curve_is_its_least() -> None:
    """It depends on neither the radius nor the tolerance, up to the tolerance."""
    control = random_curves(1, seed=3)[0]
    points = bernstein(control, np.linspace(0, 1, 20_001))[0]
    rng = np.random.default_rng(1)
    for _ in range(20):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        origin = points[rng.integers(20_001)] + 0.05 * rng.normal(size=3) - 9 * direction
        away = points - origin
        least = np.linalg.norm(away - (away @ direction)[:, None] * direction, axis=1).min()
        for radius, tolerance in product((0.2, 1, 5), (None, 1e-3, 1e-2)):
            tree = fl.build(fl.Curves.from_bezier(control, tolerance=tolerance))
            found = [
                tree.next_hits(origin, direction, radius, k=1, rank="distance", at=at) for at in ("closest", "surface")
            ]
            if radius == 5:  # all is one crossing
                found.append(tree.first_hit(origin, direction, radius))  # type: ignore[arg-type]
            for hits in found:
                assert hits.distance == pytest.approx(least, abs=2 * (tolerance or 2e-3)), (radius, tolerance)


def test_the_crossing_of_a_thick_curve_has_its_closest_approach() -> None:
    """A ray along the axis of an arch's leg: all pieces near it are one crossing."""
    arch = fl.Curves.from_bezier([[[0, 0, 0], [0, 0, 4], [3, 0, 4], [3, 0, 0]]], radius=0.4)
    tree = fl.build(arch)
    assert len(arch.pieces) > 9
    hits = tree.all_hits([-5, 0.1, 1], [1, 0, 0], at="surface")
    first = tree.first_hit([-5, 0.1, 1], [1, 0, 0], at="surface")
    assert hits.distance == pytest.approx([0.1, 0.1], abs=1e-3)
    assert (first.t, first.t_out, first.distance) == (hits.t[0], hits.t_out[0], hits.distance[0])  # type: ignore[index]
