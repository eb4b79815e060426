"""Data sets of VTK as lines, whichever file they are from: `vtk_legacy` and `vtk_xml` read them.

Cells of the types line and polyline are read, and other cells are left out. `vtk_cells` says what becomes of their
arrays and of the field data, the same as for meshes of PyVista.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...arrays import AnyArray, IntArray
from ...geometry.lines import Lines
from ...geometry.vtk_cells import Cells, line_cells, lines_of_cells
from ..source import Source

#: Types of cells that are not read, and what they are called in warnings.
_CURVES = {21: "quadratic edges", 35: "cubic lines", 68: "Lagrange curves", 75: "Bezier curves"}
_NO_INTS = np.empty(0, np.int64)


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


def lines_of(source: Source, data: DataSet, invalid: str, radius: str | None) -> Lines:
    """Return the lines of a data set; `radius` names the array that is the radius."""
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

    # Take the values of the points and cells that are read.
    per_point = {name: values[ids] for name, values in _checked(source, data.point_data, n_points, "points").items()}
    per_cell = {name: values[rows] for name, values in _checked(source, data.cell_data, n_cells, "cells").items()}
    return lines_of_cells(
        data.points[ids],
        cells.counts,
        per_point,
        per_cell,
        data.field_data,
        invalid=invalid,
        warn=source.warn,
        check=source.radius,
        radius_name=radius,
        offset=source.offset,
    )


def cells_of(source: Source, what: str, points: AnyArray, offsets: AnyArray) -> Cells:
    """Return cells, given their points and where each begins in them, (n + 1,)."""
    offsets = offsets.astype(np.int64)
    if offsets[0] != 0 or offsets[-1] != len(points) or (offsets[1:] < offsets[:-1]).any():
        raise source.error(
            f"the offsets of its {what} do not rise from 0 to the {len(points)} points that they have; "
            "the file is damaged"
        )
    return Cells(points.astype(np.int64), np.asarray(np.diff(offsets), np.int64))


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
    used, rows = line_cells(cells, data.types)
    others = {what: int((data.types == number).sum()) for number, what in _CURVES.items()}
    others["other cells"] = len(data.types) - len(rows) - sum(others.values())
    return used, rows, others


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
