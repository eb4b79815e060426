"""Cubic curves: bases from their definitions, points and tangents, and bad input."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from support.curves import CUSP, QUARTER, STRAIGHT, bernstein, curves_of, random_curves

import fastlines as fl

U = np.linspace(0, 1, 9)


def de_boor(w: np.ndarray, t: float) -> np.ndarray:
    """Return the point at 3 + t of a cubic B-spline with the knots 0, 1, 2, …, 7, from its four points."""
    points, x = list(w), 3 + t
    for level in range(1, 4):
        for j in range(3, level - 1, -1):
            along = (x - j) / (4 - level)
            points[j] = (1 - along) * points[j - 1] + along * points[j]
    return points[3]


def pyramid(w: np.ndarray, t: float) -> np.ndarray:
    """Return the point at 1 + t of the Catmull-Rom spline through four points at 0, 1, 2, 3 (Barry, Goldman 1988)."""
    x = 1 + t
    a = [(k + 1 - x) * w[k] + (x - k) * w[k + 1] for k in range(3)]
    b = [((k + 2 - x) * a[k] + (x - k) * a[k + 1]) / 2 for k in range(2)]
    return (2 - x) * b[0] + (x - 1) * b[1]


def hermite(p0: np.ndarray, p1: np.ndarray, m0: np.ndarray, m1: np.ndarray, t: float) -> np.ndarray:
    return (2 * t**3 - 3 * t**2 + 1) * p0 + (t**3 - 2 * t**2 + t) * m0 + (3 * t**2 - 2 * t**3) * p1 + (t**3 - t**2) * m1


DEFINITION = {"bspline": de_boor, "catmull-rom": pyramid}
RNG = np.random.default_rng(4)
POINTS, TANGENTS = RNG.normal(size=(11, 3)), RNG.normal(size=(11, 3))
RADII = RNG.uniform(0.5, 1, 11)
COUNTS = [6, 0, 5]


@pytest.mark.parametrize("wrap", ["nonperiodic", "periodic", "pinned"])
@pytest.mark.parametrize("basis", ["bspline", "catmull-rom"])
def test_splines_are_those_of_their_definition(basis: str, wrap: str) -> None:
    curves = fl.Curves.from_strands(POINTS, COUNTS, basis=basis, wrap=wrap, radius=RADII)
    rows = np.column_stack([POINTS, RADII])
    row = 0
    for strand, values in ((0, rows[:6]), (2, rows[6:])):
        if wrap == "periodic":
            values = np.concatenate([values, values[:3]])
        elif wrap == "pinned":
            values = np.concatenate([[2 * values[0] - values[1]], values, [2 * values[-1] - values[-2]]])
        for first in range(len(values) - 3):
            expected = np.array([DEFINITION[basis](values[first : first + 4], t) for t in U])
            got = curves.evaluate(row, U)
            assert np.allclose(got.points, expected[:, :3], atol=1e-6)
            assert np.allclose(got.radius, expected[:, 3], atol=1e-6)
            assert curves.strands[row] == strand
            row += 1
    assert row == len(curves) == {"nonperiodic": 5, "periodic": 11, "pinned": 9}[wrap]


@pytest.mark.parametrize("wrap", ["nonperiodic", "periodic", "pinned"])
def test_hermite_curves_are_those_of_their_definition(wrap: str) -> None:
    curves = fl.Curves.from_strands(POINTS, COUNTS, basis="hermite", wrap=wrap, radius=RADII, tangents=TANGENTS)
    row = 0
    for ids in (np.arange(6), np.arange(6, 11)):
        pairs = list(zip(ids, np.roll(ids, -1), strict=True))
        for i, j in pairs if wrap == "periodic" else pairs[:-1]:
            got = curves.evaluate(row, U)
            expected = [hermite(POINTS[i], POINTS[j], TANGENTS[i], TANGENTS[j], t) for t in U]
            assert np.allclose(got.points, expected, atol=1e-6)
            assert np.allclose(got.radius, RADII[i] + U * (RADII[j] - RADII[i]), atol=1e-6)
            assert np.allclose(got.tangents[0], TANGENTS[i] / np.linalg.norm(TANGENTS[i]), atol=1e-6)
            assert np.allclose(got.tangents[-1], TANGENTS[j] / np.linalg.norm(TANGENTS[j]), atol=1e-6)
            row += 1
    assert row == len(curves)


@pytest.mark.parametrize("wrap", ["nonperiodic", "periodic", "pinned"])
def test_bezier_strands_share_points(wrap: str) -> None:
    points = POINTS[:10] if wrap != "periodic" else POINTS[:9]
    counts = [3, 6] if wrap == "periodic" else [10]
    curves = fl.Curves.from_strands(points, counts, wrap=wrap, radius=RADII[: len(points)])
    ids = (
        [[0, 1, 2, 0], [3, 4, 5, 6], [6, 7, 8, 3]] if wrap == "periodic" else [[0, 1, 2, 3], [3, 4, 5, 6], [6, 7, 8, 9]]
    )
    assert np.array_equal(curves.control, points[ids].astype(np.float32))
    assert np.array_equal(curves.radius, RADII[ids].astype(np.float32))
    assert np.allclose(curves.evaluate(1, U).points, bernstein(points[ids], U)[1], atol=1e-6)


@pytest.mark.parametrize("basis", ["bspline", "catmull-rom"])
def test_pinned_strands_begin_and_end_at_their_points(basis: str) -> None:
    points = np.array([[1, 0, 3], [1e9, 1, 2], [5, -7e8, 0], [0.1, 0.2, 0.3]], np.float32)
    for n in (2, 3, 4):
        curves = fl.Curves.from_strands(points[:n], [n], basis=basis, wrap="pinned")
        assert len(curves) == n - 1
        assert np.array_equal(curves.control[0, 0], points[0])
        assert np.array_equal(curves.control[-1, 3], points[n - 1])


def test_values_of_points_become_those_of_the_ends() -> None:
    given = {"x": POINTS[:, 0], "colour": POINTS, "id": np.arange(11), "name": np.array(list("abcdefghijk"))}
    made = {
        basis: fl.Curves.from_strands(
            POINTS, [11], basis=basis, attributes=given, tangents=TANGENTS if basis == "hermite" else None
        )
        for basis in ("bspline", "catmull-rom", "hermite")
    } | {"bezier": fl.Curves.from_strands(POINTS[:10], [10], attributes={k: v[:10] for k, v in given.items()})}
    for curves in made.values():
        assert np.allclose(curves.end_attributes["colour"], curves.control[:, [0, 3]], atol=1e-6)
        assert np.allclose(curves.attributes["x"], curves.control[:, 0, 0], atol=1e-6)
    assert made["bezier"].end_attributes["id"].tolist() == [[0, 3], [3, 6], [6, 9]]
    assert made["bspline"].end_attributes["name"].tolist()[:2] == [["b", "c"], ["c", "d"]]
    assert made["catmull-rom"].attributes["id"].tolist() == list(range(1, 9))
    assert made["hermite"].attributes["id"].tolist() == list(range(10))


def test_the_largest_radius_is_that_of_the_curve() -> None:
    radius = np.random.default_rng(9).uniform(0, 1, (50, 4))
    radius[:3] = [[0, 0, 0, 0], [1, 1, 1, 1], [0, 1, 1, 0]]
    sampled = bernstein(radius.astype(np.float32), np.linspace(0, 1, 5001)).max(axis=1)
    for coefficients, expected in zip(radius, sampled, strict=True):
        curves = fl.Curves.from_bezier(STRAIGHT[None], coefficients[None])
        assert curves.max_radius == pytest.approx(expected, abs=1e-7)
    assert curves_of("no radius").max_radius == 0


def test_tangents_where_a_curve_stands_still() -> None:
    curves = fl.Curves.from_bezier(
        [QUARTER[[0, 0, 2, 3]], QUARTER[[0, 1, 3, 3]], QUARTER[[0, 0, 0, 3]], CUSP, [[1] * 3] * 4]
    )
    got = curves.evaluate([0, 1, 2, 2, 3, 4], [0, 1, 0, 1, 0.5, 0.5]).tangents

    def unit(vector: np.ndarray) -> np.ndarray:
        return vector / np.linalg.norm(vector)

    expected = [unit(QUARTER[2] - QUARTER[0]), unit(QUARTER[3] - QUARTER[1])] + [unit(QUARTER[3] - QUARTER[0])] * 2
    assert np.allclose(got[:4], expected, atol=1e-6)
    assert np.allclose(got[4], [0, -1, 0], atol=1e-6)  # on the way back from the cusp
    assert np.isnan(got[5]).all()
    forward = (curves.evaluate(1, 0.301).points - curves.evaluate(1, 0.3).points) / 1e-3
    assert np.allclose(curves.evaluate(1, 0.3005).tangents, unit(forward), atol=1e-5)


def test_radii_of_every_shape() -> None:
    control = np.tile(STRAIGHT, (2, 1, 1))
    for radius, expected in (
        (0.5, [[0.5] * 4] * 2),
        ([0.5, 1], [[0.5] * 4, [1] * 4]),
        ([[0, 3], [1, 1]], [[0, 1, 2, 3], [1] * 4]),
        ([[1, 2, 3, 4], [5, 6, 7, 8]], [[1, 2, 3, 4], [5, 6, 7, 8]]),
    ):
        assert fl.Curves.from_bezier(control, radius).radius.tolist() == expected


def test_curves_are_immutable_and_pickle() -> None:
    control = np.asarray(random_curves()[0], np.float32)
    curves = fl.Curves(control, attributes={"a": np.arange(40)}, up="z", tolerance=1)
    control[:] = 0
    assert curves.control.any()
    assert not curves.control.flags.writeable
    assert not curves.pieces.begin.flags.writeable
    assert copy.deepcopy(curves) is curves
    for again in (pickle.loads(pickle.dumps(curves)), replace(curves)):
        assert np.array_equal(again.control, curves.control)
        assert not again.control.flags.writeable
        assert (again.up, again.tolerance, again.pieces.lines.up) == ("z", 1.0, "z")
        assert isinstance(again.tolerance, float)
        assert again.attributes["a"].tolist() == list(range(40))
    pieces = pickle.loads(pickle.dumps(curves.pieces))
    assert np.array_equal(pieces.lines.segments, curves.pieces.lines.segments)
    assert repr(pieces) == f"<Pieces: {len(pieces)} of 40 curves>"
    assert repr(curves) == "<Curves: 40 curves, a>"
    strand = fl.Curves.from_strands(POINTS, [11], basis="bspline", radius=1)
    assert repr(strand) == "<Curves: 8 curves, 1 strand, radius>"
    assert strand.n_strands == 1
    assert set(strand.pieces.lines.strands) == {0}


def test_no_curves() -> None:
    for curves in (
        fl.Curves.from_bezier([], 0.5),
        fl.Curves.from_strands([], [], radius=1),
        fl.Curves.from_strands([], [0, 0], basis="bspline"),
    ):
        assert len(curves) == len(curves.pieces) == 0
        assert curves.pieces.first.tolist() == [0]
        assert (curves.bounds[0] > curves.bounds[1]).all()
        assert curves.max_radius == 0
        assert len(curves.evaluate([], []).points) == 0
        assert len(curves.locate([], [])[0]) == 0


NAN_ROW = np.array([[0, 0, 0], [1, 0, 0], [2, np.nan, 0], *np.arange(24).reshape(8, 3)], float)


def test_invalid_curves_can_be_skipped() -> None:
    control = random_curves(6)[0]
    control[1, 2, 0], control[3, 0, 0] = np.nan, 2e30
    values = np.arange(6)
    assert fl.Curves.from_bezier(control[:1]).strands.tolist() == [-1]
    made = fl.Curves.from_bezier(control, [1, 1, 1, 1, -1, 1], strands=values, attributes={"a": values}, invalid="skip")
    assert made.skipped.tolist() == [1, 3, 4]
    assert made.rows.tolist() == made.strands.tolist() == made.attributes["a"].tolist() == [0, 2, 5]
    assert repr(made) == "<Curves: 3 curves, 3 strands, radius, a, 3 skipped>"
    spline = fl.Curves.from_strands(NAN_ROW, [11], basis="catmull-rom", radius=[1] * 10 + [-1], invalid="skip")
    assert spline.skipped.tolist() == [0, 1, 2, 7]
    assert np.isfinite(spline.control).all()


F32 = np.zeros((1, 4, 3), np.float32)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: fl.Curves.from_bezier(np.zeros((2, 3, 3))), r"control has shape \(2, 3, 3\); expected \(n, 4, 3\)"),
        (lambda: fl.Curves.from_bezier("a"), "control.*cannot be read as an array of numbers"),
        (lambda: fl.Curves.from_bezier(NAN_ROW[None, :4]), r"1 of 1 curves hold NaN, Inf.*row 0.*invalid='skip'"),
        (lambda: fl.Curves.from_bezier(F32 + np.inf), "1 of 1 curves hold NaN, Inf"),
        (lambda: fl.Curves.from_bezier(np.full((1, 4, 3), 1e300)), r"a coordinate beyond 1e\+30 \(row 0\)"),
        (
            lambda: fl.Curves.from_bezier(F32, -1),
            r"radius: 1 of 1 curves have one that is not from 0 to 1e\+30 \(row 0\)",
        ),
        (lambda: fl.Curves.from_bezier(F32, [[1, 1, -1, 1]]), "radius: 1 of 1 curves"),
        (lambda: fl.Curves.from_bezier(F32, [np.nan]), "radius: 1 of 1 curves"),
        (lambda: fl.Curves.from_bezier(F32, [1, 2]), r"radius has shape \(2,\); expected one number, or \(1,\)"),
        (lambda: fl.Curves.from_bezier(F32, strands=[1, 2]), r"strands have shape \(2,\); expected \(1,\)"),
        (lambda: fl.Curves.from_bezier(F32, attributes={"a": [1, 2]}), "a has shape.*each of 1 curves"),
        (lambda: fl.Curves.from_bezier(F32, attributes=[1]), "attributes are a list; expected a mapping"),
        (lambda: fl.Curves.from_bezier(F32, attributes={"a": [1]}, end_attributes={"a": [[1, 2]]}), "'a' is in attrib"),
        (lambda: fl.Curves.from_bezier(F32, end_attributes={"a": [1]}), r"a: .*expected an array of shape \(1, 2, …\)"),
        (lambda: fl.Curves.from_bezier(F32, tolerance=0), "tolerance=0; expected a length above 0"),
        (lambda: fl.Curves.from_bezier(F32, tolerance=np.nan), "tolerance=nan; expected a length above 0"),
        (lambda: fl.Curves.from_bezier(F32, up="w"), "up='w' is not a choice"),
        (lambda: fl.Curves.from_bezier(F32, invalid="drop"), "invalid='drop' is not a choice"),
        (lambda: fl.Curves([[0]]), r"Curves take a contiguous float32 array of shape \(n, 4, 3\), not a list"),
        (
            lambda: fl.Curves(F32, np.ones(1, np.float32)),
            r"radius: an array of float32 of shape \(1,\); Curves of 1 take",
        ),
        (lambda: fl.Curves(F32, -np.ones((1, 4), np.float32)), r"radius: 1 of 1 curves \(row 0\) have coefficients"),
        (lambda: fl.Curves(F32 + np.nan), "1 of 1 curves hold NaN"),
        (lambda: fl.Curves(F32, skipped=np.array([1, 0])), "skipped are not rising rows"),
        (lambda: fl.Curves(F32, skipped=np.array([-1, 1])), "skipped are not rising rows of the 3 that were given"),
        (lambda: fl.Curves(F32, skipped=np.array([2])), "skipped are not rising rows"),
        (lambda: fl.Curves(F32, skipped=np.array([0, 0])), "skipped are not rising rows"),
        (lambda: fl.Curves.from_strands(POINTS, [11]), r"1 of 1 counts do not fit basis='bezier'.*is 11.*4, 7, 10, …"),
        (
            lambda: fl.Curves.from_strands(POINTS, [3, 8], wrap="periodic"),
            r"\(row 1; the first is 8\); expected 3, 6, 9, …",
        ),
        (
            lambda: fl.Curves.from_strands(POINTS, [8, 3], basis="bspline"),
            r"\(row 1; the first is 3\); expected 4 or more",
        ),
        (lambda: fl.Curves.from_strands(POINTS, [10, 1], basis="bspline", wrap="pinned"), "is 1.*expected 2 or more"),
        (lambda: fl.Curves.from_strands(POINTS, [10]), "counts of the strands do not add up to the 11 points"),
        (lambda: fl.Curves.from_strands(POINTS, [12, -1]), "counts of the strands do not add up"),
        (lambda: fl.Curves.from_strands(POINTS, [11], basis="nurbs"), "basis='nurbs' is not a choice"),
        (lambda: fl.Curves.from_strands(POINTS, [11], basis="bspline", wrap="closed"), "wrap='closed' is not a choice"),
        (lambda: fl.Curves.from_strands(POINTS, [11], basis="hermite"), "basis='hermite' needs tangents"),
        (lambda: fl.Curves.from_strands(POINTS, [11], basis="bspline", tangents=POINTS), "takes no tangents"),
        (lambda: fl.Curves.from_strands(POINTS, [11], basis="hermite", tangents=POINTS[1:]), "each of 11 points"),
        (
            lambda: fl.Curves.from_strands(POINTS, [11], basis="hermite", tangents=NAN_ROW),
            r"1 of 11 tangents hold NaN.*\(row 2\)",
        ),
        (lambda: fl.Curves.from_strands(NAN_ROW, [11], basis="bspline"), r"1 of 11 points hold NaN.*\(row 2\)"),
        (
            lambda: fl.Curves.from_strands(POINTS, [11], basis="bspline", radius=[1] * 10 + [-1]),
            r"radius: 1 of 11 points have one that is not from 0 to 1e\+30 \(row 10\)",
        ),
        (lambda: fl.Curves.from_strands(POINTS, [11], basis="bspline", radius=[1]), "radius has shape.*11 points"),
        (lambda: fl.Curves.from_strands(POINTS, [11], basis="bspline", radius=np.ones((11, 2))), r"expected \(11,\)"),
        (lambda: fl.Curves.from_strands(POINTS[:, :2], [11]), r"points: the shape is \(11, 2\); expected \(m, 3\)"),
        (
            lambda: fl.Curves.from_strands(
                [[-1e30, 0, 0], [1e30, 0, 0], [1e30, 0, 0], [0, 0, 0]], [4], basis="catmull-rom"
            ),
            r"1 of 1 curves hold NaN, Inf or a coordinate beyond 1e\+30",
        ),
        (lambda: curves_of("random").evaluate(40, 0.5), "curve holds 40; expected whole numbers: 0 to 39"),
        (lambda: curves_of("random").evaluate([-1, 3], 0.5), "curve holds numbers from -1 to 3"),
        (lambda: curves_of("random").evaluate(0.5, 0.5), "curve holds 0.5; expected whole numbers"),
        (
            lambda: curves_of("random").evaluate(0, [0.5, 1.5]),
            "u holds numbers from 0.5 to 1.5; expected numbers from 0",
        ),
        (lambda: curves_of("random").evaluate(0, np.nan), "u holds nan; expected numbers from 0 to 1"),
        (lambda: curves_of("random").evaluate([0, 1], [0.5] * 3), r"curve has shape \(2,\) and u \(3,\)"),
        (lambda: curves_of("random").locate(0, 2), "u holds 2; expected"),
        (lambda: curves_of("straight").parameter(1, 0.5), "piece holds 1; expected whole numbers: 0 to 0"),
        (lambda: curves_of("straight").parameter(0, -0.5), "s holds -0.5; expected numbers from 0 to 1"),
        (lambda: fl.Curves.from_bezier([]).evaluate(0, 0.5), "curve holds 0; expected whole numbers: none"),
    ],
)
def test_input_that_cannot_be_used(call, words: str) -> None:
    with pytest.raises(fl.InputError, match=words):
        call()


def test_rounding_far_from_zero_is_reported() -> None:
    with pytest.warns(fl.PrecisionWarning, match="float32 rounds coordinates"):
        fl.Curves.from_bezier(random_curves()[0] + 1e7)
