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

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import AnyArray, IntArray
from ...errors import FastlinesError, InputError
from ...geometry.lines import AXES, Lines
from ...geometry.offsets import in_file, with_metadata
from ...support.metadata import from_json, to_json
from ...support.optional import optional
from ..losses import is_encodable
from ..source import Source, reason

_SEGMENT = ("x0", "y0", "z0", "x1", "y1", "z1")
_POINT = ("x", "y", "z")
#: What marks a column of values at both ends of segments, in the metadata of its field.
_KEY, _ENDS = b"fastlines", b"end_attributes"
#: What the metadata of a schema have of lines as a whole.
_FACTS = ("up", "unit", "metadata")


def read(source: Source, invalid: str) -> Lines:
    """Read a table; a row is a segment, or a point with its strand."""
    pa = _pyarrow("reading .parquet, .feather and .arrow")
    from .arrow_table import read_table

    try:
        table, schema, geometries = read_table(source, _has_lines)
    except FastlinesError:
        raise
    except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
        raise source.error(f"not a whole table ({reason(error)}); check the extension, or write it again") from None
    used = table.column_names
    left_out = [f"{field.name} ({field.type})" for field in schema if field.name not in used]
    if geometries is not None:
        return _geometry_lines(source, table, geometries, left_out, invalid)
    columns = {name: _values(source, name, table.column(name)) for name in used if name != "strand"}
    ends = {name for name in columns if (schema.field(name).metadata or {}).get(_KEY) == _ENDS}
    strand = _strands(source, table.column("strand")) if "strand" in used else None
    made = _lines(source, columns, ends, strand, table.num_rows, schema, invalid)
    if left_out:
        source.warn(f"columns that are not numbers are not read: {', '.join(left_out)}")
    return _with_facts(source, made, schema.metadata or {})


def _has_lines(names: list[str]) -> bool:
    """Return whether there are columns of segments, or of points with their strand."""
    has_points = {*_POINT} <= {*names} or "point" in names
    return {*_SEGMENT} <= {*names} or "segment" in names or (has_points and "strand" in names)


def _geometry_lines(source: Source, table: Any, geometries: Any, left_out: list[str], invalid: str) -> Lines:
    """Return the lines of a column of geometries; the other columns are values of rows."""
    from .arrow_table import has_texts
    from .geoparquet import lines_of

    texts = [field.name for field in table.schema if has_texts(field.type)]
    numbers = [name for name in table.column_names if name not in (*texts, geometries.name)]
    per_row = {name: _values(source, name, table.column(name)) for name in numbers}
    lines = lines_of(source, table, geometries, per_row, texts, invalid)
    if left_out := [text for text in left_out if text.partition(" ")[0] not in geometries.hidden]:
        source.warn(f"columns that are neither numbers nor texts are not read: {', '.join(left_out)}")
    return lines


def write(lines: Lines, path: Path) -> list[str]:
    """Write a row for each segment: ``x0`` … ``z1``, ``strand`` and radii, and attributes by their names."""
    pa = _pyarrow("writing .parquet, .feather and .arrow")
    given: dict[str, AnyArray] = dict(zip(_SEGMENT, in_file(lines, lines.segments).reshape(-1, 6).T, strict=True))
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
        taken = name in (*_SEGMENT, *_POINT, "segment", "point", "strand", "radius", "radius0", "radius1")
        if column is None or taken or not is_encodable(name):
            lost.append(f"{name!r} ({'its name is taken' if taken else values.dtype})")
            continue
        columns[name] = column
        fields.append(pa.field(name, column.type, metadata={_KEY: _ENDS} if at_ends else None))
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


def _values(source: Source, name: str, column: Any) -> AnyArray:
    """Return a column of numbers as an array, (n,) or (n, k)."""
    import pyarrow as pa

    from .arrow_table import numbers_of

    kind, shape = numbers_of(column.type) or (column.type, [])
    if pa.types.is_dictionary(column.type):
        column = column.cast(kind)
    n = len(column)
    whole = column.combine_chunks() if column.num_chunks != 1 else column.chunk(0)
    for _ in shape:
        if whole.null_count:
            raise source.error(f"the column {name!r} has {whole.null_count} empty rows; fill them, or leave them out")
        whole = whole.flatten()
    if whole.null_count and not pa.types.is_floating(kind):
        source.warn(f"the column {name!r} has {whole.null_count} empty rows, which are NaN; so it is of type float64")
        whole = whole.cast(pa.int8()) if pa.types.is_boolean(kind) else whole
        whole = whole.cast(pa.float64(), safe=False)
    flat = np.asarray(whole.to_numpy(zero_copy_only=False))
    return flat.reshape(n, *shape) if shape else flat


def _strands(source: Source, column: Any) -> IntArray:
    """Return a number for the strand of each row."""
    import pyarrow as pa

    from .arrow_table import is_text

    is_coded = pa.types.is_dictionary(column.type)
    if is_coded and not is_text(column.type.value_type):
        column, is_coded = column.cast(column.type.value_type), False
    elif is_text(column.type):
        column, is_coded = column.dictionary_encode(), True
    column = column.unify_dictionaries() if is_coded else column
    texts = column.chunk(0).dictionary if is_coded and column.num_chunks else None
    n_empty = column.null_count + (texts.null_count if texts is not None else 0)
    if n_empty:
        raise source.error(f"the column 'strand' has {n_empty} empty rows; fill them, or leave them out")
    if is_coded:
        if texts is None:
            return np.empty(0, np.int64)
        # Number the texts in the order in which they come first; a dictionary may hold a text twice.
        same = texts.dictionary_encode().indices.to_numpy(zero_copy_only=False)
        codes = same[np.concatenate([chunk.indices.to_numpy(zero_copy_only=False) for chunk in column.chunks])]
        _, first, number = np.unique(codes, return_index=True, return_inverse=True)
        return np.asarray(np.argsort(np.argsort(first))[number], np.int64)
    numbers = np.asarray(column.to_numpy())
    if len(numbers) and (numbers.max() > np.iinfo(np.int64).max or numbers.min() < -1):
        raise source.error(
            f"the column 'strand' has numbers from {numbers.min()} to {numbers.max()}; expected 0 or more"
        )
    return numbers.astype(np.int64)


