"""``fastlines-bench growth``: the cost of a ray as the scene grows."""

from __future__ import annotations

from typing import Annotated

import typer

from fastlines import InputError
from fastlines.scenes import MAX_SEGMENTS, NAMES

from ..engine.growth.run import GrowthPreset, run_growth
from ..engine.growth.show import draw_growth, print_growth
from ..harness.internals import MAX_THREADS
from .app import app
from .options import (
    JsonFile,
    NRays,
    PlotFile,
    Quick,
    Rounds,
    Seconds,
    check_counts,
    check_files,
    check_names,
    progress_bar,
    write_json,
    write_plot,
)


@app.command(short_help="The cost of a ray as the scene grows, and the speed-up by threads.")
def growth(
    scene: Annotated[
        list[str] | None,
        typer.Option(
            "--scene",
            "-s",
            metavar="NAME,…",
            help="The scenes, separated by commas; the default is spaghetti,bun-hair.",
            show_default=False,
        ),
    ] = None,
    sizes: Annotated[
        str | None,
        typer.Option(
            "--sizes",
            metavar="N,N,…",
            help="The numbers of segments; the default is 10000,30000,100000. An exponent needs two or more. "
            "The references of spaghetti grow as n^1.5, so a million segments need tens of gigabytes.",
            show_default=False,
        ),
    ] = None,
    radius: Annotated[
        float | None,
        typer.Option(
            "--radius",
            "-r",
            metavar="R",
            help="The radius for all sizes; the default is 0.001. A scene stays about 1 wide as it grows, so its lines "
            "become denser but not thinner.",
            show_default=False,
        ),
    ] = None,
    threads: Annotated[
        str,
        typer.Option(
            "--threads", "-t", metavar="N,…", help="The numbers of threads of the queries, separated by commas."
        ),
    ] = "1,2",
    n_rays: NRays = None,
    seconds: Seconds = None,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
    plot: PlotFile = None,
) -> None:
    """Time first and all hits of camera and random rays on scenes of growing size; alternate the numbers of threads.

    For each scene, kind of rays and query, the cost of a ray is fitted as a power of the number of segments.

    [bold]Examples[/]

    [cyan]fastlines-bench growth --quick[/]

    [cyan]fastlines-bench growth --scene bun-hair --json growth.json --plot growth.png[/]  up to 100,000 segments

    [cyan]fastlines-bench growth --scene straight-hair --sizes 1000,10000,100000 --threads 1,2,4[/]
    """
    check_files(json_file, plot)
    if radius is not None and not 0 < radius < float("inf"):
        raise InputError(f"--radius {radius:g} is not a finite number above 0; expected one, such as 0.001")
    preset = GrowthPreset.of(
        quick,
        scenes=check_names("--scene", "scene", scene, NAMES),
        sizes=None if sizes is None else tuple(sorted(check_counts("--sizes", sizes, MAX_SEGMENTS, "10000,100000"))),
        radius=radius,
        threads=check_counts("--threads", threads, MAX_THREADS, "1,2"),
        n_rays=n_rays,
        seconds=seconds,
        rounds=rounds,
    )
    with progress_bar() as progress:
        result = run_growth(preset, progress)
    print_growth(result)
    write_json(json_file, result.to_json())
    write_plot(plot, draw_growth, result)
