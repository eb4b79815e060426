"""The tables of the parts."""

from __future__ import annotations

from typing import Any

from .figures import Figures
from .show_checks import print_checks
from .tables import format_3_digits, new_table, print_table, wide_console


def print_figures(figures: Figures) -> None:
    """Print the table of a part, its notes, and what was wanted."""
    console = wide_console()
    is_text = [all(isinstance(row[i], str) for row in figures.rows) for i in range(len(figures.heads))]
    table = new_table(figures.title, [], [])
    for head, text in zip(figures.heads, is_text, strict=True):
        table.add_column(head, justify="left" if text else "right", no_wrap=not text)
    for row in figures.rows:
        table.add_row(*map(_text, row))
    print_table(console, table)
    for note in figures.notes:
        console.print(note, highlight=False)
    print_checks(console, figures.checks)


def _text(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, float):
        return format_3_digits(value)
    return f"{value:,}" if isinstance(value, int) else str(value)
