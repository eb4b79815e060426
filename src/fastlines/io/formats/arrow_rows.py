"""The rows of a table: segments, or points with their strands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...arrays import AnyArray, IntArray
from ...errors import InputError
from ...geometry.lines import AXES, Lines
from ...geometry.offsets import NO_OFFSET, OFFSET
from ...support.metadata import from_json
from ..rounding import Rounding
from ..segment_collector import offset_for
from ..source import Source

SEGMENT = ("x0", "y0", "z0", "x1", "y1", "z1")
POINT = ("x", "y", "z")
COORDINATES = {*SEGMENT, *POINT, "segment", "point"}
#: What marks a column of values at both ends of segments, in the metadata of its field.
KEY, ENDS = b"fastlines", b"end_attributes"
#: What the metadata of a schema have of lines as a whole.
_FACTS = ("up", "unit", "metadata")


def has_lines(names: list[str]) -> bool:
    """Return whether there are columns of segments, or of points with their strand."""
    has_points = {*POINT} <= {*names} or "point" in names
    return {*SEGMENT} <= {*names} or "segment" in names or (has_points and "strand" in names)


class TableRows:
    """What the rows of a table are, and how they become lines.

    Parameters
    ----------
    source : Source
    schema : schema of Arrow
    left_out : list of str
        The columns that are not read.

    Attributes
    ----------
    rounding : Rounding
        What float32 has lost of the coordinates of lines that were made.
    """

    def __init__(self, source: Source, schema: Any, left_out: list[str]) -> None:
        self._source, self._names = source, schema.names
        self._ends = {field.name for field in schema if (field.metadata or {}).get(KEY) == ENDS}
        self._facts = _facts(source, schema.metadata or {})
        self._offset = NO_OFFSET
        self.rounding = Rounding()
        if left_out:
            source.warn(f"columns that are not numbers are not read: {', '.join(left_out)}")

    def set_offset(self, parts: Iterable[dict[str, AnyArray]]) -> None:
        """Set the given offset, or that of the table, of columns that come in parts."""
        wanted = self._source.offset_or(self._facts.get("metadata", {}))
        self._offset = offset_for(wanted, (self.coordinates(dict(columns))[1] for columns in parts))

    def coordinates(self, columns: dict[str, AnyArray]) -> tuple[bool, AnyArray]:
        """Take the coordinates out of the columns: whether they are of points, and all points, (m, 3)."""
        segments, points = _take(columns, SEGMENT, "segment", 6), _take(columns, POINT, "point", 3)
        if segments is not None and points is None:
            return False, segments.reshape(-1, 3)
        if points is not None and segments is None:
            return True, points
        what = "columns of segments and of points" if segments is not None else f"the columns {self._names}"
        raise self._source.error(
            f"has {what}; expected x0 y0 z0 x1 y1 z1 for a row a segment, or x y z and strand for a row a point, or "
            "geometries as in GeoParquet"
        )

    def lines(
        self, columns: dict[str, AnyArray], strand: IntArray | None, n: int, invalid: str, first_row: int = 0
    ) -> Lines:
        """Return lines of n rows, the first of which has a number in the table."""
        has_points, points = self.coordinates(columns)
        make = self._of_points if has_points else self._of_segments
        made = make(self.rounding.to_float32(points, self._offset), columns, strand, n, invalid, first_row)
        metadata = {name: value for name, value in self._facts.get("metadata", {}).items() if name != OFFSET}
        metadata |= {} if self._offset == NO_OFFSET else {OFFSET: self._offset}
        return replace(made, **self._facts | {"metadata": metadata})

    def _of_segments(
        self,
        points: AnyArray,
        columns: dict[str, AnyArray],
        strand: IntArray | None,
        n: int,
        invalid: str,
        first_row: int,
    ) -> Lines:
        radius = columns.pop("radius", None)
        if radius is None and {"radius0", "radius1"} <= columns.keys():
            radius = np.stack([columns.pop("radius0"), columns.pop("radius1")], axis=1)
        at_ends = {name: columns.pop(name) for name in sorted(self._ends & columns.keys())}
        if any(values.shape[:2] != (n, 2) for values in at_ends.values()):
            raise self._source.error(
                f"a column of values at both ends of segments is not a list of 2: one of {', '.join(at_ends)}"
            )
        return Lines.from_segments(
            points.reshape(n, 2, 3),
            strands=np.full(n, -1) if strand is None else strand,
            radius=None if radius is None else self._source.radius("radius", radius, first_row),
            attributes=columns,
            end_attributes=at_ends,
            invalid=invalid,
        )

    def _of_points(
        self,
        points: AnyArray,
        columns: dict[str, AnyArray],
        strand: IntArray | None,
        n: int,
        invalid: str,
        first_row: int,
    ) -> Lines:
        if strand is None:
            raise self._source.error(
                "has points without a column 'strand' that says to which strand each belongs; add one"
            )
        if len(strand) and strand.min() < 0:
            raise self._source.error("the column 'strand' has negative numbers; leave out points without a strand")

        # Bring the points of each strand together, in their order.
        if (strand[1:] < strand[:-1]).any():
            order = np.argsort(strand, kind="stable")
            strand, points = strand[order], points[order]
            columns = {name: values[order] for name, values in columns.items()}
        first = np.flatnonzero(np.append(True, strand[1:] != strand[:-1])[:n])
        counts = np.diff(np.append(first, n))
        radius = columns.pop("radius", None)
        radius = None if radius is None else self._source.radius("radius", radius, first_row)
        made = Lines.from_points(points, counts, radius=radius, attributes=columns, invalid=invalid)
        return replace(made, strands=np.asarray(strand[first][made.strands], np.int64))


def _take(columns: dict[str, AnyArray], names: tuple[str, ...], name: str, width: int) -> AnyArray | None:
    """Take coordinates out of the columns, (n, width), from columns of one each or from one of lists."""
    if all(part in columns and columns[part].ndim == 1 for part in names):
        return np.stack([columns.pop(part) for part in names], axis=1)
    whole = columns.get(name)
    if whole is None or whole.ndim == 1 or whole[:1].size not in (0, width) or np.prod(whole.shape[1:]) != width:
        return None
    return columns.pop(name).reshape(-1, width)


def _facts(source: Source, metadata: dict[bytes, bytes]) -> dict[str, Any]:
    """Return the upward axis, the unit and the metadata, if the table has them and they are such."""
    texts = {name: metadata.get(name.encode(), b"").decode("utf-8", "replace") for name in _FACTS}
    if texts["up"] and texts["up"] not in AXES:
        source.warn(f"its 'up' is {texts['up']!r}, no axis, and is not used")
        texts["up"] = ""
    if not texts["unit"].isprintable():
        source.warn("its 'unit' is not text, and is not used")
        texts["unit"] = ""
    facts: dict[str, Any] = {name: text for name, text in texts.items() if text}
    if known := _metadata(source, facts.pop("metadata", "")):
        facts["metadata"] = known
    return facts


def _metadata(source: Source, text: str) -> Mapping[str, Any]:
    """Return the metadata of lines, if a text holds them."""
    try:
        return from_json(text) if text else {}
    except InputError as error:
        source.warn(f"its 'metadata' are left out: {error}")
        return {}
