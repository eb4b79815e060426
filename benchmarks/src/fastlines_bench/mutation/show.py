"""The tables of a run: mutants by file and what became of them, and each that no test noticed."""

from __future__ import annotations

from collections import Counter

from ..harness.tables import new_table, print_table, wide_console
from .mutant import STATUSES, score
from .run import Outcome, undetected


def print_outcome(outcome: Outcome) -> None:
    """Print a table of all files, the score, and the mutants that are left."""
    console = wide_console()
    of_file: dict[str, Counter[str]] = {}
    for mutant in outcome.mutants:
        of_file.setdefault(mutant.file, Counter())[mutant.status] += 1
    table = new_table(f"mutants of {outcome.language}", ("file",), ("mutants", *STATUSES))
    for file, counts in of_file.items():
        table.add_row(file, str(counts.total()), *(str(counts[status]) for status in STATUSES))
    total = sum(of_file.values(), Counter[str]())
    table.add_row("all", str(total.total()), *(str(total[status]) for status in STATUSES))
    print_table(console, table)
    left_out = outcome.n_drawn - len(outcome.mutants)
    console.print(
        f"score {score(outcome.mutants):.1%}; {outcome.n_drawn:,} of {outcome.n_places:,} mutants drawn, "
        f"{left_out:,} left out, which do not compile or are not tried",
        highlight=False,
    )
    for mutant in undetected(outcome.mutants):
        place = f"{mutant.status}: {mutant.file}:{mutant.line}: {mutant.place}"
        console.print(f"{place}\n    {mutant.original}  →  {mutant.replacement}", markup=False, highlight=False)
