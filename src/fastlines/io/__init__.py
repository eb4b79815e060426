"""Readers of line files: a module for each format, and `read`, which picks the reader by the file's extension."""

from __future__ import annotations

import gzip
import os
import warnings
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path

from ..arrays import INVALID, choice
from ..errors import FileFormatError, FileWarning, InputError
from ..lines import Lines
from . import arrays, hair, tck, tfx, trk
from .source import BAD_COPY, Source, reason

__all__ = ["FORMATS", "read"]

_READERS: dict[str, tuple[Callable[[Source, str], Lines], str]] = {
    ".hair": (hair.parse, "hair, Cem Yuksel's HAIR files"),
    ".npy": (arrays.parse_npy, "NumPy array of segments, (n, 2, 3) or (n, 6)"),
    ".npz": (arrays.parse_npz, "NumPy arrays: 'segments', or 'points' and 'counts'; optionally 'radius' and others"),
    ".tck": (tck.parse, "streamlines, MRtrix"),
    ".tfx": (tfx.parse, "hair, AMD TressFX versions 3 and 4"),
    ".trk": (trk.parse, "streamlines, TrackVis"),
}

#: The formats: extension to a line of description. Each file may be packed by gzip, as in ``.trk.gz``.
FORMATS: dict[str, str] = {extension: description for extension, (_, description) in _READERS.items()}

#: The axis that points upwards, in formats with a convention: in world coordinates z is towards the top of the head.
UP = {".trk": "z", ".tck": "z", ".tfx": "y"}


def read(path: str | os.PathLike[str], *, invalid: str = "error") -> Lines:
    """Read a file of lines; its extension, in either case, names the format.

    Parameters
    ----------
    path : str or path-like
        A file with one of the extensions of `FORMATS`, packed by gzip if ``.gz`` follows.
    invalid : {"error", "skip"}
        Refuse segments that hold NaN or Inf, or leave them out and record their rows in ``skipped``.

    Returns
    -------
    Lines
        In the file's own units and axes. Segments of zero length are kept, and a strand of one point becomes one.

    Raises
    ------
    FileNotFoundError, or another OSError
        If there is no such file, or it cannot be read.
    InputError
        If segments hold NaN or Inf.
    FileFormatError
        If the extension is unknown, or the file is empty, cut short, damaged, or contradicts itself.

    Warns
    -----
    FileWarning
        If the file has an oddity (two counts in its header, bytes after its end), or lacks something that had to be
        assumed (the transform of a ``.trk``). The lines that could be read with certainty are returned.

    Examples
    --------
    >>> import os, tempfile
    >>> import numpy as np
    >>> path = os.path.join(tempfile.mkdtemp(), "cross.npy")
    >>> np.save(path, [[[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]]])
    >>> len(read(path))
    2
    """
    choice("invalid", invalid, INVALID)
    try:
        path = Path(path)
    except TypeError:
        raise InputError(f"path is a {type(path).__name__}; expected a str or a path") from None

    packed = path.suffix.lower() == ".gz"
    extension = Path(path.stem if packed else path.name).suffix.lower()
    if extension not in _READERS:
        if extension == ".flt":
            raise FileFormatError(f"{path}: is a tree, not a file of lines; fl.load reads it")
        raise FileFormatError(
            f"{path}: unknown extension {extension or '(none)'!r}; known: {', '.join(_READERS)}, each also with .gz; "
            "convert the file, or read it otherwise and pass its points to Lines.from_strands"
        )
    source = Source(_load(path), str(path))
    if packed:
        source = _unpack(source)
    parse, _ = _READERS[extension]
    try:
        lines = parse(source, invalid)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    for oddity in source.oddities:
        warnings.warn(oddity, FileWarning, stacklevel=2)
    return replace(lines, up=UP[extension]) if extension in UP else lines


def _load(path: Path) -> bytes:
    """Read all bytes of a regular file; raise an error that names the problem."""
    if path.exists() and not path.is_file() and not path.is_dir():
        raise InputError(f"{path}: is a device or a pipe; expected a regular file")
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        why = f"no such file; check the path (the working directory is {Path.cwd()})"
        raise FileNotFoundError(error.errno, why, str(path)) from None
    except ValueError as error:  # a NUL in the path
        raise InputError(f"{path}: cannot be read: {error}") from None
    if not data:
        raise FileFormatError(f"{path}: is empty; {BAD_COPY}")
    return data


def _unpack(source: Source) -> Source:
    """Unpack gzip in pieces, up to a limit."""
    if not source.data.startswith(b"\x1f\x8b"):
        raise source.error("is not packed by gzip although its name ends with .gz; rename it, or get a fresh copy")
    unpacked = bytearray()
    try:
        with gzip.GzipFile(fileobj=BytesIO(source.data)) as stream:
            while len(unpacked) <= source.unpack_limit and (piece := stream.read1(1 << 20)):
                unpacked += piece
    except Exception as error:  # gzip's own errors, and any of zlib and struct
        if not (unpacked and str(error).startswith("Not a gzipped file")):
            raise source.error(f"not a whole gzip file ({reason(error)}); {BAD_COPY}") from None
        source.warn("the bytes after its packed part are not read")
    if len(unpacked) > source.unpack_limit:
        raise source.error(
            f"unpacks to more than {source.unpack_limit} bytes, far more than lines would; if it is valid, "
            "unpack it by gunzip first"
        )
    if not unpacked:
        raise source.error(f"is empty once unpacked; {BAD_COPY}")
    whole = Source(bytes(unpacked), source.name)
    whole.oddities += source.oddities
    return whole
