"""Reads files of lines."""

from __future__ import annotations

import errno
import gzip
import os
import stat
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO
from zipfile import BadZipFile

import numpy as np

from ..arrays import INVALID, FloatArray, choice, kind_of
from ..errors import FastlinesError, FileFormatError, FileWarning, InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.collection import Geometry
from ..geometry.curves import Curves
from ..geometry.lines import Lines
from ..geometry.offsets import NO_OFFSET, Offset, check_offset, with_offset
from ..progress import ProgressCallback, ProgressOption, reporting
from ..support.named_errors import named, naming
from ..support.texts import in_one_line
from ..support.warn_caller import warn_caller
from . import table
from .format import AnyLines, Format
from .packed_source import MAGIC, PackedSource
from .source import BAD_COPY, Source, reason

#: So many of the first bytes of a file tell its format, if its extension does not.
N_START = 64
#: What Python and its parsers raise for values that no reader expects. Errors of the disk and of programs are not.
_DAMAGE = (ArithmeticError, EOFError, LookupError, RecursionError, ValueError, BadZipFile, struct.error, zlib.error)


def read(
    path: str | os.PathLike[str],
    *,
    offset: Any = None,
    invalid: str = "error",
    format: str | None = None,
    progress: ProgressOption = False,
    **options: Any,
) -> Lines | Curves | Geometry:
    """Read a file of lines; its extension, in either case, names the format.

    Parameters
    ----------
    path : str or path-like
        A file with one of the extensions of `known_formats`, packed by gzip if ``.gz`` follows. A file of another
        extension is recognised by its first bytes, where its format has some of its own. A ``.trx`` may be a folder.
        A folder of Parquet files is one table.
    offset : "auto" or three numbers, optional
        Subtracted from x, y and z in float64, before they are rounded to float32; ``"auto"`` is the middle of the
        lines, rounded to whole numbers (to as many decimals as the lines need, where they are smaller than 1). Arrays
        such as ``lines.segments`` are less the offset, and ``lines.offset`` has it. Rays, points, cameras and written
        files have the coordinates of the file.
    invalid : {"error", "skip"}
        Refuse segments that hold NaN or Inf, or leave them out and record their rows in ``skipped``.
    format : str, optional
        The name or the extension of the format, where the file's own extension does not say it.
    progress : bool or callable
        Show a bar, or call back with the fraction that is done. An error of the callback ends the reading.
    **options
        Options of the format, such as ``time=`` of USD. The error for any other option lists those of the format.

    Returns
    -------
    Lines
        In the file's own units and axes. Segments of zero length are kept, and a strand of one point becomes one.
        Formats with cubic curves return `Curves`, or a `Geometry` of both.

    Raises
    ------
    FileNotFoundError, IsADirectoryError, or another OSError
        If there is no such file, or it is a directory, or it cannot be read.
    InputError
        If segments hold NaN or Inf, or the format has no such option.
    FileFormatError
        If the extension is unknown, or the file is empty, cut short, damaged, or contradicts itself.
    MissingExtraError
        If the format needs a library that is not there.

    Warns
    -----
    FileWarning
        If the file has an oddity (two counts in its header, bytes after its end), or lacks something that had to be
        assumed (the transform of a ``.trk``). The lines that could be read with certainty are returned.
    PrecisionWarning
        If float32 rounds coordinates noticeably; an offset keeps them.

    Examples
    --------
    >>> import os, tempfile
    >>> import numpy as np
    >>> path = os.path.join(tempfile.mkdtemp(), "cross.npy")
    >>> np.save(path, [[[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]]])
    >>> len(read(path))
    2
    """
    path, row, wanted = check_arguments(path, offset, invalid, format, options)
    with reporting(progress, "read") as callback, open_source(path, row, callback) as source:
        source.offset = wanted
        lines = parse(row, source, invalid, options)
    warn_of_oddities(source)
    return lines


def check_arguments(
    path: str | os.PathLike[str], offset: Any, invalid: str, format: str | None, options: dict[str, Any]
) -> tuple[Path, Format, Offset | str | None]:
    """Check the arguments of `read`; return the path, the format and the offset."""
    choice("invalid", invalid, INVALID)
    found = table.path_of(path)
    if format is not None and not isinstance(format, str):
        raise InputError(f"format is {kind_of(format)}; expected the name of one, such as 'trk'")
    wanted = None if offset is None else check_offset(offset)
    check_path(found)
    row = format_of(found, format)
    row.check_options(str(found), options)
    return found, row, wanted


def warn_of_oddities(source: Source) -> None:
    """Warn of the oddities that were found since the last call."""
    for oddity in source.oddities:
        warn_caller(oddity, FileWarning)
    source.oddities.clear()


def format_of(path: Path, name: str | None = None) -> Format:
    """Return the format of a file: the named one, or that of its extension, or else that of its first bytes."""
    if name is not None:
        return table.named(name)
    known = table.extension_of(path)[0] in table.known_formats()
    return table.find(path, b"" if known else _start_of(path))


