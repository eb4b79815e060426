"""NumPy's own files: ``.npy`` with segments, ``.npz`` with segments or points and their columns.

Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html. `numpy.load` would allocate any size
that a header has. Here the header is compared with the file first, and nothing is ever unpickled.
"""

from __future__ import annotations

import warnings
import zipfile
from io import BytesIO
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from numpy.lib import format as npy

from ..errors import FileFormatError
from ..lines import Lines
from .source import Source, reason

AnyArray: TypeAlias = npt.NDArray[Any]

_HEADER_READERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def parse_npy(source: Source, invalid: str) -> Lines:
    """Read segments without strands from a ``.npy`` file: an array (n, 2, 3) or (n, 6) of any real numbers."""
    return Lines.from_segments(_read_array(source), invalid=invalid)


def parse_npz(source: Source, invalid: str) -> Lines:
    """Read lines from a ``.npz`` file.

    It holds ``segments`` (n, 2, 3) or (n, 6), with or without integer ``strands`` (n,) and ``radius`` (n,) or (n, 2).
    Or it holds ``points`` (m, 3) and integer ``counts`` (k,), the numbers of points of each strand, with or without
    ``radius`` (m,). Any other array has n or m rows and becomes one of the ``attributes``.
    """
    arrays = _unzip(source)
    match sorted(arrays.keys() & {"segments", "points", "counts", "strands"}):
        case ["segments"] | ["segments", "strands"]:
            name = "segments"
        case ["counts", "points"]:
            name = "points"
        case _:
            raise source.error(
                f"holds the arrays {', '.join(arrays) or '(none)'}; expected 'segments', with or without 'strands', "
                "or 'points' and 'counts'"
            )
    given, radius = arrays.pop(name), arrays.pop("radius", None)
    n_rows = len(given) if given.ndim else 0
    strands, counts = arrays.pop("strands", np.full(n_rows, -1)), arrays.pop("counts", np.zeros(0, np.int64))
    _check(source, "strands", strands, (n_rows,), integer=True)
    if name == "points":
        _check(source, "points", given, (n_rows, 3))
    _check(source, "counts", counts, counts.shape[:1], integer=True)
    if np.any(counts < 0) or np.any(counts > n_rows):  # before they are added: the sum could wrap around
        raise source.error(f"'counts' are from {counts.min()} to {counts.max()}; there are {n_rows} points")
    if radius is not None:
        _check(source, "radius", radius, (n_rows, 2) if radius.ndim == 2 and name == "segments" else (n_rows,))
        radius = source.radius("radius", radius)
    for column, values in arrays.items():
        _check(source, column, values, (n_rows, *values.shape[1:]))
    if name == "segments":
        return Lines.from_segments(given, strands=strands, radius=radius, attributes=arrays, invalid=invalid)
    return Lines.from_points(given, counts, radius=radius, attributes=arrays, invalid=invalid)


def _check(source: Source, name: str, array: AnyArray, shape: tuple[int, ...], *, integer: bool = False) -> None:
    """Refuse an array of another shape, or one that must hold integers and is not convertible to int64."""
    if array.ndim == 0 or array.shape != shape:
        raise source.error(f"{name!r} has shape {array.shape}; expected {shape}, to go with the other arrays")
    if integer and not np.can_cast(array.dtype, np.int64):
        raise source.error(f"{name!r} is of type {array.dtype}; expected integers, int64 or smaller")


def _unzip(source: Source) -> dict[str, AnyArray]:
    """Read all arrays of a ``.npz``, which must not unpack to more than `Source.unpack_limit`."""
    try:
        with zipfile.ZipFile(BytesIO(source.data)) as archive:
            members = archive.infolist()
            for member in members:
                if not member.filename.endswith(".npy") or member.compress_type not in _COMPRESSIONS:
                    raise source.error(
                        f"{member.filename!r} in it is not an array that numpy.savez wrote; "
                        "write the file again with numpy.savez"
                    )
            if sum(member.file_size for member in members) > source.unpack_limit:
                raise source.error(
                    f"unpacks to more than {source.unpack_limit} bytes, far more than lines would; if it is "
                    "valid, write it again with numpy.savez"
                )
            unpacked = {member.filename.removesuffix(".npy"): archive.read(member) for member in members}
    except FileFormatError:
        raise
    except Exception as error:  # zipfile's own errors, and any of zlib and struct
        raise source.error(f"not a whole .npz file ({reason(error)}); check the extension, or write it again") from None
    return {name: _read_array(Source(data, f"{source.name}, array {name!r}")) for name, data in unpacked.items()}


def _read_array(source: Source) -> AnyArray:
    """Read all bytes of a ``.npy`` file without trusting its header."""
    stream = BytesIO(source.data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about headers that Python 2 wrote
            version = npy.read_magic(stream)
            if version not in _HEADER_READERS:
                raise source.error(f"has version {version} of the .npy format; plain numbers have (1, 0) or (2, 0)")
            shape, in_columns, dtype = _HEADER_READERS[version](stream)
    except FileFormatError:
        raise
    except Exception as error:  # parsing the header, a Python literal, may raise anything
        raise source.error(
            f"does not start with the header of an array ({reason(error)}); check the extension, or write it again"
        ) from None
    if dtype.kind not in "fiub":
        raise source.error(f"holds {dtype}; expected real numbers")
    array = source.array("numbers", dtype, shape[::-1] if in_columns else shape, at=stream.tell())
    source.finish()
    return array.T if in_columns else array
