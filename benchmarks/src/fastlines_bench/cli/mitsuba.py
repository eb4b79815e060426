"""``fastlines-bench mitsuba``: path-traced hair beside Mitsuba 3."""

from __future__ import annotations

from typing import Annotated

import typer

from ..harness.internals import check_output
from ..harness.subjects import subjects_of
from ..peers.hair_scene import SHAPES
from ..peers.mitsuba import VARIANTS
from ..studies.path_tracing.run import PathsPreset, run_paths
from ..studies.path_tracing.show import draw_paths, print_paths
from .app import app
from .options import (
    Files,
    JsonFile,
    OneRadius,
    PlotFile,
    Quick,
    Rounds,
    Scenes,
    Threads,
    check_files,
    check_names,
    progress_bar,
    write_json,
    write_plot,
)


@app.command(short_help="Path-traced hair beside Mitsuba 3: the picture, its time, and its rays.")
def mitsuba(
    scene: Scenes = None,
    file: Files = None,
    radius: OneRadius = None,
    size: Annotated[
        int | None, typer.Option("--size", help="The width and height in pixels; 256 by default.", min=8)
    ] = None,
    samples: Annotated[
        int | None, typer.Option("--samples", help="The samples of each pixel; 64 by default.", min=2)
    ] = None,
    shape: Annotated[str, typer.Option("--shape", help=f"The shape of hairs: {' or '.join(SHAPES)}.")] = "bspline",
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            help="How far the pieces of our curves are off at most, as a fraction of the radius; by default that of "
            "fl.Curves.",
            min=1e-6,
            max=1.0,
            show_default=False,
        ),
    ] = None,
    melanin: Annotated[
        float, typer.Option("--melanin", help="The colour of the hair: 0 white, 0.3 blond, 1 black.", min=0.0, max=1.0)
    ] = 0.3,
    bounces: Annotated[
        int | None, typer.Option("--bounces", help="The greatest number of bounces; 64 by default.", min=1)
    ] = None,
    variant: Annotated[str, typer.Option("--variant", help=f"That of Mitsuba: {' or '.join(VARIANTS)}.")] = VARIANTS[0],
    threads: Threads = 2,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
    plot: PlotFile = None,
) -> None:
    """Render hair by fastlines and by Mitsuba 3 with the same camera, lights, scattering and numbers of samples.

    Mitsuba has curves of the same radius, its BSDF ``hair`` and its integrator ``path``. Both sides have a
    distant light, an even sky and a box filter. The rays of our picture are also timed alone, on both sides.

    [bold]Examples[/]

    [cyan]fastlines-bench mitsuba --quick --scene bun-hair:20000[/]

    [cyan]fastlines-bench mitsuba --file hair.tfx --json mitsuba.json --plot mitsuba.png[/]
    """
    check_files(json_file)
    check_output(plot, ".png")
    (variant,) = check_names("--variant", "variant", [variant], VARIANTS) or (variant,)
    (shape,) = check_names("--shape", "shape", [shape], SHAPES) or (shape,)
    preset = PathsPreset.of(
        quick,
        size=size,
        samples=samples,
        shape=shape,
        tolerance=tolerance,
        melanin=melanin,
        max_bounces=bounces,
        variant=variant,
        n_threads=threads,
        rounds=rounds,
    )
    named = scene or ([] if file else ["bun-hair:20000" if quick else "bun-hair"])
    results = []
    for subject in subjects_of(named, file or [], radius, quick):
        with progress_bar() as progress:
            results.append(run_paths(subject, preset, progress))
        print_paths(results[-1])
    write_json(json_file, [result.to_json() for result in results])
    write_plot(plot, draw_paths, results)
