"""The benchmark's tables, and a plot of the rates of both sides in each cell."""

from __future__ import annotations

import math
import os

from rich.table import Table

from ..harness.plot import label_log, new_figure, save, style
from ..harness.rays import KIND_NOTES
from ..harness.tables import format_3_digits, geometric_mean, new_table, print_table, wide_console
from .result import EngineCell, Result, Side


def print_engine(result: Result) -> None:
    """Print a table for each kind of rays and query, then the times and sizes of builds."""
    console = wide_console()
    peer = result.preset["peer"]
    for (kind, query), cells in result.groups().items():
        others = list(cells[0].others)
        heads = [
            "radius",
            "rays",
            "ours",
            *others,
            *(["Embree", "ratio", "to user", "differ", "max Δt"] if peer else []),
        ]
        title = f"{kind} rays ({KIND_NOTES[kind]}): {query}"
        table = new_table(title, ["scene"], heads, ["Embree's configuration"] if peer else [])
        for cell in cells:
            table.add_row(*_cells(cell))
        means = [geometric_mean(ratios) for ratios in ([c.ratio for c in cells], [c.exact_ratio for c in cells])]
        if any(means):
            table.add_section()
            table.add_row(
                "geometric mean", *[""] * (4 + len(others)), *("–" if mean is None else f"{mean:.2f}" for mean in means)
            )
        print_table(console, table)
    print_table(console, _building(result))
    threads = result.preset["n_threads"]
    plural = "s" if threads > 1 else ""
    said = f"Millions of rays per second, {threads} thread{plural}, best of {result.preset['rounds']}. "
    if result.preset["one_by_one"]:
        said += "Each ray is traced by a call of its own: ours from C++, and from C. "
    if result.preset["built_for"] is not None:
        said += f"Embree's trees are built for the radius {result.preset['built_for']:g} and queried with those shown. "
    if peer:
        said += (
            f"Embree {result.machine['embree']}: its fastest configuration in each cell. differ: the share of rays "
            "whose answer differs from ours; to user: our ratio to its user geometry, which alone has our hits. "
        )
    console.print(f"{said}{result.seconds:.0f} s in all.", highlight=False)


def _cells(cell: EngineCell) -> list[str]:
    row = [cell.scene, f"{cell.radius:g}", f"{cell.n_rays:,}", format_3_digits(cell.mrays)]
    row += map(format_3_digits, cell.others.values())
    best = cell.best
    if best is None:
        return row
    difference = best.difference
    share = "0" if difference.share == 0 else f"{difference.share:.1e}"
    dt = "–" if cell.query == "any" else f"{difference.max_dt:.0e}"
    return [
        *row,
        format_3_digits(best.mrays),
        f"{cell.ratio:.2f}",
        f"{cell.exact_ratio:.2f}",
        share,
        dt,
        str(best.config),
    ]


def _building(result: Result) -> Table:
    """Return the table of builds: our tree, and for each radius Embree's build that is best in most cells."""
    peer = result.preset["peer"]
    heads = ["segments", "tree s", "layout s", "ours MB", *(["radius", "Embree s", "Embree MB"] if peer else [])]
    table = new_table("building: seconds and megabytes", ["scene"], heads, ["Embree's build"] if peer else [])
    for built in result.built:
        row = [
            built.scene,
            f"{built.n_segments:,}",
            format_3_digits(built.build_s),
            format_3_digits(built.layout_s),
            format_3_digits(built.bytes / 1e6),
        ]
        radii = list(dict.fromkeys(cell.radius for cell in result.cells if cell.scene == built.scene))
        usual = [(radius, result.usual(built.scene, radius)) for radius in radii]
        sides = [(radius, side) for radius, side in usual if side is not None]
        if not sides:
            table.add_row(*row)
        for i, (radius, side) in enumerate(sides):
            table.add_row(*(row if i == 0 else [""] * len(row)), f"{radius:g}", *_build_cells(side))
    return table


def _build_cells(side: Side) -> list[str]:
    return [format_3_digits(side.build_s), format_3_digits(side.bytes / 1e6), str(side.config.build)]


def draw_engine(result: Result, path: str | os.PathLike[str]) -> None:
    """Plot the rates of both sides, a panel for each kind of rays and query, as a PNG."""
    groups = result.groups()
    n_cells = max(len(cells) for cells in groups.values())
    figure = new_figure(max(6.0, 0.6 * n_cells + 2), 2.6 * len(groups))
    panels = figure.subplots(len(groups), 1, squeeze=False)[:, 0]
    for panel, ((kind, query), cells) in zip(panels, groups.items(), strict=True):
        places = list(range(len(cells)))
        ours, theirs = [cell.mrays for cell in cells], [cell.best.mrays if cell.best else math.nan for cell in cells]
        panel.vlines(places, ours, theirs, color="#cbd5e1", zorder=0)
        panel.plot(places, ours, "o", label="fastlines", color="#c2410c")
        if any(cell.best for cell in cells):
            panel.plot(places, theirs, "s", label="Embree, its best", color="#64748b")
        mean = geometric_mean([cell.ratio for cell in cells])
        panel.set_title(
            f"{kind} rays, {query}" + (f": {mean:.2f} × Embree (geometric mean)" if mean else ""), loc="left"
        )
        panel.set_yscale("log")
        label_log(panel.yaxis)
        panel.set_ylabel("Mrays/s")
        panel.set_xlim(-0.5, len(cells) - 0.5)
        panel.set_xticks(places, [f"{cell.scene}\n{cell.radius:g}" for cell in cells], fontsize=6)
        style(panel)
    panels[0].legend(loc="upper right", frameon=False)
    save(figure, path)
