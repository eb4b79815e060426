"""VTK's XML files: polydata (``.vtp``) and unstructured grids (``.vtu``), in all encodings of arrays but LZ4.

Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html. An array is text, or base64 in its
element, or bytes or base64 in the element AppendedData, where ``offset`` says. Its bytes follow their number; packed
ones follow the number of blocks, their size, that of the last, and the packed size of each.
"""

from __future__ import annotations

import base64
import lzma
import re
import zlib
from typing import Any, Literal
from xml.etree import ElementTree

import numpy as np

from ...arrays import AnyArray
from ...geometry.strand_attributes import objects
from ...geometry.vtk_cells import Cells
from ..source import BAD_COPY, Source, reason
from .number_text import parse_numbers
from .vtk_data import KINDS, DataSet, cells_of

_TYPES = {
    **{f"{sign}Int{bits}": f"{sign.lower() or 'i'}{bits // 8}" for sign in ("", "U") for bits in (8, 16, 32, 64)},
    "Float32": "f4", "Float64": "f8", "String": "i1", "Bit": "u1", "vtkIdType": "i8",
}  # fmt: skip
_SIZES = {"UInt32": "u4", "UInt64": "u8"}
_APPENDED = re.compile(rb"<AppendedData\b[^<>]*+>\s*+_")


