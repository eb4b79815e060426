"""``fastlines-bench scale``: forests of trees, out of core and on Dask workers."""

from __future__ import annotations

from typing import Annotated

import typer

from fastlines import InputError
from fastlines.scenes import MAX_SEGMENTS

from ..harness.show_figures import print_figures
from ..scale.growth import draw_growth
from ..scale.run import PARTS, ScalePreset, run_scale
from .app import app
from .options import (
    JsonFile,
    PlotFile,
    Quick,
    Rounds,
    check_counts,
    check_files,
    check_names,
    progress_bar,
    write_json,
    write_plot,
)


@app.command(short_help="Forests of trees: answers, memory, Dask workers, kills, restarts, growth.")
def scale(
    part: Annotated[
        list[str] | None,
        typer.Option(
            "--part",
            "-p",
            metavar="NAME,…",
            help=f"The parts, separated by commas: {', '.join(PARTS)}. The default is all.",
            show_default=False,
        ),
    ] = None,
    n_segments: Annotated[
        int | None,
        typer.Option("--segments", "-n", help="The size of the scene that does not fit.", min=1000, show_default=False),
    ] = None,
    gigabytes: Annotated[
        float | None,
        typer.Option("--limit", help="The limit of its memory in GB.", min=0.5, show_default=False),
    ] = None,
    n_rays: Annotated[
        int | None, typer.Option("--n-rays", help="The rays of that scene, and of growth.", min=64, show_default=False)
    ] = None,
    cluster_rays: Annotated[
        int | None, typer.Option("--cluster-rays", help="The rays of the workers.", min=64, show_default=False)
    ] = None,
    kills: Annotated[
        int | None, typer.Option("--kills", help="How often to kill a worker, or a build.", min=1, show_default=False)
    ] = None,
    sizes: Annotated[
        str | None,
        typer.Option("--sizes", metavar="N,N,…", help="The numbers of segments of growth.", show_default=False),
    ] = None,
    rays: Annotated[
        str | None,
        typer.Option("--rays", metavar="N,N,…", help="The numbers of rays of growth.", show_default=False),
    ] = None,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
    plot: PlotFile = None,
) -> None:
    """Measure forests of trees.

    answers compares every query of forests of 1, 7 and 64 tiles with one tree, bit for bit. memory handles 50
    million segments within 4 GB. cluster times Dask workers beside one process. kills and restarts end workers and
    builds at random moments. growth fits times as powers of segments, rays and tiles.

    [bold]Examples[/]

    [cyan]fastlines-bench scale --quick[/]

    [cyan]fastlines-bench scale --part memory --segments 10000000 --limit 2[/]

    [cyan]fastlines-bench scale --part growth --json growth.json --plot growth.png[/]
    """
    check_files(json_file, plot)
    parts = check_names("--part", "part", part, PARTS)
    if plot is not None and parts is not None and "growth" not in parts:
        raise InputError("--plot draws the part growth, which --part leaves out; add it, or leave --plot out")
    preset = ScalePreset.of(
        quick,
        parts=parts,
        n_segments=n_segments,
        limit=None if gigabytes is None else int(gigabytes * 1e9),
        n_rays=n_rays,
        cluster_rays=cluster_rays,
        kills=kills,
        growth_sizes=None if sizes is None else check_counts("--sizes", sizes, 10**9, "100000,1000000"),
        growth_rays=None if rays is None else check_counts("--rays", rays, MAX_SEGMENTS * 100, "100000,1000000"),
        rounds=rounds,
    )
    with progress_bar() as progress:
        result = run_scale(preset, progress, print_figures)
    write_json(json_file, result.to_json())
    grown = [figures for figures in result.parts if figures.name == "growth"]
    if grown:
        write_plot(plot, draw_growth, grown[0])
