"""Writes lines to files."""

from __future__ import annotations

import gzip
import os
import shutil
import tempfile
import warnings
from pathlib import Path
from typing import Any

from ..atomic_write import atomic_write
from ..curves import Curves
from ..errors import FileWarning, InputError
from ..geometry import AnyGeometry, Geometry
from ..lines import Lines
from ..objects import lines as as_lines
from .table import FORMATS, extension_of, to_write


def write(path: str | os.PathLike[str], lines: Any) -> None:
    """Write lines or curves to a file; its extension, in either case, names the format.

    The file appears whole or not at all. Points keep their bits where the format stores float32.

    Parameters
    ----------
    path : str or path-like
        A file with one of the extensions that `docs/formats.md` lists as written, packed by gzip if ``.gz`` follows.
    lines : Lines, Curves, or what `fastlines.lines` takes
        Curves are cut into the pieces that queries test, where the format has no curves.

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
    try:
        target = Path(path)
    except TypeError:
        raise InputError(f"path is a {type(path).__name__}; expected a str or a path") from None
    row = to_write(target)
    geometry, lost = to_written(lines, row.writes)
    extension, packed = extension_of(target)
    # Libraries want the usual extension, and gzip a whole file.
    with atomic_write(target) as partial, tempfile.TemporaryDirectory(dir=partial.parent) as folder:
        plain = Path(folder) / f"lines{extension}"
        lost += row.write(geometry, plain)
        with plain.open("rb") as file, gzip.open(partial, "wb") if packed else partial.open("wb") as out:
            shutil.copyfileobj(file, out)
    if lost:
        why = "not kept, as the format has no place for it"
        warnings.warn(f"{target}: {why}: {'; '.join(lost)}", FileWarning, stacklevel=2)


def to_written(lines: Any, known: tuple[type[Any], ...], keeper: str = "files") -> tuple[Any, list[str]]:
    """Return what a writer takes, and what was lost on the way; `keeper` is what keeps it, in errors."""
    geometry = lines if isinstance(lines, AnyGeometry) else as_lines(lines)
    if type(geometry) in known:
        return geometry, []
    if isinstance(geometry, Curves):
        return geometry.pieces.lines, ["curves, which are written as their pieces, and their attributes"]
    if type(geometry) is Lines:
        return geometry, []
    if isinstance(geometry, Geometry):
        several = ", ".join(extension for extension, row in FORMATS.items() if Geometry in row.writes)
        raise InputError(
            f"this is a Geometry, and these {keeper} hold one part; give each of geometry.parts by itself, or write "
            f"all of them to one of {several}"
        )
    raise InputError(
        f"this is {type(geometry).__name__}; {keeper} hold Lines or Curves: give those, or save a tree over it, which "
        "keeps it (tree.save)"
    )
