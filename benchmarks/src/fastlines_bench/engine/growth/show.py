"""The tables of the cost of a ray as the scene grows, and a plot."""

from __future__ import annotations

import os

from rich.table import Table

from ...harness.plot import label_log, new_figure, save, style
from ...harness.tables import format_3_digits, new_table, print_table, wide_console
from .run import Growth, GrowthCell, Size

#: The colours of the scenes.
COLOURS = ("#c2410c", "#0369a1", "#15803d", "#7e22ce", "#a16207")

#: The line styles of kinds of rays, and the markers of queries.
LINES = {"camera": "-", "random": "--"}
MARKS = {"first": "o", "all": "s"}


def print_growth(growth: Growth) -> None:
    """Print a row for each kind of rays and query at each size, then the exponents."""
    console = wide_console()
    preset = growth.preset
    print_table(console, _measured(growth))
    fits = growth.exponents()
    if fits:
        print_table(console, _exponents(growth))
    console.print(
        f"Radius {preset.radius:g}, scenes about 1 wide; wall clock, best of {preset.rounds}. MB: layout and segments. "
        + "Hits, first: the share of rays that hit. "
        + ("" if fits else "An exponent needs two sizes. ")
        + f"{growth.seconds:.0f} s in all.",
        highlight=False,
    )


def _measured(growth: Growth) -> Table:
    threads = growth.preset.threads
    table = new_table("the cost of a ray as the scene grows", ["scene"], [])
    heads = ["segments", "references", "layout\nMB", "build\ns", "rays", "query", "rays\ntraced", "hits\na ray"]
    heads += [f"Mrays/s\n{n}" for n in _threads(threads)]
    heads += ["speed-up"] if len(threads) > 1 else []
    for head in heads:
        table.add_column(head, justify="left" if head in ("rays", "query") else "right", no_wrap=True)
    for size in growth.sizes:
        cells = [cell for cell in growth.cells if (cell.scene, cell.n_segments) == (size.scene, size.n_segments)]
        for i, cell in enumerate(cells):
            table.add_row(*(_size_cells(size) if i == 0 else [""] * 5), *_cells(cell))
        table.add_section()
    return table


def _exponents(growth: Growth) -> Table:
    threads = growth.preset.threads
    heads = [*(f"cost\n{n}" for n in _threads(threads)), "hits\na ray"]
    table = new_table("exponents b of the cost of a ray ~ segments^b", ["scene", "rays", "query"], heads)
    for fit in growth.exponents():
        table.add_row(
            fit.scene,
            fit.kind,
            fit.query,
            *(f"{cost:.2f}" for cost in fit.cost),
            "–" if fit.hits is None else f"{fit.hits:.2f}",
        )
    return table


def _threads(threads: tuple[int, ...]) -> list[str]:
    return [f"{n} thread{'s' if n > 1 else ''}" for n in threads]


def _size_cells(size: Size) -> list[str]:
    return [
        size.scene,
        f"{size.n_segments:,}",
        f"{size.n_refs:,}",
        format_3_digits(size.bytes / 1e6),
        format_3_digits(size.build_s),
    ]


def _cells(cell: GrowthCell) -> list[str]:
    row = [cell.kind, cell.query, f"{cell.n_rays:,}", _short(cell.hits), *map(_short, cell.mrays)]
    return [*row, f"{cell.speedup:.2f}"] if len(cell.seconds) > 1 else row


def _short(value: float) -> str:
    """Format a value with about three digits, or two if it is small."""
    return format_3_digits(value) if value >= 0.0995 or value == 0 else f"{value:.2g}"


def draw_growth(growth: Growth, path: str | os.PathLike[str]) -> None:
    """Plot the cost of a ray with the first thread count, a line for each scene, kind of rays and query, as a PNG."""
    preset = growth.preset
    exponents = {(fit.scene, fit.kind, fit.query): fit.cost[0] for fit in growth.exponents()}
    figure = new_figure(9.0, 5.0)
    panel = figure.subplots()
    for names, cells in growth.groups().items():
        scene, kind, query = names
        panel.plot(
            [cell.n_segments for cell in cells],
            [cell.ns[0] for cell in cells],
            LINES[kind],
            marker=MARKS[query],
            color=COLOURS[preset.scenes.index(scene) % len(COLOURS)],
            label=f"{scene}, {kind}, {query}" + (f": $n^{{{exponents[names]:.2f}}}$" if names in exponents else ""),
        )
    panel.set_xscale("log")
    panel.set_yscale("log")
    for axis in (panel.xaxis, panel.yaxis):
        label_log(axis)
    panel.set_xlabel("segments")
    panel.set_ylabel("ns per ray")
    threads = preset.threads[0]
    panel.set_title(f"radius {preset.radius:g}, {threads} thread{'s' if threads > 1 else ''}", loc="left")
    style(panel, grid=True)
    figure.legend(loc="outside right upper", frameon=False)
    save(figure, path)
