"""The benchmark's tables."""

from __future__ import annotations

from rich.table import Table

from ..demo.tables import print_table, wide_console
from .rays import KIND_NOTES
from .result import Cell, Result, Side, geometric_mean


def print_tables(result: Result) -> None:
    """Print a table for each kind of rays and query, then what building cost."""
    console = wide_console()
    peer = result.plan["peer"]
    for (kind, query), cells in result.groups().items():
        table = Table(title=f"{kind} rays ({KIND_NOTES[kind]}): {query}", title_justify="left", pad_edge=False)
        table.add_column("scene", style="bold", no_wrap=True)
        heads = ["radius", "rays", "ours", *(["Embree", "ratio", "to user", "differ", "max Δt"] if peer else [])]
        for head in heads:
            table.add_column(head, justify="right", no_wrap=True)
        if peer:
            table.add_column("Embree's configuration")
        for cell in cells:
            table.add_row(*_cells(cell))
        means = [geometric_mean(ratios) for ratios in ([c.ratio for c in cells], [c.exact_ratio for c in cells])]
        if any(means):
            table.add_section()
            table.add_row("geometric mean", "", "", "", "", *("–" if mean is None else f"{mean:.2f}" for mean in means))
        print_table(console, table)
    print_table(console, _building(result))
    threads = result.plan["n_threads"]
    said = f"Millions of rays a second, {threads} thread{'s' if threads > 1 else ''}, best of {result.plan['rounds']}. "
    if result.plan["one_by_one"]:
        said += "Each ray is searched alone. "
    if result.plan["built_for"] is not None:
        said += f"Embree's trees are built for the radius {result.plan['built_for']:g} and asked with those shown. "
    if peer:
        said += (
            f"Embree {result.machine['embree']}: its fastest configuration in each cell. differ: share of rays with "
            "another answer than ours; to user: our ratio to its user geometry, which alone shares our hits. "
        )
    console.print(f"{said}{result.seconds:.0f} s in all.", highlight=False)


def _cells(cell: Cell) -> list[str]:
    row = [cell.scene, f"{cell.radius:g}", f"{cell.n_rays:,}", three(cell.mrays)]
    best = cell.best
    if best is None:
        return row
    difference = best.difference
    share = "0" if difference.share == 0 else f"{difference.share:.1e}"
    dt = "–" if cell.query == "any" else f"{difference.max_dt:.0e}"
    return [*row, three(best.mrays), f"{cell.ratio:.2f}", f"{cell.exact_ratio:.2f}", share, dt, str(best.config)]


def _building(result: Result) -> Table:
    """Seconds and megabytes: our tree serves all radii; Embree's, in the build that wins most cells, one."""
    table = Table(title="building: seconds and megabytes", title_justify="left", pad_edge=False)
    table.add_column("scene", style="bold", no_wrap=True)
    peer = result.plan["peer"]
    heads = ["segments", "tree s", "layout s", "ours MB", *(["radius", "Embree s", "Embree MB"] if peer else [])]
    for head in heads:
        table.add_column(head, justify="right", no_wrap=True)
    if peer:
        table.add_column("Embree's build")
    for built in result.built:
        row = [
            built.scene,
            f"{built.n_segments:,}",
            three(built.build_s),
            three(built.layout_s),
            three(built.bytes / 1e6),
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
    return [three(side.build_s), three(side.bytes / 1e6), str(side.config.build)]


def three(value: float) -> str:
    """About three digits."""
    digits = 0 if value >= 99.95 else 1 if value >= 9.995 else 2 if value >= 0.0995 else 3
    return f"{value:,.{digits}f}"
