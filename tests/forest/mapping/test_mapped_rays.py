"""Rays as tasks: the same bits as those of one tree, of a map and of workers of Dask."""

from __future__ import annotations

import os
import signal
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import fastlines as fl
from fastlines.forest.mapping.mapping import ChunkTuning, Mapping
from fastlines.forest.mapping.where import map_of
from fastlines.forest.writing import write_forest

#: Chunks of few rays, so that few rays are many tasks.
SMALL = ChunkTuning(least=100, measured_from=1000, n_measured=2)

QUERIES = {
    "first_hit": ({}, {"at": "surface"}, {"ignore": np.arange(40)}, {"ignore_strands": [1, 2]}, {"spread": 0.05}),
    "any_hit": ({}, {"t_min": 0.1, "t_max": 0.5}, {"at": "entry"}),
    "count_hits": ({}, {"ignore": np.arange(40)}, {"at": "entry"}),
    "all_hits": ({}, {"at": "surface"}, {"at": "entry"}, {"at": "surface", "merge": "strand"}),
    "next_hits": ({"k": 2}, {"k": 3, "rank": "distance"}, {"k": 2, "ignore_strands": np.arange(9)[:, None] % 7}),
}


def scene(n_strands: int = 60) -> fl.Lines:
    rng = np.random.default_rng(5)
    points = rng.uniform(-1, 1, (n_strands, 1, 3)) + rng.normal(0, 0.08, (n_strands, 11, 3)).cumsum(axis=1)
    radius = rng.uniform(0.01, 0.02, 11 * n_strands)
    return fl.Lines.from_points(points.reshape(-1, 3), np.full(n_strands, 11), radius=radius)


