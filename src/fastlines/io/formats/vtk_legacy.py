"""VTK's legacy files (``.vtk``): polydata and unstructured grids, as text or big-endian binary, up to version 5.1.

Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html. Four lines of text (version, title,
ASCII or BINARY, kind of data set) come before sections, each of which begins with a keyword and sizes. Before version 5
cells are rows of the number of points and the points; since then two arrays, OFFSETS and CONNECTIVITY.

Lookup tables and METADATA are left out.
"""

from __future__ import annotations

import re
from urllib.parse import unquote

import numpy as np

from ...arrays import AnyArray
from ...errors import FileFormatError
from ...geometry.strand_attributes import objects
from ...geometry.vtk_cells import Cells, cells_in_rows
from ..source import BAD_COPY, Source
from .number_text import parse_numbers
from .vtk_data import DataSet, cells_of

_TYPES = {
    "bit": "u1", "unsigned_char": "u1", "char": "i1", "signed_char": "i1", "unsigned_short": "u2", "short": "i2",
    "unsigned_int": "u4", "int": "i4", "unsigned_long": "u8", "long": "i8", "float": "f4", "double": "f8",
    "vtkidtype": "i4", "unsigned_long_long": "u8", "long_long": "i8",
    **{f"vtktype{sign}int{bits}": f"{sign or 'i'}{bits // 8}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
}  # fmt: skip
_KINDS = {"VERTICES": "verts", "LINES": "lines", "POLYGONS": "polys", "TRIANGLE_STRIPS": "strips", "CELLS": "cells"}
#: Values by keyword, and how many each point or cell has; 0 is given in the file.
_VALUES = {
    "SCALARS": 0, "VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "TEXTURE_COORDINATES": 0, "GLOBAL_IDS": 1,
    "PEDIGREE_IDS": 1, "EDGE_FLAGS": 1,
}  # fmt: skip
#: Where numbers as text end: at a line that begins with another word than NaN or Inf.
_WORD = re.compile(rb"\n[ \t]*(?!(?:nan|inf|infinity)\b)[A-Za-z_]", re.IGNORECASE)


class Legacy:
    """A legacy file, read section by section."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.at = 0
        self.data = DataSet()
        self.target = self.data.field_data
        self.n_rows = 0
        first = self.line()
        match = re.match(r"# vtk DataFile Version (\d{1,4})\.(\d{1,4})", first, re.IGNORECASE)
        if not match:
            raise source.error(f"starts with {first[:40]!r}; expected '# vtk DataFile Version'; check the extension")
        self.version = int(match[1])
        self.line()  # the title
        mode = self.line().strip().upper()
        if mode not in ("ASCII", "BINARY") or self.version > 5:
            raise source.error(
                f"is of version {match[1]}.{match[2]}, {mode[:20]!r}; expected up to 5.1, ASCII or BINARY; convert it"
            )
        self.is_text = mode == "ASCII"

    def line(self) -> str:
        """Return the rest of the line, and go to the next."""
        end = self.source.data.find(b"\n", self.at)
        end = len(self.source.data) if end < 0 else end
        text = self.source.data[self.at : min(end, self.at + 4096)].decode("utf-8", "replace")
        self.at = end + 1
        return text.rstrip("\r")

    def words(self) -> list[str]:
        """Return the words of the next line that has any; none at the end of the file."""
        while self.at < len(self.source.data):
            if words := self.line().split():
                return words
        return []

    def size(self, text: str) -> int:
        """Return a number of values from the file, which must be able to hold as many."""
        if not re.fullmatch("[0-9]{1,18}", text) or int(text) > 8 * len(self.source.data):
            raise self.source.error(
                f"near byte {self.at}, {text[:20]!r} is not a number of values that its {len(self.source.data)} bytes "
                f"could hold; {BAD_COPY}"
            )
        return int(text)

    def numbers(self, type_name: str, n: int, what: str) -> AnyArray:
        """Read n values."""
        name = type_name.lower()
        if name in ("string", "utf8_string"):
            return self.strings(n)
        if name not in _TYPES:
            raise self.source.error(
                f"{what[:60]} are of type {type_name[:20]!r}, which the format does not have; {BAD_COPY}"
            )
        dtype = np.dtype(_TYPES[name])
        if not self.is_text:
            n_read = -(-n // 8) if name == "bit" else n
            values = self.source.array(what[:60], dtype.newbyteorder(">"), (n_read,), at=self.at)
            self.at = self.source.position
            native = values.astype(dtype, copy=False)
            return np.unpackbits(native)[:n].view(np.bool_) if name == "bit" else native
        values = self.text_numbers(dtype, n, what)
        return values != 0 if name == "bit" else values

    def text_numbers(self, dtype: np.dtype[AnyArray], n: int, what: str) -> AnyArray:  # type: ignore[type-var]
        """Read n numbers of text, up to the next word."""
        end = _WORD.search(self.source.data, max(self.at - 1, 0))
        stop = end.start() if end else len(self.source.data)
        values = parse_numbers(self.source.data[self.at : stop], dtype) if n else np.empty(0, dtype)
        self.source.advance(stop - self.at)
        if values is None or len(values) != n:
            found = "something else" if values is None else f"{len(values)}"
            raise self.source.error(
                f"{what[:60]}, from byte {self.at} on: expected {n} numbers, found {found}; {BAD_COPY}"
            )
        self.at = stop + 1 if n else self.at
        return values

    def strings(self, n: int) -> AnyArray:
        """Read n texts: a line each, or a length of 1 to 8 bytes and the text."""
        if self.is_text:
            return objects(unquote(self.line()) for _ in range(n) if self.at < len(self.source.data))
        texts = []
        for _ in range(n):
            n_bytes = 8 >> (self.source.data[self.at] >> 6) if self.at < len(self.source.data) else 1
            start = self.at + n_bytes
            length = int.from_bytes(self.source.data[self.at : start], "big") & ((1 << (8 * n_bytes - 2)) - 1)
            self.at = start + length
            if self.at > len(self.source.data):
                raise self.source.error(f"a text of {length} bytes from byte {start} on does not fit; {BAD_COPY}")
            texts.append(self.source.data[start : self.at].decode("utf-8", "replace"))
        return objects(texts)

    def read(self) -> DataSet:
        """Read all sections."""
        while words := self.words():
            keyword, *rest = words
            keyword = keyword.upper()
            try:
                self.section(keyword, rest)
            except FileFormatError:
                raise
            except (IndexError, ValueError):
                raise self.source.error(
                    f"its section {keyword[:30]!r} before byte {self.at} lacks sizes or a name; {BAD_COPY}"
                ) from None
        return self.data

    def section(self, keyword: str, rest: list[str]) -> None:
        """Read one section, of which the first line has been read."""
        if keyword == "DATASET":
            if rest[0].upper() not in ("POLYDATA", "UNSTRUCTURED_GRID"):
                raise self.source.error(
                    f"holds {rest[0][:30]}; expected POLYDATA or UNSTRUCTURED_GRID; convert it with ParaView"
                )
            if rest[0].upper() == "UNSTRUCTURED_GRID":
                self.data.types = np.empty(0, np.int32)
        elif keyword == "POINTS":
            self.data.points = self.numbers(rest[1], 3 * self.size(rest[0]), "points").reshape(-1, 3)
        elif keyword in _KINDS:
            self.data.cells[_KINDS[keyword]] = self.cells(keyword, self.size(rest[0]), self.size(rest[1]))
        elif keyword == "CELL_TYPES":
            self.data.types = self.numbers("int", self.size(rest[0]), "types of cells")
        elif keyword in ("POINT_DATA", "CELL_DATA"):
            self.target = self.data.point_data if keyword == "POINT_DATA" else self.data.cell_data
            self.n_rows = self.size(rest[0])
        elif keyword == "FIELD":
            self.fields(self.size(rest[1]))
        elif keyword in _VALUES:
            self.values(keyword, rest)
        elif keyword == "COLOR_SCALARS":
            n = self.size(rest[1])
            shown = self.numbers("float" if self.is_text else "unsigned_char", n * self.n_rows, "colours")
            self.keep(rest[0], np.round(shown * 255).astype(np.uint8) if self.is_text else shown, n)
        elif keyword == "LOOKUP_TABLE":
            self.numbers("float" if self.is_text else "unsigned_char", 4 * self.size(rest[1]), "lookup table")
        elif keyword == "METADATA":
            self.metadata()
        else:
            raise self.source.error(
                f"before byte {self.at}, {keyword[:30]!r} is not a section of the format; {BAD_COPY}"
            )

    def cells(self, keyword: str, n: int, n_numbers: int) -> Cells:
        """Read cells, of either version of the format."""
        if self.version >= 5:
            found = []
            for expected, size in (("OFFSETS", n), ("CONNECTIVITY", n_numbers)):
                words = self.words()
                if words[0].upper() != expected:
                    raise self.source.error(f"{keyword} has {words[0][:20]!r}; expected {expected}; {BAD_COPY}")
                found.append(self.numbers(words[1], size, f"{expected} of {keyword}"))
            return cells_of(self.source, keyword, found[1], found[0] if n else np.zeros(1, np.int64))
        rows = self.numbers("int", n_numbers, keyword)
        cells = cells_in_rows(rows)
        if cells is None or len(cells.counts) != n:
            raise self.source.error(
                f"{keyword} announces {n} cells in {n_numbers} numbers, which are not cells; {BAD_COPY}"
            )
        return cells

    def values(self, keyword: str, rest: list[str]) -> None:
        """Read an array of points or cells that has a section of its own."""
        n_columns = _VALUES[keyword]
        type_name = rest[1]
        if keyword == "SCALARS":
            n_columns = self.size(rest[2]) if len(rest) > 2 else 1
            before = self.at
            if self.words()[:1] != ["LOOKUP_TABLE"]:
                self.at = before
        elif keyword == "TEXTURE_COORDINATES":
            n_columns, type_name = self.size(rest[1]), rest[2]
        self.keep(rest[0], self.numbers(type_name, n_columns * self.n_rows, f"values of {rest[0]!r}"), n_columns)

    def fields(self, n: int) -> None:
        """Read n arrays that each give their name, columns, rows and type."""
        for _ in range(n):
            words = self.words()
            while words[:1] == ["METADATA"]:
                self.metadata()
                words = self.words()
            if words == ["NULL_ARRAY"]:
                continue
            n_columns, n_rows = self.size(words[1]), self.size(words[2])
            self.keep(words[0], self.numbers(words[3], n_columns * n_rows, f"values of {words[0]!r}"), n_columns)

    def keep(self, name: str, values: AnyArray, n_columns: int) -> None:
        """Keep an array of the current target by its name."""
        name = unquote(name)
        if name in self.target:
            self.source.warn(f"one of its arrays {name!r} is left out, as another one has the same name")
            return
        self.target[name] = values if n_columns == 1 or not n_columns else values.reshape(-1, n_columns)

    def metadata(self) -> None:
        """Skip lines up to an empty one."""
        while self.at < len(self.source.data) and self.line().strip():
            pass


def read_legacy(source: Source) -> DataSet:
    """Read a legacy file."""
    return Legacy(source).read()
