"""``fastlines bench steps``: what a ray costs, step by step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .bench import bench, cases_of, check_kinds, progress_bar, write_json
from .options import Files, Scenes

if TYPE_CHECKING:
    from ..bench.steps import StepResult


@bench.command(short_help="What a ray of ours costs, step by step.")
def steps(
    scene: Scenes = None,
    file: Files = None,
    radius: Annotated[str, typer.Option("--radius", "-r", metavar="R,R,…", help="Radii.")] = "0.001",
    rays: Annotated[
        str, typer.Option("--rays", metavar="KIND,…", help="Kinds of rays: camera, random, ao.")
    ] = "camera,random,ao",
    n_rays: Annotated[int, typer.Option("--n-rays", help="So many rays are timed.", min=64)] = 1 << 18,
    rounds: Annotated[int, typer.Option("--rounds", help="The best of so many times counts.", min=1)] = 5,
    json_file: Annotated[str | None, typer.Option("--json", metavar="FILE", help="Write all figures.")] = None,
) -> None:
    """Count the steps of our kernels, pace each step alone, and compare their sum with what a ray takes.

    One thread. Steps are counted by a module of its own, so that nothing is counted while the clock runs.

    [bold]Examples[/]

    [cyan]fastlines bench steps[/]

    [cyan]fastlines bench steps --scene spaghetti --rays camera --json steps.json[/]
    """
    from ..bench.steps import run_steps
    from .files import check_output, show_progress

    check_output(json_file, ".json")
    kinds = check_kinds(rays, ("camera", "random", "ao"))
    cases = list(cases_of(scene or [], file or [], radius, False))
    with progress_bar(show_progress()) as progress:
        result = run_steps(cases, kinds, n_rays, rounds, progress)
    _print(result)
    if json_file is not None:
        write_json(json_file, result.to_json())


def _print(result: StepResult) -> None:
    from rich.table import Table

    from ..bench.steps import AGAIN, STEPS
    from ..bench.table import three
    from ..demo.tables import print_table, wide_console

    console = wide_console()
    paces = Table(title="a step alone: nanoseconds (cycles)", title_justify="left", pad_edge=False)
    paces.add_column("step", style="bold", no_wrap=True)
    for name in result.pace:
        paces.add_column(name, justify="right", no_wrap=True)
    for step, meaning in STEPS.items():
        cells = [f"{pace[step]:.1f} ({pace[step] / pace['cycle']:.0f})" for pace in result.pace.values()]
        paces.add_row(meaning, *cells)
    print_table(console, paces)

    table = Table(title="steps a ray, and nanoseconds", title_justify="left", pad_edge=False)
    table.add_column("scene", style="bold", no_wrap=True)
    counted = ("bundles", "nodes", "leaves", "pieces", "lines", "packs", "tests")
    for head in ("radius", "rays", "query", *counted, "sum", "a ray", "share", "again"):
        table.add_column(head, justify="left" if head in ("rays", "query") else "right", no_wrap=True)
    for cell in result.cells:
        shares = [three(cell.per_ray[name]) if cell.per_ray[name] else "–" for name in counted]
        table.add_row(
            cell.scene,
            f"{cell.radius:g}",
            cell.kind,
            cell.query,
            *shares,
            f"{cell.bound_ns:.0f}",
            f"{cell.ns:.0f}",
            f"{cell.bound_ns / cell.ns:.2f}",
            "–" if cell.again_ns is None else f"{cell.again_ns:.0f}",
        )
    print_table(console, table)
    console.print(
        f"One thread, {result.machine['simd']}. sum: what the steps of a ray would take at the pace that each has "
        "alone, with nothing to wait for; stacks, packing and sorting are not in it. a ray: all there is. share: the "
        f"first of the second. again: a ray where each is asked {AGAIN} times in a row, so that all is near and hardly "
        "a guess is wrong.",
        highlight=False,
    )
