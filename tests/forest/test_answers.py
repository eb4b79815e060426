"""The answers of a forest are those of one tree, bit for bit, whatever the tiles are."""

from __future__ import annotations

import pickle
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same
from support.forests import strands, tiles_of

import fastlines as fl
from fastlines.forest.writing import write_forest

POINTS = 330


@cache
def scenes() -> dict[str, tuple[fl.Lines, fl.Tree]]:
    """Return scenes and one tree over each."""
    found = {
        "bare": strands(),
        "thick": strands(seed=1, radius=np.random.default_rng(1).uniform(0.001, 0.1, POINTS)),
        "far away": fl.Lines.from_segments(strands(seed=2).segments + np.float32(1e4)),
        "doubled": fl.Lines.from_segments(np.repeat(strands(150, seed=3).segments, 2, axis=0)),
        "flat": fl.Lines.from_segments(strands(seed=4).segments * np.float32([1, 1, 0])),
    }
    return {name: (lines, fl.build(lines)) for name, lines in found.items()}


@pytest.fixture(params=scenes())
def scene(request: pytest.FixtureRequest) -> tuple[fl.Lines, fl.Tree]:
    return scenes()[request.param]


@pytest.fixture(params=[1, 3, 7])
def forest(request: pytest.FixtureRequest, scene: tuple[fl.Lines, fl.Tree], tmp_path: Path) -> fl.Forest:
    return write_forest(scene[0], tmp_path / "forest", tiles_of(scene[0], request.param))


def rays(lines: fl.Lines, n: int = 400) -> dict[str, Any]:
    rng = np.random.default_rng(7)
    low, high = lines.bounds.astype(np.float64)
    size = high - low
    origins, targets = (low - 0.2 * size + rng.random((n, 3)) * 1.4 * size for _ in range(2))
    return {"origins": origins, "directions": (targets - origins) * rng.uniform(0.1, 10, (n, 1))}


def options(lines: fl.Lines) -> dict[str, dict[str, Any]]:
    """Return options of queries about these rays."""
    rng = np.random.default_rng(8)
    found: dict[str, dict[str, Any]] = {
        "one radius": {"radius": 0.05},
        "radius 0": {"radius": 0.0},
        "huge radius": {"radius": 5.0},
        "each its radius": {"radius": rng.uniform(0, 0.3, 400)},
        "spread": {"radius": 0.01, "spread": rng.uniform(0, 0.1, 400)},
        "bounds": {"radius": 0.1, "t_min": rng.uniform(0, 0.2, 400), "t_max": rng.uniform(0.2, 0.6, 400)},
        "ignored": {"radius": 0.2, "ignore": np.arange(0, 300, 3)},
        "ignored by each": {"radius": 0.2, "ignore": rng.integers(-1, 300, (400, 2))},
    }
    if lines.n_strands:
        found["ignored strands"] = {"radius": 0.2, "ignore_strands": np.arange(0, 30, 2)}
    return found


def test_rays(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree]) -> None:
    lines, tree = scene
    for name, given in options(lines).items():
        asked = rays(lines) | given
        ats = ("closest",) if "spread" in given else ("closest", "surface", "entry")
        for at in ats:
            for query, more in (
                ("any_hit", {}),
                ("count_hits", {}),
                ("first_hit", {}),
                ("all_hits", {}),
                ("next_hits", {"k": 1}),
                ("next_hits", {"k": 5}),
                ("next_hits", {"k": 3, "rank": "distance"}),
            ):
                got, expected = (getattr(of, query)(**asked, at=at, **more) for of in (forest, tree))
                assert_same(got, expected, f"{name} {query} {at} {more}")


@pytest.mark.parametrize("kernel", ["single", "wave", "bundle", "binary"])
def test_kernels(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree], kernel: str) -> None:
    lines, tree = scene
    asked = rays(lines) | {"radius": 0.1}
    assert_same(forest.first_hit(**asked, kernel=kernel), tree.first_hit(**asked), kernel)
    assert_same(forest.all_hits(**asked, kernel=kernel), tree.all_hits(**asked), kernel)


def test_strands_merge(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree]) -> None:
    lines, tree = scene
    asked: dict[str, Any] = rays(lines) | {"radius": 0.2, "at": "surface", "merge": "strand"}
    assert_same(forest.all_hits(**asked), tree.all_hits(**asked))


