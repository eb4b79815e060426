"""Points and pairs in the C interface, by ctypes: the answers of Python, bit for bit."""

from __future__ import annotations

import ctypes as c
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from support.c_library import (
    IGNORE,
    CTree,
    DoublePointer,
    Library,
    NearLine,
    PairOptions,
    Point,
    Points,
    pointer,
)

import fastlines as fl

TO = ("surface", "axis")


def points_near(lines: fl.Lines, n: int = 300) -> npt.NDArray[np.float64]:
    """Return points at ends, on lines, near them and far away."""
    rng = np.random.default_rng(3)
    ends = lines.segments[rng.integers(len(lines), size=n)].astype(np.float64)
    s = np.where(rng.random(n) < 0.3, rng.integers(0, 2, n), rng.random(n))[:, None]
    away = rng.normal(size=(n, 3)) * rng.choice([0, 1e-6, 0.01, 0.3, 100], n)[:, None]
    return ends[:, 0] * (1 - s) + ends[:, 1] * s + away


def c_points(points: npt.NDArray[np.float64], **rest: Any) -> Points:
    return Points(len(points), points.ctypes.data_as(DoublePointer), **rest)


def one_point(point: npt.NDArray[np.float64], **rest: Any) -> Point:
    return Point((c.c_double * 3)(*point), **rest)


def assert_same(found: dict[str, npt.NDArray[Any]], expected: Any) -> None:
    for name, values in found.items():
        of_python = getattr(expected, name)
        np.testing.assert_array_equal(values.reshape(of_python.shape), of_python, err_msg=name)


def assert_same_lines(found: list[NearLine], prim: Any, distance: Any, u: Any) -> None:
    np.testing.assert_array_equal([line.prim for line in found], prim)
    np.testing.assert_array_equal(np.array([line.distance for line in found], np.float32), distance)
    np.testing.assert_array_equal(np.array([line.u for line in found], np.float32), u)


@pytest.mark.parametrize("to", TO)
def test_answers_are_those_of_python(library: Library, lines: fl.Lines, to: str) -> None:
    tree, mine, points, radius = library.build(lines), fl.build(lines), points_near(lines), 0.05
    batch, kind = c_points(points, to=TO.index(to)), TO.index(to)
    for k in (1, 4):
        assert_same(tree.nearest_batch(batch, k), mine.nearest(points, k=k, to=to))
    close = mine.nearest(points, max_distance=radius, to=to)
    assert 0 < close.hit.sum() < len(points)
    assert_same(tree.nearest_batch(batch, 1, radius), close)
    within = mine.within(points, radius, to=to)
    assert len(within) > 300
    assert_same(tree.list_within(batch, radius), within)
    np.testing.assert_array_equal(tree.count_within(batch, radius), within.counts)
    radii = np.linspace(0, 0.1, len(points), dtype=np.float32)
    assert_same(tree.list_within(c_points(points, radii=pointer(radii), to=kind), 0), mine.within(points, radii, to=to))

    nearest = mine.nearest(points, k=3, to=to)
    places = nearest.points()
    for i in range(0, len(points), 7):
        point = one_point(points[i])
        found = tree.nearest(point, 3, to=kind)
        assert_same_lines(found, nearest.prim[i], nearest.distance[i], nearest.u[i])
        for place, line in zip(places[i], found, strict=True):
            assert tree.near_place(point, line, kind) == place.tolist()
        assert_same_lines(
            tree.nearest(point, 1, radius, to=kind),
            *([column[i]] if close.hit[i] else [] for column in (close.prim, close.distance, close.u)),
        )
        part = slice(within.offsets[i], within.offsets[i + 1])
        assert_same_lines(tree.within(point, radius, to=kind), within.prim[part], within.distance[part], within.u[part])


def test_points_leave_lines_and_strands_out(library: Library, lines: fl.Lines) -> None:
    tree, mine, points = library.build(lines), fl.build(lines), points_near(lines)
    ignore, strands = np.array([5, -1, 60]), np.array([0, 7, 21])
    given = tuple(a.ctypes.data_as(c.POINTER(c.c_int64)) for a in (ignore, strands))
    left_out = dict(zip((name for name, _ in IGNORE), (given[0], 3, given[1], 3), strict=True))
    expected = mine.nearest(points, k=2, ignore=ignore, ignore_strands=strands)
    assert (expected.prim[:, 0] != mine.nearest(points).prim).any()
    assert_same(tree.nearest_batch(c_points(points, **left_out), 2), expected)
    within = mine.within(points, 0.1, ignore=ignore, ignore_strands=strands)
    assert_same(tree.list_within(c_points(points, **left_out), 0.1), within)
    for i in range(0, len(points), 11):
        found = tree.nearest(one_point(points[i], **left_out), 2)
        assert_same_lines(found, expected.prim[i], expected.distance[i], expected.u[i])


def test_points_are_less_the_offset(library: Library, tmp_path: Path) -> None:
    segments = np.random.default_rng(1).random((50, 2, 3)) + np.array((5e5, 4e6, 0))
    lines = fl.Lines.from_segments(segments, offset="auto")
    mine = fl.build(lines)
    mine.save(tmp_path / "far.flt")
    tree, points = library.load(tmp_path / "far.flt"), segments.mean(axis=1) + 0.01
    expected = mine.nearest(points, k=2)
    assert_same(tree.nearest_batch(c_points(points), 2), expected)
    found = tree.nearest(one_point(points[7]), 2)
    assert_same_lines(found, expected.prim[7], expected.distance[7], expected.u[7])
    assert tree.near_place(one_point(points[7]), found[0]) == expected.points()[7, 0].tolist()
    with pytest.raises(RuntimeError, match="different offsets"):
        tree.pairs(0.1, library.build(lines))