class Xml:
    """An XML file, of which the arrays are decoded on demand."""

    def __init__(self, source: Source) -> None:
        self.source = source
        data = source.data
        found = _APPENDED.search(data)
        self.start = found.end() if found else len(data)
        self.is_base64 = bool(found and b"base64" in found[0])
        head = data[: found.start()] + b"</VTKFile>" if found else data
        if b"<!DOCTYPE" in head or b"<!ENTITY" in head:
            raise source.error("defines entities, which no file of VTK does; check where it is from")
        try:
            self.root = ElementTree.fromstring(head)
        except (ElementTree.ParseError, ValueError, LookupError) as error:
            raise source.error(f"its XML cannot be read ({reason(error)}); {BAD_COPY}") from None
        get = self.root.get
        order, sizes, packer = get("byte_order", "LittleEndian"), get("header_type", "UInt32"), get("compressor", "")
        if order not in ("LittleEndian", "BigEndian") or sizes not in _SIZES:
            raise source.error(f"its byte order is {order[:20]!r} and its sizes are {sizes[:20]!r}; it is damaged")
        self.byte_order: Literal["<", ">"] = "<" if order == "LittleEndian" else ">"
        self.size_type = np.dtype(_SIZES[sizes]).newbyteorder(self.byte_order)
        self.unpack = {"": None, "vtkZLibDataCompressor": _unzip, "vtkLZMADataCompressor": _unlzma}.get(
            packer, _refused
        )
        self.packer = packer
        self.left = source.unpack_limit

    def read(self) -> DataSet:
        """Read the data set; the points and cells of its pieces are joined."""
        kind = self.root.get("type", "")
        body = self.root.find(kind) if kind in ("PolyData", "UnstructuredGrid") else None
        if self.root.tag != "VTKFile" or body is None:
            raise self.source.error(
                f"is XML of the type {kind[:30]!r}; expected a VTKFile of the type PolyData or UnstructuredGrid; "
                "convert it with ParaView"
            )
        whole = DataSet(field_data=self.arrays(body.find("FieldData"), fields=True))
        parts = [self.piece(piece, is_grid=kind == "UnstructuredGrid") for piece in body.findall("Piece")]
        if not parts:
            return whole
        first = np.cumsum([0] + [len(part.points) for part in parts])
        whole.points = np.concatenate([part.points for part in parts])
        for name in parts[0].cells:
            cells = [part.cells[name] for part in parts]
            points = [part.points + at for part, at in zip(cells, first, strict=False)]
            whole.cells[name] = Cells(np.concatenate(points), np.concatenate([part.counts for part in cells]))
        if kind == "UnstructuredGrid":
            whole.types = np.concatenate([part.types for part in parts if part.types is not None])
        self.join(whole.point_data, [part.point_data for part in parts])
        # The cells of polydata are sorted by kind, and so are those of several pieces together.
        order = np.arange(0)
        if len(parts) > 1 and whole.types is None:
            order = np.argsort(np.concatenate([_kinds_of(part) for part in parts]), kind="stable")
        self.join(whole.cell_data, [part.cell_data for part in parts])
        if len(order):
            whole.cell_data = {n: v[order] if len(v) == len(order) else v for n, v in whole.cell_data.items()}
        return whole

    def join(self, whole: dict[str, AnyArray], parts: list[dict[str, AnyArray]]) -> None:
        """Join the arrays of pieces; warn of those that some pieces lack."""
        found: dict[str, list[AnyArray]] = {}
        for part in parts:
            for name, values in part.items():
                found.setdefault(name, []).append(values)
        for name, several in found.items():
            if len(several) < len(parts) or len({values.shape[1:] for values in several}) > 1:
                self.source.warn(f"its array {name!r} is not in all of its pieces, and is left out")
            else:
                whole[name] = np.concatenate(several)

    def piece(self, piece: Any, *, is_grid: bool) -> DataSet:
        """Read a piece."""
        data = DataSet(point_data=self.arrays(piece.find("PointData")), cell_data=self.arrays(piece.find("CellData")))
        points = list(self.arrays(piece.find("Points")).values())
        if points:
            data.points = points[0]
        if data.points.ndim != 2 or data.points.shape[1] != 3 or data.points.dtype.kind not in "fiu":
            raise self.source.error(f"its points have the shape {data.points.shape}; expected (n, 3); {BAD_COPY}")
        n_points = piece.get("NumberOfPoints", f"{len(data.points)}")
        if n_points != f"{len(data.points)}":
            raise self.source.error(f"it announces {n_points[:20]} points and has {len(data.points)}; {BAD_COPY}")
        data.point_data = _without_padding(data.point_data, len(data.points))
        for name, tag in {"cells": "Cells"}.items() if is_grid else {kind: kind.capitalize() for kind in KINDS}.items():
            arrays = self.arrays(piece.find(tag))
            connectivity, ends = (arrays.get(what, np.empty(0, np.int64)) for what in ("connectivity", "offsets"))
            number = f"NumberOf{tag}"
            if not {connectivity.ndim, ends.ndim} == {1} or "f" in connectivity.dtype.kind + ends.dtype.kind:
                raise self.source.error(f"its {tag} are not whole numbers; {BAD_COPY}")
            if piece.get(number, f"{len(ends)}") != f"{len(ends)}":
                raise self.source.error(f"it announces {piece.get(number)[:20]} {tag} and has {len(ends)}; {BAD_COPY}")
            data.cells[name] = cells_of(self.source, tag, connectivity, np.append(np.zeros(1, np.int64), ends))
            if is_grid:
                data.types = arrays.get("types", np.empty(0, np.uint8))
        data.cell_data = _without_padding(data.cell_data, sum(len(cells.counts) for cells in data.cells.values()))
        return data

    def arrays(self, element: Any, *, fields: bool = False) -> dict[str, AnyArray]:
        """Read the arrays of an element by name."""
        found: dict[str, AnyArray] = {}
        for i, each in enumerate(element if element is not None else ()):
            if each.tag not in ("DataArray", "Array"):
                continue
            name = each.get("Name") or f"values {i}"
            values = self.array(each, name)
            if name in found:
                self.source.warn(f"one of its arrays {name!r} is left out, as another one has the same name")
            elif each.get("type") == "String":
                texts = values.astype(np.uint8).tobytes().split(b"\0")[:-1]
                found[name] = objects(text.decode("utf-8", "replace") for text in texts)
            else:
                found[name] = values
        return found

    def array(self, element: Any, name: str) -> AnyArray:
        """Decode an array: (n,), or (n, columns)."""
        kind, form = element.get("type", ""), element.get("format", "ascii")
        columns = element.get("NumberOfComponents", "1")
        what = f"its array {name[:60]!r}"
        if kind not in _TYPES or not re.fullmatch("[0-9]{1,9}", columns):
            raise self.source.error(f"{what} is of the type {kind[:20]!r} with {columns[:20]!r} components; {BAD_COPY}")
        dtype = np.dtype(_TYPES[kind])
        if form == "ascii":
            text = (element.text or "").encode()
            values = parse_numbers(text, dtype)
            if values is None:
                raise self.source.error(f"{what} holds something else than numbers; {BAD_COPY}")
        else:
            raw = self.bytes_of(element, form, what)
            if len(raw) % dtype.itemsize:
                raise self.source.error(f"{what} has {len(raw)} bytes, in numbers of {dtype.itemsize}; {BAD_COPY}")
            values = np.frombuffer(raw, dtype.newbyteorder(self.byte_order)).astype(dtype, copy=False)
            values = np.unpackbits(values) if kind == "Bit" else values
        values = values.view(np.bool_) if kind == "Bit" else values
        n_columns = int(columns) or 1
        if len(values) % n_columns:
            raise self.source.error(f"{what} has {len(values)} numbers for {n_columns} components; {BAD_COPY}")
        return values.reshape(-1, n_columns) if n_columns > 1 else values

    def bytes_of(self, element: Any, form: str, what: str) -> bytes:
        """Return the bytes of an array, unpacked."""
        at, data, is_base64 = 0, self.source.data, True
        if form == "appended":
            offset = element.get("offset", "")
            if not re.fullmatch("[0-9]{1,18}", offset) or self.start + int(offset) > len(data):
                raise self.source.error(f"{what} is at offset {offset[:20]!r}, which is not in the file; {BAD_COPY}")
            at, is_base64 = self.start + int(offset), self.is_base64
        elif form == "binary":
            data = b"".join((element.text or "").encode().split())
        else:
            raise self.source.error(f"{what} has the format {form[:20]!r}; expected ascii, binary or appended")

        def take(begin: int, n: int) -> tuple[bytes, int]:
            """Return n bytes, and where the next ones begin if these are encoded by themselves."""
            stop = begin + (-(-n // 3) * 4 if is_base64 else n)
            part = data[begin:stop]
            if is_base64:
                try:
                    part = base64.b64decode(part, validate=True)
                except ValueError as error:
                    raise self.source.error(f"{what} is not base64 ({reason(error)}); {BAD_COPY}") from None
            if len(part) < n:
                raise self.source.error(f"{what} ends after {len(part)} of {n} bytes; {BAD_COPY}")
            return part[:n], stop

        size = self.size_type.itemsize
        if self.unpack is None:
            n_bytes = int(np.frombuffer(take(at, size)[0], self.size_type)[0])
            self.left -= n_bytes  # several arrays may be the same bytes
            self.check(n_bytes <= len(data) and self.left >= 0, what)
            # The number of bytes is encoded with them, or by itself and then padded.
            alone = is_base64 and data[at : at + -(-size // 3) * 4].endswith(b"=")
            return take(take(at, size)[1], n_bytes)[0] if alone or not is_base64 else take(at, size + n_bytes)[0][size:]
        n_blocks = int(np.frombuffer(take(at, size)[0], self.size_type)[0])
        self.check(n_blocks <= len(data), what)
        raw, at = take(at, size * (3 + n_blocks))
        sizes = [int(n) for n in np.frombuffer(raw, self.size_type)]
        full, last, packed = sizes[1], sizes[2], sizes[3:]
        self.check(sum(packed) <= len(data), what)
        expected = [full] * n_blocks
        if n_blocks and last:
            expected[-1] = last
        self.left -= sum(expected)
        self.check(self.left >= 0, what)
        blocks, out, begin = take(at, sum(packed))[0], [], 0
        for n, n_packed in zip(expected, packed, strict=True):
            try:
                out.append(self.unpack(blocks[begin : begin + n_packed], n))
            except NotImplementedError:
                raise self.source.error(f"is packed by {self.packer[:40]!r}; write it again, packed by zlib") from None
            except (zlib.error, lzma.LZMAError, EOFError, ValueError) as error:
                raise self.source.error(f"{what} cannot be unpacked ({reason(error)}); {BAD_COPY}") from None
            self.check(len(out[-1]) == n, what)
            begin += n_packed
        return b"".join(out)

    def check(self, is_good: bool, what: str) -> None:
        """Refuse sizes that cannot be true."""
        if not is_good:
            raise self.source.error(f"the sizes before {what} do not fit the {len(self.source.data)} bytes; {BAD_COPY}")


def _unzip(data: bytes, n: int) -> bytes:
    return zlib.decompressobj().decompress(data, n + 1)


def _unlzma(data: bytes, n: int) -> bytes:
    return lzma.LZMADecompressor().decompress(data, n + 1)


def _refused(data: bytes, n: int) -> bytes:
    raise NotImplementedError


def _without_padding(arrays: dict[str, AnyArray], n: int) -> dict[str, AnyArray]:
    """Cut the bits off that fill the last byte of an array of bits."""
    return {name: values[:n] if values.dtype == np.bool_ else values for name, values in arrays.items()}


def _kinds_of(part: DataSet) -> AnyArray:
    return np.repeat(np.arange(len(KINDS)), [len(part.cells[kind].counts) for kind in KINDS])


def read_xml(source: Source) -> DataSet:
    """Read an XML file."""
    return Xml(source).read()
