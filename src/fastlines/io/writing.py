"""Writes lines to files."""

from __future__ import annotations

import gzip
import os
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ..errors import FileWarning, InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.collection import Geometry
from ..geometry.foreign import lines as as_lines
from ..geometry.offsets import NO_OFFSET, OFFSET, with_offset
from ..support.atomic_write import atomic_write
from ..support.texts import counted
from ..support.warn_caller import warn_caller
from .format import Format
from .table import extension_of, known_formats, path_of, to_write


def write(path: str | os.PathLike[str], lines: Any, **options: Any) -> None:
    """Write lines or curves to a file; its extension, in either case, names the format.

    The file appears whole or not at all. Points keep their bits where the format stores float32.

    Parameters
    ----------
    path : str or path-like
        A file with the extension of a format that is written, packed by gzip if ``.gz`` follows. The error for any
        other extension lists those.
    lines : Lines, Curves, or what `fastlines.lines` takes
        Where the format has no curves, they are cut into the pieces that queries test, which keep their attributes.
    **options
        Options of the format, such as ``reference=`` of ``.trk`` and ``.trx``: whose voxel grid is written.

    Raises
    ------
    InputError
        If no format has this extension, `lines` are not lines, or the format has no such option.
    MissingExtraError
        If the format needs a library that is not there.
    OSError
        If the file cannot be written.

    Warns
    -----
    FileWarning
        Of everything that the format cannot hold.

    Examples
    --------
    >>> import os, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "cross.npz")
    >>> write(path, [[[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]]])
    >>> from fastlines.io import read
    >>> len(read(path))
    2
    """
    if isinstance(lines, str | os.PathLike):
        raise InputError(f"lines are {str(lines)!r}, the name of a file; the name comes first: fl.write(path, lines)")
    target = path_of(path)
    row = to_write(target)
    row.check_options(str(target), options, "write")
    try:
        geometry, lost = to_written(lines, row.writes)
    except InputError as error:
        raise InputError(f"{target}: {error}") from None
    if row.module is not None and geometry.offset != NO_OFFSET:  # writers of others know of no offset
        geometry = with_offset(geometry, None)
    extension, packed = extension_of(target)
    # Libraries want the usual extension, and gzip a whole file.
    with atomic_write(target) as partial, TemporaryDirectory(prefix=partial.name, dir=partial.parent) as folder:
        plain = Path(folder) / f"lines{extension}"
        try:
            lost += row.write(geometry, plain, **options) or []
        except InputError as error:
            raise InputError(f"{target}: {error}") from None
        with plain.open("rb") as file, gzip.open(partial, "wb") if packed else partial.open("wb") as out:
            shutil.copyfileobj(file, out)
    if row.metadata != "kept":
        names = dict.fromkeys(name for part in geometry.each_part() for name in part.metadata if name != OFFSET)
        lost += [f"the metadata {name!r}" for name in names if name not in row.metadata]
    n_skipped = lines.n_skipped if isinstance(lines, AnyGeometry) else 0
    if n_skipped:
        lost.append(f"{counted(n_skipped, 'rows')} of the input, skipped for NaN or Inf")
    if lost:
        lost = list(dict.fromkeys(lost))
        why = "not kept, as the format has no place for it"
        warn_caller(f"{target}: {why}: {'; '.join(lost)}", FileWarning)


def parts_to_write(lines: Any, row: Format) -> list[AnyGeometry]:
    """Return the lines and curves that a file of a format holds once they are written."""
    return [part for part in to_written(lines, row.writes)[0].each_part() if part.is_plain]


def count_strands(part: AnyGeometry, row: Format) -> int:
    """Return how many strands a file of a format holds of lines or curves that are written to it.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.io import known_formats
    >>> gap = fl.Lines.from_segments([[[0, 0, 0], [1, 0, 0]], [[2, 0, 0], [3, 0, 0]]], strands=[0, 0])
    >>> [count_strands(gap, known_formats()[name]) for name in (".npz", ".tck", ".npy")]
    [1, 2, 0]
    """
    if row.strands == "polylines":
        return int(part.begins().sum())
    return part.n_strands if row.strands == "kept" else 0


def to_written(
    lines: Any, known: tuple[type[Any], ...], keeper: str = "files", call: str = "fl.write(path, {})"
) -> tuple[Any, list[str]]:
    """Return what a writer takes, and what was lost on the way; errors name what keeps it, and the call that does."""
    geometry = lines if isinstance(lines, AnyGeometry) else as_lines(lines)
    if type(geometry) in known:
        return geometry, []
    straight = geometry.as_lines()
    if straight is not None:
        return straight, [] if straight is geometry else ["curves, which are written as their pieces"]
    if geometry.has_parts:
        each = geometry.each_part()
        several = ", ".join(extension for extension, row in known_formats().items() if Geometry in row.writes)
        parts = ", ".join(f"part {i} ({part.count_text()})" for i, part in enumerate(each)) or "no parts"
        first = next((i for i, part in enumerate(each) if part.is_plain), 0)
        raise InputError(
            f"this is a Geometry of {parts}, and such {keeper} hold one part; write all parts to one of {several}, or "
            f"one by itself, as in {call.format(f'geometry.parts[{first}]')}"
        )
    raise InputError(
        f"this is {type(geometry).__name__}; {keeper} hold Lines or Curves: give those, or save a tree over it, which "
        "keeps it (tree.save)"
    )
