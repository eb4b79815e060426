"""``fastlines bench gap``: how far builders are from the optimum."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .bench import bench, progress_bar, write_json

if TYPE_CHECKING:
    from ..bench.gap import Gaps


@bench.command(short_help="How far builders are from the optimum, on tiny inputs.")
def gap(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer and smaller inputs: some seconds.")] = False,
    json_file: Annotated[str | None, typer.Option("--json", metavar="FILE", help="Write all costs.")] = None,
    plot: Annotated[str | None, typer.Option("--plot", metavar="FILE.png", help="Draw all ratios.")] = None,
) -> None:
    """Compare what builders make with the cheapest tree there is, which a dynamic program finds for tiny inputs.

    Searches are offered the very planes of the optimum, so that a gap is the search's own; builders of sets are
    compared with the best classic BVH, and the core's builders with the best tree over a grid of planes.

    [bold]Examples[/]

    [cyan]fastlines bench gap --quick[/]

    [cyan]fastlines bench gap --json gap.json --plot gap.png[/]  some minutes
    """
    from ..atomic_write import atomic_write
    from ..bench.gap import QUICK, Plan, run_gap
    from ..bench.gap_plot import draw_gap
    from ..bench.plot import check
    from .files import check_output, show_progress

    check_output(json_file, ".json")
    check_output(plot, ".png")
    if plot is not None:
        check()
    with progress_bar(show_progress()) as progress:
        gaps = run_gap(QUICK if quick else Plan(), progress)
    _print(gaps)
    if json_file is not None:
        write_json(json_file, gaps.to_json())
    if plot is not None:
        with atomic_write(plot) as partial:
            draw_gap(gaps, partial)


def _print(gaps: Gaps) -> None:
    from rich.table import Table

    from ..bench.gap import INPUTS, mean_and_worst
    from ..demo.tables import print_table, wide_console

    console = wide_console()
    plan = gaps.plan
    sizes = {
        "same planes": f"{plan.same_planes[0]} segments, the same {plan.same_planes[1]} planes an axis for both",
        "sets": f"{plan.sets} segments, none of them cut",
        "builders": f"{plan.builders[0]} segments, the optimum over {plan.builders[1]} planes an axis",
    }
    for (group, boxes, c_trav), builders in gaps.groups().items():
        title = f"{group}: {boxes} boxes, c_trav {c_trav:g}; {sizes[group]}"
        table = Table(title=title, title_justify="left", pad_edge=False)
        table.add_column("", style="bold", no_wrap=True)
        for head in (*INPUTS, "mean", "worst"):
            table.add_column(head, justify="right", no_wrap=True)
        for builder, cells in builders.items():
            means = [mean_and_worst([cell for cell in cells if cell.scene == name])[0] for name in INPUTS]
            table.add_row(builder, *(f"{ratio:.3f}" for ratio in (*means, *mean_and_worst(cells))))
        print_table(console, table)
    console.print(
        f"Costs in parts of the optimum, geometric means of {plan.n_seeds} inputs each. The core's builders place "
        "planes over each node's own box, and some divide sets: they can get below the optimum over a fixed grid.",
        highlight=False,
    )
