"""The columns of a Parquet or Arrow file that lines can use, read within a limit.

The types of the columns are read first, and only usable columns then. Small files can hold far more than lines would,
by compression and by run lengths. So what Parquet announces is added up before anything is unpacked, and the batches of
Arrow are added up one by one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import pyarrow as pa
import pyarrow.ipc
from pyarrow import parquet

from ...errors import FastlinesError
from ..source import BAD_COPY, Source, reason
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


class TableFile:
    """One file of a table, which is read whole or batch by batch.

    Parameters
    ----------
    source : Source
    has_lines : callable
        Takes the names of columns, and returns whether they hold lines without geometries.
    in_memory : bool
        Whether all bytes of the file are read first.

    Attributes
    ----------
    schema : schema of Arrow
        Of all columns.
    names : list of str
        The usable columns.
    geometries : Geometries or None
    """

    def __init__(self, source: Source, has_lines: Callable[[list[str]], bool], *, in_memory: bool) -> None:
        self.source = source
        start = source.start(6)
        if start[:4] == b"FEA1":
            raise source.error("is Feather of version 1; write it again as version 2, or as Parquet")
        self._buffer = pa.py_buffer(source.data) if in_memory else None
        self._is_parquet = start[:4] == b"PAR1"
        self._open_ipc = pa.ipc.open_file if start == b"ARROW1" else pa.ipc.open_stream
        if self._is_parquet:
            file = parquet.ParquetFile(self._opened())
            self._facts, self.schema = file.metadata, file.schema_arrow
        else:
            self.schema = self._open_ipc(self._opened()).schema
        str(self.schema)  # decodes all names
        names = self.schema.names
        if len(set(names)) < len(names):
            raise source.error("has several columns of one name; rename them")
        self.geometries = None if has_lines(names) else find_geometries(self.schema)
        if self.geometries is None:
            used = [_is_used(source, field.name, field.type) for field in self.schema]
        else:
            of_rows = [has_texts(field.type) or numbers_of(field.type) is not None for field in self.schema]
            used = [of_rows[i] or name == self.geometries.name for i, name in enumerate(names)]
        self.names = [name for name, is_used in zip(names, used, strict=True) if is_used]
        if self._is_parquet and self.names:
            _check_parquet(source, self._facts, {name: self.schema.field(name).type for name in self.names})

    def read(self) -> Any:
        """Return the table of the usable columns."""
        if not self.names:
            return self.schema.empty_table()
        if self._is_parquet:
            file = self._parquet(self.names)
            if self.geometries is None:
                table = file.read(columns=self.names).select(self.names)
            else:
                batches = list(_limited(self.source, file.iter_batches(_BATCH, columns=self.names)))
                table = pa.Table.from_batches(batches, None if batches else file.schema_arrow).select(self.names)
        else:
            reader = self._reader(self.names)
            table = pa.Table.from_batches(list(_batches(self.source, reader)), reader.schema)
        table.validate(full=True)
        return table

    def batches(self, names: list[str], n_rows: int) -> Iterator[Any]:
        """Yield some of the usable columns as tables of up to so many rows."""
        given: Iterator[Any]
        if self._is_parquet:
            file = self._parquet(names)
            # One reader of all row groups would keep what it has read of each.
            groups = range(self._facts.num_row_groups)
            given = (batch for i in groups for batch in file.iter_batches(n_rows, row_groups=[i], columns=names))
        else:
            given = _batches(self.source, self._reader(names))
        while True:
            with whole_table(self.source):
                batch = next(given, None)
                if batch is None:
                    return
                table = pa.Table.from_batches([batch]).select(names)
                table.validate(full=True)
            yield from (table.slice(at, n_rows) for at in range(0, len(table), n_rows))
            if self._is_parquet:
                self.source.advance(self.source.size * len(table) // max(self._facts.num_rows, 1))

    def _opened(self) -> Any:
        return pa.PythonFile(self.source.open()) if self._buffer is None else pa.BufferReader(self._buffer)

    def _parquet(self, names: list[str]) -> Any:
        # Read each text once: a long one may be in many rows. The same holds for geometries.
        coded = [name for name in names if _is_bytes(self.schema.field(name).type)]
        return parquet.ParquetFile(self._opened(), metadata=self._facts, read_dictionary=coded or None)

    def _reader(self, names: list[str]) -> Any:
        fields = [self.schema.names.index(name) for name in names]
        return self._open_ipc(self._opened(), options=pa.ipc.IpcReadOptions(included_fields=sorted(fields)))


def read_table(source: Source, has_lines: Callable[[list[str]], bool]) -> Columns:
    """Return the usable columns of a file, or of all files of a folder."""
    tables, first = [], None
    for file in files_of(source, has_lines, in_memory=True):
        first = first or file
        with whole_table(file.source):
            tables.append(file.read())
    assert first is not None
    table = pa.concat_tables(tables) if len(tables) > 1 else tables[0]
    return Columns(table, first.schema, first.geometries)


def is_folder(source: Source) -> bool:
    """Return whether a table is a folder of files."""
    return source.path is not None and source.path.is_dir()


def files_of(
    source: Source, has_lines: Callable[[list[str]], bool], *, in_memory: bool = False
) -> Generator[TableFile, None, None]:
    """Yield the files of a table, which have the same columns; those of a folder are open one after the other."""
    if not is_folder(source):
        with whole_table(source):
            file = TableFile(source, has_lines, in_memory=in_memory)
        yield file
        return
    assert source.path is not None
    paths = sorted(path for path in source.path.rglob("*.parquet") if path.is_file() and path.name[0] not in "._")
    if not paths:
        raise source.error("holds no .parquet file; check the path")
    first: dict[str, Any] = {}
    source.size = sum(path.stat().st_size for path in paths)
    for path in paths:
        with path.open("rb") as opened:
            part = Source(opened, str(path), path)
            if not part.size:
                raise part.error(f"is empty; {BAD_COPY}")
            with whole_table(part):
                file = TableFile(part, has_lines, in_memory=in_memory)
            columns = {name: file.schema.field(name).type for name in file.names}
            first = first or columns
            if columns != first:
                raise part.error(
                    f"has the columns {_text(columns)}, but {paths[0].name} has {_text(first)}; the files of a folder "
                    "are one table: write them with the same columns, or read them one by one"
                )
            yield file
            source.advance(part.size)


@contextmanager
def whole_table(source: Source) -> Iterator[None]:
    """Turn what pyarrow raises into errors about a file."""
    try:
        yield
    except FastlinesError:
        raise
    except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
        if source.stopped is not None:
            raise
        raise source.error(f"not a whole table ({reason(error)}); check the extension, or write it again") from None


def _text(columns: dict[str, Any]) -> str:
    return ", ".join(f"{name} ({kind})" for name, kind in columns.items())


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


def _batches(source: Source, reader: Any) -> Iterator[Any]:
    """Read the batches of an Arrow file or stream, up to a limit."""
    is_file = isinstance(reader, pa.ipc.RecordBatchFileReader)
    return _limited(source, map(reader.get_batch, range(reader.num_record_batches)) if is_file else reader)


def _limited(source: Source, given: Iterable[Any]) -> Iterator[Any]:
    """Yield batches; refuse more bytes than a file of this size unpacks to."""
    n_bytes = 0
    for batch in given:
        columns = (column.indices if pa.types.is_dictionary(column.type) else column for column in batch.columns)
        n_bytes += sum(column.nbytes for column in columns)
        source.check_unpacked(n_bytes)
        yield batch
