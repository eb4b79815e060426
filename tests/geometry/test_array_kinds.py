"""Arrays and numbers of every kind are taken for what they hold; what they lack is named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fastlines as fl


def fortran(array: Any) -> Any:
    return np.asfortranarray(array)


def strided(array: Any) -> Any:
    return np.repeat(np.asarray(array), 2, axis=0)[::2]


def backwards(array: Any) -> Any:
    return np.ascontiguousarray(np.asarray(array)[::-1])[::-1]


def readonly(array: Any) -> Any:
    array = np.array(array, np.float32)
    array.flags.writeable = False
    return array


def unaligned(array: Any) -> Any:
    array = np.asarray(array, np.float32)
    buffer = np.zeros(array.nbytes + 1, np.uint8)
    view = buffer[1:].view(np.float32).reshape(array.shape)
    view[...] = array
    return view


KINDS: dict[str, Callable[[Any], Any]] = {
    **{dtype: lambda array, dtype=dtype: np.asarray(array, dtype) for dtype in ("f2", "f4", "f8", "g", ">f4", ">f8")},
    **{dtype: lambda array, dtype=dtype: np.asarray(array, dtype) for dtype in ("i1", "i2", "i4", "i8", ">i8")},
    **{call.__name__: call for call in (fortran, strided, backwards, readonly, unaligned)},
    "list": lambda array: np.asarray(array).tolist(),
    "matrix of rows": lambda array: [*np.asarray(array)],
    "subclass": lambda array: np.ma.masked_array(array),
}


@pytest.mark.parametrize("kind", KINDS)
def test_arrays_of_every_kind_are_taken(kind: str) -> None:
    rng = np.random.default_rng(1)
    segments, origins = rng.integers(-50, 51, (40, 2, 3)), rng.integers(-50, 51, (300, 3))
    directions, radius = rng.integers(-3, 4, (300, 3)), rng.integers(1, 9, 300)
    directions[(directions == 0).all(axis=1)] = 1
    expected = fl.brute_force(segments.astype(np.float32), origins, directions, radius)
    assert len(expected) > 300
    given = [KINDS[kind](array) for array in (segments, origins, directions, radius)]
    before = [np.array(array) for array in given]
    tree = fl.build(given[0])
    got = tree.all_hits(*given[1:])
    for name in ("offsets", "prim", "t", "u", "distance"):
        assert getattr(got, name).tobytes() == getattr(expected, name).tobytes()
    for array, copy in zip(given, before, strict=True):
        assert (np.asarray(array) == copy).all(), "the input was changed"


def test_numpy_numbers_are_numbers() -> None:
    """Numbers that come out of arrays are as good as those of Python."""
    settings = fl.Settings(fl.PlaneGrid(np.int64(4)), lookahead=[np.int32(1), np.int64(2)])
    assert settings == fl.Settings(fl.PlaneGrid(4), lookahead=[1, 2])
    assert fl.Cost(np.float32(2), np.int64(1)) == fl.Cost(2.0, 1.0)
    assert fl.Limits(np.int64(8), leaf_size=np.float32(0.5)) == fl.Limits(8, leaf_size=0.5)
    fl.build(np.ones((1, 2, 3)), splits=settings.splits, cost=fl.Cost(np.float32(2)), limits=fl.Limits(np.int64(8)))
    fl.set_num_threads(np.int64(fl.get_num_threads()))
    fl.set_num_threads(None)


@pytest.mark.parametrize("given", [np.zeros((50, 3)), np.zeros((5, 4, 3)), None])
def test_who_has_polylines_is_told_where_they_go(given: Any) -> None:
    with pytest.raises(fl.InputError, match=r"expected \(n, 2, 3\).* Lines.from_strands takes polylines"):
        fl.build(given)


def test_a_strand_of_another_shape_is_named() -> None:
    with pytest.raises(fl.InputError, match=r"strand 1: the shape is \(3, 2\); expected \(m, 3\)"):
        fl.Lines.from_strands([np.zeros((2, 3)), np.zeros((3, 2))])


def test_lines_are_shown_as_one_line() -> None:
    lines = fl.Lines.from_strands([np.zeros((3, 3)), np.ones((4, 3))])
    assert repr(lines) == "<Lines: 5 segments, 2 strands>"
    assert repr(fl.Lines.from_segments(np.zeros((2, 2, 3)), radius=[1, 2])) == "<Lines: 2 segments, radius>"


def test_a_folder_that_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"there is no folder .*nowhere; make it first: '.*lines\.flt'"):
        fl.build([[[0, 0, 0], [1, 0, 0]]]).save(tmp_path / "nowhere" / "lines.flt")


def test_faults_of_rays_are_named_together() -> None:
    tree = fl.build([[[0, 0, 0], [1, 0, 0]]])
    with pytest.raises(fl.InputError, match=r"1 of 2 rays have an origin .* \(row 1\); 1 of 2 .* zero \(row 0\); fix"):
        tree.first_hit([[0, 0, 0], [np.nan, 0, 0]], [[0, 0, 0], [0, 0, 1]], 0.1)


def test_lines_without_strands() -> None:
    ends = np.zeros((3, 2, 3), np.float32)
    lines = fl.Lines(ends)
    assert lines.strands.tolist() == [-1, -1, -1]
    assert (lines.strands.dtype, lines.n_strands) == (np.int64, 0)
    assert not lines.strands.flags.writeable
    with pytest.raises(fl.InputError, match=r"shape \(n, 2, 3\), not a list; Lines.from_segments converts"):
        fl.Lines(ends.tolist())
