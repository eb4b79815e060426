"""``fastlines-bench refit``: the speed of refits to moving segments, and of queries after them."""

from __future__ import annotations

from typing import Annotated

import typer

from ..harness.internals import method_settings
from ..harness.subjects import subjects_of
from ..refit.run import RefitPreset, run_refit
from ..refit.show import print_refit
from .app import app
from .options import Files, JsonFile, NRays, Quick, Rounds, Scenes, Threads, check_files, progress_bar, write_json


@app.command(short_help="The speed of refits to moving segments, and of queries after them.")
def refit(
    scene: Scenes = None,
    file: Files = None,
    radius: Annotated[str, typer.Option("--radius", "-r", metavar="R", help="The radius of queries.")] = "0.001",
    method: Annotated[str, typer.Option("--method", "-m", metavar="NAME", help="The builder of the tree.")] = "best",
    angle: Annotated[float, typer.Option("--angle", help="The twist of the last frame in degrees.", min=0.001)] = 360.0,
    frames: Annotated[
        int | None, typer.Option("--frames", help="The number of frames; the default is 6.", min=1, show_default=False)
    ] = None,
    n_rays: NRays = None,
    threads: Threads = 1,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Twist each scene, frame by frame; refit its tree and build a new one; time both, and queries on both.

    Refits are timed with and without the layout for queries. The answers of both trees must be the same.

    [bold]Examples[/]

    [cyan]fastlines-bench refit --quick[/]

    [cyan]fastlines-bench refit --scene straight-hair:1000000 --threads 2 --json refit.json[/]
    """
    check_files(json_file)
    method_settings(method)
    subjects = list(subjects_of(scene or [], file or [], radius, quick))
    preset = RefitPreset.of(
        quick, method=method, angle=angle, n_frames=frames, n_rays=n_rays, n_threads=threads, rounds=rounds
    )
    with progress_bar() as progress:
        result = run_refit(subjects, preset, progress)
    print_refit(result)
    write_json(json_file, result.to_json())
