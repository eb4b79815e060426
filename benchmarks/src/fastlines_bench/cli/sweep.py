"""``fastlines-bench sweep``: many radii from one tree, beside Embree, which is built anew for each."""

from __future__ import annotations

from typing import Annotated

import typer

from ..engine.sweep import SweepPreset, print_sweep, run_sweep
from ..harness.internals import method_settings
from ..harness.subjects import subjects_of
from .app import app
from .options import (
    JsonFile,
    NRays,
    Peer,
    Quick,
    Rounds,
    Threads,
    check_files,
    check_peer,
    progress_bar,
    write_json,
)


@app.command(short_help="Many radii from one tree, beside Embree rebuilt for each.")
def sweep(
    scene: Annotated[
        str, typer.Option("--scene", "-s", metavar="NAME", help="A scene: NAME, NAME:SEGMENTS or NAME:SEGMENTS:SEED.")
    ] = "photon-beams",
    radii: Annotated[
        int | None, typer.Option("--radii", help="The number of radii; the default is 60.", min=1, show_default=False)
    ] = None,
    first: Annotated[float, typer.Option("--first", help="The least radius.", min=1e-9)] = 0.0005,
    last: Annotated[float, typer.Option("--last", help="The largest radius.", min=1e-9)] = 0.05,
    method: Annotated[str, typer.Option("--method", "-m", metavar="NAME", help="The builder of our tree.")] = "best",
    n_rays: NRays = None,
    threads: Threads = 1,
    rounds: Rounds = None,
    peer: Peer = "embree",
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Find the first hits of a picture with each of many radii; builds count too.

    Ours is one build for all radii. Embree's boxes contain the radius, so it is built for each. Of user geometry, flat
    and round curves, whole or in pieces, with each quality and packet width, the fastest of each geometry is timed.
    The first hits of user geometry must be ours.

    [bold]Examples[/]

    [cyan]fastlines-bench sweep --quick[/]

    [cyan]fastlines-bench sweep --scene bun-hair --radii 30 --threads 2 --json sweep.json[/]
    """
    check_files(json_file)
    method_settings(method)
    with_embree = check_peer(peer, threads)
    (subject,) = subjects_of([scene], [], str(first), False)
    preset = SweepPreset.of(
        quick, method=method, first=first, last=last, n_radii=radii, n_rays=n_rays, n_threads=threads, rounds=rounds
    )
    with progress_bar() as progress:
        result = run_sweep(subject, preset, with_embree, progress)
    print_sweep(result)
    write_json(json_file, result.to_json())
