"""Tables in chunks: files and row groups are read one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pyarrow as pa

from ...arrays import AnyArray, IntArray
from ...geometry.lines import Lines
from ..cut_lines import regroup
from ..source import Source
from .arrow_columns import StrandNumbers, values_of, warn_of_empty
from .arrow_rows import COORDINATES, TableRows, has_lines
from .arrow_table import STRAND, TableFile, files_of, numbers_of

#: So many rows are read at once.
_ROWS = 1 << 16
_Part = tuple[dict[str, AnyArray], IntArray | None]


def chunks_of(source: Source, max_segments: int, invalid: str) -> Iterator[Lines] | None:
    """Return the chunks of a table; None if its lines are geometries, or the numbers of its strands do not rise."""
    with closing(files_of(source, has_lines)) as files:
        first = next(files)
    if first.geometries is not None or not first.names:
        return None
    surveyed = [name for name in first.names if name == STRAND or _may_be_empty(first, name)]
    strands, n_empty = StrandNumbers(source), dict.fromkeys(surveyed, 0)
    for table in _tables(source, surveyed) if surveyed else ():
        for name in surveyed:
            if name == STRAND:
                strands.survey(table.column(name))
            else:
                n_empty[name] += table.column(name).null_count
    strands.check()
    if not strands.rises:
        return None
    for name, n in n_empty.items():
        warn_of_empty(source, name, n)
    left_out = [f"{field.name} ({field.type})" for field in first.schema if field.name not in first.names]
    rows = TableRows(source, first.schema, left_out)

    def parts(names: list[str]) -> Iterator[_Part]:
        is_empty = True
        for table in _tables(source, names):
            yield _arrays(source, table, strands, n_empty)
            is_empty = False
        if is_empty:
            yield _arrays(source, first.schema.empty_table().select(names), strands, n_empty)

    def lines() -> Iterator[Lines]:
        n_rows = 0
        for columns, strand in _of_whole_strands(parts(first.names), rows):
            n = len(next(iter(columns.values())) if strand is None else strand)
            yield rows.lines(columns, strand, n, invalid, n_rows)
            n_rows += n
        rows.rounding.warn()

    places = [name for name in first.names if name in COORDINATES]
    rows.set_offset(columns for columns, _ in parts(places or first.names))
    return regroup(lines(), max_segments)


def _may_be_empty(file: TableFile, name: str) -> bool:
    """Return whether a column may have empty rows that make floats of whole numbers."""
    field = file.schema.field(name)
    found = numbers_of(field.type)
    return field.nullable and found is not None and not found[1] and not pa.types.is_floating(found[0])


def _tables(source: Source, names: list[str]) -> Iterator[Any]:
    """Yield some columns of all files of a table, some rows at a time."""
    for file in files_of(source, has_lines):
        yield from file.batches(names, _ROWS)


def _arrays(source: Source, table: Any, strands: StrandNumbers, n_empty: dict[str, int]) -> _Part:
    """Return columns as arrays, and the number of the strand of each row."""
    names = [name for name in table.column_names if name != STRAND]
    columns = {name: values_of(source, name, table.column(name), n_empty.get(name, 0)) for name in names}
    return columns, strands.of(table.column(STRAND)) if STRAND in table.column_names else None


def _of_whole_strands(parts: Iterator[_Part], rows: TableRows) -> Iterator[_Part]:
    """Yield rows so that the points of a strand are together."""
    waiting: list[_Part] = []
    for columns, strand in parts:
        if strand is None or not rows.coordinates(dict(columns))[0]:
            yield columns, strand
            continue
        # Keep the last strand, which may go on.
        start = int(np.searchsorted(strand, strand[-1])) if len(strand) else 0
        if start or not _goes_on(waiting, strand):
            if done := [*waiting, ({name: values[:start] for name, values in columns.items()}, strand[:start])]:
                yield _together(done)
            waiting = []
        waiting.append(({name: values[start:] for name, values in columns.items()}, strand[start:]))
    if waiting:
        yield _together(waiting)


def _goes_on(waiting: list[_Part], strand: IntArray) -> bool:
    last = waiting[-1][1] if waiting else None
    return last is None or not len(last) or not len(strand) or bool(last[-1] == strand[0])


def _together(parts: list[_Part]) -> _Part:
    columns = {name: np.concatenate([of[name] for of, _ in parts]) for name in parts[0][0]}
    return columns, np.concatenate([strand for _, strand in parts if strand is not None])
