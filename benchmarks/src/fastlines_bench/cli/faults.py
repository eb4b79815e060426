"""``fastlines-bench faults``: allocations, threads, and calls that write or read files fail in turn."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from fastlines import InputError

from ..faults.run import MODES, run_faults, to_json
from ..faults.show import are_handled, print_faults
from .app import app
from .options import JsonFile, check_files, check_names, progress_bar, write_json


@app.command(short_help="Allocations, threads, and calls that write or read files fail in turn.")
def faults(
    only: Annotated[
        list[str] | None,
        typer.Option("--only", metavar="NAME,…", help="What fails: memory, library, files, reads; the default is all."),
    ] = None,
    operation: Annotated[
        str | None,
        typer.Option("--operation", metavar="TEXT", help="Only operations with this text in their name, such as save."),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Make each allocation, each new thread, and each call that writes or reads a file fail in turn.

    Each operation, such as a build, a query or a save, runs again and again, and another of its calls fails each time,
    until a run has no such call. After each failure there must be a MemoryError or a sentence, and the next call and a
    tree from before must answer as they did. A file must be the old one or the new one, and nothing else may be left.
    "library" are allocations and threads of the library for C++ and C, in a program of its own. The exit code is 1 if
    any failure was not handled. It needs Linux and a C++ compiler.

    [bold]Examples[/]

    [cyan]fastlines-bench faults --json faults.json[/]  half an hour

    [cyan]fastlines-bench faults --only memory --operation first_hit[/]
    """
    check_files(json_file)
    if not sys.platform.startswith("linux"):
        raise InputError(f"faults are injected by LD_PRELOAD, on Linux; this is {sys.platform}")
    whats = check_names("--only", "thing that fails", only, tuple(MODES)) or tuple(MODES)
    with progress_bar() as progress:
        rows = run_faults(whats, operation, progress)
    if not any(rows.values()):
        raise InputError(f"--operation {operation!r}: no operation has this text in its name; try save, build or query")
    print_faults(rows)
    write_json(json_file, to_json(rows))
    if not are_handled(rows):
        raise typer.Exit(1)
