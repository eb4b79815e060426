"""Rows: what is known of some segments as columns of a file, which can be cut, taken and joined.

Columns have the names of the sections of a tree file (`structure.geometry_file`), and two more: ``ids``, and ``places``
along strands. Columns of strands are missing where there are none. A column of texts is the number of each text, and
`texts` has the texts.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...arrays import AnyArray, IntArray
from ...geometry.lines import Lines
from ...structure.geometry_file import to_sections
from ...support.immutable import own
from ...support.text_columns import TEXTS, texts_of

#: What a row has in a column that its chunk lacks.
MISSING = {"strands": -1, "places": -1, "radius": 0}

#: What the names of columns of attributes begin with, by the argument of `Lines`.
ATTRIBUTES = ("attributes", "end_attributes")


@dataclass(frozen=True)
class Column:
    """A column as all chunks are to have it: its type, the shape of a row, and whether it numbers texts."""

    dtype: np.dtype[Any]
    row: tuple[int, ...]
    of_texts: bool = False

    def joined(self, name: str, other: Column) -> Column | None:
        """Return the column that holds the rows of both; None if there is none."""
        if self.of_texts != other.of_texts:
            return None
        row = (2,) if name == "radius" and self.row != other.row else self.row
        if name != "radius" and self.row != other.row:
            return None
        return Column(np.result_type(self.dtype, other.dtype), row, self.of_texts)


Schema = Mapping[str, Column]


@dataclass(frozen=True)
class Rows:
    """Some segments: `columns` with a row for each, and the `texts` of columns that number them."""

    columns: dict[str, AnyArray]
    texts: dict[str, list[str]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.columns["segments"])

    @classmethod
    def of(cls, lines: Lines) -> tuple[Rows, list[str]]:
        """Return the rows of lines, and the attributes that files cannot keep."""
        sections, _, lost = to_sections(lines)
        sections.pop("skipped", None)
        if not len(lines) or int(lines.strands.max()) < 0:
            del sections["strands"]
        return cls.of_sections(sections), lost

    @classmethod
    def of_sections(cls, sections: Mapping[str, AnyArray]) -> Rows:
        """Return the rows that sections of a file hold; other sections have names with a dot."""
        columns = {name: values for name, values in sections.items() if not name.startswith((".", TEXTS))}
        texts = {name: sections[TEXTS + name] for name in columns if TEXTS + name in sections}
        return cls(columns, {name: json.loads(data.tobytes()) for name, data in texts.items()})

    def sections(self) -> dict[str, AnyArray]:
        """Return the rows as sections of a file."""
        texts = {
            TEXTS + name: np.frombuffer(json.dumps(known).encode(), np.uint8) for name, known in self.texts.items()
        }
        return self.columns | texts

    @property
    def schema(self) -> dict[str, Column]:
        """What columns there are."""
        return {
            name: Column(values.dtype, values.shape[1:], name in self.texts) for name, values in self.columns.items()
        }

    @property
    def row_bytes(self) -> int:
        """How many bytes a row takes."""
        return sum(values.nbytes for values in self.columns.values()) // max(1, len(self))

    def cut(self, begin: int, end: int) -> Rows:
        """Return some rows that follow each other; no copy."""
        return Rows({name: values[begin:end] for name, values in self.columns.items()}, self.texts)

    def taken(self, order: IntArray) -> Rows:
        """Return some rows in another order."""
        return Rows({name: _take(values, order) for name, values in self.columns.items()}, self.texts)

    def lines(self, facts: Mapping[str, Any]) -> Lines:
        """Return the rows as lines with these facts: ``up``, ``unit`` and ``metadata``."""
        given: dict[str, Any] = {
            name: own(self.columns[name]) for name in ("segments", "strands", "radius") if name in self.columns
        }
        for kind in ATTRIBUTES:
            prefix = f"{kind}/"
            given[kind] = {
                name.removeprefix(prefix): own(self._values(name)) for name in self.columns if name.startswith(prefix)
            }
        return Lines(**given, **facts)

    def _values(self, name: str) -> AnyArray:
        """Return a column with texts in place of their numbers."""
        values = self.columns[name]
        if name not in self.texts:
            return values
        return texts_of(values, np.frombuffer(json.dumps(self.texts[name]).encode(), np.uint8))


def joined(parts: Sequence[Rows], schema: Schema) -> Rows:
    """Return the rows of all parts in these columns, one part after the other; there may be no parts."""
    if len(parts) == 1 and parts[0].schema == schema:
        return parts[0]
    sizes = [len(part) for part in parts]
    columns: dict[str, AnyArray] = {}
    texts: dict[str, list[str]] = {}
    for name, column in schema.items():
        values = np.empty((sum(sizes), *column.row), column.dtype)
        known: dict[str, int] = {}
        begin = 0
        for part, size in zip(parts, sizes, strict=True):
            here = values[begin : begin + size]
            begin += size
            if name not in part.columns:
                here[...] = MISSING[name]
            elif column.of_texts:
                number = [known.setdefault(text, len(known)) for text in part.texts[name]]
                here[...] = np.array(number or [0], column.dtype)[part.columns[name]]
            else:
                given = part.columns[name]
                here[...] = given if given.shape[1:] == column.row else given[:, None]
        columns[name] = values
        if column.of_texts:
            texts[name] = list(known)
    return Rows(columns, texts)


def _take(values: AnyArray, order: IntArray) -> AnyArray:
    """Return rows of an array in some order: each as one item of bytes, which NumPy copies at once."""
    n_bytes = values.strides[0]
    if values.ndim == 1 or not values.flags.c_contiguous or not n_bytes:
        return values[order]
    items = values.reshape(-1).view(np.uint8).view(f"V{n_bytes}")
    return items[order].view(values.dtype).reshape(-1, *values.shape[1:])
