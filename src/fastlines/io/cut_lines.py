"""Lines that are in memory, cut into chunks of whole strands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..arrays import IntArray
from ..geometry.lines import Lines
from ..support.immutable import own


def cut_lines(lines: Lines, max_segments: int) -> Iterator[Lines]:
    """Yield the lines in chunks, as `fastlines.read_chunks` describes them.

    A chunk can only end where all strands that follow have larger numbers; otherwise they could not count on.

    Examples
    --------
    >>> lines = Lines(np.zeros((5, 2, 3), np.float32), np.array([0, 0, 1, 3, 3]))
    >>> [chunk.strands.tolist() for chunk in cut_lines(lines, 2)]
    [[0, 0], [0], [1, 1]]
    """
    n, first, before = len(lines), 0, 0
    ends = _ends(lines.strands)
    end_rows = np.append(lines.rows, n + len(lines.skipped))
    while True:
        last = (
            int(
                ends[
                    max(np.searchsorted(ends, first + max_segments, "right") - 1, np.searchsorted(ends, first, "right"))
                ]
            )
            if n
            else 0
        )
        rows = slice(first, last)
        strands = lines.strands[rows]
        start, stop = end_rows[first] if first else 0, end_rows[last]
        skipped = lines.skipped[np.searchsorted(lines.skipped, start) : np.searchsorted(lines.skipped, stop)]
        yield replace(
            lines,
            segments=lines.segments[rows],
            strands=own(np.where(strands < 0, -1, strands - before)),
            radius=None if lines.radius is None else lines.radius[rows],
            attributes={name: values[rows] for name, values in lines.attributes.items()},
            end_attributes={name: values[rows] for name, values in lines.end_attributes.items()},
            skipped=own(skipped - start),
        )
        if last == n:
            return
        first, before = last, max(before, int(strands.max()) + 1)


def _ends(strands: IntArray) -> IntArray:
    """Return the rows before which a chunk can end, and the number of rows."""
    n = len(strands)
    if not n or strands.max() < 0:
        return np.arange(1, n + 1)
    highest = np.maximum.accumulate(strands)
    lowest = np.minimum.accumulate(np.where(strands < 0, np.iinfo(np.int64).max, strands)[::-1])[::-1]
    return np.append(np.flatnonzero(highest[:-1] < lowest[1:]) + 1, n)
