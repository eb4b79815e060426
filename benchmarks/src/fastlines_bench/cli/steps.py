"""``fastlines-bench steps``: the cost of a ray by steps."""

from __future__ import annotations

from typing import Annotated

import typer

from ..engine.steps import StepsPreset, print_steps, run_steps
from ..harness.subjects import subjects_of
from .app import app
from .options import (
    Files,
    JsonFile,
    NRays,
    Quick,
    Radii,
    Rounds,
    Scenes,
    check_files,
    check_kinds,
    progress_bar,
    write_json,
)


@app.command(short_help="The cost of a ray of ours by steps.")
def steps(
    scene: Scenes = None,
    file: Files = None,
    radius: Radii = "0.001",
    rays: Annotated[
        str, typer.Option("--rays", metavar="KIND,…", help="The kinds of rays: camera, random, ao.")
    ] = "camera,random,ao",
    n_rays: NRays = None,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Count the steps of our kernels, time each step alone, and compare their sum with the time of a ray.

    Everything runs on one thread. A separate module counts the steps, so that nothing is counted in timed queries.

    [bold]Examples[/]

    [cyan]fastlines-bench steps[/]

    [cyan]fastlines-bench steps --scene spaghetti --rays camera --json steps.json[/]
    """
    check_files(json_file)
    preset = StepsPreset.of(quick, kinds=check_kinds(rays, ("camera", "random", "ao")), n_rays=n_rays, rounds=rounds)
    subjects = list(subjects_of(scene or [], file or [], radius, quick))
    with progress_bar() as progress:
        result = run_steps(subjects, preset, progress)
    print_steps(result)
    write_json(json_file, result.to_json())
