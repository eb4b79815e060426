"""``fastlines bench growth``: what a ray costs as the scene grows."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import InputError
from .bench import bench, progress_bar, write_json


@bench.command(short_help="What a ray costs as the scene grows, and whether threads help.")
def growth(
    scene: Annotated[
        list[str] | None,
        typer.Option(
            "--scene",
            "-s",
            metavar="NAME,…",
            help="Scenes with commas between them; spaghetti,bun-hair unless given.",
            show_default=False,
        ),
    ] = None,
    sizes: Annotated[
        str | None,
        typer.Option(
            "--sizes",
            metavar="N,N,…",
            help="How many segments; 10000,30000,100000 unless given. Two or more for an exponent. "
            "References of spaghetti grow as n^1.5, so a million of it needs tens of gigabytes.",
            show_default=False,
        ),
    ] = None,
    radius: Annotated[
        float | None,
        typer.Option(
            "--radius",
            "-r",
            metavar="R",
            help="One radius for all sizes; 0.001 unless given. A scene stays about 1 wide as it grows, so this is "
            "also the share of the scene, and lines of the same thickness stand denser.",
            show_default=False,
        ),
    ] = None,
    threads: Annotated[
        str, typer.Option("--threads", "-t", metavar="N,…", help="Threads of the queries, in turn.")
    ] = "1,2",
    n_rays: Annotated[
        int | None,
        typer.Option(
            "--n-rays", help="At most so many rays at a time; 262144 unless given.", min=64, show_default=False
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            help="About how long one turn of the slowest takes; 16384 rays are asked in any case.",
            min=0.0,
            show_default=False,
        ),
    ] = None,
    rounds: Annotated[
        int | None,
        typer.Option(
            "--rounds", help="How many turns each thread count has; the best counts.", min=1, show_default=False
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="1000 and 10000 segments, fewer rays: some seconds.")] = False,
    json_file: Annotated[
        str | None, typer.Option("--json", metavar="FILE", help="Write all that was measured.")
    ] = None,
    plot: Annotated[
        str | None, typer.Option("--plot", metavar="FILE.png", help="Draw the cost of a ray over the size.")
    ] = None,
) -> None:
    """Time first and all hits of camera and random rays on scenes of growing size, with each number of threads in turn.

    For each scene, kind of rays and query, the cost of a ray is fitted as a power of the number of segments.

    [bold]Examples[/]

    [cyan]fastlines bench growth --quick[/]

    [cyan]fastlines bench growth --scene bun-hair --json growth.json --plot growth.png[/]  up to 100,000 segments

    [cyan]fastlines bench growth --scene straight-hair --sizes 1000,10000,100000 --threads 1,2,4[/]
    """
    from dataclasses import replace

    from ..atomic_write import atomic_write
    from ..bench.growth import QUICK, Plan, run_growth
    from ..bench.growth_plot import draw_growth
    from ..bench.growth_table import print_growth
    from ..bench.plot import check
    from ..scenes import MAX_SEGMENTS
    from ..threads import MAX_THREADS
    from .files import check_output, show_progress

    check_output(json_file, ".json")
    check_output(plot, ".png")
    if plot is not None:
        check()
    if radius is not None and not 0 < radius < float("inf"):
        raise InputError(f"--radius {radius:g} is not a finite number above 0; expected one, such as 0.001")
    given = {
        "scenes": _scenes(scene) if scene else None,
        "sizes": None if sizes is None else tuple(sorted(_counts("--sizes", sizes, MAX_SEGMENTS, "10000,100000"))),
        "radius": radius,
        "n_rays": n_rays,
        "seconds": seconds,
        "rounds": rounds,
    }
    plan = replace(
        QUICK if quick else Plan(),
        threads=_counts("--threads", threads, MAX_THREADS, "1,2"),
        **{name: value for name, value in given.items() if value is not None},  # type: ignore[arg-type]
    )
    with progress_bar(show_progress()) as progress:
        result = run_growth(plan, progress)
    print_growth(result)
    if json_file is not None:
        write_json(json_file, result.to_json())
    if plot is not None:
        with atomic_write(plot) as partial:
            draw_growth(result, partial)


def _scenes(texts: list[str]) -> tuple[str, ...]:
    from ..checks import did_you_mean
    from ..scenes import NAMES

    names = [name for text in texts for name in text.split(",")]
    for name in names:
        if name not in NAMES:
            raise InputError(f"--scene {name!r} is not a scene{did_you_mean(name, NAMES)}")
    return tuple(dict.fromkeys(names))


def _counts(option: str, text: str, most: int, such: str) -> tuple[int, ...]:
    """Read whole numbers with commas between them, each once."""
    found = []
    for part in text.split(","):
        if not (part.isascii() and part.isdigit() and len(part) < 20 and 1 <= int(part) <= most):
            shown = part if len(part) < 100 else part[:100] + "…"
            raise InputError(
                f"{option} {shown!r} is not a whole number from 1 to {most}; expected one or more, such as {such}"
            )
        found.append(int(part))
    return tuple(dict.fromkeys(found))
