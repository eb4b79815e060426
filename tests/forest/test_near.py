"""Points, pairs and boxes of forests: bit for bit those of one tree over the whole scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from support.forests import strands, tiles_of

import fastlines as fl
from fastlines.forest import point_backend
from fastlines.forest.geometry import ForestGeometry
from fastlines.forest.writing import write_forest
from fastlines.query.proximity.pair_backend import PairsOfSets

N = 600


def thin() -> fl.Lines:
    return strands(N, seed=1)


def thick() -> fl.Lines:
    return strands(N, seed=2, radius=np.random.default_rng(3).uniform(0, 0.04, N // 10 * 11))


def far_away() -> fl.Lines:
    """Return lines with an offset; their strands have gaps in their numbers, and some lines have none."""
    lines = strands(N, seed=4)
    numbers = np.where(lines.strands % 5 == 0, -1, 3 * lines.strands)
    shifted = lines.segments.astype(np.float64) + np.array([500_000, 6_000_000, 0])
    return fl.Lines.from_segments(shifted, strands=numbers, radius=0.01, offset=(500_000, 6_000_000, 0))


def lattice() -> fl.Lines:
    """Return lines on a lattice, each three times in any order: many exact ties."""
    rng = np.random.default_rng(5)
    start = np.stack(np.meshgrid(*[np.arange(-2.0, 3)] * 3), axis=-1).reshape(-1, 3)
    start = start[rng.permutation(np.repeat(np.arange(len(start)), 3))]
    edge = np.eye(3)[rng.integers(0, 3, len(start))]
    return fl.Lines.from_segments(
        np.stack([start, start + edge], axis=1), radius=0.125, strands=np.arange(len(start)) // 4
    )


SCENES = {of.__name__: of for of in (thin, thick, far_away, lattice)}


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def lines(scene: str) -> fl.Lines:
    return SCENES[scene]()


@pytest.fixture(scope="module")
def tree(lines: fl.Lines) -> fl.Tree:
    return fl.build(lines)


@pytest.fixture(scope="module", params=[1, 3, 7, 20])
def forest(
    request: pytest.FixtureRequest, scene: str, lines: fl.Lines, tmp_path_factory: pytest.TempPathFactory
) -> fl.Forest:
    """Return a forest whose tiles are slabs; those of the lattice are mixed."""
    mixed = np.random.default_rng(6).integers(0, request.param, len(lines))
    tile_of = mixed if scene == "lattice" else tiles_of(lines, request.param)
    return write_forest(lines, tmp_path_factory.mktemp("forest"), tile_of)


def same(got: Any, expected: Any) -> None:
    assert type(got) is type(expected)
    if isinstance(got, np.ndarray):
        assert (got.shape, got.dtype) == (expected.shape, expected.dtype)
        assert got.tobytes() == expected.tobytes()
        return
    names = ("offsets", "prim", "u", "distance", "i", "j", "s", "t", "segment", "strand", "row", "strand_i", "row_j")
    known = [name for name in names if hasattr(expected, name)]
    assert len(known) >= 3
    for name in known:
        same(getattr(got, name), getattr(expected, name))


def points_of(lines: fl.Lines, n: int = 80) -> npt.NDArray[np.float64]:
    """Return points on axes, near them and far from the scene."""
    rng = np.random.default_rng(7)
    near = lines.segments[rng.integers(0, len(lines), n), 0].astype(np.float64)
    near[: n // 2] += rng.normal(0, 0.2, (n // 2, 3))
    near[-3:] *= 20
    return near + np.array(lines.offset)


# ---- Points ----


@pytest.mark.parametrize("to", [None, "axis"])
@pytest.mark.parametrize("k", [0, 1, 5, 50, 2000])
def test_nearest(forest: fl.Forest, tree: fl.Tree, lines: fl.Lines, k: int, to: str | None) -> None:
    points = points_of(lines)
    same(forest.nearest(points, k, to=to), tree.nearest(points, k, to=to))
    far = np.linspace(0, 0.5, len(points))
    for max_distance in (0.0, 0.1, far):
        found = forest.nearest(points, k, max_distance=max_distance, to=to)
        same(found, tree.nearest(points, k, max_distance=max_distance, to=to))


@pytest.mark.parametrize("to", [None, "axis"])
def test_within(forest: fl.Forest, tree: fl.Tree, lines: fl.Lines, to: str | None) -> None:
    points = points_of(lines)
    for radius in (0.0, 0.3, 50.0, np.linspace(0, 1, len(points))):
        same(forest.within(points, radius, to=to), tree.within(points, radius, to=to))
        same(forest.count_within(points, radius, to=to), tree.count_within(points, radius, to=to))


def test_what_points_leave_out(forest: fl.Forest, tree: fl.Tree, lines: fl.Lines) -> None:
    points, rng = points_of(lines), np.random.default_rng(8)
    first = tree.nearest(points)
    several = rng.integers(-1, len(lines), (len(points), 3))
    of_strands = rng.integers(-1, lines.strands.max() + 1, (len(points), 2))
    for options in (
        {"ignore": first.prim[:7]},
        {"ignore": first},
        {"ignore": np.arange(len(lines))},
        {"ignore": several, "ignore_strands": of_strands},
        {"ignore_strands": first},
        {"ignore_strands": [3, 15, -1]},
        {"ignore_strands": []},
    ):
        for k in (1, 4):
            same(forest.nearest(points, k, **options), tree.nearest(points, k, **options))
        same(forest.within(points, 0.4, **options), tree.within(points, 0.4, **options))
        same(forest.count_within(points, 0.4, **options), tree.count_within(points, 0.4, **options))


def test_points_in_any_shape(forest: fl.Forest, tree: fl.Tree, lines: fl.Lines) -> None:
    points = points_of(lines).reshape(8, 10, 3)
    points[2, 3] = np.nan
    same(forest.nearest(points, 2, invalid="skip"), tree.nearest(points, 2, invalid="skip"))
    same(forest.within(points, 0.2, invalid="skip"), tree.within(points, 0.2, invalid="skip"))
    same(forest.nearest(points[:0]), tree.nearest(points[:0]))
    same(forest.within(points[:0], 1), tree.within(points[:0], 1))
    same(forest.nearest(points[0]).points(), tree.nearest(points[0]).points())


def test_points_in_several_blocks(
    forest: fl.Forest, tree: fl.Tree, lines: fl.Lines, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = points_of(lines)
    monkeypatch.setattr(point_backend, "MOST_POINTS", 13)
    monkeypatch.setattr(point_backend, "FIRST_POINTS", 5)
    monkeypatch.setattr(point_backend, "MOST_PAIRS", 20)
    options = {"ignore": np.arange(len(points))[:, None]}
    same(forest.nearest(points, 3, **options), tree.nearest(points, 3, **options))
    same(forest.within(points, 0.3, **options), tree.within(points, 0.3, **options))


# ---- Pairs ----

LEFT_OUT = (
    {"skip_neighbours": 0},
    {},
    {"skip_neighbours": 2},
    {"skip_strand": True},
)


@pytest.mark.parametrize("left_out", LEFT_OUT)
def test_pairs(forest: fl.Forest, tree: fl.Tree, left_out: dict[str, Any]) -> None:
    for radius in (0.0, 0.05, 0.3):
        for to in (None, "axis"):
            expected = tree.pairs(radius, to=to, **left_out)
            same(forest.pairs(radius, to=to, **left_out), expected)
            assert radius == 0 or len(expected)


def test_pairs_in_parts(forest: fl.Forest, tree: fl.Tree) -> None:
    expected = tree.pairs(0.2)
    parts = list(forest.iter_pairs(0.2, max_bytes=68 * 400))
    assert len(parts) > 2
    assert max(map(len, parts)) <= 400
    for name in ("i", "j", "s", "t", "distance"):
        same(np.concatenate([getattr(part, name) for part in parts]), getattr(expected, name))
    with pytest.raises(MemoryError, match="more than the 1 pair that max_bytes holds"):
        list(forest.iter_pairs(0.2, max_bytes=68))


def test_pairs_of_two(forest: fl.Forest, tree: fl.Tree, lines: fl.Lines, tmp_path: Path) -> None:
    moved = lines.segments[:200] + np.float32(0.01)
    more = fl.Lines(moved, lines.strands[:200], metadata=lines.metadata)
    other, other_forest = fl.build(more), write_forest(more, tmp_path / "other", tiles_of(more, 3))
    for radius in (0.02, 0.2):
        expected = tree.pairs(radius, other)
        assert len(expected) > 100
        same(forest.pairs(radius, other), expected)
        same(forest.pairs(radius, other_forest), expected)
        same(tree.pairs(radius, other_forest), expected)
        same(other_forest.pairs(radius, forest), other.pairs(radius, tree))
    parts = list(forest.iter_pairs(0.1, other_forest, max_bytes=68 * 2000))
    same(np.concatenate([part.j for part in parts]), tree.pairs(0.1, other).j)


def test_places_of_pairs(forest: fl.Forest, tree: fl.Tree) -> None:
    same(forest.pairs(0.05).points(), tree.pairs(0.05).points())


def test_along(forest: fl.Forest, tree: fl.Tree, lines: fl.Lines) -> None:
    polyline = points_of(lines, 12)
    for radius in (0.0, 0.1, 0.5):
        same(forest.along(polyline, radius), tree.along(polyline, radius))
        same(forest.along(polyline, radius, to="axis"), tree.along(polyline, radius, to="axis"))
    far = polyline[:2] + 1e6
    same(forest.along(far, 0.1), tree.along(far, 0.1))


# ---- Boxes ----


def test_in_box(forest: fl.Forest, tree: fl.Tree, lines: fl.Lines) -> None:
    low = points_of(lines)
    high = low + np.random.default_rng(9).uniform(0, 0.5, low.shape)
    for to in (None, "axis"):
        same(forest.in_box(low, high, to=to), tree.in_box(low, high, to=to))
        same(forest.in_box([-np.inf] * 3, high[0], to=to), tree.in_box([-np.inf] * 3, high[0], to=to))
    same(forest.in_box(low[:0], high[:0]), tree.in_box(low[:0], high[:0]))
    same(
        forest.in_box(low.min(axis=0) - 99, low.min(axis=0) - 98),
        tree.in_box(low.min(axis=0) - 99, low.min(axis=0) - 98),
    )


# ---- Bounds on memory, and errors ----


def test_no_strand_of_every_primitive_is_looked_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = thick()
    forest, points = write_forest(lines, tmp_path / "forest", tiles_of(lines, 7)), points_of(lines)
    all_strands = ForestGeometry.strands_of

    def some_strands(geometry: ForestGeometry, prim: Any) -> Any:
        assert len(prim) < len(lines) // 2
        return all_strands(geometry, prim)

    monkeypatch.setattr(ForestGeometry, "strands_of", some_strands)
    forest.nearest(points, ignore_strands=[1, 2])
    forest.within(points, 0.1, ignore_strands=np.arange(len(points))[:, None] % 60)
    forest.pairs(0.01, skip_strand=True)


def test_few_tiles_are_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = thin()
    forest = write_forest(lines, tmp_path / "forest", tiles_of(lines, 20))
    asked: list[int] = []
    opened: Callable[[int], Any] = forest._store.open
    monkeypatch.setattr(forest._store, "open", lambda number: asked.append(number) or opened(number))
    forest.nearest(lines.segments[0, 0])
    assert len(asked) <= 5
    asked.clear()
    forest.in_box(lines.segments[0, 0], lines.segments[0, 0] + 0.01)
    assert len(asked) <= 3
    asked.clear()
    forest.pairs(0.0)
    assert len(asked) < 20 * 20


def test_sets_of_pairs_are_few(tmp_path: Path) -> None:
    lines = thin()
    forest = write_forest(lines, tmp_path / "forest", tiles_of(lines, 20))
    backend = forest._pair_backend(None)
    assert isinstance(backend, PairsOfSets)
    tasks = backend.tasks(forest._pair_query(0.01, None, 0, False, None))
    pairs = {(task.first, task.second) for task in tasks}
    assert {(i, i) for i in range(20)} <= pairs
    assert {(j, i) for i, j in pairs} == pairs
    assert len(tasks) < 200


def test_tiles_within_a_bound_on_memory(tmp_path: Path) -> None:
    lines = thick()
    write_forest(lines, tmp_path / "forest", tiles_of(lines, 7))
    largest = max(tile.n_bytes + 32 * tile.n_prims for tile in fl.Forest(tmp_path / "forest").manifest.tiles)
    forest, tree, points = fl.Forest(tmp_path / "forest", memory=2 * largest), fl.build(lines), points_of(lines)
    same(forest.nearest(points, 3), tree.nearest(points, 3))
    same(forest.within(points, 0.3), tree.within(points, 0.3))
    same(forest.pairs(0.1), tree.pairs(0.1))
    assert forest._store.is_open.sum() <= 2


def test_progress(tmp_path: Path) -> None:
    lines = thick()
    forest, points = write_forest(lines, tmp_path / "forest", tiles_of(lines, 7)), points_of(lines)
    for ask in (
        lambda progress: forest.nearest(points, 3, progress=progress),
        lambda progress: forest.within(points, 0.3, progress=progress),
        lambda progress: forest.count_within(points, 0.3, progress=progress),
        lambda progress: forest.pairs(0.1, progress=progress),
        lambda progress: forest.along(points, 0.1, progress=progress),
        lambda progress: forest.in_box(points, points + 0.1, progress=progress),
    ):
        shown: list[float] = []
        ask(shown.append)
        assert shown == sorted(shown)
        assert shown[-1] == 1.0
        assert len(shown) > 3, ask
        with pytest.raises(ZeroDivisionError):
            ask(lambda done: 1 / 0)


def test_what_is_no_forest(tmp_path: Path) -> None:
    forest = write_forest(thin(), tmp_path / "forest", tiles_of(thin(), 3))
    with pytest.raises(fl.InputError, match="other is an int; expected a Tree or a Forest"):
        forest.pairs(1, 3)  # type: ignore[arg-type]
    with pytest.raises(fl.InputError, match="ignore_strands names 60; there are 60 strands"):
        forest.nearest([0, 0, 0], ignore_strands=[60])
    with pytest.raises(fl.InputError, match="ignore names 600; there are 600 primitives"):
        forest.within([0, 0, 0], 1, ignore=[600])
    with pytest.raises(fl.InputError, match="different offsets"):
        forest.pairs(1, fl.build(far_away()))


def test_an_empty_tile_and_an_empty_forest(tmp_path: Path) -> None:
    lines = thin()
    tile_of = tiles_of(lines, 3)
    forest, tree = write_forest(lines, tmp_path / "gap", np.where(tile_of == 1, 3, tile_of)), fl.build(lines)
    points = points_of(lines)
    same(forest.nearest(points, 700), tree.nearest(points, 700))
    same(forest.within(points, 9), tree.within(points, 9))
    same(forest.pairs(0.1), tree.pairs(0.1))
    same(forest.in_box(-9, 9), tree.in_box(-9, 9))
    same(forest.along(points, 0.1), tree.along(points, 0.1))
    nothing = fl.Lines.from_segments(np.zeros((0, 2, 3)))
    none, empty = write_forest(nothing, tmp_path / "none", np.zeros(0, np.int64)), fl.build(nothing)
    same(none.nearest(points, 2), empty.nearest(points, 2))
    same(none.within(points, 9), empty.within(points, 9))
    same(none.pairs(0.1), empty.pairs(0.1))
    same(none.in_box(-9, 9), empty.in_box(-9, 9))
    same(none.along(points, 1), empty.along(points, 1))
    same(forest.pairs(0.1, empty), tree.pairs(0.1, empty))
    same(forest.pairs(0.1, none), tree.pairs(0.1, empty))
    same(none.pairs(0.1, forest), empty.pairs(0.1, tree))
