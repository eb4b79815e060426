"""``fastlines-bench calibrate``: the time of a step on this machine, and which figures of trees predict query times."""

from __future__ import annotations

from ..builders import CalibratePreset, print_calibration, run_calibrate
from ..builders.names import BUILDERS
from ..harness.subjects import subjects_of
from .app import app
from .options import (
    Builders,
    Files,
    JsonFile,
    Limit,
    NRays,
    OneRadius,
    Quick,
    Rounds,
    Scenes,
    Seconds,
    check_files,
    check_names,
    progress_bar,
    write_json,
)


@app.command(short_help="The time of a step on this machine, and which cost predicts query times.")
def calibrate(
    scene: Scenes = None,
    file: Files = None,
    builder: Builders = None,
    radius: OneRadius = None,
    limit: Limit = None,
    n_rays: NRays = None,
    seconds: Seconds = None,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Fit c_trav and c_prim to this machine, and correlate the costs of trees with their query times.

    Everything runs on one thread. Queries on the trees of all builders are alternated. Their steps are counted
    separately, in the binary tree and in the layout. Then each figure that is known before a query is compared with the
    measured times by rank: cost, cost with boxes enlarged by the radius, end-point overlap, the layout's own cost.

    [bold]Examples[/]

    [cyan]fastlines-bench calibrate --quick[/]

    [cyan]fastlines-bench calibrate --json calibrate.json[/]  all scenes and builders: about half an hour

    [cyan]fastlines-bench calibrate --scene spaghetti --scene bun-hair --builder best,bvh-cl,bvh-ss,median[/]
    """
    check_files(json_file)
    preset = CalibratePreset.of(
        quick,
        builders=check_names("--builder", "builder", builder, BUILDERS),
        limit=limit,
        n_rays=n_rays,
        seconds=seconds,
        rounds=rounds,
    )
    subjects = list(subjects_of(scene or [], file or [], radius, quick))
    with progress_bar() as progress:
        result = run_calibrate(subjects, preset, progress)
    print_calibration(result)
    write_json(json_file, result.to_json())
