"""Rays whose reach grows along them: the same answers in every way, those of the definition in float64, and picking."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import assert_same, cases, options, question
from support.builds import BUILDS, KINDS, METHODS, build
from support.nasty import spreads
from support.slow import few_of

import fastlines as fl
from fastlines.query.backend import KERNELS
from fastlines.query.queries import QUERIES, QueryName
from fastlines.theory.hits import deepest_approach

#: Half an ulp of 1 in float32.
EPS = 2.0**-24

QUESTIONS: list[tuple[QueryName, dict[str, Any]]] = [
    *((query, options(query)) for query in QUERIES),
    ("next_hits", {"k": 2, "rank": "distance"}),
]
WAYS = [*product([kernel for kernel in KERNELS if kernel != "binary"], fl.available_simd()), ("binary", None)]


@pytest.fixture(autouse=True)
def any_engine() -> Iterator[None]:
    yield
    fl.set_simd(None)
    fl.set_num_threads(None)


def segments(n: int = 200, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    start = rng.random((n, 3))
    return np.stack([start, start + rng.normal(size=(n, 3)) * 0.2], axis=1).astype(np.float32)


def rays(n: int = 3000, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Rays from outside, of any length."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(n, 3))
    directions *= rng.uniform(2, 4, (n, 1)) / np.linalg.norm(directions, axis=1, keepdims=True)
    return (rng.random((n, 3)) - directions).astype(np.float32), (directions * rng.uniform(0.1, 9, (n, 1))).astype("f4")


@pytest.mark.parametrize("name", nasty.NAMES)
@pytest.mark.parametrize("kind", few_of(KINDS))
@pytest.mark.parametrize("seed", few_of(range(2), n=1))
def test_answers_are_those_of_brute_force(kind: str, seed: int, name: str) -> None:
    case = cases(seed, n_rays=60)[name]
    asked, _ = question(case)
    asked["spread"] = np.tile(spreads(case, len(case.origins), seed), len(case.radii))
    geometry = KINDS[kind](case.segments)
    turn = seed + nasty.NAMES.index(name)
    names = ["best", list(METHODS)[turn % len(METHODS)], list(BUILDS)[(5 * turn) % len(BUILDS)]]
    trees = {build_name: build(geometry, **BUILDS[build_name]) for build_name in names}
    for query, how in QUESTIONS:
        expected = fl.brute_force(geometry, **asked, query=query, **how)
        for i, (build_name, tree) in enumerate(trees.items()):
            turn += 1
            for kernel, simd in WAYS if i == 0 else (WAYS[(7 * turn + i) % len(WAYS)],):
                turn += 1
                fl.set_simd(simd)
                fl.set_num_threads(1 + 2 * (turn % 2))
                got = getattr(tree, query)(**asked, **how, kernel=kernel)
                assert_same(got, expected, f"{build_name}: {query}, {how}, {kernel=}, {simd=}, {seed=}")


def assert_defined(lines: fl.Lines, found: np.ndarray, band: Any, *definition: Any, **more: Any) -> None:
    """Compare who is hit with the definition, except within a band around D = R."""
    clearance, _, _ = deepest_approach(lines.segments, lines.end_radii, *definition, **more)
    assert ((found == (clearance <= 0)) | (np.abs(clearance) <= band)).all()


def hit_matrix(hits: fl.AllHits, n_prims: int) -> np.ndarray:
    found = np.zeros((len(hits.offsets) - 1, n_prims), bool)
    found[hits.ray, hits.prim] = True
    return found


def depths(points: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    unit = directions.astype(np.float64) / np.linalg.norm(directions.astype(np.float64), axis=1, keepdims=True)
    return np.einsum("mnk,mk->mn", points.reshape(1, -1, 3) - origins.astype(np.float64)[:, None], unit)


def band_of(lines: fl.Lines, case: nasty.Case, radius: Any, spread: np.ndarray) -> np.ndarray:
    """Return how near to D = R rounding may decide, for each ray: 8 half ulps of what goes into D and R."""
    size = nasty.size_of(lines.segments)
    corners = lines.segments.reshape(-1, 3).astype(np.float64)
    centre = (corners.min(axis=0) + corners.max(axis=0)) / 2
    unit = case.directions.astype(np.float64)
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    aside = np.linalg.norm(np.cross(centre - case.origins, unit), axis=1)
    depth = np.abs(depths(corners, case.origins, case.directions)).max(axis=1)
    reach = lines.max_radius + np.asarray(radius, np.float64) + spread * depth
    return 8 * EPS * ((2 * size + aside) * (1 + spread) + reach)[:, None]


@pytest.mark.parametrize("name", [name for name in nasty.NAMES if name != "empty"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", few_of(range(2), n=1))
def test_hits_are_those_of_the_definition(kind: str, seed: int, name: str) -> None:
    case = cases(seed)[name]
    lines = KINDS[kind](case.segments)
    spread = spreads(case, len(case.origins), seed)
    for radius in (0.0, case.radii["medium"], case.radii["per ray"]):
        hits = fl.brute_force(lines, *case[1:3], radius, spread=spread, t_min=case.t_min, t_max=case.t_max)
        definition = *case[1:3], np.float32(radius), case.t_min, case.t_max
        band = band_of(lines, case, radius, spread)
        assert_defined(lines, hit_matrix(hits, len(lines)), band, *definition, spread=spread)


@pytest.mark.parametrize(("scale", "offset"), [(1, 0), (1e-6, 0), (1e6, 0), (1, 1e4), (1e-20, 0)])
@pytest.mark.parametrize("kind", ["outside", "inside", "along the lines", "far away", "bounded"])
def test_hits_are_those_of_the_definition_at_every_scale(kind: str, scale: float, offset: float) -> None:
    rng = np.random.default_rng(len(kind))
    ends = ((segments(60) * 2 - 1) * scale + offset).astype(np.float32)
    lines = fl.Lines.from_segments(ends, radius=(rng.random((60, 2)) * 0.1 * scale).astype(np.float32))
    n = 200
    directions = rng.normal(size=(n, 3))
    if kind == "along the lines":
        directions = (ends[:, 1] - ends[:, 0]).astype(np.float64)[rng.integers(0, 60, n)] / scale
        directions += rng.normal(size=(n, 3)) * rng.choice([0, 1e-6, 1e-3], (n, 1))
    away = {"inside": 0.3, "far away": 1e5}.get(kind, 3)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    target = ends[rng.integers(0, 60, n), 0] + rng.normal(size=(n, 3)) * 0.2 * scale
    case = nasty.Case(ends, (target - directions * away * scale).astype("f4"), (directions * 2).astype("f4"), {})
    spread = (10.0 ** rng.uniform(-3, 0.3, n) / away).astype(np.float32)
    bounds: dict[str, Any] = {"t_min": 0.0, "t_max": np.inf}
    if kind == "bounded":
        bounds = {"t_min": (rng.uniform(-3, 1, n) * scale).astype("f4"), "t_max": np.float32(2 * scale)}
    hits = fl.build(lines).all_hits(*case[1:3], spread=spread, **bounds)
    assert 0.02 < len(hits) / (n * 60) < 0.98
    band = band_of(lines, case, 0.0, spread)
    assert_defined(lines, hit_matrix(hits, 60), band, *case[1:3], spread=spread, **bounds)


def test_rays_that_pass_farther_than_the_frame_holds_miss() -> None:
    ends = (segments(20) * 1e-20).astype(np.float32)
    origins = np.array([[x, 0, -1] for x in (1.0, 1e-3, 2e-9, 5e-10, 5e-13)], np.float32)
    for spread in (1e-9, 1e-12):
        hits = fl.build(ends).count_hits(origins, [0, 0, 1], spread=spread)
        assert (hits == np.where(origins[:, 0] < spread, 20, 0)).all()
        assert np.array_equal(hits, fl.brute_force(ends, origins, [0, 0, 1], spread=spread, query="count_hits"))


def test_a_spread_of_zero_is_none() -> None:
    ends, (o, d) = segments(), rays()
    for lines in (fl.Lines.from_segments(ends), fl.Lines.from_segments(ends, radius=np.linspace(0, 0.05, len(ends)))):
        tree = fl.build(lines)
        for spread, at in product((0, np.zeros(len(o))), ("closest", "surface")):
            for query in ("first_hit", "all_hits"):
                ask = getattr(tree, query)
                assert_same(ask(o, d, 0.02, spread=spread, at=at), ask(o, d, 0.02, at=at))


@pytest.mark.parametrize("kernel", KERNELS)
def test_rays_without_a_spread_keep_their_bits_beside_others(kernel: str) -> None:
    ends, (o, d) = segments(), rays()
    spread = np.zeros(len(o))
    spread[::3] = 0.03
    plain = spread == 0
    for lines in (fl.Lines.from_segments(ends), fl.Lines.from_segments(ends, radius=np.linspace(0, 0.05, len(ends)))):
        tree = fl.build(lines)
        mixed = tree.first_hit(o, d, 0.02, spread=spread, kernel=kernel)
        expected = tree.first_hit(o, d, 0.02, kernel=kernel)
        for column in ("t", "prim", "u", "distance"):
            assert np.array_equal(getattr(mixed, column)[plain], getattr(expected, column)[plain]), column
        assert (mixed.hit != expected.hit).any()


def test_a_larger_spread_hits_what_a_smaller_one_does() -> None:
    ends, (o, d) = segments(), rays()
    tree, before = fl.build(ends), np.zeros((len(o), len(ends)), bool)
    for spread in (0, 1e-6, 1e-4, 1e-3, 0.01, 0.1, 1, 10):
        found = hit_matrix(tree.all_hits(o, d, 0.005, spread=spread), len(ends))
        assert not (before & ~found).any()
        before = found
    assert before.all()


def test_a_spread_reaches_as_far_as_the_depth_says() -> None:
    posts = [[[x, -1, z], [x, 1, z]] for z, x in ((1, 0.11), (2, 0.19), (4, 0.41), (8, 0.79))]
    tree = fl.build(posts)
    hits = tree.all_hits([0, 0, 0], [0, 0, 5], spread=0.1)  # the direction's length does not count
    assert hits.prim.tolist() == [1, 3]
    assert np.allclose(hits.t, [0.4, 1.6])
    assert np.allclose(hits.distance, [0.19, 0.79])
    assert tree.all_hits([0, 0, 0], [0, 0, 5], 0.011, spread=0.1).prim.tolist() == [0, 1, 2, 3]
    # Behind the origin the reach falls below zero, even where t_min lets the ray go.
    assert tree.count_hits([0, 0, 9], [0, 0, 1], spread=1, t_min=-20) == 0
    assert tree.count_hits([0, 0, 9], [0, 0, 1], 3, spread=1, t_min=-20) == 1  # 3 − 1 of the last post
    # Of a slanted line, the end that is relatively nearest counts, not the nearest end.
    slanted = fl.build([[[0.1, 0, 1], [0.2, 0, 9]]]).first_hit([0, 0, 0], [0, 0, 1], spread=0.5)
    assert slanted.u == 1
    assert slanted.distance == pytest.approx(0.2)


def test_a_spread_is_enough_for_lines_without_a_radius() -> None:
    tree, ray = fl.build([[[-1, 0, 0], [1, 0, 0]]]), ([0, 0.1, -5], [0, 0, 1])
    assert tree.any_hit(*ray, spread=0.03)
    assert not tree.any_hit(*ray, spread=np.zeros(()) + 0.01)
    assert tree.count_hits([ray[0]] * 2, ray[1], spread=[0, 0.03]).tolist() == [0, 1]
    assert tree.count_hits(np.zeros((0, 3)), np.zeros((0, 3)), spread=np.zeros(0)).shape == (0,)
    with pytest.raises(fl.InputError, match=r"so a query needs one: pass radius=, .* or spread="):
        tree.any_hit(*ray, spread=0)


def test_a_spread_has_no_surface() -> None:
    lines, ray = fl.Lines.from_segments(segments()), ([0, 0, -5], [0, 0, 1])
    tree = fl.build(lines)
    asks = [tree.first_hit, tree.all_hits, lambda *a, **k: tree.next_hits(*a, k=1, **k)]
    asks += [lambda *a, **k: fl.brute_force(lines, *a, **k)]
    for ask in asks:
        with pytest.raises(fl.InputError, match=r"at='surface' has no meaning with a spread: .*; leave out at= or"):
            ask(*ray, spread=0.1, at="surface")


@pytest.mark.parametrize(
    ("spread", "message"),
    [
        (-0.1, "1 of 1 rays have a spread that is not a number from 0 to 1e\\+12 .row 0.: spread = -0.1; fix"),
        (np.nan, "have a spread that is not a number"),
        (np.inf, "have a spread that is not a number"),
        (1e11, "have a radius that their spread makes larger than .* somewhere in the scene"),
        ([0.1, 0.2], r"spread has shape \(2,\); expected a number, or one for each of the rays \(\)"),
    ],
)
def test_spreads_that_no_query_can_use_are_refused(spread: Any, message: str) -> None:
    with pytest.raises(fl.InputError, match=message):
        fl.build(segments()).first_hit([0, 0, -500], [0, 0, 1], spread=spread)


def test_rays_with_such_spreads_can_be_skipped() -> None:
    origins = np.repeat([[0.5, 0.5, -5]], 4, axis=0)
    hits = fl.build(segments()).first_hit(origins, [0, 0, 1], spread=[0.1, -1, np.nan, 0.2], invalid="skip")
    assert hits.hit.tolist() == [True, False, False, True]
    assert hits.skipped.tolist() == [1, 2]
    assert np.isfinite(hits.points()[hits.hit]).all()


def test_trees_that_moved_or_were_loaded_take_a_spread(tmp_path: Path) -> None:
    ends, ray = segments(), (*rays(300),)
    tree = fl.build(ends)
    assert tree.any_hit(*ray, spread=0.01).any()
    moved = tree.refit(ends + 0.1)
    assert_same(moved.all_hits(*ray, spread=0.01), fl.brute_force(ends + np.float32(0.1), *ray, spread=0.01))
    tree.save(tmp_path / "a.flt")
    assert_same(fl.load(tmp_path / "a.flt").all_hits(*ray, spread=0.01), tree.all_hits(*ray, spread=0.01))
    thick = fl.build(fl.Lines.from_segments(ends, radius=np.full(len(ends), 0.1)), own_radius=False)
    assert_same(thick.all_hits(*ray, spread=0.01), tree.all_hits(*ray, spread=0.01))
    with pytest.raises(fl.InputError, match="a spread is for lines"):
        fl.build(fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])).any_hit(*ray, spread=0.01)


@pytest.mark.slow
def test_picking_within_ten_pixels_is_that_of_the_definition() -> None:
    """10⁵ rays of a camera in the middle of some lines, against float64; far pairs need no search."""
    lines = fl.Lines.from_segments((segments(40) * 2 - 1) * [4, 4, 8])
    camera = fl.Camera((0, 0, -2), (0, 0, 1), fov_degrees=60)
    width, height = 400, 250
    origins, directions = camera.rays(width, height)
    spread = np.float32(20 * camera.spread(height))  # 10 pixels to each side
    found = hit_matrix(fl.build(lines).all_hits(origins, directions, spread=spread), len(lines))
    unit = directions.astype(np.float64)
    n_near = 0
    for prim, (p, q) in enumerate(lines.segments.astype(np.float64)):
        offset, half = (p + q) / 2 - origins[0], np.linalg.norm(q - p) / 2
        depth = unit @ offset
        aside = np.sqrt(np.maximum(offset @ offset - np.where(depth > 0, depth, 0) ** 2, 0))
        near = aside <= spread * np.maximum(depth, 0) + (1 + spread) * half + 1e-3
        assert not found[~near, prim].any()
        one = fl.Lines.from_segments([[p, q]])
        definition = origins[near], directions[near]
        assert_defined(one, found[near, prim : prim + 1], 8 * EPS * 20, *definition, n_steps=60, spread=spread)
        n_near += near.sum()
    assert 10_000 < found.sum() < n_near < 0.5 * found.size
