"""What queries about points refuse, and what they say."""

from __future__ import annotations

import inspect
from functools import partial
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same

import fastlines as fl

SEGMENTS = [[[0.0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1, 0]]]
TREE = fl.build(SEGMENTS)
GEOMETRY = fl.Geometry([fl.Boxes([[[0, 0, 0], [1, 1, 1]]]), fl.Spheres.from_centres([[3, 0, 0]], 1)])
POINTS = np.array([[0.0, 0, 1], [2, 0, 0], [3, 3, 3]])


def changed(row: int, to: Any) -> Any:
    points = POINTS.copy()
    points[row, 0] = to
    return points


@pytest.mark.parametrize("ask", [TREE.nearest, partial(fl.brute_force_points, SEGMENTS)], ids=["tree", "brute force"])
@pytest.mark.parametrize(
    ("points", "how", "words"),
    [
        (changed(1, np.nan), {}, r"1 of 3 points hold NaN or Inf \(row 1\); fix them, or let them miss"),
        (changed(2, -np.inf), {}, r"hold NaN or Inf \(row 2\)"),
        (changed(0, 2e12), {}, r"1 of 3 points are farther from the scene than 1e\+12 \(1e\+12 times .*\(row 0\)"),
        (changed(0, 1e300), {}, r"are farther from the scene"),
        (np.full((3, 3), 1e308), {}, r"3 of 3 points are farther from the scene"),
        (
            POINTS,
            {"max_distance": -1},
            r"have a max_distance that is not a number from 0 up: max_distance = -1, for all",
        ),
        (POINTS, {"max_distance": [1, np.nan, -1]}, r"2 of 3 points have a max_distance .* \(rows 1, 2\)"),
        (
            POINTS,
            {"max_distance": [1, 2]},
            r"max_distance has shape \(2,\); expected a number, or one for each of the points",
        ),
        (POINTS, {"max_distance": "far"}, "max_distance: a str cannot be read"),
        (POINTS, {"k": -1}, "k=-1; expected a whole number, 0 or more"),
        (POINTS, {"k": 1.5}, "k=1.5; expected a whole number"),
        (POINTS, {"to": "middle"}, "to='middle' is not a choice: use 'axis' or 'surface'"),
        (POINTS, {"invalid": "ignore"}, "invalid='ignore' is not a choice"),
        (POINTS, {"parts": 0}, "parts=0 names parts of a Geometry, and this is Lines"),
        (POINTS, {"ignore": 7}, "ignore names 7; there are 2 primitives"),
        (
            POINTS,
            {"ignore": [[1], [0]]},
            r"ignore has shape \(2, 1\); .* numbers for each point, .* of the points \(3,\)",
        ),
        (POINTS, {"ignore_strands": 9}, "ignore_strands names 9; there are"),
        (POINTS[:, :2], {}, r"points have shape \(3, 2\); expected \(…, 3\): x y z of each point"),
        (3.0, {}, r"points have shape \(\)"),
        ("here", {}, "points: a str cannot be read as an array of numbers"),
        ([[0, 0, 0], [1, 1]], {}, "points: a list cannot be read as an array of numbers: its parts differ in length"),
        (np.ma.masked_invalid(changed(1, np.nan)), {}, "points hold masked values"),
    ],
)
def test_what_nearest_refuses(ask: Any, points: Any, how: dict[str, Any], words: str) -> None:
    with pytest.raises(fl.InputError, match=words):
        ask(points, **how)


@pytest.mark.parametrize("query", ["within", "count_within"])
@pytest.mark.parametrize(
    ("radius", "words"),
    [
        (-1, r"3 of 3 points have a radius that is not a number from 0 to 1e\+12 .*: radius = -1, for all"),
        (np.nan, "radius = nan, for all"),
        (np.inf, "radius = inf, for all"),
        ([0, 1, 2e12], r"1 of 3 points have a radius .* \(row 2\)"),
        ([[1, 2]], r"radius has shape \(1, 2\); expected a number, or one for each of the points \(3,\)"),
    ],
)
def test_what_within_refuses(query: str, radius: Any, words: str) -> None:
    for ask in (getattr(TREE, query), partial(fl.brute_force_points, SEGMENTS, query=query)):
        with pytest.raises(fl.InputError, match=words):
            ask(POINTS, radius)


