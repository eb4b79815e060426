"""NumPy arrays of segments (``.npy``).

Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html. `numpy.load` would allocate any size
that a header has. Here the header is compared with the file first, and nothing is ever unpickled.
"""

from __future__ import annotations

import warnings
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy_format

from ...arrays import AnyArray
from ...errors import FileFormatError
from ...geometry.lines import Lines
from ...geometry.offsets import in_file
from ..source import Source, reason

_HEADER_READERS = {(1, 0): npy_format.read_array_header_1_0, (2, 0): npy_format.read_array_header_2_0}


def read(source: Source, invalid: str) -> Lines:
    """Read segments without strands from a ``.npy`` file: an array (n, 2, 3) or (n, 6) of any real numbers."""
    return Lines.from_segments(read_array(source), offset=source.offset, invalid=invalid)


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
    stream = BytesIO(source.data)
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
    if text and dtype.kind == "U" and shape == ():
        return _text(source, dtype, stream.tell())
    if dtype.kind not in "fiub":
        raise source.error(f"holds {dtype}; expected real numbers")
    array = source.array("numbers", dtype, shape[::-1] if in_columns else shape, at=stream.tell())
    source.finish()
    return array.T if in_columns else array


def _text(source: Source, dtype: np.dtype[Any], at: int) -> AnyArray:
    array = source.array("characters", dtype, (1,), at=at)
    source.finish()
    try:
        return np.array(str(array[0]))
    except ValueError:  # a code point that does not exist
        raise source.error("holds no text; fix it") from None
