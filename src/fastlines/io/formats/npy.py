"""NumPy arrays of segments (``.npy``).

Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html. `numpy.load` would allocate any size
that a header has. Here the header is compared with the file first, and nothing is ever unpickled.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy_format

from ...arrays import AnyArray
from ...errors import FileFormatError
from ...geometry.lines import Lines
from ...geometry.offsets import NO_OFFSET, OFFSET, in_file
from ...support.immutable import own
from ..rounding import Rounding
from ..segment_collector import offset_for
from ..source import Source, reason
from ..stored_array import StoredArray

_HEADER_READERS = {(1, 0): npy_format.read_array_header_1_0, (2, 0): npy_format.read_array_header_2_0}


def read(source: Source, invalid: str) -> Lines:
    """Read segments without strands from a ``.npy`` file: an array (n, 2, 3) or (n, 6) of any real numbers."""
    return Lines.from_segments(read_array(source), offset=source.offset, invalid=invalid)


def read_chunks(source: Source, max_segments: int, invalid: str) -> Iterator[Lines] | None:
    """Read a ``.npy`` file in chunks, unless its array is stored in columns or is of another shape."""
    dtype, shape, in_columns, at = _read_header(source, source.open())
    if in_columns or shape[1:] not in ((2, 3), (6,)):
        return None
    segments = source.stored("numbers", dtype, shape, at=at)
    source.finish()
    return _chunks(source, segments, max_segments, invalid)


def _chunks(source: Source, segments: StoredArray, max_segments: int, invalid: str) -> Iterator[Lines]:
    starts = range(0, max(len(segments), 1), max_segments)
    offset = offset_for(source.offset, (segments[at : at + max_segments].reshape(-1, 3) for at in starts))
    rounding = Rounding()
    for at in starts:
        rows = segments[at : at + max_segments]
        source.advance(2 * rows.nbytes)
        points = rounding.to_float32(rows.reshape(-1, 3), offset)
        if at == starts[-1]:
            rounding.warn()
        lines = Lines.from_segments(own(points).reshape(-1, 2, 3), invalid=invalid)
        del rows, points
        yield lines if offset == NO_OFFSET else replace(lines, metadata={OFFSET: offset})


def write(lines: Lines, path: Path) -> list[str]:
    """Write the ends of segments, (n, 2, 3) float32, and nothing else; float64 if the lines have an offset."""
    with path.open("wb") as file:
        np.save(file, in_file(lines, lines.segments))
    has = {
        "strands": lines.n_strands > 0,
        "radius": lines.radius is not None,
        "the axis that points upwards": lines.up is not None,
        "the unit": lines.unit is not None,
    }
    return [*(name for name, there in has.items() if there), *map(repr, lines.attributes)]


def read_array(source: Source, *, text: bool = False) -> AnyArray:
    """Read all bytes of a ``.npy`` file without trusting its header; with `text`, also a lone text."""
    dtype, shape, in_columns, at = _read_header(source, BytesIO(source.data), text=text)
    if dtype.kind == "U":
        return _text(source, dtype, at)
    array = source.array("numbers", dtype, shape[::-1] if in_columns else shape, at=at)
    source.finish()
    return array.T if in_columns else array


def _read_header(
    source: Source, stream: BinaryIO, *, text: bool = False
) -> tuple[np.dtype[Any], tuple[int, ...], bool, int]:
    """Return the type and the shape of an array, whether it is stored in columns, and where it starts."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about headers that Python 2 wrote
            version = npy_format.read_magic(stream)
            if version not in _HEADER_READERS:
                raise source.error(f"has version {version} of the .npy format; plain numbers have (1, 0) or (2, 0)")
            shape, in_columns, dtype = _HEADER_READERS[version](stream)
    except FileFormatError:
        raise
    except Exception as error:  # parsing the header, a Python literal, may raise anything
        raise source.error(
            f"does not start with the header of an array ({reason(error)}); check the extension, or write it again"
        ) from None
    if dtype.kind not in "fiub" and not (text and dtype.kind == "U" and shape == ()):
        raise source.error(f"holds {dtype}; expected real numbers")
    return dtype, shape, in_columns, stream.tell()


def _text(source: Source, dtype: np.dtype[Any], at: int) -> AnyArray:
    array = source.array("characters", dtype, (1,), at=at)
    source.finish()
    try:
        return np.array(str(array[0]))
    except ValueError:  # a code point that does not exist
        raise source.error("holds no text; fix it") from None
