"""The columns of a Parquet or Arrow file that lines can use, read within a limit.

The types of the columns are read first, and only usable columns then. Small files can hold far more than lines would,
by compression and by run lengths. So what Parquet announces is added up before anything is unpacked, and the batches of
Arrow are added up one by one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import pyarrow as pa
import pyarrow.ipc
from pyarrow import parquet

from ..source import Source
from .geoparquet import Geometries, find_geometries

STRAND = "strand"
#: How many rows of lists are read at once.
_BATCH = 4096


class Columns(NamedTuple):
    """A table of the usable columns, the schema of the file, which has all columns, and which has geometries, if any.

    Only beside geometries are texts usable.
    """

    table: Any
    schema: Any
    geometries: Geometries | None


def read_table(source: Source, has_lines: Callable[[list[str]], bool]) -> Columns:
    """Return the usable columns of a file.

    Parameters
    ----------
    has_lines : callable
        Takes the names of columns, and returns whether they hold lines without geometries.
    """
    start = source.data[:6]
    if start[:4] == b"FEA1":
        raise source.error("is Feather of version 1; write it again as version 2, or as Parquet")
    buffer = pa.py_buffer(source.data)
    is_parquet = start[:4] == b"PAR1"
    if is_parquet:
        file = parquet.ParquetFile(pa.BufferReader(buffer))
        schema = file.schema_arrow
    else:
        open_ipc = pa.ipc.open_file if start == b"ARROW1" else pa.ipc.open_stream
        schema = open_ipc(buffer).schema
    str(schema)  # decodes all names
    names = schema.names
    if len(set(names)) < len(names):
        raise source.error("has several columns of one name; rename them")
    geometries = None if has_lines(names) else find_geometries(schema)
    if geometries is None:
        used = [i for i, field in enumerate(schema) if _is_used(source, field.name, field.type)]
    else:
        of_rows = [has_texts(field.type) or numbers_of(field.type) is not None for field in schema]
        used = [i for i, name in enumerate(names) if of_rows[i] or name == geometries.name]
    if not used:
        return Columns(schema.empty_table(), schema, None)
    if is_parquet:
        used_names = [names[i] for i in used]
        _check_parquet(source, file.metadata, {name: schema.field(name).type for name in used_names})
        # Read each text once: a long one may be in many rows. The same holds for geometries.
        coded = [name for name in used_names if _is_bytes(schema.field(name).type)]
        if coded:
            file = parquet.ParquetFile(pa.BufferReader(buffer), metadata=file.metadata, read_dictionary=coded)
        if geometries is None:
            table = file.read(columns=used_names).select(used_names)
        else:
            batches = _limited(source, file.iter_batches(_BATCH, columns=used_names))
            table = pa.Table.from_batches(batches, None if batches else file.schema_arrow).select(used_names)
    else:
        reader = open_ipc(buffer, options=pa.ipc.IpcReadOptions(included_fields=used))
        table = pa.Table.from_batches(_batches(source, reader), reader.schema)
    table.validate(full=True)
    return Columns(table, schema, geometries)


def numbers_of(kind: Any) -> tuple[Any, list[int]] | None:
    """Return the type of the numbers in a column, and the sizes of the lists that they are in; None if there are none.

    Numbers may be in a dictionary, but no lists.
    """
    if pa.types.is_dictionary(kind):
        kind = kind.value_type
        return (kind, []) if _is_number(kind) else None
    sizes: list[int] = []
    while pa.types.is_fixed_size_list(kind):
        sizes.append(kind.list_size)
        kind = kind.value_type
    return (kind, sizes) if _is_number(kind) else None


def is_text(kind: Any) -> bool:
    """Return whether values of a type are texts."""
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def has_texts(kind: Any) -> bool:
    """Return whether values of a type are texts, which may be in a dictionary."""
    return is_text(kind.value_type if pa.types.is_dictionary(kind) else kind)


def _is_bytes(kind: Any) -> bool:
    return is_text(kind) or bool(pa.types.is_binary(kind) or pa.types.is_large_binary(kind))


def _is_number(kind: Any) -> bool:
    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind))


def _is_used(source: Source, name: str, kind: Any) -> bool:
    if name != STRAND:
        return numbers_of(kind) is not None
    kind = kind.value_type if pa.types.is_dictionary(kind) else kind
    if not (pa.types.is_integer(kind) or is_text(kind)):
        raise source.error(f"the column 'strand' is of type {kind}; expected whole numbers, or texts")
    return True


def _check_parquet(source: Source, facts: Any, columns: dict[str, Any]) -> None:
    """Refuse a file that announces much more than files of its size hold."""
    per_row = 0
    for kind in columns.values():
        number, sizes = numbers_of(kind) or (pa.int64(), [])
        per_row += math.prod(sizes) * max(number.bit_width // 8, 1)
    groups = [facts.row_group(i) for i in range(facts.num_row_groups)]
    n_rows = max(facts.num_rows, sum(max(group.num_rows, 0) for group in groups))
    if n_rows * per_row > source.unpack_limit:
        raise source.error(
            f"announces {n_rows} rows of {len(columns)} columns, far more than a file of its size "
            "holds; if it is valid, write it again without compression"
        )
    # The sizes of single columns are not looked at: pyarrow ends the process if a damaged file has wrong ones.
    source.check_unpacked(sum(max(group.total_byte_size, 0) for group in groups))


def _batches(source: Source, reader: Any) -> list[Any]:
    """Read the batches of an Arrow file or stream, up to a limit."""
    is_file = isinstance(reader, pa.ipc.RecordBatchFileReader)
    return _limited(source, map(reader.get_batch, range(reader.num_record_batches)) if is_file else reader)


def _limited(source: Source, given: Iterable[Any]) -> list[Any]:
    """Return batches; refuse more bytes than a file of this size unpacks to."""
    batches = []
    n_bytes = 0
    for batch in given:
        columns = (column.indices if pa.types.is_dictionary(column.type) else column for column in batch.columns)
        n_bytes += sum(column.nbytes for column in columns)
        source.check_unpacked(n_bytes)
        batches.append(batch)
    return batches
