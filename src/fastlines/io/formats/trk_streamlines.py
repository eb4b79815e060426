"""The streamlines of a TrackVis file (``.trk``), piece by piece.

Each is its number of points, its points with their scalars, and its properties, in words of 4 bytes.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Literal

import numpy as np

from ...arrays import FloatArray, IntArray
from ..source import Source


class Streamlines:
    """Iterates over whole streamlines, several at a time.

    Yields points with their scalars, (m, 3 + s) float32, properties, (k, p) float32, and numbers of points, (k,) int64.

    Parameters
    ----------
    source : Source
    start : int
        The byte at which they start.
    byte_order : {"<", ">"}
    per_point, n_properties : int
        How many numbers each point has, and each streamline has after its points.

    Attributes
    ----------
    n_found : int
        How many whole streamlines there are, once all are read.
    left : bytes
        What follows the last whole one.
    """

    def __init__(
        self, source: Source, start: int, byte_order: Literal["<", ">"], per_point: int, n_properties: int
    ) -> None:
        self.source, self.start, self.byte_order = source, start, byte_order
        self.per_point, self.n_properties = per_point, n_properties
        self.n_found = 0
        self.left = b""

    @property
    def announced(self) -> int | None:
        """How many points the streamline announces that is not whole; None if not even that is there."""
        return int(np.frombuffer(self.left, f"{self.byte_order}i4", 1)[0]) if len(self.left) >= 4 else None

    def __iter__(self) -> Iterator[tuple[FloatArray, FloatArray, IntArray]]:
        self.n_found = 0
        waiting, n_waiting, n_needed = [b""], 0, 4
        for piece in self.source.pieces(self.start):
            # Wait for the whole of a long streamline.
            waiting.append(piece)
            n_waiting += len(piece)
            if n_waiting < n_needed:
                continue
            data = b"".join(waiting)
            words = np.frombuffer(data, f"{self.byte_order}i4", len(data) // 4)
            counts, n_used, n_needed = self._walk(words.astype("=i4", copy=False).data)
            if len(counts):
                yield *self._split(words[:n_used].view(f"{self.byte_order}f4"), counts), counts
            self.n_found += len(counts)
            self.source.advance(4 * n_used)
            waiting = [data[4 * n_used :]]
            n_waiting = len(waiting[0])
        self.left = b"".join(waiting)

    def _walk(self, words: memoryview[int]) -> tuple[IntArray, int, int]:
        """Return the numbers of points of whole streamlines, their words, and the bytes that the next one needs."""
        counts: list[int] = []
        at, n_words, n_needed = 0, len(words), 4
        while at < n_words:
            count = words[at]
            size = 1 + count * self.per_point + self.n_properties
            if count < 0 or at + size > n_words:
                n_needed = 4 * size if count >= 0 else sys.maxsize
                break
            counts.append(count)
            at += size
        return np.array(counts, np.int64), at, n_needed

    def _split(self, values: FloatArray, counts: IntArray) -> tuple[FloatArray, FloatArray]:
        """Separate points from properties, and both from the counts."""
        size = 1 + counts * self.per_point + self.n_properties
        first = np.cumsum(size) - size
        is_point = np.ones(len(values), np.bool_)
        is_point[first] = False
        where = (first + 1 + counts * self.per_point)[:, None] + np.arange(self.n_properties)
        is_point[where] = False
        rows = values[is_point].astype(np.float32, copy=False).reshape(-1, self.per_point)
        return rows, values[where].astype(np.float32, copy=False)
