"""``fastlines-bench beams``: photon beams beside their peers and a closed form."""

from __future__ import annotations

from typing import Annotated

import typer

from fastlines import InputError
from fastlines.scenes import MAX_SEGMENTS

from ..beams.draw import DRAWN, draw_beams
from ..beams.run import PARTS, BeamsPreset, run_beams
from ..harness.show_figures import print_figures
from ..peers.mitsuba import VARIANTS
from .app import app
from .options import (
    JsonFile,
    PlotFile,
    Quick,
    Rounds,
    Threads,
    check_counts,
    check_files,
    check_names,
    progress_bar,
    write_json,
    write_plot,
)


@app.command(short_help="Photon beams: gathers beside Embree, a grid and lists; a closed form; Mitsuba's volpath.")
def beams(
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
    sizes: Annotated[
        str | None,
        typer.Option(
            "--beams",
            metavar="N,N,…",
            help="The numbers of beams of gather: 36294,1000000 by default. The radius is 0.005; from 100,000, 0.001.",
            show_default=False,
        ),
    ] = None,
    size: Annotated[
        int | None, typer.Option("--size", help="The width and height in pixels; 512 by default.", min=8)
    ] = None,
    method: Annotated[
        str | None, typer.Option("--method", help="How our tree is built; best by default.", show_default=False)
    ] = None,
    passes: Annotated[
        int | None, typer.Option("--passes", help="The progressive passes; 30 by default.", min=1)
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option("--seconds", help="The seconds of each side of caustic, a quarter of the reference's.", min=0.1),
    ] = None,
    variant: Annotated[str, typer.Option("--variant", help=f"That of Mitsuba: {' or '.join(VARIANTS)}.")] = VARIANTS[0],
    threads: Threads = 1,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
    plot: PlotFile = None,
) -> None:
    """Measure photon beams.

    point-light compares beams with the closed form of a point light in fog: two radii, long and short beams, energy,
    and beams in pieces. gather times one gather of the thesis's mirrored cube by one query, by lists of hits and NumPy,
    by Embree, by a uniform grid and by brute force. passes builds for new beams in each pass. radii gathers the same
    beams with several radii. caustic renders a glass sphere in fog beside Mitsuba's volpath.

    [bold]Examples[/]

    [cyan]fastlines-bench beams --quick --part gather,passes,radii[/]

    [cyan]fastlines-bench beams --part gather --beams 36294 --json gather.json[/]

    [cyan]fastlines-bench beams --part point-light,caustic --plot beams.png[/]
    """
    check_files(json_file, plot)
    parts = check_names("--part", "part", part, PARTS)
    (variant,) = check_names("--variant", "variant", [variant], VARIANTS) or (variant,)
    if plot is not None and parts is not None and not set(parts) & set(DRAWN):
        raise InputError(
            f"--plot draws {', '.join(DRAWN)}, all of which --part leaves out; add one, or leave --plot out"
        )
    preset = BeamsPreset.of(
        quick,
        parts=parts,
        beams=None if sizes is None else check_counts("--beams", sizes, MAX_SEGMENTS, "36294,1000000"),
        size=size,
        method=method,
        methods=None if method is None else (method,),
        passes=passes,
        caustic_s=seconds,
        reference_s=None if seconds is None else 4 * seconds,
        variant=variant,
        n_threads=threads,
        rounds=rounds,
    )
    with progress_bar() as progress:
        result = run_beams(preset, progress, print_figures)
    write_json(json_file, result.to_json())
    write_plot(plot, draw_beams, result)