def test_hits_in_parts(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree]) -> None:
    lines, tree = scene
    asked = rays(lines) | {"radius": 0.2}
    parts = list(forest.iter_all_hits(**asked, max_bytes=20_000))
    whole = tree.all_hits(**asked)
    assert len(parts) > 1
    for column in ("t", "prim", "u", "distance"):
        assert np.concatenate([getattr(part, column) for part in parts]).tobytes() == getattr(whole, column).tobytes()


def test_points(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree]) -> None:
    lines, tree = scene
    points = rays(lines)["origins"]
    radius = np.random.default_rng(9).uniform(0, 0.5, len(points))
    for to in ("axis", "surface"):
        for k in (1, 4, 300):
            got, expected = (of.nearest(points, k, to=to) for of in (forest, tree))
            assert_same(got, expected, f"nearest {k} {to}")
            assert got.points().tobytes() == expected.points().tobytes()
        limited = {"max_distance": radius, "to": to, "ignore": np.arange(0, 300, 2)}
        assert_same(forest.nearest(points, 3, **limited), tree.nearest(points, 3, **limited), to)
        assert_same(forest.within(points, radius, to=to), tree.within(points, radius, to=to), to)
        assert_same(forest.count_within(points, radius, to=to), tree.count_within(points, radius, to=to), to)


def test_what_hits_say(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree]) -> None:
    lines, tree = scene
    asked: dict[str, Any] = rays(lines) | {"radius": 0.1, "at": "surface"}
    got, expected = (of.first_hit(**asked) for of in (forest, tree))
    for ask in ("points", "normals", "tangents"):
        assert getattr(got, ask)().tobytes() == getattr(expected, ask)().tobytes()
    assert got.points(outside=True).tobytes() == expected.points(outside=True).tobytes()
    for name in lines.sample_names:
        assert got.sample(name).tobytes() == expected.sample(name).tobytes()
    back = pickle.loads(pickle.dumps(got))
    assert back.strand.tolist() == expected.strand.tolist()
    assert back.row.tolist() == expected.row.tolist()


def test_a_tile_that_was_built_again(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree]) -> None:
    lines, tree = scene
    asked = rays(lines) | {"radius": 0.1}
    for method in ("kd-cl", "bvh-ss"):
        forest = forest.rebuild(forest.n_tiles - 1, method)
        assert_same(forest.all_hits(**asked), tree.all_hits(**asked), method)


def test_little_memory(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree]) -> None:
    lines, tree = scene
    asked = rays(lines) | {"radius": 0.1}
    small = fl.Forest(forest.path, memory=max(tile.n_bytes for tile in forest.manifest.tiles))
    assert_same(small.first_hit(**asked), tree.first_hit(**asked))
    assert_same(small.all_hits(**asked), tree.all_hits(**asked))


def test_a_damaged_tile_is_noticed_when_it_is_asked(scene: tuple[fl.Lines, fl.Tree], tmp_path: Path) -> None:
    lines, tree = scene
    forest = write_forest(lines, tmp_path / "forest", tiles_of(lines, 7))
    (forest.path / "00006.flt").unlink()
    opened = fl.Forest(forest.path)
    low, high = lines.bounds.astype(np.float64)
    across = {"origins": low - [0, 1, 0], "directions": [0, 1, 0], "radius": 0.0}
    assert_same(opened.first_hit(**across), tree.first_hit(**across))
    with pytest.raises(fl.FileFormatError, match=r"00006.flt is not the tile 6 of this forest: it is missing; call"):
        opened.count_hits(low - 1, high - low + 2, radius=5)


def test_queries_are_checked_as_those_of_a_tree(forest: fl.Forest, scene: tuple[fl.Lines, fl.Tree]) -> None:
    tree = scene[1]
    wrong: list[dict[str, Any]] = [
        {"directions": [0, 0, 0]},
        {"radius": -1},
        {"kernel": "fast"},
        {"ignore": [300]},
        {"parts": 0},
        {"at": "surface", "spread": 0.1},
    ]
    for given in wrong:
        asked = {"origins": [0, 0, 0], "directions": [0, 0, 1], "radius": 0.1} | given
        with pytest.raises(fl.InputError) as of_forest:
            forest.first_hit(**asked)
        with pytest.raises(fl.InputError) as of_tree:
            tree.first_hit(**asked)
        assert str(of_forest.value).replace("ForestGeometry", "Lines") == str(of_tree.value)


