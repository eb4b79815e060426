"""The exact test against its definition in float64, and scenes whose answer is known."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support import nasty
from support.slow import few_of

import fastlines as fl
from fastlines.theory.hits import capsule_interval, closest_approach

#: Half an ulp of 1 in float32; errors are counted in it, relative to the numbers that go into a distance.
EPS = 2.0**-24

cases = cache(nasty.cases)


def pairs(case: nasty.Case) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the length of each direction, its rays' distance from the scene's centre, and the scene's size."""
    directions, size = case.directions.astype(np.float64), nasty.size_of(case.segments)
    corners = case.segments.reshape(-1, 3).astype(np.float64)
    centre = (corners.min(axis=0) + corners.max(axis=0)) / 2
    length = np.linalg.norm(directions, axis=1)
    aside = np.linalg.norm(np.cross(centre - case.origins, directions / length[:, None]), axis=1)
    return length, aside, size


def distance_to_segments(x: np.ndarray, p: np.ndarray, e: np.ndarray) -> np.ndarray:
    """Return the distance of each point from the segment p + s·e beside it."""
    ee = (e * e).sum(axis=1)
    s = np.clip(((x - p) * e).sum(axis=1) / np.where(ee > 0, ee, 1), 0, 1)
    return np.linalg.norm(p + s[:, None] * e - x, axis=1)


@pytest.mark.parametrize("name", [name for name in nasty.NAMES if name != "empty"])
@pytest.mark.parametrize("seed", few_of(range(6), n=1))
def test_brute_force_keeps_to_the_definition(seed: int, name: str) -> None:
    case = cases(seed)[name]
    length, aside, size = pairs(case)
    distance, t, _ = closest_approach(*case[:3], case.t_min, case.t_max)
    ends, o, d = (array.astype(np.float64) for array in case[:3])
    e = ends[:, 1] - ends[:, 0]
    for radius in case.radii.values():
        hits = fl.brute_force(*case[:3], radius, t_min=case.t_min, t_max=case.t_max)
        ray, prim = hits.ray, hits.prim
        r = np.broadcast_to(np.asarray(radius, np.float32), len(o)).astype(np.float64)
        unit = 2 * size + aside + r
        tolerance = 8 * EPS * unit

        # Who is hit.
        hit = np.zeros(distance.shape, bool)
        hit[ray, prim] = True
        clear = np.abs(distance - r[:, None]) > tolerance[:, None]
        assert ((hit == (distance <= r[:, None])) | ~clear).all()

        # How near, and that t and u are where it is that near, to the precision of t.
        assert (np.abs(hits.distance - distance[ray, prim]) <= tolerance[ray]).all()
        assert (hits.distance <= r[ray] * (1 + 2 * EPS)).all()
        assert ((hits.u >= 0) & (hits.u <= 1)).all()
        t_float = np.spacing(np.abs(hits.t)).astype(np.float64) * length[ray]
        apart = ends[prim, 0] + hits.u[:, None] * e[prim] - o[ray] - hits.t[:, None].astype(float) * d[ray]
        wrong = np.abs(np.linalg.norm(apart, axis=1) - hits.distance)
        assert (wrong <= tolerance[ray] + t_float).all()

        # Where: the less well defined, the more the segment runs along the ray.
        e_length = np.linalg.norm(e[prim], axis=1)
        across = np.linalg.norm(np.cross(d[ray] / length[ray, None], e[prim]), axis=1)
        defined = across > 4 * 2.0**-22 * unit[ray]
        sine = np.divide(across, e_length, out=np.ones(len(ray)), where=defined)
        wrong = np.abs(hits.t - t[ray, prim]) * length[ray] - t_float
        assert (wrong * sine <= 64 * EPS * unit[ray])[defined].all()
        assert ((hits.t >= np.broadcast_to(case.t_min, len(o))[ray]) & (hits.t >= -np.inf)).all()
        assert (hits.t <= np.broadcast_to(case.t_max, len(o))[ray]).all()


