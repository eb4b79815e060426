"""One small, whole file of text for each format that is text; and numbers that no reader expects."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from .usd_files import curves, usda

#: Words in the place of a number: too large, too many digits, NaN, of another alphabet, none at all.
NUMBERS: list[bytes] = [
    *(b"9" * 400, b"-" + b"1" * 400, b"1" + b"0" * 5000, b"0." + b"3" * 5000, b"1e400", b"-1e400", b"1e-400", b"1e308"),
    *(b"nan", b"NaN", b"Infinity", b"-Infinity", b"inf", b"null", b"true", b'""', b"[]", b"", b"0x1F", b"1_0", b"1e"),
    *(b"-1", b"0", b"+5", b"2147483648", b"4294967295", b"9223372036854775807", b"18446744073709551616"),
    "١٢".encode(),
]

_GPX = (
    '<?xml version="1.0" encoding="UTF-8"?><gpx version="1.1" creator="x"><trk><trkseg>'
    '<trkpt lat="46.5" lon="13.7"><ele>900</ele><time>2020-01-01T00:00:00Z</time><hr>77</hr></trkpt>'
    '<trkpt lat="46.6" lon="13.8"><ele>910.5</ele><time>2020-01-01T00:00:01.5+01:00</time></trkpt></trkseg></trk>'
    '<rte><rtept lat="1" lon="1"/><rtept lat="2" lon="2"/></rte></gpx>'
)
_PBRT = (
    "Scale 1 2 3\nTranslate 1 0 0\nWorldBegin\nAttributeBegin\nRotate 30 0 0 1\n"
    'Shape "curve" "string type" ["cylinder"] "point3 P" [0 0 0 1 0 0 1 1 0 2 1 0] "float width0" [0.1]\n'
    'AttributeEnd\nObjectBegin "a"\nShape "curve" "point P" [0 0 0 1 0 0 1 1 0 2 1 0] "integer degree" [3]\nObjectEnd\n'
    'ObjectInstance "a"\nWorldEnd\n'
)
_VTK = (
    "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 2 0 0 3 0 0\n"
    "LINES 2 6\n2 0 1\n2 2 3\nPOINT_DATA 4\nSCALARS fa float 1\nLOOKUP_TABLE default\n1 2 3 4\n"
    "FIELD f 1\nq 3 4 double\n1 2 3 4 5 6 7 8 9 10 11 12\nCELL_DATA 2\nVECTORS v float\n1 2 3 4 5 6\n"
)
_VTU = (
    '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>'
    '<Piece NumberOfPoints="3" NumberOfCells="2"><Points><DataArray type="Float32" NumberOfComponents="3" '
    'format="ascii">0 0 0 1 0 0 2 0 0</DataArray></Points><Cells><DataArray type="Int32" Name="connectivity" '
    'format="ascii">0 1 1 2</DataArray><DataArray type="Int32" Name="offsets" format="ascii">2 4</DataArray>'
    '<DataArray type="UInt8" Name="types" format="ascii">3 3</DataArray></Cells><PointData><DataArray type="Float64" '
    'Name="r" format="ascii" NumberOfComponents="1">1 2 3</DataArray></PointData></Piece></UnstructuredGrid></VTKFile>'
)
_CIF = (
    "data_x\nloop_\n" + "".join(f"_atom_site.{name}\n" for name in (
        "group_PDB", "id", "type_symbol", "label_atom_id", "label_alt_id", "label_comp_id", "label_asym_id",
        "label_seq_id", "Cartn_x", "Cartn_y", "Cartn_z", "occupancy", "B_iso_or_equiv", "auth_seq_id", "auth_asym_id",
        "pdbx_PDB_model_num")) + "ATOM 1 C CA . GLY A 1 0 0 0 1 10 1 A 1\nATOM 2 C CB . GLY A 1 1.4 0 0 1 10 1 A 1\n"
)  # fmt: skip
_PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\n" + "".join(f"property float {name}\n" for name in "xyz")
    + "element face 0\nproperty list uchar int vertex_indices\nelement edge 2\nproperty int vertex1\n"
    "property int vertex2\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1\n1 2\n"
)  # fmt: skip
_DXF = (
    "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n0.0\n20\n0.0\n11\n1.0\n21\n2.5\n"
    "0\nCIRCLE\n8\n0\n10\n5.0\n20\n0.0\n40\n2.0\n0\nENDSEC\n0\nEOF\n"
)
_JSON = (
    '{"type": "FeatureCollection", "features": [{"type": "Feature", "id": 7, "properties": {"a": 1, "b": 2.5, '
    '"c": true}, "geometry": {"type": "LineString", "coordinates": [[0, 0], [1.5, 1, 3]]}}, {"type": "Feature", '
    '"properties": {"a": 2}, "geometry": {"type": "MultiLineString", "coordinates": [[[0, 0], [1, 1]]]}}]}'
)

#: Files by their names; those in `NEEDS` need a library.
TEXTS: dict[str, bytes] = {
    "a.json": _JSON.encode(),
    "a.geojsonl": b'{"type": "LineString", "coordinates": [[0, 0], [1, 1]]}\n' * 2,
    "a.csv": b'id;length;wet;the_geom\n1;1.5;true;LINESTRING(0 0,1 0,1 2)\n2;;FALSE;"LINESTRING (5 5 1, 6 6 2)"\n',
    "a.wkt": b"SRID=4326;LINESTRING Z (0 0 1, 1 1 2)\nMULTILINESTRING M ((0 0 1, 1 1 1),(2 2 2, 3 3 3))\n",
    "a.gpx": _GPX.encode(),
    "a.swc": b"# OFFSET 1 2 3\n# SCALE 1 1 1\n1 1 0 0 0 1 -1\n2 3 5 0 0 1.5 1\n3 3 9 0 0 1 2\n4 3 9 1 0 1 2\n",
    "a.vtk": _VTK.encode(),
    "a.vtu": _VTU.encode(),
    "a.pbrt": _PBRT.encode(),
    "a.txt": b"0 0 0 1\n1 0 0 1\n2 0 0 1\n3 0 0 1\n\n1 1 1 1\n2 2 2 1\n",
    "a.obj": b"v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\nl -1 -2\n",
    "a.ply": _PLY.encode(),
    "a.dxf": _DXF.encode(),
    "a.pdb": b"".join(
        b"ATOM  %5d  CA  GLY A%4d    %8.3f%8.3f%8.3f  1.00 10.00           C\n" % (i, i, 1.4 * i, 0, 0) for i in (1, 2)
    ),
    "a.cif": _CIF.encode(),
    "a.usda": usda(curves(widths=("constant", [2]))),
}
NEEDS = {".dxf": "ezdxf", ".pdb": "gemmi", ".cif": "gemmi", ".usda": "pxr"}


def with_odd_numbers(data: bytes, n: int, seed: int = 0) -> Iterator[bytes]:
    """Yield n copies of a text in which one number is another word."""
    rng = np.random.default_rng(seed)
    places = [found.span() for found in re.finditer(rb"[0-9.]+", data)]
    for i in range(n):
        start, stop = places[rng.integers(len(places))]
        yield data[:start] + NUMBERS[i % len(NUMBERS)] + data[stop:]
