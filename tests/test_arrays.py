"""Checks of arguments: what is just allowed and just refused; arrays that are the same as the definition says."""

from __future__ import annotations

import itertools
import re
import sys
import warnings
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines import arrays


@pytest.mark.parametrize(("least", "most"), [(0, 0), (0, 1), (1, 4096), (-3, -1), (5, 5)])
def test_a_count_is_within_both_bounds(least: int, most: int) -> None:
    for value in (least, most, np.int8(least), np.int64(most)):
        assert arrays.count("n", value, least, most) == value
    for value in (least - 1, most + 1, np.int64(most + 1), arrays.LARGEST, arrays.LARGEST + 1):
        with pytest.raises(fl.InputError, match=rf"n=.*expected a whole number, {least} to {most}$"):
            arrays.count("n", value, least, most)


def test_a_count_without_an_upper_bound_fits_the_core() -> None:
    assert arrays.count("n", arrays.LARGEST, 0) == arrays.LARGEST == 2**63 - 1
    with pytest.raises(fl.InputError, match=f"0 to {2**63 - 1}$"):
        arrays.count("n", 2**63, 0)
    with pytest.raises(fl.InputError, match=r"0 or more$"):
        arrays.count("n", -1, 0)


@pytest.mark.parametrize("value", [True, False, 1.0, "1", None, np.float64(1), np.bool_(True), np.array(1)])
def test_what_is_no_whole_number_is_no_count(value: Any) -> None:
    with pytest.raises(fl.InputError, match="whole number"):
        arrays.count("n", value, 0, 2)


def test_a_tile_of_a_forest_of_one_tile(tmp_path: Any) -> None:
    forest = fl.build_forest(np.ones((1, 2, 3)), tmp_path / "forest")
    assert forest.n_tiles == 1
    with pytest.raises(fl.InputError, match="tile=1; expected a whole number, 0 to 0"):
        forest.rebuild(1)


def test_a_number_is_within_both_bounds() -> None:
    for value in (0.5, 2, np.float32(0.5), np.int64(1), np.array(2.0)):
        made = arrays.number("x", value, "0.5 to 2", 0.5, 2.0)
        assert type(made) is float
        assert made == value
    for value in (np.nextafter(0.5, 0), np.nextafter(2.0, 3), np.nan, np.inf, True, "1", None, 1j, np.array([1.0])):
        with pytest.raises(fl.InputError, match=r"x=.*; expected 0\.5 to 2"):
            arrays.number("x", value, "0.5 to 2", 0.5, 2.0)
    assert arrays.number("x", sys.float_info.max, "finite", 0.0) == sys.float_info.max
    with pytest.raises(fl.InputError, match="finite"):
        arrays.number("x", np.inf, "finite", 0.0)
    assert str(arrays.number("x", -0.0, "any", -1.0)) == "0.0"


def test_integers_fit_int64() -> None:
    assert arrays.to_integers(np.array([2**63 - 1], np.uint64), "n").tolist() == [2**63 - 1]
    assert arrays.to_integers([], "n").dtype == np.int64
    assert arrays.to_integers(np.array([], np.uint64), "n").tolist() == []
    for wrong in (np.array([0, 2**63], np.uint64), [1.5], ["a"], [True]):
        with pytest.raises(fl.InputError, match="n h"):
            arrays.to_integers(wrong, "n")


def test_a_column_has_a_row_for_each() -> None:
    assert arrays.column([7, 8], "c", 2, "lines").tolist() == [7, 8]
    assert arrays.column(np.zeros((0, 3)), "c", 0, "lines").shape == (0, 3)
    for wrong in (7, [7], [7, 8, 9], np.float32(1)):
        with pytest.raises(fl.InputError, match="expected one row for each of 2 lines"):
            arrays.column(wrong, "c", 2, "lines")
    with pytest.raises(fl.InputError, match="cannot be read as an array"):
        arrays.column([[1], [1, 2]], "c", 2, "lines")


@pytest.mark.parametrize("dtype", [np.float32, np.uint8, object, "U3"])
@pytest.mark.parametrize("shape", [(), (3,), (2, 2), (0,)])
@pytest.mark.parametrize("sizes", [[], [1], [2], [1, 1], [3, 1, 2], [1, 4], [5, 1], [2, 2, 2]])
def test_neighbours_are_the_rows_that_follow_each_other_in_runs(sizes: list[int], shape: Any, dtype: Any) -> None:
    n = sum(sizes)
    values = np.arange(n * int(np.prod(shape))).reshape(n, *shape).astype(dtype)
    pairs = []
    for end, size in zip(itertools.accumulate(sizes), sizes, strict=True):
        run = values[end - size : end]
        pairs += [(run[0], run[0])] if size == 1 else list(itertools.pairwise(run))
    found = arrays.neighbours(values, np.array(sizes, np.int64))
    assert found.dtype == values.dtype
    assert found.shape == (len(pairs), 2, *shape)
    assert [[np.asarray(end).tolist() for end in pair] for pair in pairs] == found.tolist()
    assert not np.shares_memory(found, values)


