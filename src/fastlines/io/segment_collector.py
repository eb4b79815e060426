"""Segments of points that are read piece by piece, so that the points of a file are never in memory all at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..arrays import COORDINATE_LIMIT, AnyArray, IntArray, is_far, neighbours, warn_of_rounding
from ..geometry.lines import Lines
from ..geometry.offsets import NO_OFFSET, OFFSET, Offset, check_offset, rounded_middle
from ..support.distinct import distinct
from ..support.immutable import own
from .source import Source

#: About how many points are joined at a time.
_PART = 1 << 16


class SegmentCollector:
    """Joins points to lines, as `Lines.from_points` does.

    Parameters
    ----------
    n_points : int
        The most points that may come. Memory is taken as they come.
    values : mapping of str to array of no rows, optional
        The types and shapes of what is known of each point.
    offset : three numbers
        Subtracted from points in float64.
    """

    def __init__(self, n_points: int, values: Mapping[str, AnyArray] | None = None, offset: Offset = NO_OFFSET) -> None:
        self._offset = offset
        self._segments = np.empty((n_points, 2, 3), np.float32)
        self._values = {
            name: np.empty((n_points, 2, *array.shape[1:]), array.dtype) for name, array in (values or {}).items()
        }
        self._counts = [np.empty(0, np.int64)]
        self._n_segments = 0
        self._is_rounded = False

    def add(self, points: npt.NDArray[np.floating], counts: IntArray, values: Mapping[str, AnyArray]) -> None:
        """Add strands: their points, (m, 3), one strand after the other, and how many points each has."""
        sizes = counts[counts > 0]
        start, stop = self._n_segments, self._n_segments + int(np.maximum(sizes - 1, 1).sum())
        if self._offset != NO_OFFSET:
            points = points - np.array(self._offset)
        self._is_rounded |= points.dtype.itemsize > 4
        with np.errstate(over="ignore"):  # infinite coordinates are reported with their rows
            self._segments[start:stop] = neighbours(points.astype(np.float32, copy=False), sizes)
        for name, array in values.items():
            self._values[name][start:stop] = neighbours(array, sizes)
        self._counts.append(counts)
        self._n_segments = stop

    def add_in_parts(self, points: npt.NDArray[np.floating], counts: IntArray, values: Mapping[str, AnyArray]) -> None:
        """Add strands as `add` does, some at a time, so that what is made on the way stays small."""
        offsets = np.append(0, np.cumsum(counts))
        cuts = distinct(np.append(np.searchsorted(offsets, np.arange(0, len(points), _PART)), len(counts)))
        for first, last in pairwise(cuts):
            part = slice(offsets[first], offsets[last])
            self.add(points[part], counts[first:last], {name: array[part] for name, array in values.items()})

    @property
    def may_be_coarse(self) -> bool:
        """Whether points were rounded to float32, and are so far from zero that this may matter."""
        return self._is_rounded and is_far(self._segments[: self._n_segments].reshape(-1, 3))

    def lines(self, invalid: str) -> Lines:
        """Return the lines; nothing can be added any more."""
        counts = np.concatenate(self._counts)
        for array in (self._segments, *self._values.values()):
            array.resize((self._n_segments, *array.shape[1:]), refcheck=False)
        strands = np.repeat(np.flatnonzero(counts > 0), np.maximum(counts[counts > 0] - 1, 1))
        values = {name: own(array) for name, array in self._values.items()}
        made = Lines.from_segments(own(self._segments), strands=own(strands), end_attributes=values, invalid=invalid)
        return made if self._offset == NO_OFFSET else replace(made, metadata={OFFSET: self._offset})


def offset_for(source: Source, parts: Iterable[npt.NDArray[np.floating]]) -> Offset:
    """Return the offset that was asked for, of points that come in parts."""
    wanted = check_offset(source.offset)
    if not isinstance(wanted, str):
        return wanted
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for points in parts:
        usable = points[(np.abs(points) <= COORDINATE_LIMIT).all(axis=1)]
        low, high = (
            np.minimum(low, usable.min(axis=0, initial=np.inf)),
            np.maximum(high, usable.max(axis=0, initial=-np.inf)),
        )
    return rounded_middle(low, high) if (low <= high).all() else NO_OFFSET


def warn_if_coarse(parts: Iterable[npt.NDArray[np.floating]], offset: Offset) -> None:
    """Warn if float32 rounds points noticeably, which are given in parts and less an offset."""
    points = np.concatenate(list(parts)) - np.array(offset)
    with np.errstate(over="ignore"):
        rounded = points.astype(np.float32)
    warn_of_rounding(points, rounded)