def check_path(path: Path) -> None:
    """Refuse what is not a regular file, nor a folder of a format, before it is opened: a pipe would block."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError as error:
        why = f"no such file; check the path (the working directory is {Path.cwd()})"
        raise FileNotFoundError(error.errno, why, str(path)) from None
    except ValueError as error:  # a NUL in the path
        raise InputError(f"{path}: cannot be read: {error}") from None
    if stat.S_ISDIR(mode):
        if table.of_folder(path):
            return
        raise IsADirectoryError(
            errno.EISDIR, "is a directory; expected a file of lines, or a folder of Parquet files", str(path)
        )
    if not stat.S_ISREG(mode):
        raise InputError(f"{path}: is a device or a pipe; expected a regular file")


def parse(row: Format, source: Source, invalid: str, options: dict[str, Any]) -> AnyLines:
    """Return the lines of a file."""
    with parsing(row, source):
        lines: AnyLines = row.code.read(source, invalid, **options)
    if not isinstance(lines, AnyGeometry):
        raise FileFormatError(
            f"{source.name}: the format {row.name!r} returned {kind_of(lines)}; expected Lines, Curves or a "
            "Geometry of several"
        )
    if (oddity := thickness_oddity(lines)) is not None:
        source.warn(oddity)
    parts = [with_conventions(part, row) for part in lines.each_part()]
    if row.module is not None and source.offset is not None:  # readers of others know of no offset
        parts = [with_offset(part, source.offset) if part.offset == NO_OFFSET else part for part in parts]
    return Geometry(parts) if lines.has_parts else parts[0]


@contextmanager
def parsing(row: Format, source: Source) -> Iterator[None]:
    """Turn what a reader raises into errors about its file."""
    try:
        with np.errstate(all="ignore"):  # what is NaN or Inf in the end is reported with its row
            yield
    except Exception as error:
        if source.stopped is not None:
            raise source.stopped from None
        if isinstance(error, InputError):
            raise InputError(f"{source.name}: {in_one_line(str(error))}") from None
        if isinstance(error, _DAMAGE) and not isinstance(error, FastlinesError):
            kind = type(error).__name__
            raise source.error(f"cannot be read as {row.name} ({kind}: {reason(error)}); {BAD_COPY}") from error
        if isinstance(error, OSError):
            raise named(error, source.name) from None
        raise


def thickness_oddity(lines: AnyGeometry) -> str | None:
    """Say that lines are thicker than all of them are long; a single point may be a ball."""
    return too_thick(lines.max_radius, lines.bounds) if len(lines) else None


def too_thick(radius: float, bounds: FloatArray) -> str | None:
    """Say that the largest radius is more than the size of a scene with these bounds."""
    size = float(np.ptp(bounds, axis=0).max())
    if not radius > size > 0:
        return None
    return (
        f"its radius is up to {radius:.4g}, more than the size of its whole scene, {size:.4g}; if that is a mistake, "
        "replace it by lines.with_radius(…), or leave it out by --no-own-radius on the command line"
    )


def with_conventions(part: Any, row: Format) -> Any:
    """Set the axis and the unit by the format's convention, where the file does not say."""
    known = {"up": row.up, "unit": row.unit}
    missing = {name: value for name, value in known.items() if value and getattr(part, name, None) is None}
    return replace(part, **missing) if missing else part


def _start_of(path: Path) -> bytes:
    """Return the first bytes of a file, unpacked; none if it cannot be read, which `read` reports."""
    if not path.is_file():
        return b""
    try:
        with (gzip.open if path.suffix.lower() == ".gz" else open)(path, "rb") as file:
            start = Source(bytes(file.read(N_START)), str(path))
        return start.as_utf8().data
    except FileFormatError:  # a letter is cut in two
        return b""
    except (OSError, EOFError, ValueError):
        return b""


@contextmanager
def open_source(path: Path, row: Format, progress: ProgressCallback | None = None) -> Iterator[Source]:
    """Open a file, or a folder that is a file of its format; text becomes UTF-8."""
    if row.folder is not None and path.is_dir():
        yield Source(b"", str(path), path, progress)
        return
    with path.open("rb") as file:
        try:
            with naming(path):
                source = _open(file, path, progress)
                opened = source.as_utf8() if row.text else source
            yield opened
        except FileFormatError:
            with naming(path):
                file.seek(0)
                start = file.read(len(MAGIC))
            if path.suffix.lower() == ".gz" or start != MAGIC:
                raise
            raise FileFormatError(f"{path}: is packed by gzip; add .gz to its name, or unpack it") from None


def _open(file: BinaryIO, path: Path, progress: ProgressCallback | None) -> Source:
    """Return the bytes of a file, unpacked."""
    packed = path.suffix.lower() == ".gz"
    source = PackedSource(file, str(path), progress) if packed else Source(file, str(path), path, progress)
    if not source.size:
        raise source.error(f"is empty; {BAD_COPY}")
    source.advance(0)
    return source
