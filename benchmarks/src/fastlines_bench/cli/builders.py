"""``fastlines-bench builders``: the build time, cost and query times of each builder's tree."""

from __future__ import annotations

from typing import Annotated

import typer

from ..builders.names import BUILDERS
from ..builders.run import BuildersPreset, run_builders
from ..builders.show import draw_builders, print_builders
from ..harness.subjects import subjects_of
from .app import app
from .options import (
    Files,
    JsonFile,
    NRays,
    OneRadius,
    Peer,
    PlotFile,
    Quick,
    Rounds,
    Scenes,
    Seconds,
    Threads,
    check_files,
    check_names,
    check_peer,
    progress_bar,
    write_json,
    write_plot,
)


@app.command(short_help="All builders: build time, cost of the tree, query time.")
def builders(
    scene: Scenes = None,
    file: Files = None,
    builder: Annotated[
        list[str] | None,
        typer.Option(
            "--builder",
            "-b",
            metavar="NAME,…",
            help="The builders, separated by commas; the default is all.",
            show_default=False,
        ),
    ] = None,
    radius: OneRadius = None,
    peer: Peer = "embree",
    threads: Threads = 1,
    limit: Annotated[
        float | None,
        typer.Option(
            "--limit",
            metavar="SECONDS",
            help="The limit for all builds of one builder on one scene. A build that exceeds it is reported and left "
            "out.",
            min=0.0,
            show_default=False,
        ),
    ] = None,
    n_rays: NRays = None,
    seconds: Seconds = None,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
    plot: PlotFile = None,
) -> None:
    """Build a tree with each builder; compare references, nodes, cost, build time and query times.

    Builds are alternated, and so are queries; all trees must give the same answers. Embree's build (package embreex) is
    timed too, with segments cut to the length at which its queries are fastest. The last table lists the expected
    properties of the builder best, and whether they hold.

    [bold]Examples[/]

    [cyan]fastlines-bench builders --quick[/]

    [cyan]fastlines-bench builders --json builders.json --plot builders.png[/]  all scenes and builders: about an hour

    [cyan]fastlines-bench builders --scene spaghetti --builder best,bvh-d2,kd-d2 --peer none[/]

    [cyan]fastlines-bench builders --scene bun-hair:1000000 --builder best,bvh-ss --threads 2 --limit 120[/]
    """
    check_files(json_file, plot)
    preset = BuildersPreset.of(
        quick,
        n_threads=threads,
        peer=check_peer(peer, threads),
        builders=check_names("--builder", "builder", builder, BUILDERS),
        limit=limit,
        n_rays=n_rays,
        seconds=seconds,
        rounds=rounds,
    )
    subjects = list(subjects_of(scene or [], file or [], radius, quick))
    with progress_bar() as progress:
        result = run_builders(subjects, preset, progress)
    print_builders(result)
    write_json(json_file, result.to_json())
    write_plot(plot, draw_builders, result)
