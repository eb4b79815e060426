"""The tables of refits, and of queries on refitted trees beside rebuilt ones."""

from __future__ import annotations

from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from .run import RefitResult


def print_refit(result: RefitResult) -> None:
    """Print a table of refits and one of queries."""
    console = wide_console()
    refits, queries = (
        new_table(title, ["scene"], ["degrees", *heads.split("|")])
        for title, heads in (
            ("refits of a growing twist", "refs/seg|refit ms|Mseg/s|Mref/s|layout ms|both Mseg/s|build ms"),
            (
                "queries: nanoseconds per random ray",
                "growth|to rebuilt|first|rebuilt|ratio|all|rebuilt|ratio|pays after Mrays",
            ),
        )
    )
    for cell in result.cells:
        both_s = cell.refit_s + cell.layout_s
        refits.add_row(
            cell.scene,
            f"{cell.angle:.0f}",
            format_3_digits(cell.n_refs / cell.n_prims),
            format_3_digits(cell.refit_s * 1e3),
            format_3_digits(cell.n_prims / cell.refit_s / 1e6),
            format_3_digits(cell.n_refs / cell.refit_s / 1e6),
            format_3_digits(cell.layout_s * 1e3),
            format_3_digits(cell.n_prims / both_s / 1e6),
            format_3_digits(cell.build_s * 1e3),
        )
        queries.add_row(
            cell.scene,
            f"{cell.angle:.0f}",
            f"{cell.growth:.2f}",
            f"{cell.to_rebuilt:.2f}",
            f"{cell.first_ns:.0f}",
            f"{cell.first_rebuilt_ns:.0f}",
            f"{cell.first_ns / cell.first_rebuilt_ns:.2f}",
            f"{cell.all_ns:.0f}",
            f"{cell.all_rebuilt_ns:.0f}",
            f"{cell.all_ns / cell.all_rebuilt_ns:.2f}",
            "never" if cell.pays_after == float("inf") else format_3_digits(cell.pays_after / 1e6),
        )
    print_table(console, refits)
    print_table(console, queries)
    console.print(
        f"{result.preset.method}, threads: {result.preset.n_threads}, {result.machine['simd']}. seg: segments; ref: "
        "references; layout: the time that it adds to a refit; build: with its layout, on one thread. growth: the cost "
        "divided by that as built; to rebuilt: divided by that of a rebuilt tree. pays after: the number of rays, half "
        "of them for each query, after which a rebuild pays off.",
        highlight=False,
    )
