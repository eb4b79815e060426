"""Selections of lines, spheres and curves keep all that is known of what they hold; -1 selects nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fastlines as fl
from fastlines.errors import InputError

METADATA = {"grid": {"dimensions": (1, 2, 3)}}
#: The strand 8 is in two places, and one segment is of no strand.
STRANDS = np.array([8, 8, 3, -1, 8])
N = len(STRANDS)
ATTRIBUTES = {"id": np.arange(N), "name": np.array(list("abcde"))}
ENDS = {"fa": np.arange(2 * N).reshape(N, 2) / 7}
FACTS = {"up": "y", "unit": "mm", "metadata": METADATA}
SEGMENTS = np.random.default_rng(1).random((N, 2, 3), np.float32)
CONTROL = np.random.default_rng(2).random((N, 4, 3), np.float32)
SKIPPED = np.array([0, 4])


def kinds() -> dict[str, fl.Lines | fl.Curves]:
    columns = {"strands": STRANDS, "attributes": ATTRIBUTES, "end_attributes": ENDS, "skipped": SKIPPED, **FACTS}
    lines = fl.Lines(SEGMENTS, radius=np.arange(N, dtype="f4"), **columns)
    points = np.repeat(SEGMENTS[:, :1], 2, axis=1)
    return {
        "lines": lines,
        "without radius": replace(lines, radius=None),
        "a radius at each end": replace(lines, radius=np.arange(2 * N, dtype="f4").reshape(N, 2)),
        "spheres": fl.Spheres(points, radius=np.arange(N, dtype="f4"), **columns),
        "curves": fl.Curves(CONTROL, np.arange(4 * N, dtype="f4").reshape(N, 4), tolerance=0.5, **columns),
    }


KINDS = kinds()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("prims", "rows"),
    [
        (slice(1, 3), [1, 2]),
        (slice(None, None, -2), [4, 2, 0]),
        (slice(-2, None), [3, 4]),
        ([True, False, False, True, False], [0, 3]),
        (np.array([4, 0, 0]), [4, 0, 0]),
        ([], []),
        (np.array([2], "u1"), [2]),
        (3, [3]),
        (np.int64(3), [3]),
        (np.zeros(N, bool), []),
    ],
)
def test_prims(kind: str, prims: object, rows: list[int]) -> None:
    whole = KINDS[kind]
    for some in (whole[prims], whole.select(prims=prims)):
        assert type(some) is type(whole)
        assert np.array_equal(some.control_points, whole.control_points[rows])
        assert some.strands.tolist() == STRANDS[rows].tolist()
        assert (some.radius is None) == (whole.radius is None)
        assert whole.radius is None or np.array_equal(some.radius, whole.radius[rows])
        assert {name: values.tolist() for name, values in some.attributes.items()} == {
            "id": rows,
            "name": [str(name) for name in ATTRIBUTES["name"][rows]],
            "fa": ENDS["fa"][rows, 0].tolist(),
        }
        assert some.end_attributes["fa"].tolist() == ENDS["fa"][rows].tolist()
        assert (some.up, some.unit, some.metadata) == ("y", "mm", METADATA)
        assert getattr(some, "tolerance", None) == getattr(whole, "tolerance", None)
        assert some.rows.tolist() == list(range(len(rows)))
        assert not some.control_points.flags.writeable


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("strands", "rows"),
    [
        ([8], [0, 1, 4]),
        ([3, 8], [2, 0, 1, 4]),
        (np.array([8, 3, 3]), [0, 1, 4, 2, 2]),
        (3, [2]),
        ([], []),
        ([True, False], [2]),  # in the order of the numbers of strands: 3, 8
        (np.array([False, True]), [0, 1, 4]),
    ],
)
def test_strands_keep_their_numbers(kind: str, strands: object, rows: list[int]) -> None:
    some = KINDS[kind].select(strands=strands)
    assert some.attributes["id"].tolist() == rows
    assert some.strands.tolist() == STRANDS[rows].tolist()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda lines: lines[[0, -1]], r"prims hold -1 \(row 1\), which stands for a miss .*hits\.prim\[hits\.hit\]"),
        (lambda lines: lines[-1], "prims hold -1"),
        (lambda lines: lines[5], "prims hold 5; expected numbers below 5"),
        (lambda lines: lines[[True, False]], r"a mask of shape \(2,\) was given; expected \(5,\)"),
        (lambda lines: lines[[[0, 1]]], r"prims have shape \(1, 2\)"),
        (lambda lines: lines[[0.5]], "prims have dtype float64; expected whole numbers"),
        (lambda lines: lines["fa"], "prims have dtype <U2"),
        (lambda lines: lines.select(strands=[8, -1]), r"strands hold -1 \(row 1\)"),
        (lambda lines: lines.select(strands=[4, 8, 5]), "strands hold 4, 5; none of the 2 strands has this number"),
        (lambda lines: lines.select(strands=np.ones(5, bool)), r"expected \(2,\), one for each of 2 strands"),
        (lambda lines: lines.select(), "either strands= or prims="),
        (lambda lines: lines.select(strands=[8], prims=[0]), "either strands= or prims="),
    ],
)
def test_what_selects_nothing_is_refused(call, said: str) -> None:
    for geometry in KINDS.values():
        with pytest.raises(InputError, match=said):
            call(geometry)


def test_a_container_is_no_sequence_of_containers() -> None:
    lines = KINDS["lines"]
    with pytest.raises(TypeError, match="not iterable"):
        list(lines)  # type: ignore[call-overload]
    assert np.asarray(lines)[()] is fl.lines(lines) is lines
    assert np.asarray([lines, lines]).shape == (2,)
    for several in ([lines, lines], (lines, [0, 1]), [[lines]]):
        with pytest.raises(InputError):
            fl.lines(several)


def test_the_strands_that_were_hit() -> None:
    lines = fl.Lines.from_strands([[[0, i, 0], [1, i, 0], [2, i, 0]] for i in range(5)])
    hits = fl.build(lines).first_hit([[0.5, i, -1] for i in (3, 9, 1, 3)], [0, 0, 1], 0.1)
    some = lines.select(strands=np.unique(hits.strand[hits.hit]))
    assert some.strands.tolist() == [1, 1, 3, 3]
    assert [strand[0, 1] for strand in some.to_strands()] == [1, 3]
    with pytest.raises(InputError, match="strands hold -1"):
        lines.select(strands=np.unique(hits.strand))


def test_strands_by_their_length() -> None:
    lines = fl.Lines.from_strands([[[0, 0, 0], [i, 0, 0]] for i in range(5)]).select(strands=[4, 1, 3])
    assert lines.strand_lengths().tolist() == [1, 3, 4]
    assert lines.select(strands=lines.strand_lengths() > 2).strands.tolist() == [3, 4]


def test_the_answers_of_a_selection() -> None:
    rng = np.random.default_rng(3)
    lines = fl.Lines.from_strands(rng.random((30, 8, 3)), radius=rng.random((30, 8)) / 50)
    rays = rng.random((200, 3)) * [1, 1, 0] - [0, 0, 1], [0, 0, 1]
    chosen = np.array([20, 3, 11])
    all_of, some = (fl.build(which).all_hits(*rays) for which in (lines, lines.select(strands=chosen)))
    kept = np.isin(all_of.strand, chosen)
    assert np.array_equal(all_of.ray[kept], some.ray)
    np.testing.assert_allclose(all_of.t[kept], some.t, rtol=1e-5)
    assert np.array_equal(all_of.strand[kept], some.strand)


strand_points = st.lists(st.tuples(*[st.integers(0, 2)] * 3), min_size=1, max_size=4)


@given(st.lists(strand_points, max_size=5))
def test_points_and_offsets_are_those_of_the_strands(strands: list[list[tuple[int, int, int]]]) -> None:
    lines = fl.Lines.from_strands(strands)
    twice = [strand * 2 if len(strand) == 1 else strand for strand in strands]
    assert [strand.tolist() for strand in lines.to_strands()] == [[list(at) for at in strand] for strand in twice]
    assert lines.offsets.tolist() == np.cumsum([0, *map(len, twice)]).tolist()
    assert lines.points.tolist() == [list(at) for strand in twice for at in strand]
    again = fl.lines((lines.points, lines.offsets))
    assert np.array_equal(again.segments, lines.segments)
    assert np.array_equal(again.strands, lines.strands)


def test_gaps_and_segments_without_strands_are_polylines_of_their_own() -> None:
    segments = [[[0, 0, 0], [1, 0, 0]], [[2, 0, 0], [3, 0, 0]], [[3, 0, 0], [4, 0, 0]], [[4, 0, 0], [5, 0, 0]]]
    lines = fl.Lines.from_segments(segments, strands=[0, 0, 0, -1])
    assert lines.offsets.tolist() == [0, 2, 5, 7]
    assert lines.at_points(np.arange(8).reshape(4, 2)).tolist() == [0, 1, 2, 4, 5, 6, 7]
    empty = lines[:0]
    assert (empty.offsets.tolist(), empty.points.shape, empty.to_strands()) == ([0], (0, 3), [])


POLYLINES = [np.eye(3), np.eye(3)[:2] + 5, np.zeros((0, 3)), np.ones((1, 3))]
FLAT = np.arange(6) / 4
PARTS = [FLAT[:3], FLAT[3:5], FLAT[5:5], FLAT[5:]]
FLAT_ENDS = [[0, 0.25], [0.25, 0.5], [0.75, 1], [1.25, 1.25]]


@pytest.mark.parametrize(
    "values", [FLAT, FLAT.tolist(), PARTS, [part.tolist() for part in PARTS], np.array([*PARTS, None], object)[:-1]]
)
def test_values_of_strands_are_flat_or_in_one_array_for_each(values: object) -> None:
    lines = fl.Lines.from_strands(POLYLINES, radius=values, attributes={"fa": values})
    assert lines.radius.tolist() == lines.end_attributes["fa"].tolist() == FLAT_ENDS
    assert lines.strands.tolist() == [0, 0, 1, 3]


def test_vectors_of_strands() -> None:
    colors = np.arange(18).reshape(6, 3)
    for given_values in (colors, colors.tolist(), [colors[:3], colors[3:5], colors[5:5], colors[5:]]):
        lines = fl.Lines.from_strands(POLYLINES, radius=0.5, attributes={"color": given_values})
        assert lines.radius.tolist() == [[0.5, 0.5]] * 4
        assert lines.at_points(lines.end_attributes["color"]).tolist() == [*colors.tolist(), colors[5].tolist()]
    # Two strands of three points with three values each.
    square = np.arange(18.0).reshape(2, 3, 3)
    assert fl.Lines.from_strands(square, attributes={"v": square}).end_attributes["v"].shape == (4, 2, 3)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ([[1, 2], [3, 4], [], [5]], "has 2 values for strand 0; expected 3, one for each of its points"),
        ([1, 2, 3, 4], r"has shape \(4,\); expected one row for each of 6 points"),
    ],
)
def test_values_that_do_not_fit_the_strands(values: object, said: str) -> None:
    for more in ({"radius": values}, {"attributes": {"fa": values}}):
        with pytest.raises(InputError, match=said):
            fl.Lines.from_strands(POLYLINES, **more)
