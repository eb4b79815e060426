"""``fastlines-bench engine``: our engine against Embree."""

from __future__ import annotations

from typing import Annotated

import typer

from fastlines import InputError

from ..engine.preset import EnginePreset
from ..engine.run import run_engine
from ..engine.shapes.names import SHAPES
from ..engine.shapes.run import run_shapes
from ..engine.shapes.show import print_shapes
from ..engine.shapes.subjects import shape_subjects
from ..engine.show import draw_engine, print_engine
from ..harness.internals import Effort, method_settings
from ..harness.rays import KINDS
from ..harness.subjects import subjects_of
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
    check_names,
    check_peer,
    progress_bar,
    write_json,
    write_plot,
)

#: The kinds of rays for shapes.
SHAPE_KINDS = ("camera", "tiled", "random")


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
        str | None,
        typer.Option(
            "--rays",
            metavar="KIND,…",
            help="The kinds of rays: camera, tiled, random, ao. The default is camera,random,ao, and camera,random for "
            "shapes, which have no ao.",
            show_default=False,
        ),
    ] = None,
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
        typer.Option(
            "--one-by-one",
            help="Trace each ray by a call of its own: of our C++ library (shapes: kernel single), and of "
            "rtcIntersect1.",
        ),
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
            help="Query shapes with a surface beside Embree's: cones (lines that taper to a fifth of the radius along "
            "each strand), cubic hair, spheres and triangles.",
        ),
    ] = False,
    shape: Annotated[
        str | None,
        typer.Option(
            "--shape",
            metavar="NAME,…",
            help="Only these of the shapes: cones, hair, spheres, triangles. Each has scenes of its own, which --scene "
            "chooses from; --radius is for cones and hair.",
            show_default=False,
        ),
    ] = None,
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

    [cyan]fastlines-bench engine --shapes[/]  cones, cubic hair, spheres and triangles

    [cyan]fastlines-bench engine --shape hair,triangles --scene bun-hair:1000000 --scene knot[/]
    """
    check_files(json_file, plot)
    chosen = check_names("--shape", "shape", [shape] if shape is not None else None, SHAPES) or ()
    if shapes and not chosen:
        chosen = tuple(SHAPES)
    if chosen and built_for is not None:
        raise InputError("--shapes and --built-for do not go together: Embree's shapes are built for their radius")
    if chosen and plot is not None:
        raise InputError("--plot draws no shapes; leave it out, --json has their figures")
    if method is not None:
        method_settings(method)
    preset = EnginePreset.of(
        quick,
        kinds=check_kinds(rays or "camera,random" + ("" if chosen else ",ao"), SHAPE_KINDS if chosen else KINDS),
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
        shapes=chosen,
    )
    if chosen:
        of_shapes = shape_subjects(chosen, scene or [], file or [], radius, quick)
        with progress_bar() as progress:
            found = run_shapes(of_shapes, preset, progress)
        print_shapes(found)
        write_json(json_file, found.to_json())
        if found.missing:
            raise typer.Exit(1)
        return
    subjects = list(subjects_of(scene or [], file or [], radius, quick))
    largest = max(radius for subject in subjects for radius in subject.radii)
    if built_for is not None and (peer == "none" or not largest <= built_for < float("inf")):
        raise InputError(
            f"--built-for {built_for:g}: expected --peer embree, and a radius no less than the largest of the queries, "
            f"{largest:g}"
        )
    with progress_bar() as progress:
        result = run_engine(subjects, preset, progress)
    print_engine(result)
    write_json(json_file, result.to_json())
    write_plot(plot, draw_engine, result)