@pytest.mark.parametrize("name", [name for name in nasty.NAMES if name != "empty"])
@pytest.mark.parametrize("seed", few_of(range(6), n=1))
def test_surface_is_where_the_ray_enters_the_capsule(seed: int, name: str) -> None:
    case = cases(seed)[name]
    length, aside, size = pairs(case)
    ends, o, d = (array.astype(np.float64) for array in case[:3])
    e = ends[:, 1] - ends[:, 0]
    for radius in case.radii.values():
        hits = fl.brute_force(*case[:3], radius, t_min=case.t_min, t_max=case.t_max, at="surface")
        ray, prim = hits.ray, hits.prim
        r = np.broadcast_to(np.asarray(radius, np.float32), len(o)).astype(np.float64)[ray]
        tolerance = 16 * EPS * (2 * size + aside[ray] + r)
        low, high = (np.broadcast_to(bound, len(o))[ray] for bound in (case.t_min, case.t_max))

        # The points of entry and exit lie on the capsule, unless a bound on t cuts it there.
        for t, bound in ((hits.t, low), (hits.t_out, high)):
            t_float = np.spacing(np.abs(t)).astype(np.float64) * length[ray]
            at = o[ray] + t[:, None].astype(float) * d[ray]
            near = distance_to_segments(at, ends[prim, 0], e[prim])
            assert (near <= r + tolerance + t_float).all()
            assert ((near >= r - tolerance - t_float) | (t == bound)).all()
        assert (np.isfinite(hits.u) & (hits.u >= 0) & (hits.u <= 1)).all()
        apart = np.linalg.norm(
            ends[prim, 0] + hits.u[:, None] * e[prim] - o[ray] - hits.t[:, None].astype(float) * d[ray], axis=1
        )
        t_float = np.spacing(np.abs(hits.t)).astype(np.float64) * length[ray]
        assert (apart <= r + tolerance + t_float).all()

        # And they are those of the union of its parts, where the ray does more than graze it.
        t_in, t_out = (found[ray, prim] for found in capsule_interval(*case[:3], radius, case.t_min, case.t_max))
        across = np.linalg.norm(np.cross(d[ray] / length[ray, None], e[prim]), axis=1)
        well = (hits.distance < 0.7 * r) & (across > 0.05 * np.linalg.norm(e[prim], axis=1)) & (r > 1e-3 * size)
        assert not np.isnan(t_in[well]).any()
        for got, expected in ((hits.t, t_in), (hits.t_out, t_out)):
            wrong = np.abs(got - expected)[well] * length[ray][well]
            t_float = np.spacing(np.abs(got[well])).astype(np.float64) * length[ray][well]
            assert (wrong <= 200 * tolerance[well] + t_float).all()


@pytest.mark.parametrize("method", [*fl.METHODS, None])
def test_example_of_the_thesis(method: str | None) -> None:
    """§5.4.3: the ray passes through the middle of the segment at t = 5."""
    segment, origin, direction = [[[-1, -1, -1], [1, 1, 1]]], [0, 0, -5], [0, 0, 1]
    hit = (
        fl.brute_force(segment, origin, direction, 0.5, query="first_hit")
        if method is None
        else fl.build(segment, method).first_hit(origin, direction, 0.5)
    )
    assert (hit.t, hit.prim, hit.u, hit.distance) == (5, 0, 0.5, 0)
    surface = fl.build(segment, method or "kd-d2").first_hit(origin, direction, 0.5, at="surface")
    half_chord = 0.5 * np.sqrt(3 / 2)  # r / sin θ, with cos θ = 1/√3
    assert surface.t == pytest.approx(5 - half_chord, abs=1e-6)
    assert surface.t_out == pytest.approx(5 + half_chord, abs=1e-6)


@pytest.mark.parametrize("method", fl.METHODS)
def test_grid_of_parallel_lines(method: str) -> None:
    """10 × 10 lines along z, 1 apart: a ray along x at height y = j + δ passes 10 of them if δ ≤ r, else none."""
    i, j = np.meshgrid(np.arange(10.0), np.arange(10.0))
    low = np.stack([i, j, 0 * i - 3], axis=-1).reshape(-1, 3)
    tree = fl.build(np.stack([low, low + np.array([0, 0, 6])], axis=1), method)
    offset = np.array([0.0, 0.125, 0.25, 0.375])
    origins = np.stack([np.full(4, -1), 4 + offset, np.linspace(-2, 2, 4)], axis=1)
    assert tree.count_hits(origins, [1, 0, 0], 0.25).tolist() == [10, 10, 10, 0]
    assert tree.count_hits(origins, [1, 0, 0], 0.0).tolist() == [10, 0, 0, 0]
    assert tree.count_hits(origins, [1, 0, 0], 1.25).tolist() == [30, 30, 30, 20]
    assert tree.count_hits(origins, [1, 0, 0], 0.25, t_min=1, t_max=[1, 2, 2.75, 99]).tolist() == [1, 2, 2, 0]
    assert tree.count_hits(origins, [-1, 0, 0], 1.5, t_min=-np.inf).tolist() == [30, 30, 30, 30]
    every = tree.all_hits(origins[0], [0.5, 0, 0], 0.25)
    assert every.t.tolist() == list(range(2, 22, 2))
    assert every.prim.tolist() == list(range(40, 50))
    first = tree.first_hit(origins, [1, 0, 0], 0.25)
    assert first.prim.tolist() == [40, 40, 40, -1]
    assert first.distance.tolist() == [0, 0.125, 0.25, np.inf]
    # Along the lines: every one within the radius, entered at its lower end.
    along = tree.all_hits([4, 4, -9], [0, 0, 1], 1)
    assert along.prim.tolist() == [34, 43, 44, 45, 54]
    assert along.t.tolist() == [6] * 5


