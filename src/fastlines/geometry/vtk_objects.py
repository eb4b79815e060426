"""Lines from meshes of VTK and PyVista in memory, which are recognised by their attributes: neither is imported here.

| object                                                         | recognised by                                    |
|----------------------------------------------------------------|--------------------------------------------------|
| ``PolyData`` of PyVista                                        | ``lines``, ``points``, ``point_data``, ``n_verts`` |
| ``UnstructuredGrid`` of PyVista                                | ``cells``, ``celltypes``, ``points``             |
| ``vtkPolyData``, ``vtkUnstructuredGrid``                       | ``GetLines``, or ``GetCells``; ``GetPointData``  |
| ``MultiBlock`` of PyVista, ``vtkMultiBlockDataSet``            | ``GetBlock``, ``GetNumberOfBlocks``              |

`vtk_cells` says what becomes of their arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..arrays import AnyArray, kind_of
from ..errors import InputError
from ..support.texts import kinds_text
from .join_lines import join_lines
from .lines import Lines
from .making import Making, flat_column, has
from .offsets import AUTO, middle_of
from .vtk_cells import cells_in_rows, line_cells, lines_of_cells

#: The attribute that counts the blocks of a MultiBlock.
BLOCK = "block"
#: Blocks in blocks, at most.
_MAX_DEPTH = 64


def of_vtk(obj: Any, how: Making) -> Lines | None:
    """Return the lines of a mesh or of several; None if the object is none."""
    if has(obj, "GetBlock", "GetNumberOfBlocks"):
        return _of_blocks(obj, how)
    if has(obj, "GetPointData", "GetCellData") and not has(obj, "point_data", "n_cells"):
        return _of_mesh(_as_pyvista(obj), kind_of(obj), how)
    return _of_mesh(obj, kind_of(obj), how)


def _of_mesh(mesh: Any, name: str, how: Making) -> Lines | None:
    if has(mesh, "lines", "points", "point_data", "cell_data"):
        rows = np.asarray(mesh.lines)
        # Cells are vertices, lines, faces and strips, in this order.
        first, n_cells, others = int(mesh.n_verts), int(mesh.n_cells), "vertices, faces or strips"
        types = None
    elif has(mesh, "cells", "celltypes", "points", "point_data", "cell_data"):
        rows, types = np.asarray(mesh.cells), np.asarray(mesh.celltypes)
        first, n_cells, others = 0, len(types), "neither lines nor polylines"
    else:
        return None
    points = np.asarray(mesh.points).reshape(-1, 3)
    cells = cells_in_rows(rows)
    used = np.arange(0 if cells is None else len(cells.counts))
    if cells is not None and types is not None:
        cells, used = line_cells(cells, types) if len(types) == len(cells.counts) else (None, used)
    if cells is None or ((cells.points < 0) | (cells.points >= len(points))).any():
        raise InputError(f"{name}: its lines name points beyond its {len(points)} points, or are cut short")
    if len(points) and not n_cells:
        how.warn(f"the {len(points)} points of {name} are not read, as no line joins them")
    if n_cells > len(cells.counts):
        how.warn(f"{n_cells - len(cells.counts)} cells of {name} are {others}, and are not read")
    return lines_of_cells(
        points[cells.points],
        cells.counts,
        {name: flat_column(values[cells.points]) for name, values in _items(mesh.point_data)},
        {name: flat_column(values[first + used]) for name, values in _items(mesh.cell_data)},
        dict(_items(getattr(mesh, "field_data", {}))),
        **how.options,
        warn=lambda text: how.warn(f"{name}: {text}"),
    )


def _of_blocks(obj: Any, how: Making) -> Lines:
    """Join the lines of all blocks, those in blocks too."""
    parts: list[Lines] = []
    numbers: list[int] = []
    others: dict[str, int] = {}
    blocks = list(_blocks(obj, 0))
    if how.offset == AUTO:  # the same one for all blocks
        places = [_points_of(block) for block in blocks if block is not None]
        how = replace(how, offset=middle_of(np.concatenate([np.empty((0, 3)), *places])))
    for number, block in enumerate(blocks):
        made = None if block is None else of_vtk(block, how)
        if made is not None:
            parts.append(made)
            numbers.append(number)
        elif block is not None:
            others[type(block).__name__] = others.get(type(block).__name__, 0) + 1
    if others:
        how.warn(f"blocks of {kind_of(obj)} that are no lines are not read: {kinds_text(others)}")
    if not parts:
        raise InputError(f"{kind_of(obj)} has no block of lines; expected a PolyData or an UnstructuredGrid in it")
    return join_lines(parts, BLOCK, numbers, lambda text: how.warn(f"{kind_of(obj)}: {text}"))


def _blocks(obj: Any, depth: int) -> Iterator[Any]:
    """Yield the blocks that are no blocks of blocks, in their order; None for one that is empty."""
    if depth > _MAX_DEPTH:
        raise InputError(f"{kind_of(obj)}: its blocks are nested more than {_MAX_DEPTH} deep")
    for i in range(obj.GetNumberOfBlocks()):
        block = obj.GetBlock(i)
        if has(block, "GetBlock", "GetNumberOfBlocks"):
            yield from _blocks(block, depth + 1)
        else:
            yield block


def _points_of(mesh: Any) -> AnyArray:
    """Return the points of a mesh of PyVista or VTK."""
    points = mesh.points if has(mesh, "point_data", "n_cells") else _as_pyvista(mesh).points
    return np.asarray(points).reshape(-1, 3)


def _as_pyvista(obj: Any) -> SimpleNamespace:
    """Return the arrays of an object of VTK by the names that PyVista gives them."""
    to_numpy = import_module("vtkmodules.util.numpy_support").vtk_to_numpy  # of the library that made the object

    def columns(data: Any) -> dict[str, AnyArray]:
        arrays = [data.GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
        return {array.GetName() or f"array {i}": _values(array, to_numpy) for i, array in enumerate(arrays)}

    def rows(cells: Any) -> AnyArray:
        ends, ids = to_numpy(cells.GetOffsetsArray()), to_numpy(cells.GetConnectivityArray())
        return np.insert(ids, ends[:-1], np.diff(ends)) if len(ends) else ids

    points = obj.GetPoints()
    found = SimpleNamespace(
        points=np.empty((0, 3), np.float32) if points is None else to_numpy(points.GetData()),
        point_data=columns(obj.GetPointData()),
        cell_data=columns(obj.GetCellData()),
        field_data=columns(obj.GetFieldData()),
        n_cells=obj.GetNumberOfCells(),
    )
    if has(obj, "GetLines", "GetNumberOfVerts"):
        found.lines, found.n_verts = rows(obj.GetLines()), obj.GetNumberOfVerts()
    elif has(obj, "GetCells", "GetCellType"):
        found.cells = rows(obj.GetCells())
        found.celltypes = np.array([obj.GetCellType(i) for i in range(found.n_cells)], np.int64)
    return found


def _values(array: Any, to_numpy: Callable[[Any], AnyArray]) -> AnyArray:
    """Return an array of VTK, which may hold texts."""
    if not array.IsA("vtkDataArray"):
        return np.array([str(array.GetValue(i)) for i in range(array.GetNumberOfValues())])
    return to_numpy(array)


def _items(data: Any) -> list[tuple[str, AnyArray]]:
    return [(str(name), np.asarray(data[name])) for name in list(data.keys())]
