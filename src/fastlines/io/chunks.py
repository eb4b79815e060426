"""Reads files of lines in chunks of whole strands, so that they may be larger than memory."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import count, unusable_text
from ..errors import InputError
from ..geometry.line_input import FIX_INVALID
from ..geometry.lines import Lines
from ..geometry.offsets import Offset
from ..progress import ProgressOption, check_progress, reporting
from .cut_lines import cut_lines
from .format import AnyLines, Format
from .reading import (
    check_arguments,
    open_source,
    parse,
    parsing,
    too_thick,
    warn_of_oddities,
    with_conventions,
)
from .source import Source


def read_chunks(
    path: str | os.PathLike[str],
    max_segments: int = 1_000_000,
    *,
    offset: Any = None,
    invalid: str = "error",
    format: str | None = None,
    progress: ProgressOption = False,
    **options: Any,
) -> Iterator[Lines]:
    """Read a file of lines in chunks of whole strands.

    The chunks together are the lines that `read` returns: the segments, radii and attributes of one chunk follow those
    of the chunk before. The strands of a chunk count on: those of the next begin where the largest number of this one
    ends, as its rows do. So strand s of a chunk is strand ``s + sum(chunk.strands.max() + 1 for the chunks before)`` of
    the file, where chunks without strands count 0.

    Of streamlines (.trk, .tck, .trx), .npy, tables (Parquet, Arrow) and linear curves of USD, only a part of the file
    is in memory: a chunk or two, and the longest strand; of USD, the largest prim. Files of other formats are read
    whole and cut. So are tables of geometries, tables in which the numbers of strands do not rise, and cubic curves.

    Parameters
    ----------
    path : str or path-like
        As of `read`. A folder of Parquet files is one table.
    max_segments : int
        The most segments of a chunk. A longer strand is a chunk of its own.
    offset : "auto" or three numbers, optional
        As of `read`; all chunks have the same one. ``"auto"`` reads a file once more.
    invalid : {"error", "skip"}
        As of `read`. ``skipped`` has rows of the chunk.
    format, progress, **options
        As of `read`.

    Yields
    ------
    Lines
        At least one, which may be empty. Each has the unit, the upward axis and the metadata of the file. Curves become
        lines, as `Curves.as_lines` does it.

    Raises
    ------
    FileNotFoundError, InputError, FileFormatError, MissingExtraError
        As `read` does. What is wrong within a file is raised in place of the chunk that has it.

    Warns
    -----
    FileWarning, PrecisionWarning
        As `read` does, with the chunk that shows it, or with the last one.

    Examples
    --------
    >>> import os, tempfile
    >>> import numpy as np
    >>> path = os.path.join(tempfile.mkdtemp(), "three.npy")
    >>> np.save(path, [[[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]], [[0, 0, -1], [0, 0, 1]]])
    >>> [len(chunk) for chunk in read_chunks(path, max_segments=2)]
    [2, 1]
    """
    max_segments = count("max_segments", max_segments, 1)
    check_progress(progress)
    found, row, wanted = check_arguments(path, offset, invalid, format, options)
    return _chunks(found, row, max_segments, wanted, invalid, progress, options)


def _chunks(
    path: Path,
    row: Format,
    max_segments: int,
    offset: Offset | str | None,
    invalid: str,
    progress: ProgressOption,
    options: dict[str, Any],
) -> Iterator[Lines]:
    with reporting(progress, "read") as callback, open_source(path, row, callback) as source:
        source.offset = offset
        # Readers of others know of no offset.
        streams = hasattr(row.code, "read_chunks") and (row.module is None or source.offset is None)
        with parsing(row, source):
            found = row.code.read_chunks(source, max_segments, "skip", **options) if streams else None
        if found is None:
            lines = straight(source, parse(row, source, invalid, options))
            warn_of_oddities(source)
            yield from cut_lines(lines, max_segments)
            return
        so_far = _SoFar()
        with closing(found) as chunks:
            while True:
                with parsing(row, source):
                    chunk = next(chunks, None)
                if chunk is None:
                    break
                so_far.add(chunk)
                if invalid == "error":
                    so_far.refuse_skipped(source)
                warn_of_oddities(source)
                yield with_conventions(chunk, row)
                del chunk  # before the next one is made
        if (oddity := so_far.thickness_oddity()) is not None:
            source.warn(oddity)
        warn_of_oddities(source)


class _SoFar:
    """What is known of the rows of a file that were read so far."""

    def __init__(self) -> None:
        self._n_rows, self._skipped, self._radius = 0, np.empty(0, np.int64), 0.0
        self._bounds = np.array([[np.inf] * 3, [-np.inf] * 3], np.float32)

    def add(self, chunk: Lines) -> None:
        """Add the next rows."""
        self._skipped = chunk.skipped + self._n_rows
        self._n_rows += len(chunk) + len(chunk.skipped)
        if chunk.radius is not None:
            low, high = chunk.bounds
            self._bounds = np.stack([np.minimum(self._bounds[0], low), np.maximum(self._bounds[1], high)])
            self._radius = max(self._radius, chunk.max_radius)

    def refuse_skipped(self, source: Source) -> None:
        """Refuse the rows of the last chunk that hold NaN or Inf."""
        if len(self._skipped):
            said = unusable_text(self._skipped, f"the first {self._n_rows} segments")
            raise InputError(f"{source.name}: {said}{FIX_INVALID}")

    def thickness_oddity(self) -> str | None:
        """Say that lines are thicker than all of them are long."""
        return too_thick(self._radius, self._bounds) if self._radius else None


def straight(source: Source, lines: AnyLines) -> Lines:
    """Return lines, or curves as lines; refuse a file of both."""
    found: Any = lines.as_lines()
    if found is None:
        raise InputError(
            f"{source.name}: holds lines and curves; read_chunks returns lines: read a part of the file, such as one "
            "prim of USD by prim=, or all by fl.read"
        )
    made: Lines = found
    return made
