"""Polydata of VTK (``.vtp``): polylines, a radius and arrays of points and cells, by the library ``vtk``.

Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html. `vtk_data` says what is read and
written. Files are written with packed binary arrays.
"""

from __future__ import annotations

from pathlib import Path

from ..lines import Lines
from .vtk import messages
from .vtk import read as read
from .vtk_data import library, polydata_of


def write(lines: Lines, path: Path) -> list[str]:
    """Write strands as polylines, with the radius as the array ``radius`` of points."""
    writer = library("vtkIOXML").vtkXMLPolyDataWriter()
    data, lost = polydata_of(lines)
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    with messages() as said:
        is_written = writer.Write()
    if not is_written or said[0]:
        raise OSError(f"{path}: the library vtk could not write the file: {' '.join(said[0].split())[:200]}")
    return lost
