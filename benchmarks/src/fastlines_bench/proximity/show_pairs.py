"""The table of the benchmark of pairs."""

from __future__ import annotations

from ..harness.show_checks import print_checks
from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from .pairs import PairsResult


def print_pairs(result: PairsResult) -> None:
    """Print a row for each scene, size and side, the exponents, and what is wanted."""
    console = wide_console()
    heads = ["segments", "radius", "pairs", "build s", "ms", "ns/segment", "ratio", "differ"]
    table = new_table("pairs of segments that touch", ["scene", "side"], heads, ["samples"])
    for cell in result.cells:
        sizes = [f"{cell.n_segments:,}", f"{cell.radius:g}", f"{cell.n_pairs:,}"]
        own = [format_3_digits(cell.build_s), *_times(cell.seconds, cell.n_segments), "", "", ""]
        table.add_row(cell.scene, "ours", *sizes, *own, end_section=not cell.rivals)
        for rival in cell.rivals:
            build = format_3_digits(rival.build_s) if rival.build_s else ""
            figures = [build, *_times(rival.seconds, cell.n_segments), f"{rival.ratio:.2f}", str(rival.n_differ)]
            last = rival is cell.rivals[-1]
            table.add_row(cell.scene, rival.peer, *sizes, *figures, rival.note, end_section=last)
    print_table(console, table)
    print_checks(console, result.checks())
    threads = result.preset.n_threads
    console.print(
        f"{threads} thread{'s' if threads > 1 else ''}, {result.machine['simd']}, medians of {result.preset.rounds} "
        "rounds, without builds. Ratios are the peer's time divided by ours. scipy: pairs of samples of a k-d tree, as "
        "far apart as is fastest, with an exact test. all pairs: our test of 16 pairs at a time, without a tree. "
        "textbook: the same by the formula of textbooks. differ: pairs at the radius, up to rounding, that one side "
        "alone has. "
        f"{result.total_s:.0f} s in all.",
        highlight=False,
    )
    for name, why in result.missing.items():
        console.print(f"NOT MEASURED: {name} {why}", style="bold", markup=False, highlight=False)


def _times(seconds: float, n_segments: int) -> list[str]:
    return [format_3_digits(seconds * 1e3), format_3_digits(seconds / n_segments * 1e9)]
