"""``fastlines-bench mutation``: how many small faults in the code the tests notice."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from fastlines import InputError

from ..mutation.run import Plan, read_again, run_cpp, run_python, undetected
from ..mutation.show import print_outcome
from .app import app
from .options import JsonFile, check_files, check_names, progress_bar, write_json

#: What mutates the sources of a language and runs the tests.
LANGUAGES = {"cpp": run_cpp, "python": run_python}


def _tell(text: str) -> None:
    typer.echo(text, err=True)


@app.command(short_help="How many small faults in the code the tests notice.")
def mutation(
    language: Annotated[
        str, typer.Option("--language", metavar="NAME", help="The language of the sources: cpp, python.")
    ] = "cpp",
    sample: Annotated[int, typer.Option("--sample", metavar="N", help="How many mutants are drawn.", min=1)] = 150,
    everything: Annotated[bool, typer.Option("--all", help="Try all mutants instead of a sample.")] = False,
    seed: Annotated[int, typer.Option("--seed", help="The seed: the same seed draws the same mutants.", min=0)] = 64,
    seconds: Annotated[float, typer.Option("--seconds", help="The most time of tests for one mutant.", min=0.1)] = 60.0,
    jobs: Annotated[int, typer.Option("--jobs", "-j", help="How many mutants are tried at a time.", min=1, max=64)] = 1,
    checkout: Annotated[Path, typer.Option("--checkout", metavar="FOLDER", help="The repository.")] = Path(),
    work: Annotated[
        Path | None,
        typer.Option(
            "--work",
            metavar="FOLDER",
            help="Keep what is compiled and which tests reach what in this folder, and use it again.",
            show_default=False,
        ),
    ] = None,
    again: Annotated[
        Path | None,
        typer.Option(
            "--again", metavar="FILE", help="Try only what survived in this file of --json.", show_default=False
        ),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Change one expression or statement of the code at a time, and run the tests, which should notice.

    A mutant is such a change: < becomes <=, + becomes -, a margin is left out, a condition is always true, a statement
    is removed. All of them are compiled or imported at once, each behind a switch, and only the tests that reach a
    mutant run. Mutants that do not compile are left out. Those that are known to give the same answers are counted
    apart. The exit code is 1 if a mutant survives.

    It needs Linux, a checkout, a C++ compiler, and pip install '.[test]' './benchmarks[mutation]'.

    [bold]Examples[/]

    [cyan]fastlines-bench mutation --json mutants.json --work mutated[/]  most of an hour

    [cyan]fastlines-bench mutation --work mutated --again mutants.json[/]  what survived, after a change of the tests

    [cyan]fastlines-bench mutation --language python[/]  the checks and limits in Python
    """
    check_files(json_file)
    if not sys.platform.startswith("linux"):
        raise InputError(f"mutants are switched in memory that processes share, on Linux; this is {sys.platform}")
    (name,) = check_names("--language", "language", [language], tuple(LANGUAGES)) or ("cpp",)
    plan = Plan(
        checkout.resolve(),
        None if everything else sample,
        seed,
        seconds,
        jobs,
        work,
        None if again is None else read_again(again),
    )
    with progress_bar() as progress:
        outcome = LANGUAGES[name](plan, progress, _tell)
    print_outcome(outcome)
    write_json(json_file, outcome.to_json())
    if undetected(outcome.mutants):
        raise typer.Exit(1)
