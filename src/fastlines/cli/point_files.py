"""Points, as ``fastlines nearest`` and ``fastlines within`` read them."""

from __future__ import annotations

import csv
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import InputError
from ..support.optional import optional
from .array_files import load_array, load_arrays
from .files import open_input

#: The columns of a table that are the coordinates.
AXES = ("x", "y", "z")
#: What separates the columns of a table in text, by the extension.
SEPARATORS = {".csv": ",", ".tsv": "\t"}


def point_of(text: str) -> npt.NDArray[np.float64] | None:
    """Return the point that a text such as 1,2.5,-3 is, (1, 3); None for anything else, such as the name of a file.

    Examples
    --------
    >>> point_of("-1,2.5e3,.7").tolist(), point_of("points.npy"), point_of("1,2")
    ([[-1.0, 2500.0, 0.7]], None, None)
    """
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        return None
    return np.array([[x, y, z]])


def read_points(text: str) -> npt.NDArray[Any]:
    """Return the point that a text is, or the points of a file, (n, 3); a query checks their values."""
    points: npt.NDArray[Any] | None = point_of(text)
    if points is not None:
        return points
    extension = Path(text).suffix.lower()
    if extension == ".npy":
        points = load_array(text, "points")
    elif extension == ".npz":
        arrays = load_arrays(text, "points", ("points", "counts"))
        # With counts they are the points of strands, which may have an offset.
        points = None if "counts" in arrays else arrays.get("points")
    elif extension in SEPARATORS:
        points = _of_text(text, SEPARATORS[extension])
    elif extension == ".parquet":
        points = _of_parquet(text)
    if points is None:
        points = _of_lines(text)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{text}: has the shape {points.shape}; expected (n, 3): x, y and z of each point")
    return points


def _of_text(path: str, separator: str) -> npt.NDArray[Any]:
    """Read a table in text: with a header that has x, y and z, or without one, of three columns."""
    with open(path, encoding="utf-8-sig", errors="replace", newline="") as file:
        first = [cell.strip() for cell in next(csv.reader([file.readline()], delimiter=separator), [])]
        names = [cell.lower() for cell in first]
        has_header = {*AXES} <= {*names}
        if not has_header and (len(first) != 3 or point_of(",".join(names)) is None):
            shown = ", ".join(first)[:60] or "nothing"
            raise InputError(
                f"{path}: begins with {shown}; expected a header with x, y and z, or three numbers in each row"
            )
        if has_header and (twice := [axis for axis in AXES if names.count(axis) > 1]):
            raise InputError(f"{path}: has several columns {twice[0]}; expected one each of x, y and z")
        if not has_header:
            file.seek(0)
        columns = [names.index(axis) for axis in AXES] if has_header else [0, 1, 2]
        try:
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "loadtxt: input contained no data")
                return np.loadtxt(
                    file, delimiter=separator, usecols=columns, ndmin=2, comments=None, quotechar='"'
                ).reshape(-1, 3)
        except ValueError as error:
            raise InputError(f"{path}: the columns x, y and z cannot be read as numbers: {error}") from None


def _of_parquet(path: str) -> npt.NDArray[Any] | None:
    """Read the columns x, y and z; None if there are no such columns."""
    parquet = optional("pyarrow.parquet", "reading .parquet", "arrow")
    try:
        if not {*AXES} <= {*parquet.read_schema(path).names}:
            return None
        table = parquet.read_table(path, columns=list(AXES))
        return np.stack([np.asarray(table.column(axis), np.float64) for axis in AXES], axis=1)
    except FileNotFoundError:
        raise
    except (OSError, TypeError, ValueError, MemoryError) as error:
        why = " ".join(str(error).split())[:120]
        raise InputError(f"{path}: the columns x, y and z cannot be read as numbers: {why}") from None


def _of_lines(text: str) -> npt.NDArray[Any]:
    """Return the points of lines, or the centres of spheres; each once where it is all of a strand."""
    if "," in text and not Path(text).exists():
        raise InputError(f"{text}: no such file, and not three numbers separated by commas, such as 1,2.5,-3")
    lines = open_input(text).lines
    points, first = lines.points, lines.offsets[:-1]
    if not len(first):
        return points
    alone = first[(np.diff(lines.offsets) == 2) & (points[first] == points[first + 1]).all(axis=1)]
    return np.delete(points, alone, axis=0)
