"""VTK's polydata (``.vtp``): polylines, a radius and arrays of points and cells.

Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html. `vtk_data` says what is read. Files
are written with raw appended arrays, which are not packed.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from ...arrays import AnyArray
from ...geometry.lines import Lines
from ...geometry.vtk_cells import RADIUS
from ...support.texts import printable
from ..losses import free_name, strand_numbers
from ..polylines import polylines_of
from .vtk import read as read

_TYPES = {"f": "Float", "i": "Int", "u": "UInt"}


def write(lines: Lines, path: Path) -> list[str]:
    """Write strands as polylines, with the radius as the array ``radius`` of points."""
    parts = polylines_of(lines)
    lost = list(parts.lost)
    radius = {} if parts.radius is None else {RADIUS: parts.radius}
    taken = {RADIUS, *lines.attributes}
    arrays: list[AnyArray] = []
    at = 0

    def declared(name: str, values: AnyArray) -> str:
        """Return the element of an array, which will be appended."""
        nonlocal at
        values = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
        columns = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
        kind = f"{_TYPES[values.dtype.kind]}{8 * values.dtype.itemsize}"
        arrays.append(values)
        offset, at = at, at + 8 + values.nbytes
        return f'<DataArray type="{kind}" Name={quoteattr(name)}{columns} format="appended" offset="{offset}"/>'

    def section(tag: str, several: Mapping[str, AnyArray]) -> list[str]:
        return [f"<{tag}>", *(declared(name, values) for name, values in several.items()), f"</{tag}>"]

    texts = [
        f'<Array type="String" Name="{name}" NumberOfTuples="1" format="ascii">{" ".join(map(str, text.encode()))} 0'
        "</Array>"
        for name, text in (("unit", lines.unit), ("up", lines.up))
        if text is not None
    ]
    head = [
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        "<PolyData>",
        *(["<FieldData>", *texts, "</FieldData>"] if texts else []),
        f'<Piece NumberOfPoints="{len(parts.points)}" NumberOfVerts="0" NumberOfLines="{len(parts.counts)}" '
        'NumberOfStrips="0" NumberOfPolys="0">',
        *section("PointData", radius | _kept(parts.point_attributes, taken, lost)),
        *section("CellData", _kept(parts.attributes, taken, lost)),
        *section("Points", {"Points": parts.points}),
        *section("Lines", {"connectivity": np.arange(len(parts.points)), "offsets": parts.offsets[1:]}),
        "</Piece>",
        "</PolyData>",
        '<AppendedData encoding="raw">',
    ]
    with path.open("wb") as file:
        file.write("\n".join(head).encode() + b"\n_")
        for values in arrays:
            file.write(np.array(values.nbytes, "<u8").tobytes())
            file.write(values.reshape(-1).view(np.uint8).data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")
    return lost + strand_numbers(parts.strand)


def _kept(several: Mapping[str, AnyArray], taken: set[str], lost: list[str]) -> dict[str, AnyArray]:
    """Return the attributes in types that VTK has; add the others to `lost`."""
    kept = {}
    for name, values in several.items():
        if values.dtype.kind not in "fiub" or values.dtype.itemsize > 8 or values.ndim > 2 or 0 in values.shape[1:]:
            lost.append(f"{name!r}, {values.dtype} of shape {values.shape}")
            continue
        if values.dtype.kind == "b":
            lost.append(f"that {name!r} is boolean (0 and 1 are written)")
            values = values.astype(np.uint8)
        if values.dtype == np.float16:
            values = values.astype(np.float32)
        clean = f"{name} of lines" if name.casefold() == RADIUS else printable(name) or "?"
        kept[free_name(name, clean, taken, lost)] = values
    return kept
