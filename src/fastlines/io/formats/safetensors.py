"""Named arrays in a safetensors file (``.safetensors``): segments, points or curves, and their columns.

Format: https://huggingface.co/docs/safetensors/index#format. Eight bytes hold the length of a header in JSON, which has
the type, the shape and the first and last byte of each array; the arrays follow without gaps. `named_arrays.py` lists
the names. ``up``, ``unit``, ``metadata`` and ``tolerance`` are among the texts of ``__metadata__``; others
there are not read.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import AnyArray
from ...geometry.curves import Curves
from ...geometry.lines import Lines
from ...support.container import ALIGNMENT, DTYPES, MAX_HEADER, NAMES
from ..source import BAD_COPY, Source
from .named_arrays import from_arrays, to_arrays

#: The most dimensions of an array; every version of NumPy has as many.
MAX_DIMENSIONS = 32


def read(source: Source, invalid: str) -> Lines | Curves:
    """Read lines or curves from the arrays of a ``.safetensors`` file, which have the same names as in a ``.npz``."""
    length = int(source.array("lengths of the header", "<u8", (1,))[0])
    if length > MAX_HEADER:
        raise source.error(f"its header has {length} bytes, expected at most {MAX_HEADER}; check the extension")
    text = source.array("bytes of the header", "u1", (length,)).tobytes()
    try:
        header = json.loads(text, object_pairs_hook=_once)
        metadata = header.pop("__metadata__", {})
        entries = [
            (int(entry["data_offsets"][0]), int(entry["data_offsets"][1]), name, str(entry["dtype"]), entry["shape"])
            for name, entry in header.items()
        ]
        shapes = {name: tuple(map(int, shape)) for _, _, name, _, shape in entries}
        if not all(isinstance(value, str) for value in metadata.values()):
            raise TypeError
    except (ValueError, TypeError, KeyError, AttributeError, IndexError, OverflowError, RecursionError):
        raise source.error("its header is not that of a safetensors file; check the extension") from None

    # The arrays follow each other and fill the file.
    data = memoryview(source.data)[8 + length :]
    arrays: dict[str, AnyArray] = {}
    position = 0
    for begin, end, name, type_name, _ in sorted(entries):
        if type_name not in DTYPES:
            raise source.error(f"{name!r} is of type {type_name}; expected one of {', '.join(DTYPES)}; convert it")
        dtype, shape = DTYPES[type_name], shapes[name]
        if begin != position or len(shape) > MAX_DIMENSIONS or not all(0 <= size <= len(source.data) for size in shape):
            raise source.error(f"{name!r} is not where the array before it ends, or has a wrong shape; fix the header")
        if end - begin != dtype.itemsize * math.prod(shape):
            raise source.error(f"{name!r} of shape {shape} does not have {end - begin} bytes; fix the header")
        if end > len(data):
            raise source.error(f"{name!r} ends at byte {8 + length + end}, and the file has fewer; {BAD_COPY}")
        position = end
        array = np.ndarray(shape, dtype, buffer=data, offset=begin)
        arrays[name] = array if array.flags.aligned else array.copy()
    if position != len(data):
        raise source.error(f"{len(data) - position} bytes are left over behind its last array; write the file again")
    return from_arrays(source, arrays, metadata, invalid)


def write(geometry: Lines | Curves, path: Path) -> list[str]:
    """Write all arrays by their names in `named_arrays.py`."""
    arrays, facts, lost = to_arrays(geometry)
    little = {name: array.astype(array.dtype.newbyteorder("<"), copy=False) for name, array in arrays.items()}
    header: dict[str, Any] = {"__metadata__": facts}
    kept: list[AnyArray] = []
    position = 0
    # Wide numbers come first, so that all are aligned.
    for name, array in sorted(little.items(), key=lambda item: -item[1].dtype.itemsize):
        if array.dtype not in NAMES:
            lost.append(f"{name!r} ({array.dtype})")
            continue
        end = position + array.nbytes
        header[name] = {"dtype": NAMES[array.dtype], "shape": array.shape, "data_offsets": [position, end]}
        kept.append(np.ascontiguousarray(array))
        position = end
    text = json.dumps(header).encode()
    text += b" " * (-(8 + len(text)) % ALIGNMENT)
    with path.open("wb") as file:
        file.write(len(text).to_bytes(8, "little") + text)
        for array in kept:
            file.write(array.data)
    return lost


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Make a dictionary; each name may be there once."""
    made = dict(pairs)
    if len(made) != len(pairs):
        raise ValueError("a name is there twice")
    return made
