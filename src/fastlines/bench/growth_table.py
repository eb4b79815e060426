"""The tables of what a ray costs as the scene grows."""

from __future__ import annotations

from rich.table import Table

from ..demo.tables import print_table, wide_console
from .growth import Cell, Growth, Size
from .table import three


def print_growth(growth: Growth) -> None:
    """Print what was measured, a row for each kind of rays and query at each size; then the exponents."""
    console = wide_console()
    plan = growth.plan
    print_table(console, _measured(growth))
    fits = growth.fits()
    if fits:
        print_table(console, _exponents(growth))
    console.print(
        f"Radius {plan.radius:g}, scenes about 1 wide; wall clock, best of {plan.rounds}. MB: layout and segments. "
        + "Hits, first: the share of rays that hit. "
        + ("" if fits else "An exponent needs two sizes. ")
        + f"{growth.seconds:.0f} s in all.",
        highlight=False,
    )


def _measured(growth: Growth) -> Table:
    threads = growth.plan.threads
    table = _table("what a ray costs as the scene grows", "scene")
    heads = ["segments", "references", "layout\nMB", "build\ns", "rays", "query", "rays\nasked", "hits\na ray"]
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
    threads = growth.plan.threads
    table = _table("exponents b of the cost of a ray ~ segments^b", "scene")
    table.add_column("rays", no_wrap=True)
    table.add_column("query", no_wrap=True)
    for head in (*(f"cost\n{n}" for n in _threads(threads)), "hits\na ray"):
        table.add_column(head, justify="right", no_wrap=True)
    for fit in growth.fits():
        table.add_row(
            fit.scene,
            fit.kind,
            fit.query,
            *(f"{cost:.2f}" for cost in fit.cost),
            "–" if fit.hits is None else f"{fit.hits:.2f}",
        )
    return table


def _table(title: str, first: str) -> Table:
    table = Table(title=title, title_justify="left", pad_edge=False)
    table.add_column(first, style="bold", no_wrap=True)
    return table


def _threads(threads: tuple[int, ...]) -> list[str]:
    return [f"{n} thread{'s' if n > 1 else ''}" for n in threads]


def _size_cells(size: Size) -> list[str]:
    return [
        size.scene,
        f"{size.n_segments:,}",
        f"{size.n_refs:,}",
        three(size.bytes / 1e6),
        three(size.build_s),
    ]


def _cells(cell: Cell) -> list[str]:
    row = [cell.kind, cell.query, f"{cell.n_rays:,}", _short(cell.hits), *map(_short, cell.mrays)]
    return [*row, f"{cell.speedup:.2f}"] if len(cell.seconds) > 1 else row


def _short(value: float) -> str:
    """About three digits; two of what is small."""
    return three(value) if value >= 0.0995 or value == 0 else f"{value:.2g}"