def test_the_box_of_points() -> None:
    points = np.array([[1, -2, 3], [-4, 5, 0], [0, 0, 9]], np.float32)
    assert arrays.box_of(points).tolist() == [[-4, -2, 0], [1, 5, 9]]
    assert arrays.box_of(points[:0]).tolist() == [[np.inf] * 3, [-np.inf] * 3]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1.0001e30, -1.0001e30])
def test_each_unusable_coordinate_is_found_alone(bad: float) -> None:
    limit = np.float32(arrays.COORDINATE_LIMIT)
    corners = np.full((6, 2, 3), limit)
    corners[::2] = -limit
    assert not arrays.unusable(corners).any()
    for row, end, axis in np.ndindex(corners.shape):
        wrong = corners.copy()
        wrong[row, end, axis] = bad
        assert np.flatnonzero(arrays.unusable(wrong)).tolist() == [row]
    assert arrays.unusable(corners[:0]).shape == (0,)


def test_texts_are_told_from_numbers() -> None:
    for texts in (np.array(["a"]), np.array(["a", "b"], object), np.array([], object), np.array([["a"]], object)):
        assert arrays.is_text(texts)
    for others in (np.array([1]), np.array(["a", 1], object), np.array([1, "a"], object), np.array([b"a"])):
        assert not arrays.is_text(others)


def test_far_means_that_the_step_of_float32_is_coarse_for_the_scene() -> None:
    # Near x, float32 rounds by up to x · 2^-24. The size of the scene times 2^-18 is allowed.
    for axis, size in itertools.product(range(3), (1.0, 8.0)):
        points = np.zeros((2, 3), np.float32)
        points[:, axis] = 64 * size - size, 64 * size
        assert not arrays.is_far(points)
        assert not arrays.is_far(-points)
        points[:, axis] += np.float32(size / 8)
        assert arrays.is_far(points)
        assert arrays.is_far(-points)
    assert not arrays.is_far(np.zeros((0, 3), np.float32))
    assert not arrays.is_far(np.zeros((1, 3), np.float32))
    assert arrays.is_far(np.ones((1, 3), np.float32))


def test_the_size_of_a_scene_leaves_out_what_is_too_large() -> None:
    points = np.array([[0, 0, 0], [1, 1, 1], [4e30, 0, 0]], np.float32)
    assert arrays.is_far(points)
    assert not arrays.is_far(np.float32([[0, 0, 0], [-1e30, 1, 1], [1e30, 0, 0]]))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("far", [1e6, -1e6])
def test_lost_digits_are_warned_of(axis: int, far: float) -> None:
    points = np.zeros((2, 3))
    points[:, axis] = far, far + 1 / 3
    rounded = points.astype(np.float32)
    lost = np.abs(points - rounded).max()
    text = f"up to {abs(points).max():g}, in a scene of size 0.333333, by up to {lost:.2g};"
    with pytest.warns(fl.PrecisionWarning, match=re.escape(text)):
        arrays.warn_of_rounding(points, rounded)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        arrays.warn_of_rounding(rounded, rounded)  # nothing is lost of what was float32
        arrays.warn_of_rounding(points - points[0], (points - points[0]).astype(np.float32))


def test_a_loss_is_worth_a_warning_from_a_fraction_of_the_size_on() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        arrays.warn_of_loss(2.0**-18, 1.0, 1.0)
        arrays.warn_of_loss(1.0, 1.0, 0.0)  # without a size, no fraction of it
    with pytest.warns(fl.PrecisionWarning, match="by up to 3.8e-06"):
        arrays.warn_of_loss(2.0**-18 * 1.001, 1.0, 1.0)


def test_one_thing_or_several_of_a_kind() -> None:
    assert arrays.sequence("s", 3, int, "numbers") == (3,)
    assert arrays.sequence("s", [3, 4], int, "numbers") == (3, 4)
    for wrong in ([], [3, "a"], ["a", 3], "a", {3}, None):
        with pytest.raises(fl.InputError, match=r"s=.*expected numbers"):
            arrays.sequence("s", wrong, int, "numbers")


def test_errors_name_the_first_rows() -> None:
    bad = np.zeros(20, bool)
    for n, text in ((1, "row 0"), (2, "rows 0, 1"), (5, "rows 0, 1, 2, 3, 4"), (6, "rows 0, 1, 2, 3, 4 and 1 more")):
        bad[:n] = True
        assert arrays.list_rows(bad) == text


def test_masked_values_of_attributes_are_refused() -> None:
    masked = np.ma.masked_array([1.0], [True])
    segments, control = np.zeros((1, 2, 3), np.float32), np.zeros((1, 4, 3), np.float32)
    for make in (
        lambda: fl.Lines(segments, attributes={"a": masked}),
        lambda: fl.Lines(segments, end_attributes={"a": np.ma.stack([masked, masked], axis=1)}),
        lambda: fl.Curves(control, attributes={"a": masked}),
    ):
        with pytest.raises(fl.InputError, match="a hold masked values; fill them"):
            make()
