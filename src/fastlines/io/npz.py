"""Several NumPy arrays in one file (``.npz``): segments or points, and their columns."""

from __future__ import annotations

import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileFormatError
from ..lines import Lines
from .npy import AnyArray, read_array
from .source import Source, reason

_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def read(source: Source, invalid: str) -> Lines:
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


def write(lines: Lines, path: Path) -> list[str]:
    """Write ``segments``, ``strands`` and ``radius``, and attributes by their names.

    Values at both ends of segments, (n, 2, …), keep that shape, and become attributes of that shape when read.
    """
    arrays: dict[str, Any] = {"segments": lines.segments, "strands": lines.strands}
    if lines.radius is not None:
        arrays["radius"] = lines.radius
    kept = {
        name: values
        for name, values in {**lines.attributes, **lines.end_attributes}.items()
        if values.dtype.kind in "fiub"
    }
    with path.open("wb") as file:
        np.savez(file, **(arrays | kept))
    return [f"{name!r} ({values.dtype})" for name, values in lines.attributes.items() if name not in kept]


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
    return {name: read_array(Source(data, f"{source.name}, array {name!r}")) for name, data in unpacked.items()}
