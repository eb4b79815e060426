"""The reader of files of lines for ``pyvista.read``: `fastlines.read`, and lines as ``pyvista.PolyData``."""

from __future__ import annotations

import importlib
import os
import warnings
from typing import Any

import numpy as np

from ..curves import Curves
from ..errors import FileWarning, MissingExtraError
from ..geometry import Geometry
from ..io import read as read_lines
from ..io.polylines import polylines_of
from ..lines import Lines


def pyvista() -> Any:
    """Import PyVista, which is optional."""
    try:
        return importlib.import_module("pyvista")
    except ImportError:
        raise MissingExtraError("exchange of lines with PyVista", "pyvista") from None


def read(path: str | os.PathLike[str], **options: Any) -> Any:
    """Read a file of lines as ``pyvista.PolyData``.

    Parameters
    ----------
    path : str or path-like
        A file in a format of `fastlines.read`.
    **options
        As for `fastlines.read`.

    Returns
    -------
    pyvista.PolyData
        As `to_polydata` makes it. A file with curves beside lines gives a ``pyvista.MultiBlock`` of its parts.
    """
    lines = read_lines(path, **options)
    if isinstance(lines, Geometry):
        return pyvista().MultiBlock([to_polydata(part) for part in lines.parts])
    return to_polydata(lines)


def to_polydata(lines: Any) -> Any:
    """Return lines as ``pyvista.PolyData``: a polyline for each strand.

    The radius is the array ``radius`` of points, so ``mesh.tube(scalars="radius", absolute=True)`` draws it. Attributes
    are arrays of points or of cells. ``field_data`` has the ``unit`` and the axis ``up``, if known. Curves are cut into
    the pieces that queries test.

    Parameters
    ----------
    lines : Lines or Curves

    Warns
    -----
    FileWarning
        Of attributes that differ within a strand but belong to no point.
    """
    straight: Lines = lines.pieces.lines if isinstance(lines, Curves) else lines
    parts = polylines_of(straight)
    # VTK wants the number of points of each cell before them.
    cells = np.insert(np.arange(len(parts.points)), parts.offsets[:-1], parts.counts)
    mesh = pyvista().PolyData(parts.points, lines=cells) if len(cells) else pyvista().PolyData()
    if parts.radius is not None:
        mesh.point_data["radius"] = parts.radius
    lost = list(parts.lost)
    for target, arrays in ((mesh.point_data, parts.point_attributes), (mesh.cell_data, parts.attributes)):
        for name, values in arrays.items():
            if values.ndim > 2 or values.dtype.kind not in "fiub" or name.casefold() == "radius":
                lost.append(f"{name!r}, {values.dtype} of shape {values.shape}")
            else:
                target[name] = values
    for name, text in (("unit", straight.unit), ("up", straight.up)):
        if text is not None:
            mesh.field_data[name] = [text]
    if lost:
        warnings.warn(f"not kept in PolyData: {'; '.join(lost)}", FileWarning, stacklevel=3)
    return mesh