@pytest.mark.parametrize("method", fl.METHODS)
@pytest.mark.parametrize("turned", [False, True])
def test_ray_along_a_segment_takes_the_smaller_t(method: str, turned: bool) -> None:
    segment = np.array([[[1, 0, 0], [3, 0, 0]]], np.float32)
    tree = fl.build(segment[:, ::-1] if turned else segment, method)
    start, end = (1, 0) if turned else (0, 1)
    hit = tree.first_hit([[0, 0, 0], [0, 0.25, 0], [2, 0, 0], [5, 0, 0]], [[1, 0, 0]] * 3 + [[-1, 0, 0]], 0.5)
    assert hit.t.tolist() == [1, 1, 0, 2]
    assert hit.u.tolist() == [start, start, 0.5, end]
    assert hit.distance.tolist() == [0, 0.25, 0, 0]


@pytest.mark.parametrize("method", fl.METHODS)
def test_ties_go_to_the_lower_id(method: str) -> None:
    """Twenty copies of one segment, and twenty others that the ray meets at the same t."""
    rng = np.random.default_rng(5)
    fan = np.zeros((20, 2, 3))
    fan[:, 0, :2] = rng.normal(0, 1, (20, 2))
    fan[:, 1, :2] = -fan[:, 0, :2]
    segments = np.concatenate([fan, np.repeat(fan[3:4], 20, axis=0)])[::-1]
    tree = fl.build(segments, method, limits=fl.Limits(max_refs=2000))
    for scale in (1, 1e-3, 1e3):
        hit = tree.first_hit([0, 0, -2], [0, 0, scale], 0.01)
        assert (hit.prim, hit.t) == (0, np.float32(2 / np.float32(scale)))
    every = tree.all_hits([0, 0, -2], [0, 0, 1], 0.01)
    assert every.prim.tolist() == list(range(40))
    assert (every.t == 2).all()


@pytest.mark.parametrize("n", [600, 5_000, 65_536])
def test_many_ties_are_listed_in_order(n: int) -> None:
    """Copies of one segment, which no t tells apart; those of the largest number come in a few long runs, by number."""
    copies = np.repeat(np.array([[[0, 0, 0], [1, 0, 0]]], np.float32), n, axis=0)
    every = fl.build(copies, "best").all_hits([[0.5, 0, -1], [0.5, 1, 0]] * 2, [[0, 0, 1], [0, -1, 0]] * 2, 0.01)
    assert every.offsets.tolist() == [i * n for i in range(5)]
    assert (every.prim.reshape(4, n) == np.arange(n)).all()


def test_definition_of_the_capsule_and_of_the_distance_agree() -> None:
    """The float64 references check each other: an interval exists where the distance is at most the radius."""
    for name in ("crossing", "some points", "rays along segments", "window per ray"):
        case = cases(11)[name]
        bounds = (case.t_min, case.t_max)
        distance, t, _ = closest_approach(*case[:3], *bounds)
        for radius in (case.radii["medium"], case.radii["larger than the scene"]):
            t_in, t_out = capsule_interval(*case[:3], radius, *bounds)
            sure = np.abs(distance - radius) > 1e-9 * (1 + np.abs(distance))
            assert ((distance <= radius) == ~np.isnan(t_in))[sure].all()
            hit = ~np.isnan(t_in) & sure
            slack = 1e-6 * (1 + np.abs(t[hit]))
            assert ((t_in[hit] <= t[hit] + slack) & (t[hit] <= t_out[hit] + slack)).all()


@pytest.mark.parametrize("unit", [1.0, 2.0**40, 2.0**-40])
def test_sizes_that_count_as_zero(unit: float) -> None:
    """Squares of 2^-75 underflow: in the frame of the scene, or in the unit of a scene of no size."""
    point, around = [[[0, 0, 0], [0, 0, 0]]], [[[-unit, -unit, -unit], [-unit, -unit, unit]], [[unit] * 3] * 2]
    for segments, size in ((point, 1.0), (point + around, 2 * unit)):
        tree = fl.build(segments)
        for x, hits in ((2.0**-75, True), (2.0**-74, False)):
            ray = ([x * size, 0, -unit], [0, 0, 1])
            for answer in (tree.first_hit(*ray, 0), fl.brute_force(segments, *ray, 0, query="first_hit")):
                assert bool(answer.hit) == hits
                assert answer.distance == (0 if hits else np.inf)
            assert bool(tree.any_hit(*ray, x * size)), "a radius that is as large"