@pytest.mark.parametrize("to", TO)
def test_pairs_are_those_of_python(library: Library, lines: fl.Lines, to: str) -> None:
    tree, mine = library.build(lines), fl.build(lines)
    options = PairOptions(to=TO.index(to))
    expected = mine.pairs(0.02, to=to)
    assert len(expected) > 100
    assert_same(tree.pairs(0.02, options=options), expected)
    options = PairOptions(to=TO.index(to), has_skip_neighbours=1, skip_neighbours=0)
    assert_same(tree.pairs(0.02, options=options), mine.pairs(0.02, skip_neighbours=0, to=to))
    options = PairOptions(to=TO.index(to), skip_strand=1)
    assert_same(tree.pairs(0.02, options=options), mine.pairs(0.02, skip_strand=True, to=to))

    other = fl.Lines.from_segments(lines.segments[::3] + np.float32(0.01))
    tree_of_other: CTree = library.build(other)
    expected = mine.pairs(0.02, fl.build(other), to=to)
    assert len(expected) > 100
    assert_same(tree.pairs(0.02, tree_of_other, PairOptions(to=TO.index(to))), expected)
    assert_same(tree_of_other.pairs(0.02, tree), fl.build(other).pairs(0.02, mine))


def test_a_ring_has_the_neighbours_of_python(library: Library) -> None:
    angle = np.linspace(0, 2 * np.pi, 13)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1).astype(np.float32)
    ring[-1] = ring[0]
    lines = fl.Lines.from_strands([ring, ring[::-1] + np.float32(0.01)])
    tree, mine = library.build(lines), fl.build(lines)
    for skip in (0, 1, 2):
        options = PairOptions(has_skip_neighbours=1, skip_neighbours=skip)
        expected = mine.pairs(0.6, skip_neighbours=skip)
        assert_same(tree.pairs(0.6, options=options), expected)


def test_bad_input_has_a_message(library: Library, lines: fl.Lines) -> None:
    tree, points = library.build(lines), np.zeros((3, 3))
    points[1, 2] = np.nan
    for wrong, call in {
        "point 1 has a coordinate that is not finite": lambda: tree.nearest_batch(c_points(points), 1),
        "a max_distance of -1": lambda: tree.nearest(one_point(points[0]), 1, -1),
        "the point has a radius of -2, which is not a number from 0": lambda: tree.within(one_point(points[0]), -2),
        "unknown fl_to; expected FL_TO_SURFACE or FL_TO_AXIS": lambda: tree.nearest(one_point(points[0]), 1, to=2),
        "there is no line 300": lambda: tree.near_place(one_point(points[0]), NearLine(prim=300)),
        "the pairs have a radius of nan": lambda: tree.pairs(np.nan),
        "those of two trees never are": lambda: tree.pairs(1, tree, PairOptions(skip_strand=1)),
    }.items():
        with pytest.raises(RuntimeError, match=wrong):
            call()


def test_null_pointers_are_refused_by_name(library: Library, lines: fl.Lines) -> None:
    built, made, n, one = library.build(lines), c.c_void_p(), c.c_size_t(1), c.c_float(1)
    tree, point, batch = built.tree, c.byref(one_point(np.zeros(3))), c.byref(c_points(np.zeros((1, 3))))
    room = c.byref(c.create_string_buffer(64))
    calls: list[tuple[str, list[Any], dict[int, str]]] = [
        ("fl_nearest", [tree, point, one, 0, n, room, room], {0: "tree", 1: "point", 5: "lines", 6: "n"}),
        ("fl_within", [tree, point, one, 0, room, n, room], {0: "tree", 1: "point", 4: "lines", 6: "n"}),
        ("fl_count_within", [tree, point, one, 0, room], {0: "tree", 1: "point", 4: "n"}),
        ("fl_get_near_place", [tree, point, room, 0, room], {0: "tree", 1: "point", 2: "line", 4: "place"}),
        ("fl_nearest_batch", [tree, batch, one, n, None, None, None], {0: "tree", 1: "points"}),
        ("fl_count_within_batch", [tree, batch, one, room], {0: "tree", 1: "points", 3: "n"}),
        ("fl_list_within", [tree, batch, one, c.byref(made)], {0: "tree", 1: "points", 3: "lists"}),
        ("fl_find_pairs", [tree, None, one, None, c.byref(made)], {0: "first", 4: "pairs"}),
    ]
    for name, arguments, pointers in calls:
        for place, what in pointers.items():
            with pytest.raises(RuntimeError, match=f"^{what} is NULL"):
                library.call(name, *arguments[:place], None, *arguments[place + 1 :])
    with pytest.raises(RuntimeError, match="points->positions is NULL"):
        library.call("fl_count_within_batch", tree, c.byref(Points(1)), one, room)
    assert library.dll.fl_get_near_lists(None).n_points == library.dll.fl_get_pairs(None).n == 0
    library.dll.fl_free_near_lists(None)
    library.dll.fl_free_pairs(None)
