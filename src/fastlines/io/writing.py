"""Writes lines to files."""

from __future__ import annotations

import gzip
import os
import shutil
import tempfile
import warnings
from pathlib import Path
from typing import Any

from ..errors import FileWarning, InputError
from ..geometry.collection import AnyGeometry, Geometry, count_text, counted, parts_of
from ..geometry.curves import Curves
from ..geometry.foreign import lines as as_lines
from ..geometry.lines import Lines
from ..support.atomic_write import atomic_write
from .curves_as_lines import curves_as_lines
from .format import Format
from .polylines import begins_of
from .table import extension_of, known_formats, path_of, to_write


def write(path: str | os.PathLike[str], lines: Any) -> None:
    """Write lines or curves to a file; its extension, in either case, names the format.

    The file appears whole or not at all. Points keep their bits where the format stores float32.

    Parameters
    ----------
    path : str or path-like
        A file with the extension of a format that is written, packed by gzip if ``.gz`` follows. The error for any
        other extension lists those.
    lines : Lines, Curves, or what `fastlines.lines` takes
        Where the format has no curves, they are cut into the pieces that queries test, which keep their attributes.

    Raises
    ------
    InputError
        If no format has this extension, or `lines` are not lines.
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
    try:
        geometry, lost = to_written(lines, row.writes)
    except InputError as error:
        raise InputError(f"{target}: {error}") from None
    extension, packed = extension_of(target)
    # Libraries want the usual extension, and gzip a whole file.
    with atomic_write(target) as partial, tempfile.TemporaryDirectory(dir=partial.parent) as folder:
        plain = Path(folder) / f"lines{extension}"
        lost += row.write(geometry, plain)
        with plain.open("rb") as file, gzip.open(partial, "wb") if packed else partial.open("wb") as out:
            shutil.copyfileobj(file, out)
    n_skipped = sum(len(part.skipped) for part in parts_of(lines) if isinstance(part, Lines | Curves))
    if n_skipped:
        lost.append(f"{counted(n_skipped, 'rows')} of the input, skipped for NaN or Inf")
    if lost:
        lost = list(dict.fromkeys(lost))
        why = "not kept, as the format has no place for it"
        warnings.warn(f"{target}: {why}: {'; '.join(lost)}", FileWarning, stacklevel=2)


def parts_to_write(lines: Any, row: Format) -> list[Lines | Curves]:
    """Return the lines and curves that a file of a format holds once they are written."""
    return [part for part in parts_of(to_written(lines, row.writes)[0]) if isinstance(part, Lines | Curves)]


def count_strands(part: Lines | Curves, row: Format) -> int:
    """Return how many strands a file of a format holds of lines or curves that are written to it.

    Examples
    --------
    >>> from fastlines.io import known_formats
    >>> gap = Lines.from_segments([[[0, 0, 0], [1, 0, 0]], [[2, 0, 0], [3, 0, 0]]], strands=[0, 0])
    >>> [count_strands(gap, known_formats()[name]) for name in (".npz", ".tck", ".npy")]
    [1, 2, 0]
    """
    if row.strands == "polylines":
        return int(begins_of(part).sum())
    return part.n_strands if row.strands == "kept" else 0


def to_written(
    lines: Any, known: tuple[type[Any], ...], keeper: str = "files", call: str = "fl.write(path, {})"
) -> tuple[Any, list[str]]:
    """Return what a writer takes, and what was lost on the way; errors name what keeps it, and the call that does."""
    geometry = lines if isinstance(lines, AnyGeometry) else as_lines(lines)
    if type(geometry) in known:
        return geometry, []
    if isinstance(geometry, Curves):
        return curves_as_lines(geometry), ["curves, which are written as their pieces"]
    if type(geometry) is Lines:
        return geometry, []
    if isinstance(geometry, Geometry):
        several = ", ".join(extension for extension, row in known_formats().items() if Geometry in row.writes)
        parts = ", ".join(f"part {i} ({count_text(part)})" for i, part in enumerate(geometry.parts)) or "no parts"
        first = next((i for i, part in enumerate(geometry.parts) if type(part) in (Lines, Curves)), 0)
        raise InputError(
            f"this is a Geometry of {parts}, and such {keeper} hold one part; write all parts to one of {several}, or "
            f"one by itself, as in {call.format(f'geometry.parts[{first}]')}"
        )
    raise InputError(
        f"this is {type(geometry).__name__}; {keeper} hold Lines or Curves: give those, or save a tree over it, which "
        "keeps it (tree.save)"
    )
