"""The streamlines of a TRX file (``.trx``): which points they have, and of which groups they are."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arrays import AnyArray, IntArray
from ...support.distinct import distinct
from ..source import BAD_COPY, Source
from ..stored_array import StoredArray

#: So many streamlines are looked at at once.
_BLOCK = 1 << 16


class Offsets:
    """The first point of each streamline, checked; a slice of streamlines has their numbers of points, (k,) int64.

    Parameters
    ----------
    source : Source
    offsets : StoredArray
        They rise from 0 to the number of points. An older version of the format lacks the last one.
    n_streamlines, n_points : int
        What the header counts.
    """

    def __init__(self, source: Source, offsets: StoredArray, n_streamlines: int, n_points: int) -> None:
        self._offsets, self._n, self._n_points = offsets, n_streamlines, n_points
        lacks_end = offsets.ndim == 1 and len(offsets) == n_streamlines > 0
        if lacks_end:
            source.warn("its offsets lack the end of the last streamline, as in an older version of the format")
        shape = (n_streamlines + 1,) if lacks_end else offsets.shape
        if offsets.dtype.kind not in "iu" or shape != (n_streamlines + 1,):
            raise source.error(
                f"its offsets are {offsets.dtype} of shape {shape}; by its header, expected whole numbers of shape "
                f"({n_streamlines + 1},); {BAD_COPY}"
            )
        rises = all((np.diff(self._of(slice(at, at + _BLOCK))) >= 0).all() for at in range(0, n_streamlines, _BLOCK))
        first, last = offsets[:1][0], n_points if lacks_end else offsets[n_streamlines:][0]
        if first != 0 or last != n_points or not rises:
            raise source.error(
                f"its {n_streamlines + 1} offsets, from {first} to {last}, do not rise from 0 to the {n_points} "
                f"points of its {n_streamlines} streamlines; its header or its offsets are wrong: write it again"
            )

    def __getitem__(self, strands: slice) -> IntArray:
        return np.diff(self._of(strands))

    def parts(self, n_points: int) -> Iterator[tuple[slice, slice]]:
        """Yield the points and the numbers of some streamlines at a time: about as many points, or one streamline."""
        for start in range(0, self._n, _BLOCK):
            offsets = self._of(slice(start, start + _BLOCK))
            steps = np.searchsorted(offsets, np.arange(offsets[0], offsets[-1], n_points))
            cuts = distinct(np.concatenate([[0], steps, [len(offsets) - 1]]))
            for first, last in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
                yield slice(int(offsets[first]), int(offsets[last])), slice(start + first, start + last)

    def rows_of(self, strands: IntArray) -> tuple[IntArray, IntArray]:
        """Return the points of some streamlines, one after the other, and how many each has."""
        offsets = self._of(slice(0, self._n))
        first, sizes = offsets[strands], np.diff(offsets)[strands]
        rows = np.repeat(first - np.cumsum(sizes) + sizes, sizes) + np.arange(int(sizes.sum()))
        return rows, sizes

    def _of(self, strands: slice) -> IntArray:
        """Return the first point of each of some streamlines, and the end of the last one."""
        first, last, _ = strands.indices(self._n)
        offsets = self._offsets[first : last + 1].astype(np.int64)
        return offsets if len(offsets) > last - first else np.append(offsets, self._n_points)


class Group:
    """Which streamlines are of a group, one bit each; a slice of streamlines has their booleans.

    Examples
    --------
    >>> Group(np.array([1, 8]), 10)[7:]
    array([False,  True, False])
    """

    def __init__(self, numbers: AnyArray, n_streamlines: int) -> None:
        belongs = np.zeros(n_streamlines, np.bool_)
        belongs[numbers.astype(np.int64)] = True
        self._bits, self._n = np.packbits(belongs), n_streamlines

    def __getitem__(self, strands: slice) -> AnyArray:
        first, last, _ = strands.indices(self._n)
        bits = np.unpackbits(self._bits[first // 8 : -(-last // 8)])
        return bits[first % 8 : first % 8 + last - first].view(np.bool_)
