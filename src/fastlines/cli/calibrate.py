"""``fastlines bench calibrate``: what a step takes here, and which figure of a tree tells how fast it is."""

from __future__ import annotations

from typing import Annotated

import typer

from .bench import bench, cases_of, progress_bar, write_json
from .options import Builders, Files, Limit, OneRadius, Scenes, Seconds
from .pareto import check_builders


@bench.command(short_help="What a step takes here, and which cost predicts query times.")
def calibrate(
    scene: Scenes = None,
    file: Files = None,
    builder: Builders = None,
    radius: OneRadius = None,
    limit: Limit = None,
    n_rays: Annotated[
        int | None,
        typer.Option("--n-rays", help="At most so many rays; 131072 unless given.", min=64, show_default=False),
    ] = None,
    seconds: Seconds = None,
    rounds: Annotated[
        int | None,
        typer.Option("--rounds", help="How many turns each tree has; the best counts.", min=1, show_default=False),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Two small scenes, fewer rays: a minute.")] = False,
    json_file: Annotated[
        str | None, typer.Option("--json", metavar="FILE", help="Write all that was measured.")
    ] = None,
) -> None:
    """Fit c_trav and c_prim to this machine, and compare the order that costs predict with that of query times.

    One thread. The trees of all builders are asked in turn, and their steps are counted apart from that: through the
    tree as it was built, and on the layout. Then each figure that is known beforehand (cost, with boxes grown by the
    radius, end-point overlap, the layout's own cost) is set beside the measured times, by rank.

    [bold]Examples[/]

    [cyan]fastlines bench calibrate --quick[/]

    [cyan]fastlines bench calibrate --json calibrate.json[/]  all scenes and builders: half an hour or so

    [cyan]fastlines bench calibrate --scene spaghetti --scene bun-hair --builder best,bvh-cl,bvh-ss,median[/]
    """
    from dataclasses import replace

    from ..bench.calibrate import QUICK, Plan, run_calibrate
    from ..bench.calibrate_table import print_calibration
    from .files import check_output, show_progress

    check_output(json_file, ".json")
    given = {
        "builders": check_builders(builder),
        "limit": limit,
        "n_rays": n_rays,
        "seconds": seconds,
        "rounds": rounds,
    }
    plan = replace(
        QUICK if quick else Plan(),
        **{name: value for name, value in given.items() if value is not None},  # type: ignore[arg-type]
    )
    cases = list(cases_of(scene or [], file or [], None if radius is None else repr(radius), quick))
    with progress_bar(show_progress()) as progress:
        result = run_calibrate(cases, plan, progress)
    print_calibration(result)
    if json_file is not None:
        write_json(json_file, result.to_json())
