"""The tables of the benchmark of points."""

from __future__ import annotations

from rich.table import Table

from ..harness.show_checks import print_checks
from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from .nearest import NearestResult


def print_nearest(result: NearestResult) -> None:
    """Print a row for each scene and peer, a row for each radius of `within`, and what is wanted."""
    console = wide_console()
    if result.nearest:
        print_table(console, _nearest(result))
    if result.within:
        print_table(console, _within(result))
    print_checks(console, result.checks())
    threads = result.preset.n_threads
    console.print(
        f"{threads} thread{'s' if threads > 1 else ''}, {result.machine['simd']}, medians of {result.preset.rounds} "
        "rounds. Ratios are the peer's time divided by ours. items: segments or samples in the tree. off: the extremes "
        "of its distances less ours, as fractions of the size, the diagonal of the box. fcpw gets points in Morton "
        f"order, all others unsorted ones. build s: seconds of the clock. {result.seconds:.0f} s in all.",
        highlight=False,
    )
    for name in result.missing:
        console.print(
            f"NOT MEASURED: {name} is not installed: run  pip install './benchmarks\\[nearest]'", style="bold"
        )


def _nearest(result: NearestResult) -> Table:
    title = f"nearest: millions of points per second, {result.preset.n_points:,} points"
    heads = ["k", "items", "build s", "Mpoints/s", "ratio", "floor", "off"]
    table = new_table(title, ["scene", "peer"], heads)
    for cell in result.nearest:
        name = f"{cell.scene} ({cell.source})"
        k = str(cell.k)
        own = [f"{cell.n_prims:,}", format_3_digits(cell.build_s), format_3_digits(cell.mpoints)]
        table.add_row(name, "ours", k, *own, "", "", "", end_section=not cell.rivals)
        for rival in cell.rivals:
            figures = [f"{rival.n_items:,}", format_3_digits(rival.build_s), format_3_digits(rival.mpoints)]
            floor = "" if rival.floor is None else f"{rival.floor:g}"
            off = f"{rival.least:.0e} … {rival.most:.0e}"
            last = rival is cell.rivals[-1]
            table.add_row("", rival.peer, k, *figures, f"{rival.ratio:.2f}", floor, off, end_section=last)
    return table


def _within(result: NearestResult) -> Table:
    title = "within: nanoseconds per point, and of rays from t = 0 to t = 0 with the same radius"
    heads = ["radius", "per point", "within", "count", "rays", "ratio", "rays differ"]
    table = new_table(title, ["scene", "radius is"], heads)
    for cell in result.within:
        times = [format_3_digits(ns) for ns in (cell.within_ns, cell.count_ns, cell.ray_ns)]
        row = [f"{cell.radius:.3g}", format_3_digits(cell.per_point), *times, f"{cell.ratio:.2f}", f"{cell.differ:.0e}"]
        table.add_row(cell.scene, cell.name, *row)
    return table
