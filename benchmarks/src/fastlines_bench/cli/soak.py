"""``fastlines-bench soak``: random cases against brute force, and brute force against float64."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from fastlines import InputError

from ..soak.answers import QUERIES
from ..soak.draw import KINDS, Choice
from ..soak.faults import FAULTS, run_trial
from ..soak.run import Plan, run_soak
from ..soak.show import print_summary, print_trials
from .app import app
from .options import JsonFile, check_files, check_names, progress_bar, write_json


def _tell(text: str) -> None:
    typer.echo(text, err=True)


@app.command(short_help="Random scenes, trees and queries against brute force, for as long as you like.")
def soak(
    minutes: Annotated[float, typer.Option("--minutes", help="How long it runs.", min=0.01)] = 1.0,
    seed: Annotated[int, typer.Option("--seed", help="The seed: the same seed makes the same cases.", min=0)] = 0,
    cases: Annotated[
        int | None,
        typer.Option("--cases", metavar="N", help="End after so many cases.", min=1, show_default=False),
    ] = None,
    case: Annotated[
        int | None,
        typer.Option("--case", metavar="K", help="Run case K of the seed alone.", min=0, show_default=False),
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(
            "--only",
            metavar="NAME,…",
            help="Kinds of geometry and queries to draw from, such as curves,first_hit; the default is all.",
            show_default=False,
        ),
    ] = None,
    write: Annotated[
        Path | None,
        typer.Option("--write", metavar="FOLDER", help="Write each difference as a test.", show_default=False),
    ] = None,
    planted: Annotated[
        bool, typer.Option("--planted", help="Plant faults one at a time, and tell how soon each is found.")
    ] = False,
    json_file: JsonFile = None,
) -> None:
    """Compare random queries on random trees with brute force, bit for bit, and brute force with float64.

    A case is a nasty scene of any kind of geometry, a tree of any builder and settings, what users do with trees (save,
    load, pickle, refit, forests), and queries with any options, kernel, instruction set and number of threads. Each
    difference is made small and printed as a test. Every second case decides which rays hit which primitives, and
    compares that with float64. Ctrl-C ends with the summary so far; the exit code is 1 if anything differs.

    [bold]Examples[/]

    [cyan]fastlines-bench soak --minutes 30 --seed 7 --write found[/]

    [cyan]fastlines-bench soak --seed 7 --case 1234[/]  one case again

    [cyan]fastlines-bench soak --only curves,nearest --minutes 5[/]

    [cyan]fastlines-bench soak --planted --minutes 5[/]  at most five minutes for each of the faults
    """
    check_files(json_file)
    if case is not None and (cases is not None or planted):
        raise InputError("--case runs one case; leave out --cases and --planted")
    if planted and (write is not None or json_file is not None):
        raise InputError("--planted prints a table of the faults; leave out --write and --json")
    if not math.isfinite(minutes):
        raise InputError(f"--minutes is {minutes}; expected a number of minutes")
    choice = Choice.of(check_names("--only", "kind of geometry or a query", only, (*KINDS, *QUERIES)))
    plan = Plan(minutes, seed, cases, case, choice, write)
    if planted:
        with progress_bar() as progress:
            trials = []
            for fault in FAULTS:
                _tell(f"planted: {fault.name}")
                trials.append(run_trial(fault, plan, progress, _tell))
        print_trials(trials)
        found = all(trial.is_found for trial in trials)
        raise typer.Exit(0 if found else 1)
    with progress_bar() as progress:
        summary = run_soak(plan, progress, _tell)
    print_summary(summary)
    write_json(json_file, summary.to_json())
    if not summary.is_clean:
        raise typer.Exit(1)
