"""Cells and arrays of VTK as lines: the one rule for data sets in files and for meshes in memory.

- Cells that are lines become strands, by their number among the lines.
- An array of points or of cells whose name is ``radius``, in upper or lower case, is the radius; points come first. A
  reader's option can name another array; then one of the name ``radius`` is an attribute.
- Other arrays are attributes. Where an array of cells has a name that is taken, `` of cell`` is appended to it.
- The texts ``unit`` and ``up`` in the field data are the unit and the upward axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..arrays import AnyArray, IntArray
from ..errors import InputError
from .lines import AXES, Lines
from .strand_attributes import with_strand_values

RADIUS = "radius"
#: The types of cells that are lines.
LINE, POLYLINE = 3, 4
_NO_INTS = np.empty(0, np.int64)


@dataclass
class Cells:
    """Cells of one kind, or of all kinds.

    Attributes
    ----------
    points : (m,) int64
        The points of all cells, one cell after the other.
    counts : (n,) int64
        How many points each cell has.
    """

    points: IntArray = field(default_factory=lambda: _NO_INTS)
    counts: IntArray = field(default_factory=lambda: _NO_INTS)


def cells_in_rows(rows: AnyArray) -> Cells | None:
    """Return cells, given the number of points of each and then its points; None if there are fewer points."""
    rows = np.ascontiguousarray(rows, np.int64)
    numbers: memoryview[int] = rows.data
    begins: list[int] = []
    at = 0
    while at < len(rows):
        begins.append(at)
        if numbers[at] < 0:
            return None
        at += 1 + numbers[at]
    if at != len(rows):
        return None
    is_point = np.ones(len(rows), np.bool_)
    is_point[begins] = False
    return Cells(rows[is_point], rows[begins] if begins else _NO_INTS)


def line_cells(cells: Cells, types: AnyArray) -> tuple[Cells, IntArray]:
    """Return the cells that are lines, and their rows among cells of these types."""
    is_line = (types == LINE) | (types == POLYLINE)
    return Cells(cells.points[np.repeat(is_line, cells.counts)], cells.counts[is_line]), np.flatnonzero(is_line)


def lines_of_cells(
    points: AnyArray,
    counts: IntArray,
    per_point: Mapping[str, AnyArray],
    per_cell: Mapping[str, AnyArray],
    field_data: Mapping[str, AnyArray],
    *,
    invalid: str,
    warn: Callable[[str], None],
    check: Callable[[str, AnyArray], AnyArray] = lambda what, values: values,
    radius_name: str | None = None,
    offset: Any = None,
) -> Lines:
    """Return lines of cells that are lines.

    Parameters
    ----------
    points : (m, 3) array
        The points of all cells, one cell after the other.
    counts : (k,) int64
        How many points each cell has.
    per_point, per_cell : mapping of str to array
        Values of these points, m rows, and of these cells, k rows.
    field_data : mapping of str to array
        What belongs to the data set as a whole.
    invalid, offset
        As in `Lines.from_points`.
    warn : callable
        Takes what is left out, in words.
    check : callable, optional
        Takes what the radius is called, and the radius; returns it, or raises.
    radius_name : str, optional
        The array that is the radius.

    Raises
    ------
    InputError
        If no array of numbers, one each, has the name of the radius.
    """
    per_point, per_cell = dict(per_point), dict(per_cell)
    radius = _take_radius(per_point, check, radius_name)
    if radius is None and (of_cells := _take_radius(per_cell, check, radius_name)) is not None:
        radius = np.repeat(of_cells, counts)
    if radius is None and radius_name is not None:
        arrays = {**per_point, **per_cell}
        known = ", ".join(repr(name) for name, values in arrays.items() if _is_number(values)) or "none"
        raise InputError(f"there is no array {radius_name!r} of one number each for the radius; those are: {known}")
    if radius_name is not None:
        per_point = {f"{name} of point" if _is_radius(name, v) else name: v for name, v in per_point.items()}
    texts = _texts(field_data, warn)
    made = Lines.from_points(points, counts, radius=radius, attributes=per_point, offset=offset, invalid=invalid)

    # A second radius is an attribute of cells.
    second = {
        name: f"{name} of cell" for name, values in per_cell.items() if radius is not None and _is_radius(name, values)
    }
    made = with_strand_values(made, {second.get(name, name): values for name, values in per_cell.items()}, "cell")
    return replace(made, unit=texts.get("unit"), up=texts.get("up"))


def _is_number(values: AnyArray) -> bool:
    return values.ndim == 1 and values.dtype.kind in "fiub"


def _is_radius(name: str, values: AnyArray) -> bool:
    return name.casefold() == RADIUS and _is_number(values)


def _take_radius(
    arrays: dict[str, AnyArray], check: Callable[[str, AnyArray], AnyArray], wanted: str | None
) -> AnyArray | None:
    """Remove the radius from arrays, and return it if there is one: the wanted array, or that of the usual name."""
    is_it = _is_radius if wanted is None else lambda name, values: name == wanted and _is_number(values)
    name = next((name for name, values in arrays.items() if is_it(name, values)), None)
    return None if name is None else check(f"values of {name!r}", arrays.pop(name))


def _texts(arrays: Mapping[str, AnyArray], warn: Callable[[str], None]) -> dict[str, str]:
    """Return the unit and the upward axis; warn of all else that belongs to no point and no cell."""
    found: dict[str, str] = {}
    other = []
    for name, values in arrays.items():
        text = str(values.reshape(-1)[0]) if values.dtype.kind in "OU" and values.size == 1 else ""
        if (name == "up" and text in AXES) or (name == "unit" and text and text.isprintable()):
            found[name] = text
        else:
            other.append(repr(name))
    if other:
        warn(f"its field data {', '.join(other)} are left out: they belong to no point and no cell")
    return found
