"""Tables in narrow terminals: nothing is cut off, and each part repeats the names of the rows."""

from __future__ import annotations

import io
import re

import pytest
from command_line import done
from rich.console import Console
from rich.table import Table

import fastlines as fl
from fastlines_bench.harness.internals import DEFAULT_METHOD, THESIS_METHODS
from fastlines_bench.harness.tables import print_table

COMMANDS = {
    "builders": ("builders", "--quick", "--scene", "spaghetti:200", "--peer", "none"),
    "growth": ("growth", "--quick", "--scene", "spaghetti"),
    "refit": ("refit", "--quick", "--scene", "spaghetti:200"),
}


def shown(table: Table, width: int) -> str:
    console = Console(file=io.StringIO(), width=width, force_terminal=True, color_system=None)
    print_table(console, table)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    assert max(map(len, text.splitlines())) <= width
    return text


def methods_table() -> Table:
    table = Table(title="trees", title_justify="left", pad_edge=False)
    table.add_column("tree", style="bold", no_wrap=True)
    for i in range(12):
        table.add_column(f"figure {i}", justify="right", no_wrap=True)
    table.add_column("what it is")
    for method in fl.METHODS:
        table.add_row(method, *(f"{1234 + 100 * i:,}" for i in range(12)), "words that may go on in the next line " * 3)
        table.add_section()
    return table


@pytest.mark.parametrize("width", [40, 80, 132, 400])
def test_names_and_figures_are_whole_at_any_width(width: int) -> None:
    text = shown(methods_table(), width)
    assert "…" not in text
    n_parts = text.count("trees")
    assert (n_parts == 1) == (width == 400)
    for method in fl.METHODS:
        assert len(re.findall(rf"{method}\b", text)) == n_parts
    for i in range(12):
        assert len(re.findall(rf"figure {i}\b", text)) == 1
        assert text.count(f"{1234 + 100 * i:,}") == len(fl.METHODS)


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_cuts_names_at_80_columns(
    command: str, monkeypatch: pytest.MonkeyPatch, in_own_folder: None
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("FORCE_COLOR", "1")  # as in a terminal
    text = done(*COMMANDS[command])
    assert "…" not in text
    assert "spaghetti" in text.lower()
    if command == "builders":
        assert all(method in text for method in (*THESIS_METHODS, DEFAULT_METHOD))
