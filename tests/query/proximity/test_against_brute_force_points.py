"""Every tree answers points as brute force does, bit for bit: with each instruction set and number of threads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import assert_same, cases
from support.builds import ALL_KINDS, KINDS, build
from support.points import points_of, radii_of

import fastlines as fl
from fastlines.geometry.collection import as_geometry

BUILDS: dict[str, dict[str, Any]] = {
    "best": {"method": "best"},
    "bvh-cl": {"method": "bvh-cl"},
    "kd-cl": {"method": "kd-cl"},
    "kd-d2": {"method": "kd-d2"},
    "presplit": {"method": "bvh-cl", "presplit": fl.Presplit(refs=5), "limits": fl.Limits(max_refs=2000)},
}
WAYS = [(simd, n_threads) for simd in fl.available_simd() for n_threads in (1, 2, 4)]
PLACE = np.array([5.3e6, 4.2e5, 100])
#: How many seeds there are for each kind of primitive; all but the first are slow.
N_SEEDS = {"segments": 3, "round cones": 3, "a mixture": 2}


@pytest.fixture(autouse=True)
def any_engine() -> Iterator[None]:
    yield
    fl.set_simd(None)
    fl.set_num_threads(None)


def questions(geometry: Any, points: Any, case: nasty.Case, seed: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield queries and their arguments."""
    radii, n_prims = radii_of(points, case, seed), len(geometry)
    rng = np.random.default_rng(seed)
    some = rng.integers(0, n_prims, n_prims // 3) if n_prims else []
    each = rng.integers(-1, max(1, n_prims), (len(points), 5)) if n_prims else np.full((len(points), 2), -1)
    for to in ("axis", "surface"):
        yield "nearest", {"to": to}
        yield "nearest", {"k": 8, "to": to}
        for radius in radii.values():
            yield "within", {"radius": radius, "to": to}
            yield "count_within", {"radius": radius, "to": to}
        yield "nearest", {"max_distance": radii["each"], "to": to, "k": 3}
        yield "nearest", {"ignore": each, "to": to}
        yield "within", {"radius": radii["each"], "ignore": some, "to": to}
    yield "nearest", {"k": n_prims + 3}
    if n_strands := sum(part.n_strands for part in geometry.each_part()):
        yield "nearest", {"k": 2, "ignore_strands": rng.integers(-1, n_strands, (len(points), 2))}
        yield "within", {"radius": radii["medium"], "ignore_strands": [0], "ignore": each}
    for parts in (0, [1, 3], []) if geometry.has_parts else ():
        yield "nearest", {"k": 2, "parts": parts, "ignore": some}
        yield "count_within", {"radius": radii["each"], "parts": parts, "ignore": each}


def is_slow(kind: str, seed: int, name: str) -> bool:
    """Return whether a case may wait: other seeds, and of most kinds two of three scenes, in turn."""
    turn = (list(ALL_KINDS).index(kind) + nasty.NAMES.index(name)) % 3
    return seed > 0 or (turn != 0 and kind not in ("segments", "round cones"))


@pytest.mark.parametrize(
    ("kind", "seed", "name"),
    [
        pytest.param(kind, seed, name, marks=pytest.mark.slow if is_slow(kind, seed, name) else ())
        for kind in ALL_KINDS
        for seed in range(N_SEEDS.get(kind, 1))
        for name in nasty.SCENES
    ],
)
def test_answers_are_those_of_brute_force(seed: int, name: str, kind: str) -> None:
    case = cases(seed)[name]
    made = ALL_KINDS[kind](case.segments)
    if kind == "segments":
        made = fl.Lines.from_segments(case.segments, strands=np.arange(len(case.segments)) // 3)
    geometry, points = as_geometry(made), points_of(case, seed)
    if kind == "one's own":  # whose boxes, grown by rounding, are what a tree calls the scene
        points = points[np.abs(points).max(axis=1) < 1e5 * max(1, nasty.size_of(case.segments))]
    of_lines = kind in KINDS or kind == "curves"
    trees = {name: build(made, **how) for name, how in BUILDS.items() if of_lines or "presplit" not in how}
    turn = seed
    for query, asked in questions(geometry, points, case, seed):
        how = {**asked, "invalid": "skip"}  # some are too far away for the smallest scenes
        expected = fl.brute_force_points(made, points, query=query, **how)
        for i, (build_name, tree) in enumerate(trees.items()):
            turn += 1
            for simd, n_threads in WAYS if i == 0 else (WAYS[(7 * turn + i) % len(WAYS)],):
                fl.set_simd(simd)
                fl.set_num_threads(n_threads)
                got = getattr(tree, query)(points, **how)
                assert_same(got, expected, f"{build_name}: {query}, {how}, {simd=}, {n_threads=}, {seed=}")


@pytest.mark.parametrize("simd", fl.available_simd())
@pytest.mark.parametrize("kind", [pytest.param(kind, id=kind) for kind in KINDS])
def test_many_points_in_several_blocks(kind: str, simd: str) -> None:
    """Blocks of points are sorted, and go to several threads."""
    rng = np.random.default_rng(4)
    made = ALL_KINDS[kind](nasty.named_scene("hair", 400))
    points, radius = rng.uniform(-1, 1, (5000, 3)), rng.uniform(0, 0.2, 5000)
    expected = fl.brute_force_points(made, points), fl.brute_force_points(made, points, radius, query="within")
    tree = fl.build(made)
    fl.set_simd(simd)
    for n_threads in (1, 2, 4):
        fl.set_num_threads(n_threads)
        assert_same(tree.nearest(points), expected[0])
        assert_same(tree.within(points, radius), expected[1])
        assert_same(tree.count_within(points, radius), expected[1].counts)


@pytest.mark.parametrize("kind", ["none", "taper", "huge"])
@pytest.mark.parametrize("scale", [1e-30, 1e28])
def test_extreme_sizes(scale: float, kind: str) -> None:
    """Coordinates and radii are near the least and the largest that float32 holds."""
    rng = np.random.default_rng(6)
    ends = np.concatenate([nasty.named_scene(name, 40) for name in ("crossing", "points", "duplicates")]) * scale
    taper = rng.random((len(ends), 2)) ** 6 * scale
    radius = {"none": None, "taper": taper, "huge": np.where(rng.random((len(ends), 2)) < 0.1, 90 * scale, taper)}[kind]
    lines = fl.Lines.from_segments(ends, radius=radius)
    points = nasty.targets(rng, ends.astype(np.float64), 100, 10 * scale)
    radii = np.float32(scale * 10.0 ** rng.uniform(-6, 2, len(points)))
    for to in ("axis", "surface"):
        nearest = fl.brute_force_points(lines, points, k=3, to=to)
        within = fl.brute_force_points(lines, points, radii, query="within", to=to)
        for i, (name, how) in enumerate(BUILDS.items()):
            simd, n_threads = WAYS[7 * i % len(WAYS)]
            tree, which = build(lines, **how), f"{name}: {to=}, {simd=}, {n_threads=}"
            fl.set_simd(simd)
            fl.set_num_threads(n_threads)
            assert_same(tree.nearest(points, k=3, to=to), nearest, which)
            assert_same(tree.within(points, radii, to=to), within, which)
            assert_same(tree.count_within(points, radii, to=to), within.counts, which)


@pytest.mark.parametrize("offset", [None, "auto"])
def test_places_far_from_zero(offset: str | None) -> None:
    rng = np.random.default_rng(5)
    segments = nasty.named_scene("hair", 80).astype(np.float64) + PLACE
    lines = fl.Lines.from_segments(segments.astype(np.float32) if offset is None else segments, offset=offset)
    points = rng.uniform(-1, 1, (200, 3)) + PLACE
    for how in BUILDS.values():
        tree = build(lines, **how)
        assert_same(tree.nearest(points, k=3), fl.brute_force_points(lines, points, k=3))
        assert_same(tree.within(points, 0.3), fl.brute_force_points(lines, points, 0.3, query="within"))
