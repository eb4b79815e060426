"""The demonstration's table, as Markdown and in the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..limits import limit_notes
from ..scenes import RADII
from .measure import Timing
from .result import QUERIES, Result, Row, SceneResult

#: Marks a figure that was measured on a part of the rays.
PART_MARK = "*"
if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Column, Table

#: The columns of a terminal that shows all queries.
WIDE = 132


def markdown(result: Result) -> str:
    """Write all tables as Markdown."""
    machine = result.machine
    agree = "yes, bit for bit" if result.answers_agree else "not compared"
    lines = [
        "# Five trees over five scenes",
        "",
        f"{machine['processor']}, {machine['threads']} threads, {machine['system']}; fastlines {machine['fastlines']}, "
        f"Python {machine['python']}; {machine['date']}; the {result.plan.name} run took {result.seconds:.0f} s.",
        "",
        f"Answers agree: {agree} ({result.n_compared:,} compared). Trees valid: all {len(result.rows)}. "
        f"f = g: yes, to {result.largest_difference:.0e}.",
        "",
        f"Radii: {', '.join(f'{name} = {value:g}' for name, value in RADII.items())}. Times are milliseconds for "
        f"{result.plan.rays}² = {result.plan.rays**2:,} camera rays (in brackets: millions of rays a second).",
    ]
    for scene in result.scenes:
        lines += ["", f"## {scene.title}", "", f"{scene.n_segments:,} segments{_other_size(scene)}", ""]
        heads = ["tree", "primitives", "references", "nodes", "depth", "cost", "thesis's cost", "build, s"]
        heads += [f"{kind} {radius}" for kind, radius in QUERIES]
        lines += [" | ".join(["", *heads, ""]).strip(), "|---" * len(heads) + "|"]
        for row in scene.rows:
            cells = [row.method, *tree_cells(row), *(f"{ms(t)} ({mrays(t)})" for t in row.timings.values())]
            lines.append(f"| {' | '.join(cells)} |")
        for note in (part_note(scene), limits_note(scene)):
            lines += ["", note] if note else []
    return "\n".join(lines) + "\n"


def wide_console() -> Console:
    """Return the terminal, or as wide a page as shows everything."""
    from rich.console import Console

    console = Console()
    return console if console.is_terminal else Console(width=WIDE)


def print_table(console: Console, table: Table) -> None:
    """Print a table; where it is too wide, in parts, each of which has the columns of names again. None is cut off."""
    from rich.measure import Measurement
    from rich.table import Table

    def least(column: Column) -> int:
        measured = [Measurement.get(console, console.options, cell) for cell in (column.header, *column.cells)]
        return max(cell.maximum if column.no_wrap else cell.minimum for cell in measured) + 3  # a line and two spaces

    # Divide the columns.
    widths = [least(column) for column in table.columns]
    names = [i for i, column in enumerate(table.columns) if column.no_wrap and column.justify == "left"]
    parts: list[list[int]] = [[]]
    for i in range(len(widths)):
        if i in names:
            continue
        if parts[-1] and sum(widths[j] for j in (*names, *parts[-1], i)) + 1 > console.width:
            parts.append([])
        parts[-1].append(i)

    # Make a table of each part.
    rows = list(zip(*(column.cells for column in table.columns), strict=True))
    for part in parts:
        columns = sorted([*names, *part])
        heads = (table.columns[i].copy() for i in columns)
        shown = Table(*heads, title=table.title, title_justify=table.title_justify, pad_edge=table.pad_edge)
        for row, cells in zip(table.rows, rows, strict=True):
            shown.add_row(*(cells[i] for i in columns), end_section=row.end_section)
        console.print(shown)


def print_tables(result: Result) -> None:
    """Print all tables: costs, and millions of rays a second, of the radius M only if the terminal is narrow."""
    from rich.table import Table

    console = wide_console()
    queries = [query for query in QUERIES if console.width >= WIDE or query[1] == "M"]
    for scene in result.scenes:
        table = Table(title=f"{scene.title}: {scene.n_segments:,} segments", title_justify="left", pad_edge=False)
        table.add_column("tree", style="bold", no_wrap=True)
        for head in ("refs", "nodes", "depth", "cost", "thesis", "build s", *(f"{k} {r}" for k, r in queries)):
            table.add_column(head, justify="right", no_wrap=True)
        for row in scene.rows:
            table.add_row(row.method, *tree_cells(row)[1:], *(mrays(row.timings[query]) for query in queries))
        print_table(console, table)
    radii = ", ".join(f"{name} {value:g}" for name, value in RADII.items())
    console.print(
        f"First and all hits: millions of rays a second ({PART_MARK} = a part of the rays was asked), radii {radii}. "
        f"Answers agree bit for bit ({result.n_compared:,} compared), all {len(result.rows)} trees are valid, "
        f"f = g to {result.largest_difference:.0e}; {result.seconds:.0f} s in all.",
        highlight=False,
    )


def tree_cells(row: Row) -> list[str]:
    """Primitives, references, nodes, depth, cost, the thesis's cost and seconds to build."""
    stats = row.stats
    thesis = f"{row.thesis.cost:,.2f}" if row.thesis else "–"
    counts = [f"{stats[key]:,}" for key in ("n_prims", "n_refs", "n_nodes", "depth")]
    return [*counts, f"{stats['cost']:,.2f}", thesis, f"{row.build_s:.2f}"]


def ms(timing: Timing) -> str:
    """Milliseconds for all rays, marked if only a part was asked."""
    return f"{_three_digits(timing.ms)}{mark(timing)}"


def mrays(timing: Timing) -> str:
    """Millions of rays a second, marked if only a part was asked."""
    return f"{_three_digits(timing.mrays)}{mark(timing)}"


def mark(timing: Timing) -> str:
    """Mark a figure that was measured on a part of the rays."""
    return PART_MARK if timing.n_measured < timing.n_rays else ""


def part_note(scene: SceneResult) -> str:
    """Say which figures were measured on a part of the rays; "" if none was."""
    parts: dict[str, set[int]] = {}
    for row in scene.rows:
        for timing in row.timings.values():
            if mark(timing):
                parts.setdefault(row.method, set()).add(round(timing.n_rays / timing.n_measured))
    if not parts:
        return ""
    said = "; ".join(f"{method}: 1/{', 1/'.join(map(str, sorted(shares)))}" for method, shares in parts.items())
    return f"{PART_MARK} Measured on an evenly spread part of the rays and scaled up: {said}."


def limits_note(scene: SceneResult) -> str:
    """Say which trees felt a limit; "" if none did."""
    said = [f"{row.method}: {note}" for row in scene.rows for note in limit_notes(row.stats["limits_hit"])]
    return f"Limits were felt: {'; '.join(said)}." if said else ""


def _other_size(scene: SceneResult) -> str:
    if scene.n_segments == scene.n_thesis:
        return ", as in the thesis"
    return f"; the thesis's costs are for {scene.n_thesis:,}"


def _three_digits(value: float) -> str:
    digits = 0 if value >= 99.95 else 1 if value >= 9.995 else 2 if value >= 0.0995 else 3
    return f"{value:,.{digits}f}"
