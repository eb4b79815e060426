"""Figures as files, which appear whole or not at all; the same figure gives the same bytes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from ..support.atomic_write import atomic_write
from .axes import DPI, library

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The formats of drawings, by extension, and the fields of their metadata that would tell when they were written.
FORMATS = {".svg": {"Date": None}, ".png": {"Software": None}, ".pdf": {"CreationDate": None}, ".webp": None}


def check_drawing_path(path: str | os.PathLike[str]) -> str:
    """Return the extension of the file of a drawing; refuse others.

    Examples
    --------
    >>> check_drawing_path("tree.SVG")
    '.svg'
    """
    extension = Path(path).suffix.lower()
    if extension not in FORMATS:
        expected = ", ".join(FORMATS)
        raise InputError(
            f"{path}: unknown extension {extension or '(none)'!r} for a drawing; expected one of {expected}"
        )
    return extension


def write_drawing(path: str | os.PathLike[str], figure: Figure) -> None:
    """Write a figure as .svg, .png, .pdf or .webp, which is the smallest.

    Raises
    ------
    InputError
        If the extension is another one.
    """
    extension = check_drawing_path(path)
    with library().rc_context({"svg.hashsalt": "fastlines"}), atomic_write(path) as partial:
        figure.savefig(partial, format=extension[1:], metadata=FORMATS[extension], dpi=DPI)
