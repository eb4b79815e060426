"""Tables of answers: CSV, Parquet, or arrays of NumPy, written part by part.

CSV has as few digits of each number as give the same number back. What a row lacks, such as the primitive of a miss,
is an empty cell in CSV, null in Parquet, and -1, or NaN for what is no index, in ``.npz``.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..support.atomic_write import atomic_write
from ..support.optional import optional
from .files import check_output

#: Columns of the same length by their names; what is masked is missing.
Columns: TypeAlias = Mapping[str, npt.NDArray[Any]]

#: Rows of text that are made at a time.
ROWS = 1 << 16


def check_table(output: str | None, inputs: tuple[str | None, ...]) -> None:
    """Refuse, before any work, a table that cannot be written."""
    check_output(output, ".csv", ".parquet", ".npz", inputs=inputs)
    if output is not None and output.lower().endswith(".parquet"):
        optional("pyarrow.parquet", "writing .parquet", "arrow")


@contextmanager
def table_writer(output: str) -> Iterator[Callable[[Columns], None]]:
    """Return what writes the next rows of a file, which appears whole or not at all."""
    write = {".csv": _csv, ".parquet": _parquet, ".npz": _npz}[Path(output).suffix.lower()]
    with atomic_write(output) as partial, write(partial) as append:
        yield append


def rows_of_text(columns: Columns) -> Iterator[str]:
    """Yield rows as text, some at a time.

    Examples
    --------
    >>> u = np.ma.masked_array(np.float32([0.1, 0]), [False, True])
    >>> print("".join(rows_of_text({"prim": np.array([7, 8]), "u": u})), end="")
    7,0.1
    8,
    """
    n = max(map(len, columns.values()), default=0)
    for begin in range(0, n, ROWS):
        words = [_words(values[begin : begin + ROWS]) for values in columns.values()]
        yield "\n".join(map(",".join, zip(*words, strict=True))) + "\n"


def _words(values: npt.NDArray[Any]) -> list[str]:
    """Return each number in as few digits as give it back, and nothing for what is missing."""
    given = np.ma.getdata(values)
    words = _float32_words(given) if given.dtype == np.float32 else [*map(repr, given.tolist())]
    for row in np.flatnonzero(np.ma.getmaskarray(values)).tolist():
        words[row] = ""
    return words


def _float32_words(values: npt.NDArray[np.float32]) -> list[str]:
    """Return float32 numbers as text: twice as fast as NumPy does.

    9 digits always give them back. Take fewer if these do, where the powers of ten are exact in float64.
    """
    size = np.abs(values).astype(np.float64)
    size[~((size > 1e-13) & (size < 1e6))] = np.nan
    digits, exponent = np.full(len(size), 9), np.floor(np.log10(size))
    for n in (8, 7, 6):
        scale = 10.0 ** (n - 1 - exponent)
        digits[(np.rint(size * scale) / scale).astype(np.float32) == size] = n
    formats = [f"%.{n}g" for n in range(10)]
    return (",".join([formats[n] for n in digits.tolist()]) % tuple(values.tolist())).split(",") if len(values) else []


def header(columns: Columns) -> str:
    """Return the names of columns as a line of text."""
    line = StringIO()
    csv.writer(line, lineterminator="\n").writerow(columns)
    return line.getvalue()


@contextmanager
def _csv(path: Path) -> Iterator[Callable[[Columns], None]]:
    with path.open("w", encoding="utf-8", newline="") as file:

        def append(columns: Columns) -> None:
            if not file.tell():
                file.write(header(columns))
            file.writelines(rows_of_text(columns))

        yield append


@contextmanager
def _parquet(path: Path) -> Iterator[Callable[[Columns], None]]:
    import pyarrow as pa
    from pyarrow import parquet

    writer: Any = None
    try:

        def append(columns: Columns) -> None:
            nonlocal writer
            table = pa.table(dict(columns))
            writer = writer or parquet.ParquetWriter(str(path), table.schema)
            writer.write_table(table)

        yield append
    finally:
        if writer is not None:
            writer.close()


@contextmanager
def _npz(path: Path) -> Iterator[Callable[[Columns], None]]:
    parts: list[Columns] = []
    yield parts.append
    arrays: dict[str, Any] = {name: np.concatenate([np.ma.getdata(part[name]) for part in parts]) for name in parts[0]}
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)
