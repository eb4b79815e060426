"""Segments of strands that are read piece by piece, so that the points of a file are never in memory all at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import COORDINATE_LIMIT, AnyArray, IntArray, neighbours
from ..geometry.lines import Lines
from ..geometry.offsets import NO_OFFSET, OFFSET, Offset, check_offset, rounded_middle
from ..geometry.strand_attributes import with_strand_values
from ..support.distinct import distinct
from ..support.immutable import own
from .rounding import Rounding

#: About how many points are joined at a time.
PART = 1 << 16

NO_STRANDS: IntArray = np.empty(0, np.int64)


class Strands(NamedTuple):
    """Some whole strands of a file.

    Attributes
    ----------
    points : (m, 3) array of floats
        The points of all strands, one strand after the other.
    counts : (k,) int64
        How many points each strand has.
    values : mapping of str to (m, …) array
        What is known of each point.
    per_strand : mapping of str to (k, …) array
        What is known of each strand.
    """

    points: npt.NDArray[np.floating]
    counts: IntArray
    values: Mapping[str, AnyArray]
    per_strand: Mapping[str, AnyArray]

    def split(self, n: int) -> tuple[Strands, Strands]:
        """Return the first n strands, and the others."""
        m = int(self.counts[:n].sum())
        first, second = (
            Strands(
                self.points[rows],
                self.counts[strands],
                {name: array[rows] for name, array in self.values.items()},
                {name: array[strands] for name, array in self.per_strand.items()},
            )
            for rows, strands in ((slice(m), slice(n)), (slice(m, None), slice(n, None)))
        )
        return first, second

    def parts(self) -> Iterator[Strands]:
        """Yield some strands at a time, so that what is made on the way stays small."""
        offsets = np.append(0, np.cumsum(self.counts))
        cuts = distinct(np.append(np.searchsorted(offsets, np.arange(0, len(self.points), PART)), len(self.counts)))
        rest = self
        for n in np.diff(cuts).tolist():
            part, rest = rest.split(n)
            yield part


def lines_of(
    parts: Iterable[Strands],
    like: Strands,
    n_points: int,
    offset: Offset,
    metadata: Mapping[str, Any],
    max_segments: int | None,
    invalid: str,
) -> Iterator[Lines]:
    """Join the points of strands to lines, as `Lines.from_points` does; yield them in chunks.

    Parameters
    ----------
    parts : iterable of Strands
        When it ends, the file is read and checked: the last chunk is yielded then.
    like : Strands
        Without rows: the types and shapes of what is known.
    n_points : int
        The most points that may come.
    offset : three numbers
        Subtracted from points in float64.
    metadata : mapping
        What else is known of the lines as a whole.
    max_segments : int or None
        The most segments of a chunk, unless it is one strand. With None, all lines are one chunk.
    """
    rounding, facts = Rounding(), {} if offset == NO_OFFSET else {OFFSET: offset}
    facts |= metadata
    n_rows = n_points if max_segments is None else min(n_points, max_segments)
    chunk = _Chunk(like, n_rows, offset, rounding, facts)
    n_strands = n_numbered = 0
    for part in parts:
        rest = part
        while len(rest.counts):
            n = len(rest.counts) if max_segments is None else chunk.n_fitting(rest.counts, max_segments)
            if n:
                taken, rest = rest.split(n)
                chunk.add(taken)
                continue
            made = chunk.lines(n_strands - n_numbered, invalid)
            n_strands += chunk.n_strands
            n_numbered += int(made.strands.max(initial=-1)) + 1
            chunk = _Chunk(like, n_rows, offset, rounding, facts)
            yield made
            del made
    rounding.warn()
    yield chunk.lines(n_strands - n_numbered, invalid)


class _Chunk:
    """The segments of the strands of one chunk."""

    def __init__(
        self, like: Strands, n_rows: int, offset: Offset, rounding: Rounding, metadata: Mapping[str, Any]
    ) -> None:
        self._offset, self._rounding, self._metadata = offset, rounding, metadata
        self._segments = np.empty((n_rows, 2, 3), np.float32)
        self._values = {
            name: np.empty((n_rows, 2, *array.shape[1:]), array.dtype) for name, array in like.values.items()
        }
        self._per_strand = {name: [array] for name, array in like.per_strand.items()}
        self._counts = [like.counts]
        self._n_segments = 0
        self.n_strands = 0

    def n_fitting(self, counts: IntArray, max_segments: int) -> int:
        """Return how many of the next strands belong to the chunk: also one that is too long, if it is the first."""
        ends = np.cumsum(_n_segments(counts))
        n = int(np.searchsorted(ends, max_segments - self._n_segments, "right"))
        return n if n or self._n_segments else int(np.searchsorted(ends, 0, "right")) + 1

    def add(self, strands: Strands) -> None:
        """Add strands."""
        points, sizes = strands.points, strands.counts[strands.counts > 0]
        start, stop = self._n_segments, self._n_segments + int(_n_segments(sizes).sum())
        if stop > (n_rows := len(self._segments)):
            self._resize(max(stop, n_rows + n_rows // 2))
        self._segments[start:stop] = neighbours(self._rounding.to_float32(points, self._offset), sizes)
        for name, array in strands.values.items():
            self._values[name][start:stop] = neighbours(array, sizes)
        for name, array in strands.per_strand.items():
            self._per_strand[name].append(array)
        self._counts.append(strands.counts)
        self._n_segments = stop
        self.n_strands += len(strands.counts)

    def lines(self, first_strand: int, invalid: str) -> Lines:
        """Return the lines, whose strands are counted from a number on; nothing can be added any more."""
        counts = np.concatenate(self._counts)
        self._resize(self._n_segments)
        strands = np.repeat(np.flatnonzero(counts > 0), _n_segments(counts[counts > 0]))
        values = {name: own(array) for name, array in self._values.items()}
        made = Lines.from_segments(own(self._segments), strands=own(strands), end_attributes=values, invalid=invalid)
        made = with_strand_values(made, {name: np.concatenate(v) for name, v in self._per_strand.items()}, "streamline")
        counted: dict[str, Any] = {"strands": own(made.strands + first_strand)} if first_strand else {}
        return replace(made, metadata=self._metadata, **counted)

    def _resize(self, n_rows: int) -> None:
        for array in (self._segments, *self._values.values()):
            if len(array) != n_rows:
                array.resize((n_rows, *array.shape[1:]), refcheck=False)


def _n_segments(counts: IntArray) -> IntArray:
    """Return how many segments strands of so many points have: a lone point has one."""
    return np.where(counts > 1, counts - 1, counts)


def offset_for(wanted: Offset | str | None, parts: Iterable[npt.NDArray[Any]]) -> Offset:
    """Return the offset that was asked for, of points that come in parts."""
    wanted = check_offset(wanted)
    if not isinstance(wanted, str):
        return wanted
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for points in parts:
        usable = points[(np.abs(points) <= COORDINATE_LIMIT).all(axis=1)].astype(np.float64)
        low, high = (
            np.minimum(low, usable.min(axis=0, initial=np.inf)),
            np.maximum(high, usable.max(axis=0, initial=-np.inf)),
        )
    return rounded_middle(low, high) if (low <= high).all() else NO_OFFSET
