"""Tables of Parquet and Apache Arrow (``.parquet``, ``.feather``, ``.arrow``): a row for each segment or each point.

Formats: https://parquet.apache.org/docs/file-format/ and https://arrow.apache.org/docs/format/Columnar.html; Feather of
version 2 is the latter in a file. The library pyarrow reads and writes them.

| a row is  | columns                                                                                   |
|-----------|-------------------------------------------------------------------------------------------|
| a segment | ``x0 y0 z0 x1 y1 z1``, or ``segment``, a list of 6 or of 2 × 3; optionally ``strand``      |
| a point   | ``x y z``, or ``point``, a list of 3; and ``strand``, whose points are in the order of rows |

``strand`` holds whole numbers, which are kept, or texts, which are numbered in the order in which they come first.
``radius``, or ``radius0`` and ``radius1`` of segments, is the radius. Other columns of numbers, or of lists of numbers
of fixed size, become attributes. Columns of other types are not read, with a warning. Tables without such rows may have
geometries, as GeoParquet has them: `geoparquet` reads those.

pyarrow does not check all of a file before it uses it: a damaged one may end the program.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import AnyArray
from ...geometry.lines import Lines
from ...geometry.offsets import in_file
from ...support.metadata import to_json
from ...support.optional import optional
from ..losses import is_encodable
from ..source import Source
from .arrow_rows import COORDINATES, ENDS, KEY, SEGMENT, TableRows, has_lines

_READING = "reading .parquet, .feather and .arrow"


def read(source: Source, invalid: str) -> Lines:
    """Read a table; a row is a segment, or a point with its strand."""
    _pyarrow(_READING)
    from .arrow_columns import strands_of, values_of
    from .arrow_table import read_table

    table, schema, geometries = read_table(source, has_lines)
    used = table.column_names
    left_out = [f"{field.name} ({field.type})" for field in schema if field.name not in used]
    if geometries is not None:
        return _geometry_lines(source, table, geometries, left_out, invalid)
    columns = {name: values_of(source, name, table.column(name)) for name in used if name != "strand"}
    strand = strands_of(source, table.column("strand")) if "strand" in used else None
    rows = TableRows(source, schema, left_out)
    rows.set_offset([columns])
    made = rows.lines(columns, strand, table.num_rows, invalid)
    rows.rounding.warn()
    return made


def read_chunks(source: Source, max_segments: int, invalid: str) -> Iterator[Lines] | None:
    """Read a table in chunks; not one of geometries, nor one whose numbers of strands do not rise."""
    _pyarrow(_READING)
    from .arrow_chunks import chunks_of

    return chunks_of(source, max_segments, invalid)


def _geometry_lines(source: Source, table: Any, geometries: Any, left_out: list[str], invalid: str) -> Lines:
    """Return the lines of a column of geometries; the other columns are values of rows."""
    from .arrow_columns import values_of
    from .arrow_table import has_texts
    from .geoparquet import lines_of

    texts = [field.name for field in table.schema if has_texts(field.type)]
    numbers = [name for name in table.column_names if name not in (*texts, geometries.name)]
    per_row = {name: values_of(source, name, table.column(name)) for name in numbers}
    lines = lines_of(source, table, geometries, per_row, texts, invalid)
    if left_out := [text for text in left_out if text.partition(" ")[0] not in geometries.hidden]:
        source.warn(f"columns that are neither numbers nor texts are not read: {', '.join(left_out)}")
    return lines


def write(lines: Lines, path: Path) -> list[str]:
    """Write a row for each segment: ``x0`` … ``z1``, ``strand`` and radii, and attributes by their names."""
    pa = _pyarrow("writing .parquet, .feather and .arrow")
    given: dict[str, AnyArray] = dict(zip(SEGMENT, in_file(lines, lines.segments).reshape(-1, 6).T, strict=True))
    if (lines.strands >= 0).any():
        given["strand"] = lines.strands
    if lines.radius is not None:
        radii = lines.radius
        given |= {"radius": radii} if radii.ndim == 1 else {"radius0": radii[:, 0], "radius1": radii[:, 1]}
    columns = {name: _column(values) for name, values in given.items()}
    fields = [pa.field(name, column.type) for name, column in columns.items()]
    lost = []
    for name, values in lines.attributes.items():
        at_ends = name in lines.end_attributes
        column = _column(lines.end_attributes[name] if at_ends else values)
        taken = name in {*COORDINATES, "strand", "radius", "radius0", "radius1"}
        if column is None or taken or not is_encodable(name):
            lost.append(f"{name!r} ({'its name is taken' if taken else values.dtype})")
            continue
        columns[name] = column
        fields.append(pa.field(name, column.type, metadata={KEY: ENDS} if at_ends else None))
    facts = {name: value for name in ("up", "unit") if (value := getattr(lines, name))}
    facts |= {"metadata": to_json(lines.metadata)} if lines.metadata else {}
    table = pa.Table.from_arrays(list(columns.values()), schema=pa.schema(fields, metadata=facts or None))
    if path.suffix == ".parquet":
        from pyarrow import parquet

        parquet.write_table(table, str(path))
    else:
        with pa.OSFile(str(path), "wb") as sink, pa.ipc.new_file(sink, table.schema) as writer:
            writer.write_table(table)
    return lost


def _pyarrow(what: str) -> Any:
    optional("pyarrow.ipc", what, "arrow")
    return optional("pyarrow", what, "arrow")


def _column(values: AnyArray) -> Any:
    """Return an array (n, …) as a column of Arrow: numbers, or lists of fixed size; None if it has no such type."""
    import pyarrow as pa

    if values.dtype.kind not in "fiub" or values.dtype.itemsize > 8 or 0 in values.shape[1:]:
        return None
    column = pa.array(np.ascontiguousarray(values, values.dtype.newbyteorder("=")).reshape(-1))
    for size in values.shape[:0:-1]:
        column = pa.FixedSizeListArray.from_arrays(column, size)
    return column
