"""Lines as data sets of VTK, and data sets as lines; the library ``vtk`` is imported where it is used.

Data sets: https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html. Cells of the types line and polyline
become strands, by their number among these cells. Other cells are left out. An array of points or cells whose name is
``radius``, in either case, is the radius. The texts ``unit`` and ``up`` are kept as arrays of the data set itself.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import MissingExtraError
from ..lines import AXES, Lines
from .polylines import polylines_of
from .source import Source
from .streamlines import with_values

AnyArray = npt.NDArray[Any]

RADIUS = "radius"
#: The types of cells that are read, and what others are called in warnings.
LINE, POLYLINE = 3, 4
_CURVES = {21: "quadratic edges", 35: "cubic lines", 68: "Lagrange curves", 75: "Bezier curves"}


def library(module: str) -> Any:
    """Import a module of VTK, which is optional."""
    try:
        return importlib.import_module(f"vtkmodules.{module}")
    except ImportError:
        raise MissingExtraError("reading and writing VTK's formats", "vtk") from None


@dataclass(frozen=True)
class Cells:
    """Cells as rows of points: those of the line cells of a data set, which they are, and the number of others."""

    points: npt.NDArray[np.int64]
    counts: npt.NDArray[np.int64]
    rows: npt.NDArray[np.int64]
    others: dict[str, int]


def lines_of(source: Source, data: Any, invalid: str) -> Lines:
    """Return the lines of a ``vtkPolyData`` or a ``vtkUnstructuredGrid``."""
    cells = _grid_cells(data) if data.IsA("vtkUnstructuredGrid") else _polydata_cells(data)
    left_out = [f"{n} {what}" for what, n in cells.others.items() if n]
    if left_out:
        source.warn(f"{', '.join(left_out)} are left out; only lines and polylines are read")
    points = numbers(data.GetPoints().GetData()) if data.GetPoints() else None
    points = np.empty((0, 3), np.float32) if points is None else points
    n_points = len(points)
    ids = cells.points
    if len(ids) and (ids.min() < 0 or ids.max() >= n_points):
        raise source.error(
            f"its cells are of points {ids.min()} to {ids.max()}, but it has {n_points} points; the file is damaged"
        )

    # Gather values per point and per cell; one of them may be the radius.
    per_point = {name: values[ids] for name, values in _arrays(source, data.GetPointData(), n_points, "points").items()}
    per_cell = _arrays(source, data.GetCellData(), data.GetNumberOfCells(), "cells")
    per_cell = {name: values[cells.rows] for name, values in per_cell.items()}
    radius = _take_radius(source, per_point)
    if radius is None and (of_cells := _take_radius(source, per_cell)) is not None:
        radius = np.repeat(of_cells, cells.counts)
    lines = Lines.from_points(points[ids], cells.counts, radius=radius, attributes=per_point, invalid=invalid)
    texts = _texts(source, data.GetFieldData())
    return replace(with_values(lines, per_cell, "cell"), unit=texts.get("unit"), up=texts.get("up"))


def polydata_of(lines: Lines) -> tuple[Any, list[str]]:
    """Return lines as ``vtkPolyData`` with a polyline for each strand, and what it cannot hold, in words."""
    core, model = library("vtkCommonCore"), library("vtkCommonDataModel")
    support = library("util.numpy_support")
    parts = polylines_of(lines)
    lost = list(parts.lost)

    def as_vtk(values: AnyArray, name: str) -> Any:
        array = support.numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        return array

    data, points, cells = model.vtkPolyData(), core.vtkPoints(), model.vtkCellArray()
    points.SetData(as_vtk(parts.points, "points"))
    cells.SetData(
        support.numpy_to_vtkIdTypeArray(parts.offsets, deep=True),
        support.numpy_to_vtkIdTypeArray(np.arange(len(parts.points)), deep=True),
    )
    data.SetPoints(points)
    data.SetLines(cells)
    if parts.radius is not None:
        data.GetPointData().AddArray(as_vtk(parts.radius, RADIUS))
    for target, several in (
        (data.GetPointData(), parts.point_attributes),
        (data.GetCellData(), parts.attributes),
    ):
        for name, values in several.items():
            if values.dtype.kind not in "fiub" or values.dtype.itemsize > 8 or values.ndim > 2 or 0 in values.shape[1:]:
                lost.append(f"{name!r}, {values.dtype} of shape {values.shape}")
                continue
            if values.dtype.kind == "b":
                lost.append(f"that {name!r} is boolean (0 and 1 are written)")
            if name.casefold() == RADIUS:
                lost.append(f"that {name!r} is an attribute (it is written as {f'{name} of lines'!r})")
                name = f"{name} of lines"
            target.AddArray(as_vtk(_native(values), name))
    for name, text in (("unit", lines.unit), ("up", lines.up)):
        if text is not None:
            strings = core.vtkStringArray()
            strings.SetName(name)
            strings.InsertNextValue(text)
            data.GetFieldData().AddArray(strings)
    strand = parts.strand
    if (strand >= 0).any() and not np.array_equal(strand, np.arange(len(strand))):
        lost.append("numbers of strands (polylines are counted from 0)")
    return data, lost


def _native(values: AnyArray) -> AnyArray:
    """Return values in a type that VTK has."""
    wanted = {"b": np.dtype(np.uint8), "f": np.dtype(f"f{max(values.dtype.itemsize, 4)}")}
    return values.astype(wanted.get(values.dtype.kind, values.dtype.newbyteorder("=")), copy=False)


def numbers(array: Any) -> AnyArray | None:
    """Return an array of VTK as one of NumPy; None if it does not hold numbers."""
    core, support = library("vtkCommonCore"), library("util.numpy_support")
    if not array.IsA("vtkDataArray"):
        return None
    if array.IsA("vtkBitArray") or not array.HasStandardMemoryLayout():
        plain = core.vtkUnsignedCharArray() if array.IsA("vtkBitArray") else array.NewInstance()
        if not plain.HasStandardMemoryLayout():  # implicit arrays make their like
            plain = core.vtkDataArray.CreateDataArray(array.GetDataType())
        plain.DeepCopy(array)
        array = plain
    return np.array(support.vtk_to_numpy(array))


def _arrays(source: Source, data: Any, n: int, what: str) -> dict[str, AnyArray]:
    """Return the arrays of points or cells by name; warn of those that hold no numbers, or not n rows."""
    found: dict[str, AnyArray] = {}
    for i in range(data.GetNumberOfArrays()):
        array = data.GetAbstractArray(i)
        name = array.GetName() or f"values {i}"
        values = numbers(array)
        if values is None or len(values) != n:
            why = "holds no numbers" if values is None else f"has {len(values)} rows for {n} {what}"
            source.warn(f"its array {name!r} {why}, and is left out")
        elif name in found:
            source.warn(f"one of its arrays {name!r} is left out, as another one has the same name")
        else:
            found[name] = values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values
    return found


def _take_radius(source: Source, arrays: dict[str, AnyArray]) -> AnyArray | None:
    """Remove the radius from arrays, and return it if there is one."""
    name = next((name for name, values in arrays.items() if name.casefold() == RADIUS and values.ndim == 1), None)
    return None if name is None else source.radius(f"values of {name!r}", arrays.pop(name))


def _texts(source: Source, data: Any) -> dict[str, str]:
    """Return the unit and the upward axis that `polydata_of` wrote; warn of all else that belongs to no point."""
    found: dict[str, str] = {}
    other = []
    for i in range(data.GetNumberOfArrays()):
        array = data.GetAbstractArray(i)
        name = array.GetName() or f"values {i}"
        text = array.GetValue(0) if array.IsA("vtkStringArray") and array.GetNumberOfValues() == 1 else ""
        if (name == "up" and text in AXES) or (name == "unit" and text and text.isprintable()):
            found[name] = text
        else:
            other.append(repr(name))
    if other:
        source.warn(f"its field data {', '.join(other)} are left out, as they belong to no point and no cell")
    return found


def _cell_rows(array: Any) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the points of all cells, and the number of points of each."""
    offsets, points = numbers(array.GetOffsetsArray()), numbers(array.GetConnectivityArray())
    if offsets is None or points is None or not len(offsets):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    return points.astype(np.int64, copy=False), np.asarray(np.diff(offsets.astype(np.int64)), np.int64)


def _polydata_cells(data: Any) -> Cells:
    points, counts = _cell_rows(data.GetLines())
    others = {
        "vertices": data.GetNumberOfVerts(),
        "polygons": data.GetNumberOfPolys(),
        "triangle strips": data.GetNumberOfStrips(),
    }
    return Cells(points, counts, data.GetNumberOfVerts() + np.arange(len(counts)), others)


def _grid_cells(data: Any) -> Cells:
    points, counts = _cell_rows(data.GetCells())
    if not len(counts):
        return Cells(points, counts, counts, {})
    types = np.array([data.GetCellType(i) for i in range(len(counts))])
    is_line = (types == LINE) | (types == POLYLINE)
    others = {what: int((types == number).sum()) for number, what in _CURVES.items()}
    others["other cells"] = int((~is_line).sum()) - sum(others.values())
    return Cells(points[np.repeat(is_line, counts)], counts[is_line], np.flatnonzero(is_line), others)