def test_errors_about_one_point_repeat_its_value() -> None:
    with pytest.raises(fl.InputError, match=r"1 of 1 points have a radius .*\(row 0\): radius = -2"):
        TREE.within([0, 0, 0], -2)


def test_within_needs_a_radius() -> None:
    with pytest.raises(TypeError, match="radius"):
        TREE.within(POINTS)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"nearest\(\) got an unexpected keyword argument 'radius'"):
        TREE.nearest(POINTS, radius=1)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"query": "first_hit"}, "query='first_hit' is not a choice: use 'nearest' or 'within' or 'count_within'"),
        ({"query": "within"}, "query='within' needs radius="),
        ({"radius": 1}, "query='nearest' takes max_distance= instead of radius="),
        ({"query": "within", "radius": 1, "k": 2}, "k=2 is for query='nearest', this is 'within'; leave it out"),
        ({"query": "count_within", "radius": 1, "max_distance": 2}, "max_distance=2 is for query='nearest'"),
    ],
)
def test_what_brute_force_refuses(how: dict[str, Any], words: str) -> None:
    with pytest.raises(fl.InputError, match=words):
        fl.brute_force_points(SEGMENTS, POINTS, **how)


def test_points_are_numbers_of_any_kind() -> None:
    expected = TREE.nearest(POINTS, 2)
    for points in (
        POINTS.tolist(),
        POINTS.astype(np.float32),
        POINTS.astype(int),
        np.asfortranarray(POINTS),
        POINTS[::-1][::-1],
    ):
        assert_same(TREE.nearest(points, 2), expected)
    readonly = POINTS.copy()
    readonly.flags.writeable = False
    assert_same(TREE.within(readonly, np.float64(1.5)), TREE.within(POINTS, [1.5] * 3))
    assert_same(
        TREE.nearest(POINTS[:, None], 2, max_distance=np.full((3, 1), 1.5)).prim[:, 0],
        TREE.nearest(POINTS, 2, max_distance=1.5).prim,
    )


def test_a_point_is_not_rounded_before_it_is_in_the_frame() -> None:
    """Float32 would round it to the line."""
    lines = fl.Lines.from_segments(np.float32([[[1024, 0, 0], [1024, 1, 0]]]))
    found = fl.build(lines).nearest([1024 + 1e-5, 0.5, 0])
    np.testing.assert_allclose(found.distance, 1e-5, rtol=1e-6)
    assert fl.build(lines).within([1024 + 1e-5, 0.5, 0], 0.9e-5).prim.size == 0


def test_signatures_show_all_options() -> None:
    shared = {"to": None, "ignore": None, "ignore_strands": None, "parts": None, "invalid": "error", "progress": False}
    for query in (fl.Tree.nearest, fl.Tree.within, fl.Tree.count_within, fl.brute_force_points):
        parameters = inspect.signature(query).parameters
        assert {name: parameters[name].default for name in shared} == shared
        assert "radius_name" not in parameters
    assert list(inspect.signature(fl.Tree.nearest).parameters)[:3] == ["self", "points", "k"]


def test_a_large_distance_is_no_limit() -> None:
    for largest in (np.inf, 1e30, 3e38):
        assert TREE.nearest(POINTS, max_distance=largest).hit.all()
    far = TREE.nearest([1e11, 0, 0])
    assert (far.prim, far.distance) == (0, np.float32(1e11))


def test_parts_of_a_geometry() -> None:
    tree = fl.build(GEOMETRY)
    assert tree.nearest(POINTS, parts=1).part.tolist() == [1, 1, 1]  # type: ignore[union-attr]
    assert tree.count_within(POINTS, 9, parts=[]).tolist() == [0, 0, 0]
    with pytest.raises(fl.InputError, match="parts names 2; there are 2 parts"):
        tree.nearest(POINTS, parts=2)
