"""Data sets of VTK as lines, whichever file they are from: `vtk_legacy` and `vtk_xml` read them.

Cells of the types line and polyline become strands, by their number among these cells; other cells are left out. An
array of points or cells whose name is ``radius``, in upper or lower case, is the radius. The texts ``unit`` and ``up``
in the field data of a data set are the unit and the upward axis, as `vtp` writes them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...lines import AXES, Lines
from ..source import Source
from .streamlines import with_values

AnyArray = npt.NDArray[Any]

RADIUS = "radius"
#: The types of cells that are read, and what some others are called in warnings.
LINE, POLYLINE = 3, 4
_CURVES = {21: "quadratic edges", 35: "cubic lines", 68: "Lagrange curves", 75: "Bezier curves"}
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


@dataclass
class DataSet:
    """What a file holds. Polydata has cells by kind, in the order of their values; a grid has cells with types."""

    points: AnyArray = field(default_factory=lambda: np.empty((0, 3), np.float32))
    cells: dict[str, Cells] = field(default_factory=dict)
    types: AnyArray | None = None
    point_data: dict[str, AnyArray] = field(default_factory=dict)
    cell_data: dict[str, AnyArray] = field(default_factory=dict)
    field_data: dict[str, AnyArray] = field(default_factory=dict)


#: The kinds of cells of polydata, in the order in which cell data count them, and what warnings call them.
KINDS = {"verts": "vertices", "lines": "lines", "polys": "polygons", "strips": "triangle strips"}


def lines_of(source: Source, data: DataSet, invalid: str) -> Lines:
    """Return the lines of a data set."""
    cells, rows, others = _line_cells(source, data)
    left_out = [f"{n} {what}" for what, n in others.items() if n]
    if left_out:
        source.warn(f"{', '.join(left_out)} left out: only lines and polylines are read")
    elif len(data.points) and not len(cells.counts):
        source.warn(f"its {len(data.points)} points are left out, as no line joins them")
    n_cells = len(cells.counts) + sum(others.values())
    ids, n_points = cells.points, len(data.points)
    if len(ids) and (ids.min() < 0 or ids.max() >= n_points):
        raise source.error(
            f"its lines are of points {ids.min()} to {ids.max()}, but it has {n_points} points; the file is damaged"
        )

    # Take the values of the points and cells that are read; one array may be the radius.
    per_point = {name: values[ids] for name, values in _checked(source, data.point_data, n_points, "points").items()}
    per_cell = {name: values[rows] for name, values in _checked(source, data.cell_data, n_cells, "cells").items()}
    radius = _take_radius(source, per_point)
    if radius is None and (of_cells := _take_radius(source, per_cell)) is not None:
        radius = np.repeat(of_cells, cells.counts)
    texts = _texts(source, data.field_data)
    lines = Lines.from_points(data.points[ids], cells.counts, radius=radius, attributes=per_point, invalid=invalid)
    return replace(with_values(lines, per_cell, "cell"), unit=texts.get("unit"), up=texts.get("up"))


def cells_of(source: Source, what: str, points: AnyArray, offsets: AnyArray) -> Cells:
    """Return cells, given their points and where each begins in them, (n + 1,)."""
    offsets = offsets.astype(np.int64)
    if offsets[0] != 0 or offsets[-1] != len(points) or (offsets[1:] < offsets[:-1]).any():
        raise source.error(
            f"the offsets of its {what} do not rise from 0 to the {len(points)} points that they have; "
            "the file is damaged"
        )
    return Cells(points.astype(np.int64), np.asarray(np.diff(offsets), np.int64))


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


def _line_cells(source: Source, data: DataSet) -> tuple[Cells, IntArray, dict[str, int]]:
    """Return the cells that are lines, their rows among all cells, and the numbers of other cells."""
    if data.types is None:
        counts = {kind: len(data.cells.get(kind, Cells()).counts) for kind in KINDS}
        lines = data.cells.get("lines", Cells())
        rows = counts["verts"] + np.arange(len(lines.counts))
        return lines, rows, {KINDS[kind]: n for kind, n in counts.items() if kind != "lines"}
    cells = data.cells.get("cells", Cells())
    if len(data.types) != len(cells.counts):
        raise source.error(f"it has {len(cells.counts)} cells, but the types of {len(data.types)}; it is damaged")
    is_line = (data.types == LINE) | (data.types == POLYLINE)
    others = {what: int((data.types == number).sum()) for number, what in _CURVES.items()}
    others["other cells"] = int((~is_line).sum()) - sum(others.values())
    used = Cells(cells.points[np.repeat(is_line, cells.counts)], cells.counts[is_line])
    return used, np.flatnonzero(is_line), others


def _checked(source: Source, arrays: Mapping[str, AnyArray], n: int, what: str) -> dict[str, AnyArray]:
    """Return the arrays of numbers with n rows; warn of others."""
    found: dict[str, AnyArray] = {}
    for name, values in arrays.items():
        if values.dtype.kind not in "fiub":
            source.warn(f"its array {name!r} holds no numbers, and is left out")
        elif len(values) != n:
            source.warn(f"its array {name!r} has {len(values)} rows for {n} {what}, and is left out")
        else:
            found[name] = values
    return found


def _take_radius(source: Source, arrays: dict[str, AnyArray]) -> AnyArray | None:
    """Remove the radius from arrays, and return it if there is one."""
    name = next((name for name, values in arrays.items() if name.casefold() == RADIUS and values.ndim == 1), None)
    return None if name is None else source.radius(f"values of {name!r}", arrays.pop(name))


def _texts(source: Source, arrays: Mapping[str, AnyArray]) -> dict[str, str]:
    """Return the unit and the upward axis; warn of all else that belongs to no point and no cell."""
    found: dict[str, str] = {}
    other = []
    for name, values in arrays.items():
        text = str(values[0]) if values.dtype.kind == "U" and values.shape == (1,) else ""
        if (name == "up" and text in AXES) or (name == "unit" and text and text.isprintable()):
            found[name] = text
        else:
            other.append(repr(name))
    if other:
        source.warn(f"its field data {', '.join(other)} are left out: they belong to no point and no cell")
    return found
