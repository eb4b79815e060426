"""Files of VTK, written by hand: polydata of the points of `line_files.POINTS`, with everything that may be in it."""

from __future__ import annotations

import base64
import lzma
import zlib

import numpy as np

from .line_files import POINTS

#: Line cells: of three, two, no and one point; a vertex and a polygon stand before and after them.
CELLS = {"verts": [[0]], "lines": [[0, 1, 2], [3, 4], [], [6]], "polys": [[0, 1, 2]]}
#: Values per point, and per cell in the order of `CELLS`.
RADIUS = np.arange(7, dtype="f4") / 4
COLOUR = np.arange(21, dtype="u1").reshape(7, 3)
NUMBER = np.arange(6, dtype="i4") * 10
#: What is read of that.
STRANDS = [0, 0, 1, 3]
ROWS = np.array([[0, 1], [1, 2], [3, 4], [6, 6]])
CELL_NUMBERS = [10, 10, 20, 40]

_LEGACY = {"verts": "VERTICES", "lines": "LINES", "polys": "POLYGONS"}
_TYPES = {"f4": "float", "f8": "double", "u1": "unsigned_char", "i4": "int", "i8": "vtktypeint64"}


def legacy(*, binary: bool = False, version: str = "3.0", lines: bool = True, kind: str = "POLYDATA") -> bytes:
    """Write a legacy file."""

    def numbers(values: object, dtype: str) -> bytes:
        array = np.asarray(values, dtype)
        if binary:
            return array.astype(array.dtype.newbyteorder(">")).tobytes() + b"\n"
        return " ".join(repr(value) for value in array.ravel().tolist()).encode() + b"\n"

    parts = [f"# vtk DataFile Version {version}\ntitle\n{'BINARY' if binary else 'ASCII'}\nDATASET {kind}\n".encode()]
    parts += [b"POINTS 7 float\n", numbers(POINTS, "f4")]
    for name, cells in CELLS.items() if lines else ():
        flat = [point for cell in cells for point in cell]
        if version >= "5":
            parts.append(f"{_LEGACY[name]} {len(cells) + 1} {len(flat)}\nOFFSETS vtktypeint64\n".encode())
            parts.append(numbers(np.cumsum([0, *map(len, cells)]), "i8"))
            parts += [b"CONNECTIVITY vtktypeint64\n", numbers(flat, "i8")]
        else:
            rows = [number for cell in cells for number in (len(cell), *cell)]
            parts += [f"{_LEGACY[name]} {len(cells)} {len(rows)}\n".encode(), numbers(rows, "i4")]
    parts += [b"\nPOINT_DATA 7\nSCALARS Radius float\nLOOKUP_TABLE default\n", numbers(RADIUS, "f4")]
    parts += [b"FIELD FieldData 1\nthe%20colour 3 7 unsigned_char\n", numbers(COLOUR, "u1")]
    parts += [b"METADATA\nINFORMATION 0\n\n"]
    parts += [b"CELL_DATA 6\nSCALARS number int 1\n", numbers(NUMBER, "i4")] if lines else []
    return b"".join(parts)


def xml(
    *,
    form: str = "ascii",
    packer: str = "",
    raw: bool = True,
    size_type: str = "UInt32",
    order: str = "<",
    block: int = 16,
    alone: bool = True,
    fields: str = "",
    pieces: int = 1,
) -> bytes:
    """Write an XML file; `form` is ascii, binary or appended, and `alone` encodes sizes by themselves."""
    appended: list[bytes] = []

    def encoded(data: bytes, is_text: bool) -> bytes:
        sizes = np.dtype({"UInt32": "u4", "UInt64": "u8"}[size_type]).newbyteorder(order)
        if not packer:
            head = np.array([len(data)], sizes).tobytes()
            if not is_text:
                return head + data
            return base64.b64encode(head) + base64.b64encode(data) if alone else base64.b64encode(head + data)
        parts = [data[at : at + block] for at in range(0, len(data), block)]
        pack = {"vtkZLibDataCompressor": zlib.compress}.get(packer, lzma.compress)
        packed = [pack(part) for part in parts]
        last = len(parts[-1]) % block if parts else 0
        head = np.array([len(parts), block, last, *map(len, packed)], sizes).tobytes()
        body = b"".join(packed)
        return base64.b64encode(head) + base64.b64encode(body) if is_text else head + body

    def array(name: str, kind: str, values: object, columns: int = 1) -> str:
        dtype = np.dtype({"Float32": "f4", "Int64": "i8", "Int32": "i4", "UInt8": "u1"}[kind]).newbyteorder(order)
        flat = np.asarray(values, dtype).ravel()
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{columns}"'
        if form == "ascii":
            return f'{head} format="ascii">{" ".join(repr(value) for value in flat.tolist())}</DataArray>'
        if form == "binary":
            return f'{head} format="binary">\n{encoded(flat.tobytes(), True).decode()}\n</DataArray>'
        offset = sum(map(len, appended))
        appended.append(encoded(flat.tobytes(), not raw))
        return f'{head} format="appended" offset="{offset}"/>'

    def cells(tag: str, several: list[list[int]]) -> str:
        flat, ends = [point for cell in several for point in cell], np.cumsum([len(cell) for cell in several])
        return f"<{tag}>{array('connectivity', 'Int64', flat)}{array('offsets', 'Int64', ends)}</{tag}>"

    piece = '<Piece NumberOfPoints="7" NumberOfVerts="1" NumberOfLines="4" NumberOfStrips="0" NumberOfPolys="1">'
    head = f'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" header_type="{size_type}"'
    head += f' byte_order="{"LittleEndian" if order == "<" else "BigEndian"}"'
    head += f' compressor="{packer}">' if packer else ">"
    body = "".join(
        f"{piece}<PointData>{array('RADIUS', 'Float32', RADIUS)}{array('the colour', 'UInt8', COLOUR, 3)}</PointData>"
        f"<CellData>{array('number', 'Int32', NUMBER)}</CellData>"
        f"<Points>{array('Points', 'Float32', POINTS, 3)}</Points>"
        + "".join(cells(name.capitalize(), CELLS[name]) for name in CELLS)
        + "</Piece>"
        for _ in range(pieces)
    )
    text = f"{head}\n<PolyData>{fields}{body}</PolyData>\n".encode()
    if appended:
        encoding = "raw" if raw else "base64"
        text += f'<AppendedData encoding="{encoding}">\n_'.encode() + b"".join(appended) + b"\n</AppendedData>\n"
    return text + b"</VTKFile>\n"
