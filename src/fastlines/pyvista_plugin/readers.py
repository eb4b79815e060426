"""The reader of files of lines for ``pyvista.read``: `fastlines.read`, and lines as ``pyvista.PolyData``."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ..arrays import AnyArray
from ..errors import FileWarning
from ..geometry.lines import Lines
from ..geometry.vtk_cells import RADIUS
from ..io import read as read_lines
from ..io.losses import is_encodable, strand_numbers
from ..io.polylines import polylines_of
from ..io.writing import to_written
from ..support.optional import optional
from ..support.warn_caller import warn_caller


def pyvista() -> Any:
    """Import PyVista, which is optional."""
    return optional("pyvista", "exchange of lines with PyVista", "pyvista")


def read(path: str | os.PathLike[str], **options: Any) -> Any:
    """Read a file of lines as ``pyvista.PolyData``.

    Parameters
    ----------
    path : str or path-like
        A file in a format of `fastlines.read`. ``pyvista.read`` calls this function for those that PyVista does not
        read itself.
    **options
        As for `fastlines.read`.

    Returns
    -------
    pyvista.PolyData
        As `to_polydata` makes it. A file with curves beside lines gives a ``pyvista.MultiBlock`` of its parts.
    """
    lines = read_lines(path, **options)
    if lines.has_parts:
        return pyvista().MultiBlock([to_polydata(part) for part in lines.each_part()])
    return to_polydata(lines)


def to_polydata(lines: Any) -> Any:
    """Return lines as ``pyvista.PolyData``: a polyline for each strand.

    The radius is the array ``radius`` of points, so ``mesh.tube(scalars="radius", absolute=True)`` draws it. Attributes
    are arrays of points or of cells. ``field_data`` has the ``unit`` and the axis ``up``, if known. Curves are cut into
    the pieces that queries test, which keep their attributes.

    Parameters
    ----------
    lines : Lines, Curves, or what `fastlines.lines` takes

    Raises
    ------
    InputError
        If `lines` are something else, such as a `Geometry`: convert its parts one by one.

    Warns
    -----
    FileWarning
        Of everything that PolyData cannot hold, such as attributes that differ within a strand but belong to no point.
    """
    straight, lost = to_written(lines, (Lines,), "meshes", "to_polydata({})")
    parts = polylines_of(straight)
    # VTK wants the number of points of each cell before them.
    cells = np.insert(np.arange(len(parts.points)), parts.offsets[:-1], parts.counts)
    mesh = pyvista().PolyData(parts.points, lines=cells) if len(cells) else pyvista().PolyData()
    if parts.radius is not None:
        mesh.point_data[RADIUS] = parts.radius
    lost += parts.lost
    for target, arrays in ((mesh.point_data, parts.point_attributes), (mesh.cell_data, parts.attributes)):
        for name, values in arrays.items():
            if _is_held(name, values):
                target[name] = values.astype(np.float32) if values.dtype == np.float16 else values
            else:
                lost.append(f"{name!r}, {values.dtype} of shape {values.shape}")
    if (parts.strand >= 0).any():
        lost += strand_numbers(parts.strand)
    for name, text in (("unit", straight.unit), ("up", straight.up)):
        if text is not None:
            mesh.GetFieldData().AddArray(_text(name, text))
    if lost:
        warn_caller(f"not kept in PolyData: {'; '.join(lost)}", FileWarning)
    return mesh


def _text(name: str, text: str) -> Any:
    """Return an array of one text in any letters: `field_data` takes only ASCII, but units are µm and Å."""
    array = optional("vtkmodules.vtkCommonCore", "exchange of lines with PyVista", "pyvista").vtkStringArray()
    array.SetName(name)
    array.InsertNextValue(text)
    return array


def _is_held(name: str, values: AnyArray) -> bool:
    """Return whether PolyData holds an attribute; by the name ``radius``, it would be read as the radius."""
    is_name = name and "\0" not in name and is_encodable(name)
    is_number = values.dtype.kind in "fiub" and values.dtype.itemsize <= 8
    # PyVista refuses empty arrays of vectors.
    is_held = values.ndim == 1 or (values.ndim == 2 and values.size > 0)
    return bool(is_name) and is_number and is_held and name.casefold() != RADIUS
