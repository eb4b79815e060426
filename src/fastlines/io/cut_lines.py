"""Lines cut into chunks of whole strands: lines that are in memory, or that come in parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
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
    return _counting_on(_cut(lines, max_segments))


def regroup(parts: Iterable[Lines], max_segments: int) -> Iterator[Lines]:
    """Yield in chunks what comes in parts, at least one, which may end within strands.

    The numbers of strands rise, and are those of the whole; all parts have the same columns.
    """
    return _counting_on(_regroup(parts, max_segments))


def _counting_on(chunks: Iterable[Lines]) -> Iterator[Lines]:
    """Number the strands of each chunk from the end of those before."""
    before = 0
    for chunk in chunks:
        strands, first = chunk.strands, before
        before = max(before, int(strands.max(initial=-1)) + 1)
        yield replace(chunk, strands=own(np.where(strands < 0, -1, strands - first))) if first else chunk
        del chunk, strands


def _regroup(parts: Iterable[Lines], max_segments: int) -> Iterator[Lines]:
    waiting: list[Lines] = []
    for part in parts:
        waiting.append(part)
        first, last = (int(of.strands.max(initial=-1)) for of in (waiting[0], part))
        if sum(map(len, waiting)) <= max_segments or 0 <= first == last:  # or in the middle of a long strand
            continue
        # Keep the last strand, which may go on.
        whole, n_done = _joined(waiting), 0
        n_ended = len(whole) - 1 if whole.strands.max() < 0 else int(np.argmax(whole.strands == whole.strands.max()))
        for start, stop in _pieces(whole.strands, max_segments):
            if stop <= n_ended:
                yield _slice(whole, start, stop)
                n_done = stop
        waiting = [_slice(whole, n_done, len(whole))]
        del whole
    yield from _cut(_joined(waiting), max_segments)


def _cut(lines: Lines, max_segments: int) -> Iterator[Lines]:
    for first, last in _pieces(lines.strands, max_segments):
        yield _slice(lines, first, last)


def _pieces(strands: IntArray, max_segments: int) -> Iterator[tuple[int, int]]:
    """Yield the first row of each chunk, and the row at which it ends."""
    n, first, last = len(strands), 0, -1
    ends = _ends(strands)
    while last < n:
        fitting, longer = (np.searchsorted(ends, first + size, "right") for size in (max_segments, 0))
        last = int(ends[max(fitting - 1, longer)]) if n else 0
        yield first, last
        first = last


def _slice(lines: Lines, first: int, last: int) -> Lines:
    """Return some of the lines, and the rows among them that were skipped."""
    skipped = lines.skipped
    if len(skipped):
        rows = np.append(lines.rows, len(lines) + len(skipped))
        start, stop = rows[first] if first else 0, rows[last]
        skipped = own(skipped[slice(*np.searchsorted(skipped, [start, stop]))] - start)
    part = slice(first, last)
    return replace(
        lines,
        segments=lines.segments[part],
        strands=lines.strands[part],
        radius=None if lines.radius is None else lines.radius[part],
        attributes={name: values[part] for name, values in lines.attributes.items()},
        end_attributes={name: values[part] for name, values in lines.end_attributes.items()},
        skipped=skipped,
    )


def _ends(strands: IntArray) -> IntArray:
    """Return the rows before which a chunk can end, and the number of rows."""
    n = len(strands)
    if not n or strands.max() < 0:
        return np.arange(1, n + 1)
    highest = np.maximum.accumulate(strands)
    lowest = np.minimum.accumulate(np.where(strands < 0, np.iinfo(np.int64).max, strands)[::-1])[::-1]
    return np.append(np.flatnonzero(highest[:-1] < lowest[1:]) + 1, n)


def _joined(parts: Sequence[Lines]) -> Lines:
    """Return lines one after the other."""
    if len(parts) == 1:
        return parts[0]
    first, radii = parts[0], [part.radius for part in parts]
    n_rows = np.cumsum([0] + [len(part) + len(part.skipped) for part in parts])
    columns: list[dict[str, np.ndarray]] = [
        {name: own(np.concatenate([given[name] for given in of])) for name in of[0]}
        for of in ([part.attributes for part in parts], [part.end_attributes for part in parts])
    ]
    return replace(
        first,
        segments=own(np.concatenate([part.segments for part in parts])),
        strands=own(np.concatenate([part.strands for part in parts])),
        radius=None
        if first.radius is None
        else own(np.concatenate([radius for radius in radii if radius is not None])),
        attributes=columns[0],
        end_attributes=columns[1],
        skipped=own(np.concatenate([part.skipped + at for part, at in zip(parts, n_rows, strict=False)])),
    )
