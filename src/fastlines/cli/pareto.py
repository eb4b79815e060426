"""``fastlines bench pareto``: what each builder's tree costs to build, and what that buys."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import InputError
from .bench import bench, cases_of, check_peer, progress_bar, write_json
from .options import Builders, Files, Limit, OneRadius, Scenes, Seconds


@bench.command(short_help="All builders: build time, cost of the tree, query time.")
def pareto(
    scene: Scenes = None,
    file: Files = None,
    builder: Builders = None,
    radius: OneRadius = None,
    peer: Annotated[str, typer.Option("--peer", help="Whose build is timed beside ours: embree or none.")] = "embree",
    threads: Annotated[
        int, typer.Option("--threads", "-t", help="Threads of all builds and queries.", min=1, max=1024)
    ] = 1,
    limit: Limit = None,
    n_rays: Annotated[
        int | None,
        typer.Option("--n-rays", help="At most so many rays; 262144 unless given.", min=64, show_default=False),
    ] = None,
    seconds: Seconds = None,
    rounds: Annotated[
        int | None,
        typer.Option(
            "--rounds",
            help="How many turns each builder has; 5 unless given. Of builds the median counts, of queries the best.",
            min=1,
            show_default=False,
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Two small scenes, fewer rays: a minute.")] = False,
    json_file: Annotated[
        str | None, typer.Option("--json", metavar="FILE", help="Write all that was measured.")
    ] = None,
    plot: Annotated[
        str | None, typer.Option("--plot", metavar="FILE.png", help="Draw build time against cost and query time.")
    ] = None,
) -> None:
    r"""Build a tree with each builder, and ask all of them the same: references, nodes, cost, build and query time.

    Builds take turns, and so do queries; all trees must answer alike. Beside them stands Embree's build (package
    embreex, pip install "fastlines\[bench]"), with segments cut as its queries like best. At the end it says what ought
    to hold of the builder best, and whether it does.

    [bold]Examples[/]

    [cyan]fastlines bench pareto --quick[/]

    [cyan]fastlines bench pareto --json pareto.json --plot pareto.png[/]  all scenes and builders: an hour or so

    [cyan]fastlines bench pareto --scene spaghetti --builder best,bvh-d2,kd-d2 --peer none[/]

    [cyan]fastlines bench pareto --scene bun-hair:1000000 --builder best,bvh-ss --threads 2 --limit 120[/]
    """
    from dataclasses import replace

    from ..atomic_write import atomic_write
    from ..bench.pareto import QUICK, Plan, run_pareto
    from ..bench.pareto_plot import draw_pareto
    from ..bench.pareto_table import print_pareto
    from ..bench.plot import check
    from .files import check_output, show_progress

    check_output(json_file, ".json")
    check_output(plot, ".png")
    if plot is not None:
        check()
    given = {
        "builders": check_builders(builder),
        "limit": limit,
        "n_rays": n_rays,
        "seconds": seconds,
        "rounds": rounds,
    }
    plan = replace(
        QUICK if quick else Plan(),
        n_threads=threads,
        peer=check_peer(peer, threads),
        **{name: value for name, value in given.items() if value is not None},  # type: ignore[arg-type]
    )
    cases = list(cases_of(scene or [], file or [], None if radius is None else repr(radius), quick))
    with progress_bar(show_progress()) as progress:
        result = run_pareto(cases, plan, progress)
    print_pareto(result)
    if json_file is not None:
        write_json(json_file, result.to_json())
    if plot is not None:
        with atomic_write(plot) as partial:
            draw_pareto(result, partial)


def check_builders(texts: list[str] | None) -> tuple[str, ...] | None:
    """Take the options --builder apart."""
    from ..bench.builders import BUILDERS
    from ..checks import did_you_mean

    if not texts:
        return None
    names = [name for text in texts for name in text.split(",")]
    for name in names:
        if name not in BUILDERS:
            raise InputError(f"--builder {name!r} is not a builder{did_you_mean(name, BUILDERS)}")
    return tuple(dict.fromkeys(names))
