"""``fastlines-bench compare`` and ``answers``: two installed copies of fastlines compared."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from fastlines import FastlinesError, InputError
from fastlines.scenes import NAMES

from ..engine.copies import CopiesPreset, compare_copies, differences, hash_answers, print_comparison
from ..harness import machine
from ..peers.copy_process import Copy
from ..peers.copy_worker import KINDS, QUERIES
from .app import app
from .options import (
    JsonFile,
    NRays,
    Quick,
    Rounds,
    Seconds,
    Threads,
    check_files,
    check_kinds,
    check_names,
    progress_bar,
    write_json,
)

Scene = Annotated[
    list[str] | None,
    typer.Option("--scene", "-s", metavar="NAME,…", help="The scenes, separated by commas.", show_default=False),
]
Radii = Annotated[
    str | None,
    typer.Option(
        "--radius", "-r", metavar="R,R,…", help="The radii of the queries, separated by commas.", show_default=False
    ),
]
COPY_HELP = "a Python that has fastlines, or a folder that pip install --target made"


def _radii(text: str | None) -> tuple[float, ...] | None:
    try:
        return None if text is None else tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--radius {text!r} is not one or more numbers, such as 0.005,0.001") from None


@app.command(short_help="The speed-up of one installed copy of fastlines over another.")
def compare(
    old: Annotated[str, typer.Option("--old", metavar="COPY", help=f"The old copy: {COPY_HELP}.")],
    new: Annotated[str, typer.Option("--new", metavar="COPY", help=f"The new copy: {COPY_HELP}.")] = sys.executable,
    scene: Scene = None,
    radius: Radii = None,
    rays: Annotated[
        str, typer.Option("--rays", metavar="KIND,…", help="The kinds of rays, separated by commas.")
    ] = ",".join(KINDS),
    query: Annotated[
        str, typer.Option("--query", metavar="NAME,…", help="The queries, separated by commas.")
    ] = "first,any,all,count,next",
    threads: Threads = 1,
    seconds: Seconds = None,
    rounds: Rounds = None,
    simd: Annotated[
        str | None,
        typer.Option("--simd", metavar="NAME", help="The instruction set of both copies.", show_default=False),
    ] = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Compare two copies of fastlines: alternate builds and queries on the same rays, and check answers bit for bit.

    Each copy has a worker process, which is started again for each scene and radius. A ratio is the median over the
    rounds of old seconds by new seconds: above 1 the new copy is faster. Compare a copy with itself to see the noise.

    [bold]Examples[/]

    [cyan]git worktree add ../before HEAD~1[/]

    [cyan]pip install --no-deps --target ../installed/before ../before[/]

    [cyan]fastlines-bench compare --old ../installed/before[/]

    [cyan]fastlines-bench compare --old ../old/bin/python --new ../new/bin/python --scene bun-hair --radius 0.001[/]
    """
    check_files(json_file)
    preset = CopiesPreset.of(
        quick,
        scenes=check_names("--scene", "scene", scene, NAMES),
        radii=_radii(radius),
        kinds=check_kinds(rays, KINDS),
        queries=check_names("--query", "query", [query], QUERIES),
        n_threads=threads,
        seconds=seconds,
        rounds=rounds,
    )
    if simd is not None:
        os.environ["FASTLINES_SIMD"] = simd
    with progress_bar() as progress:
        found = compare_copies(old, new, preset, machine.describe(threads=threads), progress)
    print_comparison(found)
    write_json(json_file, found.to_json())
    if not all(each.same for each in found.contests):
        raise typer.Exit(1)


@app.command(short_help="Hashes of all answers, to check another version against.")
def answers(
    write: Annotated[
        str | None,
        typer.Option(
            "--write", metavar="FILE.json", help="The file to which the hashes are written.", show_default=False
        ),
    ] = None,
    check: Annotated[
        str | None,
        typer.Option(
            "--check", metavar="FILE.json", help="The file with whose hashes they are compared.", show_default=False
        ),
    ] = None,
    copy: Annotated[
        str, typer.Option("--copy", metavar="COPY", help=f"The copy: {COPY_HELP}. Without it, the running Python.")
    ] = sys.executable,
    threads: Threads = 2,
    n_rays: NRays = None,
    quick: Quick = False,
) -> None:
    """Hash the trees and the answers of a copy of fastlines: all queries, kinds of rays, scenes and radii.

    Write the hashes with one version and check another version against them. The command names all that differ; then
    its exit code is 1.

    [bold]Examples[/]

    [cyan]fastlines-bench answers --copy ../old/bin/python --write answers.json[/]

    [cyan]fastlines-bench answers --check answers.json[/]
    """
    if (write is None) == (check is None):
        raise InputError("give one of --write FILE and --check FILE")
    check_files(write)
    preset = CopiesPreset.of(quick, n_rays=n_rays)
    known = None
    if check is not None:
        try:
            known = json.loads(Path(check).read_text(encoding="utf-8"))
            before = known["hashes"]
            preset = CopiesPreset.of(quick=known["quick"], n_rays=known["n_rays"])
        except (ValueError, LookupError, TypeError):
            raise InputError(f"{check}: is not a file that 'fastlines-bench answers --write' wrote") from None
    with Copy(copy, threads) as hashed, progress_bar() as progress:
        found = hash_answers(hashed, preset, progress)
    if known is None:
        write_json(write, {"copy": hashed.about, "quick": quick, "n_rays": preset.n_rays, "hashes": found})
        typer.echo(f"{write}: {len(found)} hashes of fastlines {hashed.about['version']}")
        return
    differ = differences(before, found)
    for name in differ:
        typer.echo(f"differs: {name}")
    if differ:
        raise FastlinesError(f"{len(differ)} of {len(found)} hashes differ from those in {check}")
    typer.echo(f"all {len(found)} trees and answers are those in {check}, bit for bit")
