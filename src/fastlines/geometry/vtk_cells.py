"""Cells and arrays of VTK as lines: the one rule for data sets in files and for meshes in memory.

- Cells that are lines become strands, by their number among the lines.
- An array of points or of cells whose name is ``radius``, in upper or lower case, is the radius; points come first.
- Other arrays are attributes. Where an array of cells has a name that is taken, `` of cell`` is appended to it.
- The texts ``unit`` and ``up`` in the field data are the unit and the upward axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import AnyArray, IntArray
from .lines import AXES, Lines
from .strand_attributes import with_strand_values

RADIUS = "radius"
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
    invalid : {"error", "skip"}
        As in `Lines.from_points`.
    warn : callable
        Takes what is left out, in words.
    check : callable, optional
        Takes what the radius is called, and the radius; returns it, or raises.
    """
    per_point, per_cell = dict(per_point), dict(per_cell)
    radius = _take_radius(per_point, check)
    if radius is None and (of_cells := _take_radius(per_cell, check)) is not None:
        radius = np.repeat(of_cells, counts)
    texts = _texts(field_data, warn)
    made = Lines.from_points(points, counts, radius=radius, attributes=per_point, invalid=invalid)

    # A second radius is an attribute of cells.
    second = {
        name: f"{name} of cell" for name, values in per_cell.items() if radius is not None and _is_radius(name, values)
    }
    made = with_strand_values(made, {second.get(name, name): values for name, values in per_cell.items()}, "cell")
    return replace(made, unit=texts.get("unit"), up=texts.get("up"))


def _is_radius(name: str, values: AnyArray) -> bool:
    return name.casefold() == RADIUS and values.ndim == 1 and values.dtype.kind in "fiub"


def _take_radius(arrays: dict[str, AnyArray], check: Callable[[str, AnyArray], AnyArray]) -> AnyArray | None:
    """Remove the radius from arrays, and return it if there is one."""
    name = next((name for name, values in arrays.items() if _is_radius(name, values)), None)
    return None if name is None else check(f"values of {name!r}", arrays.pop(name))


def _texts(arrays: Mapping[str, AnyArray], warn: Callable[[str], None]) -> dict[str, str]:
    """Return the unit and the upward axis; warn of all else that belongs to no point and no cell."""
    found: dict[str, str] = {}
    other = []
    for name, values in arrays.items():
        text = str(values.reshape(-1)[0]) if values.dtype.kind == "U" and values.size == 1 else ""
        if (name == "up" and text in AXES) or (name == "unit" and text and text.isprintable()):
            found[name] = text
        else:
            other.append(repr(name))
    if other:
        warn(f"its field data {', '.join(other)} are left out: they belong to no point and no cell")
    return found
