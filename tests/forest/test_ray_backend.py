"""Rays and a forest: every answer is that of one tree, bit for bit, however primitives are divided into tiles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same
from support.builds import KINDS

import fastlines as fl
from fastlines.arrays import IntArray
from fastlines.forest.forest import Forest
from fastlines.forest.ray_backend import RayBlocks
from fastlines.forest.writing import write_forest
from fastlines.query.backend import KERNELS

N_SEGMENTS, N_RAYS = 300, 200

#: Queries of all kinds; those at the surface are for rays without a spread.
QUERIES: list[tuple[str, dict[str, Any]]] = [
    *((query, {}) for query in ("first_hit", "any_hit", "count_hits", "all_hits")),
    *(("next_hits", {"k": k}) for k in (0, 1, 3, 100)),
    *(("next_hits", {"k": k, "rank": "distance"}) for k in (0, 2, 100)),
    ("first_hit", {"at": "surface"}),
    ("all_hits", {"at": "surface"}),
    ("all_hits", {"at": "surface", "merge": "strand"}),
    ("next_hits", {"k": 2, "at": "surface"}),
    ("next_hits", {"k": 2, "at": "surface", "rank": "distance"}),
    *((query, {"at": "entry"}) for query in ("first_hit", "any_hit", "count_hits", "all_hits")),
    ("next_hits", {"k": 2, "at": "entry"}),
]


def scene(name: str, kind: str) -> fl.Lines:
    rng = np.random.default_rng(3)
    centres = rng.random((N_SEGMENTS, 1, 3))
    if name == "clustered":
        centres = rng.random((6, 1, 3))[rng.integers(0, 6, N_SEGMENTS)] + rng.normal(0, 0.02, (N_SEGMENTS, 1, 3))
    segments = (centres + rng.normal(0, 0.04, (N_SEGMENTS, 2, 3))).astype(np.float32)
    if name == "duplicates":
        segments = segments[rng.integers(0, 40, N_SEGMENTS)]
    if name == "far away":
        segments = segments * np.float32(1e-3) + np.float32([10, 20, -5])
    return KINDS[kind](segments)


def tiles_of(lines: fl.Lines, n_tiles: int, how: str) -> IntArray:
    if how == "scattered":
        return np.arange(len(lines)) % n_tiles
    order = np.argsort(lines.segments.mean(axis=1)[:, 0], kind="stable")
    tiles = np.empty(len(lines), np.int64)
    tiles[order] = np.arange(len(lines)) * n_tiles // len(lines)
    return tiles


def rays_of(lines: fl.Lines, **options: Any) -> dict[str, Any]:
    """Return incoherent rays from outside and inside, with directions of all lengths."""
    rng = np.random.default_rng(5)
    low, high = lines.bounds
    size = (high - low).max()
    origins = low + (high - low) * rng.uniform(-1, 2, (N_RAYS, 3))
    targets = low + (high - low) * rng.random((N_RAYS, 3))
    scale = 10 ** rng.uniform(-2, 2, (N_RAYS, 1))
    directions = (targets - origins) * scale
    origins[::9, 1:], directions[::9, 1:] = targets[::9, 1:], [-0.0, 0.0]  # parallel to an axis
    rays = {"origins": origins, "directions": directions, "radius": rng.random(N_RAYS) * size * 0.03}
    if options.pop("bounds", False):
        rays |= {"t_min": 0.3 / scale[:, 0], "t_max": (0.5 + rng.random(N_RAYS)) / scale[:, 0]}
    return rays | options


def picture_of(lines: fl.Lines) -> dict[str, Any]:
    low, high = lines.bounds
    y, x = np.mgrid[0:24, 0:30] / 24
    at = np.stack([x, y, 0.5 + 0 * x], axis=-1)
    origin = low + (high - low) * [0.5, 0.5, -2]
    return {"origins": origin, "directions": low + (high - low) * at - origin, "radius": (high - low).max() * 0.01}


@pytest.fixture
def forest_and_tree(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Forest, fl.Tree]:
    name, kind, n_tiles, how = request.param
    lines = scene(name, kind)
    return write_forest(lines, tmp_path / "forest", tiles_of(lines, n_tiles, how)), fl.build(lines)


def check(forest: Forest, tree: fl.Tree, rays: dict[str, Any]) -> None:
    n_hits = 0
    for query, options in QUERIES:
        if "at" in options and "spread" in rays:
            continue
        got, expected = (getattr(of, query)(**rays, **options) for of in (forest, tree))
        assert_same(got, expected, f"{query} {options}")
        n_hits += len(expected.t) if query == "all_hits" else 0
    assert n_hits > 0


EVERY_FOREST = [
    (name, kind, n_tiles, how)
    for name in ("random", "clustered", "duplicates", "far away")
    for kind in ("segments", "round cones")
    for n_tiles, how in ((1, "cut"), (3, "scattered"), (7, "cut"), (20, "cut"))
]
SOME_FORESTS = [("random", "segments", 7, "cut"), ("duplicates", "round cones", 3, "scattered")]


@pytest.mark.parametrize("forest_and_tree", EVERY_FOREST, ids=str, indirect=True)
def test_answers_are_those_of_one_tree(forest_and_tree: tuple[Forest, fl.Tree]) -> None:
    forest, tree = forest_and_tree
    rng = np.random.default_rng(6)
    check(forest, tree, rays_of(tree.geometry))
    check(forest, tree, rays_of(tree.geometry, bounds=True))
    check(forest, tree, rays_of(tree.geometry, spread=0.02))
    check(forest, tree, rays_of(tree.geometry, spread=rng.random(N_RAYS) * 0.02 * (rng.random(N_RAYS) < 0.5)))
    check(forest, tree, picture_of(tree.geometry))


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("forest_and_tree", SOME_FORESTS, ids=str, indirect=True)
def test_kernels(forest_and_tree: tuple[Forest, fl.Tree], kernel: str) -> None:
    forest, tree = forest_and_tree
    for rays in (rays_of(tree.geometry), picture_of(tree.geometry)):
        check(forest, tree, rays | {"kernel": kernel})


@pytest.mark.parametrize("forest_and_tree", SOME_FORESTS, ids=str, indirect=True)
def test_the_answer_is_that_of_brute_force(forest_and_tree: tuple[Forest, fl.Tree]) -> None:
    forest, tree = forest_and_tree
    rays = rays_of(tree.geometry)
    for query, options in QUERIES:
        expected = fl.brute_force(tree.geometry, **rays, query=query, **options)  # type: ignore[arg-type]
        assert_same(getattr(forest, query)(**rays, **options), expected, query)


@pytest.mark.parametrize("forest_and_tree", SOME_FORESTS, ids=str, indirect=True)
def test_primitives_and_strands_that_are_left_out(forest_and_tree: tuple[Forest, fl.Tree]) -> None:
    forest, tree = forest_and_tree
    rays = rays_of(tree.geometry)
    first = tree.first_hit(**rays)
    check(forest, tree, rays | {"ignore": first})
    check(forest, tree, rays | {"ignore": np.arange(0, N_SEGMENTS, 3)})


@pytest.mark.parametrize("forest_and_tree", SOME_FORESTS, ids=str, indirect=True)
def test_rays_that_miss_or_are_not_there(forest_and_tree: tuple[Forest, fl.Tree]) -> None:
    forest, tree = forest_and_tree
    away = {"origins": [[9, 9, 9], [-7, 0, 0]], "directions": [[1, 0, 0], [0, 1, 0]], "radius": 0.1}
    none = {"origins": np.zeros((0, 3)), "directions": np.zeros((0, 3)), "radius": 0.1}
    for rays in (away, none):
        for query, options in QUERIES:
            got, expected = (getattr(of, query)(**rays, **options) for of in (forest, tree))
            assert_same(got, expected, query)


@pytest.mark.parametrize("forest_and_tree", SOME_FORESTS, ids=str, indirect=True)
def test_invalid_rays_are_skipped(forest_and_tree: tuple[Forest, fl.Tree]) -> None:
    forest, tree = forest_and_tree
    rays = rays_of(tree.geometry, invalid="skip")
    rays["origins"][3], rays["directions"][11] = np.nan, 0
    check(forest, tree, rays)


@pytest.mark.parametrize("forest_and_tree", SOME_FORESTS, ids=str, indirect=True)
def test_blocks_of_rays(forest_and_tree: tuple[Forest, fl.Tree], monkeypatch: pytest.MonkeyPatch) -> None:
    forest, tree = forest_and_tree
    for name, value in {"MAX_RAYS": 37, "FIRST_RAYS": 10, "HITS": 60, "STEPS": 70, "MAX_KEPT": 2}.items():
        monkeypatch.setattr(RayBlocks, name, value)
    check(forest, tree, rays_of(tree.geometry, bounds=True))
    check(forest, tree, picture_of(tree.geometry))


@pytest.mark.parametrize("forest_and_tree", SOME_FORESTS[:1], ids=str, indirect=True)
def test_progress_rises_to_the_end_and_can_stop_the_query(
    forest_and_tree: tuple[Forest, fl.Tree], monkeypatch: pytest.MonkeyPatch
) -> None:
    forest, tree = forest_and_tree
    monkeypatch.setattr(RayBlocks, "MAX_RAYS", 50)
    monkeypatch.setattr(RayBlocks, "FIRST_RAYS", 50)
    for query, options in QUERIES:
        seen: list[float] = []
        getattr(forest, query)(**rays_of(tree.geometry), **options, progress=seen.append)
        assert seen == sorted(seen)
        assert seen[-1] == 1

        def stop(done: float) -> None:
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            getattr(forest, query)(**rays_of(tree.geometry), **options, progress=stop)


@pytest.mark.parametrize("forest_and_tree", SOME_FORESTS[:1], ids=str, indirect=True)
def test_tiles_that_do_not_fit_into_memory_together(forest_and_tree: tuple[Forest, fl.Tree]) -> None:
    forest, tree = forest_and_tree
    largest = max(tile.n_bytes for tile in forest.manifest.tiles)
    check(Forest(forest.path, memory=2 * largest), tree, rays_of(tree.geometry))


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="the system does not list what is mapped")
def test_lists_of_hits_keep_no_closed_tile_mapped(tmp_path):
    lines = fl.scenes.make("bun-hair", 2_000).lines
    write_forest(lines, tmp_path / "f", np.arange(len(lines)) // 250)
    largest = max(path.stat().st_size for path in (tmp_path / "f").glob("*.flt"))
    forest = fl.Forest(tmp_path / "f", memory=2 * largest)
    origins, directions = fl.Camera.framing(lines).rays(16, 16)
    mapped = []

    def look(share):
        mapped.append(Path("/proc/self/maps").read_text().count(f"{tmp_path}/f/0"))

    forest.all_hits(origins, directions, 0.05, progress=look)
    assert max(mapped) <= 3  # those that are open, and the one that is queried