@pytest.mark.parametrize("to", [None, "axis"])
def test_empty_tiles(tmp_path: Path, to: str | None) -> None:
    lines = fl.Lines.from_segments(strands(seed=5).segments + np.float32(100), radius=0.01)
    tree = fl.build(lines)
    forest = write_forest(lines, tmp_path / "forest", 2 * tiles_of(lines, 3) + 1)
    assert [tile.n_prims for tile in forest.manifest.tiles] == [0, 100, 0, 100, 0, 100]
    asked: dict[str, Any] = rays(lines) | {"radius": 0.1, "ignore": np.arange(0, 300, 2)}
    assert_same(forest.all_hits(**asked), tree.all_hits(**asked))
    left_out: dict[str, Any] = {"ignore": asked["ignore"], "to": to}
    points = np.concatenate([asked["origins"], np.zeros((1, 3))])
    assert_same(forest.nearest(points, 20, **left_out), tree.nearest(points, 20, **left_out))
    assert_same(forest.within(points, 200, **left_out), tree.within(points, 200, **left_out))
    assert_same(forest.in_box([[-1e3] * 3], [[1e3] * 3], to=to), tree.in_box([[-1e3] * 3], [[1e3] * 3], to=to))
    for column in ("i", "j", "distance"):
        got, expected = (getattr(of.pairs(0.1, to=to), column) for of in (forest, tree))
        assert got.tobytes() == expected.tobytes()


def test_a_tiny_scene(tmp_path: Path) -> None:
    unit = np.float32(1e-25)
    lines = fl.Lines.from_segments(strands(seed=6).segments * unit, radius=0.01 * unit)
    tree, forest = fl.build(lines), write_forest(lines, tmp_path / "forest", tiles_of(lines, 7))
    asked = rays(lines) | {"radius": 0.01 * unit, "spread": 0.2}
    assert_same(forest.all_hits(**asked), tree.all_hits(**asked))
    points = rays(lines)["origins"]
    assert_same(forest.nearest(points, 5), tree.nearest(points, 5))


def test_without_the_radius_of_the_lines(tmp_path: Path) -> None:
    lines = scenes()["thick"][0]
    tree = fl.build(lines, own_radius=False)
    asked = rays(lines) | {"radius": 0.1}
    written = write_forest(lines, tmp_path / "written", tiles_of(lines, 3), own_radius=False)
    built = fl.build_forest(lines, tmp_path / "built", max_segments=100, own_radius=False)
    for forest in (written, built):
        assert_same(forest.all_hits(**asked), tree.all_hits(**asked))
        assert forest.geometry.needs_radius
        with pytest.raises(fl.InputError, match="own_radius is the same in all tiles"):
            forest.rebuild(0, own_radius=True)


def test_threads_ask_at_the_same_time(tmp_path: Path) -> None:
    lines, tree = scenes()["thick"]
    forest = write_forest(lines, tmp_path / "forest", tiles_of(lines, 7))
    largest = max(tile.n_bytes for tile in forest.manifest.tiles)
    asked = rays(lines) | {"radius": 0.1, "at": "surface"}
    expected = tree.all_hits(**asked)
    for memory in (None, 2 * largest):
        opened = fl.Forest(forest.path, memory=memory)
        with ThreadPoolExecutor(4) as pool:
            for got in pool.map(lambda _: opened.all_hits(**asked), range(8)):  # noqa: B023  # all end in this round
                assert_same(got, expected)
                assert got.normals().tobytes() == expected.normals().tobytes()


def test_another_process_gives_the_same_answer(tmp_path: Path) -> None:
    lines, tree = scenes()["bare"]
    forest = write_forest(lines, tmp_path / "forest", tiles_of(lines, 3))
    asked = rays(lines) | {"radius": 0.1}
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        found = pool.submit(ask, forest, asked).result()
    assert_same(found, tree.first_hit(**asked))
    assert found.strand.tolist() == tree.first_hit(**asked).strand.tolist()


def ask(forest: fl.Forest, asked: dict[str, Any]) -> fl.FirstHits:
    return forest.first_hit(**asked)
