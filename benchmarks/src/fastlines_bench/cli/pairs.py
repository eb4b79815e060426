"""``fastlines-bench pairs``: all pairs of segments that touch, beside a k-d tree of samples and all pairs."""

from __future__ import annotations

from typing import Annotated

import typer

from ..proximity.contacts import GENERATORS
from ..proximity.pairs import PairsPreset, run_pairs
from ..proximity.show_pairs import print_pairs
from .app import app
from .options import JsonFile, Quick, Rounds, Threads, check_counts, check_files, check_names, progress_bar, write_json


@app.command(short_help="All pairs of segments that touch, beside a k-d tree of samples and all pairs.")
def pairs(
    scene: Annotated[
        list[str] | None,
        typer.Option(
            "--scene",
            "-s",
            metavar="NAME,…",
            help="The scenes, separated by commas: yarn, rods, crossing. The default is all.",
            show_default=False,
        ),
    ] = None,
    sizes: Annotated[
        str | None,
        typer.Option(
            "--sizes",
            metavar="N,N,…",
            help="The numbers of segments of yarn and rods; the default is 10000,100000,1000000.",
            show_default=False,
        ),
    ] = None,
    threads: Threads = 1,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Find all pairs of segments that touch, in knitted yarn, a pile of rods, and long lines that cross.

    Peers are a k-d tree of scipy over samples, with the best spacing, up to 100,000 segments; and two loops over
    all pairs, 16 at a time, up to 20,000 segments: one with our test, and one with the formula of textbooks, for one
    thread. The pairs of all sides must be the same.

    [bold]Examples[/]

    [cyan]fastlines-bench pairs --quick[/]

    [cyan]fastlines-bench pairs --json pairs.json[/]  up to a million segments: some minutes

    [cyan]fastlines-bench pairs --scene rods --sizes 100000 --threads 2[/]
    """
    check_files(json_file)
    preset = PairsPreset.of(
        quick,
        scenes=check_names("--scene", "scene", scene, GENERATORS),
        sizes=None if sizes is None else tuple(sorted(check_counts("--sizes", sizes, 10**8, "10000,100000"))),
        n_threads=threads,
        rounds=rounds,
    )
    with progress_bar() as progress:
        result = run_pairs(preset, progress)
    print_pairs(result)
    write_json(json_file, result.to_json())
