"""``fastlines-bench engine``: our engine against Embree."""

from __future__ import annotations

from typing import Annotated

import typer

from fastlines import InputError

from ..engine import EnginePreset, draw, print_tables, run_engine
from ..harness.rays import KINDS
from ..harness.subjects import subjects_of
from ..package import Effort, method_settings
from .app import app
from .options import (
    Files,
    JsonFile,
    NRays,
    Peer,
    PlotFile,
    Quick,
    Rounds,
    Scenes,
    Seconds,
    Threads,
    check_files,
    check_kinds,
    check_peer,
    progress_bar,
    write_json,
    write_plot,
)


@app.command(short_help="Queries of our trees against Embree's.")
def engine(
    scene: Scenes = None,
    file: Files = None,
    radius: Annotated[
        str | None,
        typer.Option(
            "--radius",
            "-r",
            metavar="R,R,…",
            help="The radii, separated by commas. The default is 0.005, 0.001 and 0.0005 for scenes, and these shares "
            "of the box's largest side for files.",
            show_default=False,
        ),
    ] = None,
    rays: Annotated[
        str, typer.Option("--rays", metavar="KIND,…", help="The kinds of rays: camera, tiled, random, ao.")
    ] = "camera,random,ao",
    n_rays: NRays = None,
    threads: Threads = 1,
    method: Annotated[
        str | None,
        typer.Option(
            "--method",
            "-m",
            metavar="NAME",
            help="Our builder; the default is best.",
            show_default=False,
        ),
    ] = None,
    effort: Effort = None,
    peer: Peer = "embree",
    seconds: Seconds = None,
    rounds: Rounds = None,
    retune: Annotated[
        bool, typer.Option("--retune", help="Repeat the tuning of the lengths to which segments are cut for Embree.")
    ] = False,
    one_by_one: Annotated[
        bool,
        typer.Option("--one-by-one", help="Trace each ray alone: with our kernel single, and with rtcIntersect1."),
    ] = False,
    built_for: Annotated[
        float | None,
        typer.Option(
            "--built-for",
            metavar="R",
            help="Build Embree's user geometry for this radius, and query it and our tree with those of --radius.",
            show_default=False,
        ),
    ] = None,
    shapes: Annotated[
        bool,
        typer.Option(
            "--shapes",
            help="Query thick lines at their surface, which taper to a fifth of the radius along each strand, with a "
            "query radius of 0. Embree has round curves.",
        ),
    ] = False,
    quick: Quick = False,
    json_file: JsonFile = None,
    plot: PlotFile = None,
) -> None:
    """Alternate queries of our tree and of Embree on the same rays, and compare their answers.

    Embree comes from the package embreex. It is measured as user geometry, as flat and round curves and as ribbons;
    with whole segments and with segments cut to a length that is tuned for the scene; ray by ray and in packets. The
    fastest of these configurations counts in each cell.

    [bold]Examples[/]

    [cyan]fastlines-bench engine --quick[/]

    [cyan]fastlines-bench engine --json engine.json --plot engine.png[/]  all scenes and radii: many minutes

    [cyan]fastlines-bench engine --scene spaghetti --scene bun-hair --radius 0.001 --rays camera,random[/]

    [cyan]fastlines-bench engine --file hair.tfx --peer none --threads 2[/]

    [cyan]fastlines-bench engine --one-by-one --rays camera,random[/]

    [cyan]fastlines-bench engine --radius 0.0005,0.005 --built-for 0.005[/]  one tree for both

    [cyan]fastlines-bench engine --shapes --rays camera,random[/]  tapered lines
    """
    check_files(json_file, plot)
    if method is not None:
        method_settings(method)
    preset = EnginePreset.of(
        quick,
        kinds=check_kinds(rays, KINDS),
        n_rays=n_rays,
        n_threads=threads,
        method=method,
        effort=effort,
        peer=check_peer(peer, threads),
        seconds=seconds,
        rounds=rounds,
        retune=retune,
        one_by_one=one_by_one,
        built_for=built_for,
        shapes=shapes,
    )
    subjects = list(subjects_of(scene or [], file or [], radius, quick))
    largest = max(radius for subject in subjects for radius in subject.radii)
    if shapes and built_for is not None:
        raise InputError("--shapes and --built-for do not go together: Embree's curves are built for their radius")
    if built_for is not None and (peer == "none" or not largest <= built_for < float("inf")):
        raise InputError(
            f"--built-for {built_for:g}: expected --peer embree, and a radius no less than the largest of the queries, "
            f"{largest:g}"
        )
    with progress_bar() as progress:
        result = run_engine(subjects, preset, progress)
    print_tables(result)
    write_json(json_file, result.to_json())
    write_plot(plot, draw, result)
