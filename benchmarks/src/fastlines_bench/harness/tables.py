"""Tables in the terminal, and the format of their figures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.measure import Measurement
from rich.table import Column, Table

from .internals import format_3_digits

__all__ = ["format_3_digits", "geometric_mean", "new_table", "print_table", "wide_console"]

#: The width in characters if the output is not a terminal.
WIDE = 132


def geometric_mean(ratios: Sequence[float]) -> float | None:
    """Return the geometric mean of all ratios that are not NaN; None if there are none."""
    logs = [math.log(ratio) for ratio in ratios if not math.isnan(ratio)]
    return math.exp(sum(logs) / len(logs)) if logs else None


def new_table(title: str, names: Iterable[str], figures: Iterable[str], wrapped: Iterable[str] = ()) -> Table:
    """Return an empty table with left-aligned names, right-aligned figures and wrapped text; column 1 is bold."""
    table = Table(title=title, title_justify="left", pad_edge=False)
    for i, head in enumerate(names):
        table.add_column(head, style="" if i else "bold", no_wrap=True)
    for head in figures:
        table.add_column(head, justify="right", no_wrap=True)
    for head in wrapped:
        table.add_column(head)
    return table


def wide_console() -> Console:
    """Return a console: the terminal, or a wide page if the output is not a terminal."""
    console = Console()
    return console if console.is_terminal else Console(width=WIDE)


def print_table(console: Console, table: Table) -> None:
    """Print a table; if it is too wide, print it in parts that repeat the columns of names. No cell is cut off."""

    def least(column: Column) -> int:
        measured = [Measurement.get(console, console.options, cell) for cell in (column.header, *column.cells)]
        return max(cell.maximum if column.no_wrap else cell.minimum for cell in measured) + 3  # a line and two spaces

    # Divide the columns.
    widths = [least(column) for column in table.columns]
    names = [i for i, column in enumerate(table.columns) if column.no_wrap and column.justify == "left"]
    parts: list[list[int]] = [[]]
    for i in range(len(widths)):
        if i in names:
            continue
        if parts[-1] and sum(widths[j] for j in (*names, *parts[-1], i)) + 1 > console.width:
            parts.append([])
        parts[-1].append(i)

    # Make a table of each part.
    rows = list(zip(*(column.cells for column in table.columns), strict=True))
    for part in parts:
        columns = sorted([*names, *part])
        heads = (table.columns[i].copy() for i in columns)
        shown = Table(*heads, title=table.title, title_justify=table.title_justify, pad_edge=table.pad_edge)
        for row, cells in zip(table.rows, rows, strict=True):
            shown.add_row(*(cells[i] for i in columns), end_section=row.end_section)
        console.print(shown)