def _lines(
    source: Source,
    columns: dict[str, AnyArray],
    ends: set[str],
    strand: IntArray | None,
    n: int,
    schema: Any,
    invalid: str,
) -> Lines:
    """Make lines of the columns of a table of n rows."""
    offset = source.offset_or(_metadata(source, schema.metadata or {}))
    segments, points = _take(columns, _SEGMENT, "segment", 6), _take(columns, _POINT, "point", 3)
    if (segments is None) == (points is None):
        what = "columns of segments and of points" if segments is not None else f"the columns {schema.names}"
        raise source.error(
            f"has {what}; expected x0 y0 z0 x1 y1 z1 for a row a segment, or x y z and strand for a row a point, or "
            "geometries as in GeoParquet"
        )
    if segments is not None:
        radius = columns.pop("radius", None)
        if radius is None and {"radius0", "radius1"} <= columns.keys():
            radius = np.stack([columns.pop("radius0"), columns.pop("radius1")], axis=1)
        at_ends = {name: columns.pop(name) for name in sorted(ends & columns.keys())}
        if any(values.shape[:2] != (n, 2) for values in at_ends.values()):
            raise source.error(
                f"a column of values at both ends of segments is not a list of 2: one of {', '.join(at_ends)}"
            )
        return Lines.from_segments(
            segments.reshape(n, 2, 3),
            strands=np.full(n, -1) if strand is None else strand,
            radius=None if radius is None else source.radius("radius", radius),
            attributes=columns,
            end_attributes=at_ends,
            offset=offset,
            invalid=invalid,
        )
    assert points is not None
    if strand is None:
        raise source.error("has points without a column 'strand' that says to which strand each belongs; add one")
    if len(strand) and strand.min() < 0:
        raise source.error("the column 'strand' has negative numbers; leave out points without a strand")

    # Bring the points of each strand together, in their order.
    if (strand[1:] < strand[:-1]).any():
        order = np.argsort(strand, kind="stable")
        strand, points = strand[order], points[order]
        columns = {name: values[order] for name, values in columns.items()}
    first = np.flatnonzero(np.append(True, strand[1:] != strand[:-1])[: len(strand)])
    counts = np.diff(np.append(first, len(strand)))
    radius = columns.pop("radius", None)
    radius = None if radius is None else source.radius("radius", radius)
    made = Lines.from_points(points, counts, radius=radius, attributes=columns, offset=offset, invalid=invalid)
    return replace(made, strands=strand[first][made.strands])


def _take(columns: dict[str, AnyArray], names: tuple[str, ...], name: str, width: int) -> AnyArray | None:
    """Take coordinates out of the columns, (n, width), from columns of one each or from one of lists."""
    if all(part in columns and columns[part].ndim == 1 for part in names):
        return np.stack([columns.pop(part) for part in names], axis=1)
    whole = columns.get(name)
    if whole is None or whole.ndim == 1 or whole[:1].size not in (0, width) or np.prod(whole.shape[1:]) != width:
        return None
    return columns.pop(name).reshape(-1, width)


def _column(values: AnyArray) -> Any:
    """Return an array (n, …) as a column of Arrow: numbers, or lists of fixed size; None if it has no such type."""
    import pyarrow as pa

    if values.dtype.kind not in "fiub" or values.dtype.itemsize > 8 or 0 in values.shape[1:]:
        return None
    column = pa.array(np.ascontiguousarray(values, values.dtype.newbyteorder("=")).reshape(-1))
    for size in values.shape[:0:-1]:
        column = pa.FixedSizeListArray.from_arrays(column, size)
    return column


def _with_facts(source: Source, lines: Lines, metadata: dict[bytes, bytes]) -> Lines:
    """Set the upward axis, the unit and the metadata, if the table has them and they are such."""
    texts = {name: metadata.get(name.encode(), b"").decode("utf-8", "replace") for name in _FACTS}
    if texts["up"] and texts["up"] not in AXES:
        source.warn(f"its 'up' is {texts['up']!r}, no axis, and is not used")
        texts["up"] = ""
    if not texts["unit"].isprintable():
        source.warn("its 'unit' is not text, and is not used")
        texts["unit"] = ""
    facts: dict[str, Any] = {name: text for name, text in texts.items() if text}
    facts.pop("metadata", None)
    if metadata_of := _metadata(source, metadata):
        facts["metadata"] = with_metadata(lines, metadata_of)
    return replace(lines, **facts) if facts else lines


def _metadata(source: Source, metadata: dict[bytes, bytes]) -> Mapping[str, Any]:
    """Return the metadata of lines, if the table has them and they are such."""
    text = metadata.get(b"metadata", b"").decode("utf-8", "replace")
    try:
        return from_json(text) if text else {}
    except InputError as error:
        source.warn(f"its 'metadata' are left out: {error}")
        return {}