def rays(n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(n)
    return rng.uniform(-2, 2, (n, 3)), rng.normal(size=(n, 3))


def assert_same(found, expected) -> None:
    """Compare all arrays of two answers, bit for bit."""
    if isinstance(expected, np.ndarray):
        assert found.dtype == expected.dtype
        assert np.array_equal(found, expected)
        return
    for name in ("offsets", "t", "prim", "u", "distance", "t_out", "skipped", "strand"):
        one, other = getattr(found, name, None), getattr(expected, name, None)
        assert (one is None) == (other is None), name
        if other is not None:
            assert (one.dtype, one.shape) == (other.dtype, other.shape), name
            assert one.tobytes() == other.tobytes(), name


def asked(of, query: str, options: dict, n: int = 1800):
    origins, directions = rays(n)
    shape = (9, n // 9, 3)
    if isinstance(given := options.get("ignore_strands"), np.ndarray):
        options = {**options, "ignore_strands": given[:, None]}  # for each row of rays
    return getattr(of, query)(origins.reshape(shape), directions.reshape(shape), 0.03, **options)


@pytest.fixture(scope="module")
def tree() -> fl.Tree:
    return fl.build(scene())


@pytest.fixture(scope="module", params=["a tree file", "7 tiles"])
def forest(request, tree, tmp_path_factory) -> fl.Forest:
    return forest_of(tree, tmp_path_factory.mktemp("forest"), request.param)


def forest_of(tree: fl.Tree, folder: Path, kind: str) -> fl.Forest:
    """Write a tree, or a forest of the same lines."""
    if kind == "7 tiles":
        return write_forest(tree.geometry, folder, np.arange(len(tree.geometry)) % 7)
    tree.save(folder / "tree.flt")
    return fl.Forest(folder / "tree.flt")


def on(forest: fl.Forest, where, tuning: ChunkTuning = SMALL) -> fl.Forest:
    made = forest.on(where)
    made._mapping = Mapping(map_of(where), tuning=tuning)
    return made


@pytest.mark.parametrize("query", QUERIES)
def test_a_map_gives_the_bits_of_one_tree(tree, forest, query):
    with ThreadPoolExecutor(2) as executor:
        mapped = on(forest, executor.map)
        for options in QUERIES[query]:
            assert_same(asked(mapped, query, options), asked(tree, query, options))


def test_workers_of_dask_give_the_bits_of_one_tree(tree, forest, client):
    mapped = on(forest, client)
    for query, several in QUERIES.items():
        for options in several[-1:]:
            assert_same(asked(mapped, query, options), asked(tree, query, options))


@pytest.mark.parametrize("n", [0, 1, 256, 257])
def test_few_rays(tree, forest, n):
    def failing(function, tasks):
        raise AssertionError("few rays are no tasks")

    mapped = on(forest, failing if n <= 256 else map)
    for query, several in QUERIES.items():
        origins, directions = rays(n)
        options = {"k": several[0]["k"]} if "k" in several[0] else {}
        expected = getattr(tree, query)(origins, directions, 0.03, **options)
        assert_same(getattr(mapped, query)(origins, directions, 0.03, **options), expected)


def test_parts_of_all_hits(tree, forest):
    mapped = on(forest, map)
    origins, directions = rays(900)
    parts = list(mapped.iter_all_hits(origins, directions, 0.03, max_bytes=5_000))
    assert len(parts) > 2
    expected = tree.all_hits(origins, directions, 0.03)
    assert np.array_equal(np.concatenate([part.prim for part in parts]), expected.prim)


def test_progress_and_invalid_rays(tree, forest):
    origins, directions = rays(1500)
    origins[7] = np.nan
    shares = []
    given = {"radius": 0.03, "invalid": "skip"}
    found = on(forest, map).first_hit(origins, directions, **given, progress=shares.append)
    assert_same(found, tree.first_hit(origins, directions, **given))
    assert len(shares) > 5
    assert shares == sorted(shares)
    assert shares[-1] == 1


def test_a_worker_killed_in_the_middle_changes_nothing(tree, forest, client):
    killed = []

    def kill(share):
        if share < 1 and not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    origins, directions = rays(6000)
    found = on(forest, client).all_hits(origins, directions, 0.03, progress=kill)
    assert killed
    assert_same(found, tree.all_hits(origins, directions, 0.03))


def test_a_worker_that_does_not_see_the_forest(tree, tmp_path, client):
    tree.save(tmp_path / "here.flt")
    forest = fl.Forest(tmp_path / "here.flt")
    (tmp_path / "here.flt").rename(tmp_path / "there.flt")
    with pytest.raises(fl.WorkerError, match=r"^worker tcp://.*: does not see .*here\.flt; workers need the files"):
        asked(on(forest, client), "first_hit", {})
    fl.build(scene(30)).save(tmp_path / "here.flt")
    with pytest.raises(fl.WorkerError, match=r"^worker tcp://.*: sees another forest at .*here\.flt than the caller"):
        asked(on(forest, client), "first_hit", {})


def test_a_tile_that_is_missing_on_a_worker(tree, tmp_path, client):
    forest = forest_of(tree, tmp_path, "7 tiles")
    # The caller has opened all tiles before.
    asked(forest, "count_hits", {}, 90)
    (tmp_path / "00004.flt").unlink()
    with pytest.raises(fl.WorkerError, match=r"^worker tcp://.*: .*00004\.flt .* missing.*build_forest"):
        asked(on(forest, client), "first_hit", {})


def test_a_spread_of_some_rays_counts_for_the_kernel_of_all(tmp_path):
    # Crossings of curves have intervals, but not with a spread: whole chunks without one still have none.
    rng = np.random.default_rng(7)
    curves = fl.Curves.from_bezier(rng.normal(0, 0.3, (60, 4, 3)).cumsum(axis=1))
    tree = fl.build(curves)
    tree.save(tmp_path / "curves.flt")
    forest = on(fl.Forest(tmp_path / "curves.flt"), map)
    origins, directions = rays(1200)
    spread = np.repeat([0, 0.01], 600)
    for query in ("first_hit", "all_hits", "count_hits"):
        expected = getattr(tree, query)(origins, directions, 0.2, spread=spread)
        assert_same(getattr(forest, query)(origins, directions, 0.2, spread=spread), expected)
    counts = tree.count_hits(origins[:600], directions[:600], 0.2)
    assert (counts != tree.count_hits(origins, directions, 0.2, spread=spread)[:600]).any()


@pytest.mark.parametrize("segments", [np.zeros((0, 2, 3)), scene().segments])
def test_rays_that_meet_no_tile(tmp_path, segments):
    forest = fl.build_forest(segments, tmp_path / "forest", max_segments=100)
    origins, directions = rays(500)
    origins[:, 2], directions[:, 2] = 50, 1
    found = on(forest, map)
    assert not found.first_hit(origins, directions, 0.01).hit.any()
    assert found.all_hits(origins, directions, 0.01).offsets[-1] == 0
    assert not found.any_hit(origins, directions, 0.01).any()
    assert not found.count_within(origins, 0.01).any()
