"""The tables of a run: operations, the calls that failed in turn, and each failure that was not handled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..harness.tables import new_table, print_table, wide_console
from .run import Row

#: What each mode means, by what fails.
MODES = {
    "once": "one allocation fails",
    "ever": "all allocations from one on fail",
    "threads": "no thread starts from one on",
    "ENOSPC": "the disk is full from one call on",
    "EIO": "one call fails with EIO",
    "EINTR": "one call is interrupted",
    "short": "one call reads half",
}

#: Bytes that may stay in use for each fault: those of counters and caches of the interpreter.
MAX_LEAKED = 64.0


def faults_of(row: Row) -> list[str]:
    """Return what was wrong, with the memory that stays in use among it."""
    leaks = [f"{row.leaked:.0f} bytes stay in use for each fault"] if row.leaked > MAX_LEAKED else []
    return [*row.wrong, *leaks]


def calls_text(row: Row) -> str:
    """Return which calls failed, and how often."""
    return ", ".join(f"{n} {call}" for call, n in row.calls.items())


def print_faults(rows: Mapping[str, Sequence[Row]]) -> None:
    """Print a table for each of what failed, and then each failure that was not handled."""
    console = wide_console()
    for what, of in rows.items():
        heads = ("operation", "what fails")
        table = new_table(
            f"faults of {what}", heads, ("calls", "handled"), ("which",) if what in ("files", "reads") else ()
        )
        for row in of:
            n_wrong = len({each.split(":")[0] for each in faults_of(row)})
            cells = (row.operation, MODES[row.mode], f"{row.n_calls:,}", f"{row.n_calls - n_wrong:,}")
            table.add_row(*cells, *((calls_text(row),) if what in ("files", "reads") else ()))
        print_table(console, table)
    for what, of in rows.items():
        for row in of:
            for each in faults_of(row):
                console.print(f"{what}, {row.operation}, {MODES[row.mode]}: call {each}", markup=False, highlight=False)


def are_handled(rows: Mapping[str, Sequence[Row]]) -> bool:
    """Return whether each failure was handled."""
    return not any(faults_of(row) for of in rows.values() for row in of)
