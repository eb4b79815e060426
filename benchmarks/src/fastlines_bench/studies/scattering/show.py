"""The tables of ``fastlines-bench hair``."""

from __future__ import annotations

from ...harness.tables import format_3_digits, new_table, print_table, wide_console
from .run import FLOOR, OFF_AXIS, HairResult


def print_hair(result: HairResult) -> None:
    """Print a row for each material and quantity, and one for each material as averaged hair."""
    console = wide_console()
    title = f"relative error beside Mitsuba {result.mitsuba}: {result.preset.n_pairs:,} pairs of directions each"
    table = new_table(title, ["material", "I0", "of"], ["max", "max off axis", "99.9 %", "median"])
    for cell in result.cells:
        figures = (f"{each:.1e}" for each in (cell.max, cell.max_off_axis, cell.p999, cell.median))
        table.add_row(cell.material, cell.bessel, cell.quantity, *figures)
    print_table(console, table)
    title = "averaged hair: tables beside sums over the offset"
    table = new_table(title, ["material"], ["max", "99 %", "median", "tables, ms", "averaged, ns", "single, ns"])
    for average in result.averages:
        errors = (f"{each:.1e}" for each in (average.max, average.p99, average.median))
        times = (format_3_digits(each) for each in (average.build_ms, average.averaged_ns, average.single_ns))
        table.add_row(average.material, *errors, *times)
    print_table(console, table)
    console.print(
        f"Errors are relative to Mitsuba's value or to the sum, or to {FLOOR:g} per steradian where that is less. "
        "Mitsuba computes in float32, we in float64. I0: whose approximation of the Bessel function our model uses. "
        f"Off axis: offsets of at least {OFF_AXIS:g}. The comparison took {result.seconds:.0f} s.",
        highlight=False,
    )
