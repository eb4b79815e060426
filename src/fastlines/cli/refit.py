"""``fastlines bench refit``: how fast trees follow moving segments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .bench import bench, cases_of, progress_bar, write_json
from .options import Files, Scenes

if TYPE_CHECKING:
    from ..bench.refit import RefitResult


@bench.command(short_help="How fast trees follow moving segments, and what their queries lose.")
def refit(
    scene: Scenes = None,
    file: Files = None,
    radius: Annotated[str, typer.Option("--radius", "-r", metavar="R", help="The radius of queries.")] = "0.001",
    method: Annotated[str, typer.Option("--method", "-m", metavar="NAME", help="Which tree.")] = "best",
    angle: Annotated[
        float, typer.Option("--angle", help="Degrees by which the last frame twists a scene.", min=0.001)
    ] = 360.0,
    frames: Annotated[int, typer.Option("--frames", help="Frames up to it.", min=1)] = 6,
    n_rays: Annotated[int, typer.Option("--n-rays", help="Random rays for each query.", min=64)] = 1 << 17,
    threads: Annotated[
        int, typer.Option("--threads", "-t", help="Threads of refits and queries.", min=1, max=1024)
    ] = 1,
    rounds: Annotated[int, typer.Option("--rounds", help="The best of so many times counts.", min=1)] = 5,
    quick: Annotated[bool, typer.Option("--quick", help="Two small scenes, two frames: some seconds.")] = False,
    json_file: Annotated[str | None, typer.Option("--json", metavar="FILE", help="Write all figures.")] = None,
) -> None:
    """Twist each scene, frame by frame; refit its tree, and build one anew; time both, and queries on both.

    Refits are made with and without the layout that queries run on. The answers of both trees must be the same.

    [bold]Examples[/]

    [cyan]fastlines bench refit --quick[/]

    [cyan]fastlines bench refit --scene straight-hair:1000000 --threads 2 --json refit.json[/]
    """
    from ..bench.refit import RefitPlan, run_refit
    from ..methods import method_settings
    from .files import check_output, show_progress

    check_output(json_file, ".json")
    method_settings(method)
    cases = list(cases_of(scene or [], file or [], radius, quick))
    if quick:
        frames, n_rays, rounds = min(frames, 2), min(n_rays, 1 << 14), min(rounds, 2)
    with progress_bar(show_progress()) as progress:
        result = run_refit(cases, RefitPlan(method, angle, frames, n_rays, threads, rounds), progress)
    _print(result)
    if json_file is not None:
        write_json(json_file, result.to_json())


def _print(result: RefitResult) -> None:
    from rich.table import Table

    from ..bench.table import three
    from ..demo.tables import print_table, wide_console

    console = wide_console()
    refits = Table(title="refits of a growing twist", title_justify="left", pad_edge=False)
    queries = Table(title="queries: nanoseconds a random ray", title_justify="left", pad_edge=False)
    for table, heads in (
        (refits, "refs/seg|refit ms|Mseg/s|Mref/s|layout ms|both Mseg/s|build ms"),
        (queries, "growth|to rebuilt|first|rebuilt|ratio|all|rebuilt|ratio|pays after Mrays"),
    ):
        table.add_column("scene", style="bold", no_wrap=True)
        for head in ("degrees", *heads.split("|")):
            table.add_column(head, justify="right", no_wrap=True)
    for cell in result.cells:
        both_s = cell.refit_s + cell.layout_s
        refits.add_row(
            cell.scene,
            f"{cell.angle:.0f}",
            three(cell.n_refs / cell.n_prims),
            three(cell.refit_s * 1e3),
            three(cell.n_prims / cell.refit_s / 1e6),
            three(cell.n_refs / cell.refit_s / 1e6),
            three(cell.layout_s * 1e3),
            three(cell.n_prims / both_s / 1e6),
            three(cell.build_s * 1e3),
        )
        queries.add_row(
            cell.scene,
            f"{cell.angle:.0f}",
            f"{cell.growth:.2f}",
            f"{cell.to_rebuilt:.2f}",
            f"{cell.first_ns:.0f}",
            f"{cell.first_rebuilt_ns:.0f}",
            f"{cell.first_ns / cell.first_rebuilt_ns:.2f}",
            f"{cell.all_ns:.0f}",
            f"{cell.all_rebuilt_ns:.0f}",
            f"{cell.all_ns / cell.all_rebuilt_ns:.2f}",
            "never" if cell.pays_after == float("inf") else three(cell.pays_after / 1e6),
        )
    print_table(console, refits)
    print_table(console, queries)
    console.print(
        f"{result.plan.method}, threads: {result.plan.n_threads}, {result.machine['simd']}. seg: segments; ref: "
        "references; layout: what it adds to a refit; build: with its layout, on one thread. growth: cost by cost as "
        "built; to rebuilt: by that of a tree built anew. pays after: so many rays, half of them for each query, lose "
        "by the refitted tree what a build takes.",
        highlight=False,
    )
