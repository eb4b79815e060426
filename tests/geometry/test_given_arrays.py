"""Shapes and values of what is given: what is just refused, and what is just taken."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import fastlines as fl
from fastlines.arrays import is_on_device

SEGMENTS = np.arange(12.0).reshape(2, 2, 3)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: fl.Lines.from_segments(np.zeros((0, 1, 3))), r"segments have shape \(0, 1, 3\); expected \(n, 2, 3\)"),
        (lambda: fl.Lines.from_segments(np.zeros((0, 5))), r"segments have shape \(0, 5\); expected \(n, 2, 3\)"),
        (lambda: fl.Lines.from_segments(SEGMENTS, strands=[1]), r"strands have shape \(1,\); expected \(2,\), one for"),
        (
            lambda: fl.Lines(np.asfortranarray(SEGMENTS, np.float32)),
            r"Lines take a contiguous float32 array of shape \(n, 2, 3\)",
        ),
        (
            lambda: fl.Triangles(np.zeros((2, 3, 3)), corner_attributes={"a": np.zeros((2, 2))}),
            r"a has shape \(2, 2\); expected \(2, 3, …\): a value for each corner",
        ),
        (
            lambda: fl.Geometry([fl.Geometry([fl.Lines.from_segments(SEGMENTS)])]),
            "part 0 is a Geometry; expected one of",
        ),
        (lambda: fl.build(SEGMENTS, frame=[[-1.5e30] * 3, [1] * 3]), "frame holds NaN, Inf or a coordinate beyond"),
    ],
)
def test_other_shapes_and_values_are_refused(make: Callable[[], object], said: str) -> None:
    with pytest.raises(fl.InputError, match=said):
        make()


def test_a_frame_may_be_as_large_as_coordinates() -> None:
    assert fl.build(SEGMENTS, frame=[[-1e30] * 3, [1e30] * 3]).n_nodes > 0


def test_a_radius_may_be_a_trillion_sizes() -> None:
    line = [[[0, 0, 0], [1, 0, 0]]]
    assert fl.build(fl.Lines.from_segments(line, radius=0.999e12)).any_hit([0, 0, 0], [0, 0, 1])
    with pytest.raises(fl.InputError, match=r"1\.001e\+12, is more than 1e\+12 times the size"):
        fl.build(fl.Lines.from_segments(line, radius=1.001e12)).any_hit([0, 0, 0], [0, 0, 1])


@pytest.mark.parametrize(("kind", "expected"), [(1, False), (2, True)])
def test_where_an_array_is(kind: int, expected: bool) -> None:
    """DLPack numbers the kinds of devices: 1 is the CPU, and 2 is CUDA."""

    class Array:
        def __dlpack_device__(self) -> tuple[int, int]:
            return kind, 0

    assert is_on_device(Array()) is expected
