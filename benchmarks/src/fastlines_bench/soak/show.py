"""The summary of a soak as tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from rich.console import Console

from ..harness.internals import counted
from ..harness.tables import new_table, print_table, wide_console
from .faults import Trial
from .run import Answer, Summary
from .values import Values
from .write import text_of_test

#: The keys of the answers that a summary counts.
GEOMETRY, QUERY, BUILDER, KERNEL, SIMD = range(5)


def print_summary(summary: Summary) -> None:
    """Print what was asked, what was decided, and what differs."""
    console = wide_console()
    for head, row, column in (("geometry", GEOMETRY, QUERY), ("builder", BUILDER, KERNEL), ("query", QUERY, SIMD)):
        _print_counts(console, head, summary.answers, row, column)
    for title, counts in (("threads", summary.threads), ("trees", summary.steps), ("options", summary.options)):
        text = ", ".join(f"{name} {n:,}" for name, n in sorted(counts.items()) if n)
        console.print(f"[bold]answers by {title}:[/] {text}" if text else f"no {title}", highlight=False)
    _print_decisions(console, summary)
    _print_values(console, summary.tally.values)
    _print_end(console, summary)


def _print_counts(console: Console, head: str, answers: Counter[Answer], row: int, column: int) -> None:
    """Print the number of answers by two of their keys."""
    sums: Counter[tuple[str, str]] = Counter()
    for key, n in answers.items():
        sums[key[row], key[column]] += n
    rows, columns = sorted({a for a, _ in sums}), sorted({b for _, b in sums})
    if rows:
        table = new_table(f"answers by {head}", [head], columns)
        for name in rows:
            table.add_row(name, *(f"{sums[name, of]:,}" for of in columns))
        print_table(console, table)


def _print_decisions(console: Console, summary: Summary) -> None:
    """Print decisions outside the band by shape and by scene, for each instruction set."""
    tally = summary.tally
    if not tally.n:
        return
    sets = sorted({key[2] for key in tally.n})
    names = [f"{simd}: n" for simd in sets] + [f"{simd}: wrong" for simd in sets]
    for at, what in ((0, "shape"), (1, "scene")):
        table = new_table(f"decisions outside the band, by {what}", [what], names)
        for name in sorted({key[at] for key in tally.n}):
            table.add_row(name, *_figures(tally.n, at, name, sets), *_figures(tally.wrong, at, name, sets))
        print_table(console, table)
    for what in ("rays", "points", "pairs", "boxes of space"):
        keys = [key for key in tally.n if f", {what}" in key[0]]
        n, wrong = (sum(counts[key] for key in keys) for counts in (tally.n, tally.wrong))
        console.print(f"decisions about {what} outside the band: {n:,}, wrong: {wrong:,}", highlight=False)
    in_band, refused = f"{tally.n_in_band:,} decisions", counted(tally.n_refused, "batches")
    console.print(f"{in_band} are in the band; {refused} were refused", highlight=False)


def _print_values(console: Console, values: Values) -> None:
    """Print how many values were compared, and how much of their bound the largest error takes, on all sets."""
    if not values.n:
        return
    table = new_table("values beside float64", ["value"], ["n", "off by more", "largest error, of its bound"])
    for name in sorted({key[0] for key in values.n}):
        keys = [key for key in values.n if key[0] == name]
        n, wrong = (sum(counts[key] for key in keys) for counts in (values.n, values.wrong))
        table.add_row(name, f"{n:,}", f"{wrong:,}", f"{max(values.largest[key] for key in keys):.2f}")
    print_table(console, table)


def _figures(counts: Counter[tuple[str, str, str]], at: int, name: str, sets: Iterable[str]) -> list[str]:
    return [f"{sum(n for key, n in counts.items() if key[at] == name and key[2] == simd):,}" for simd in sets]


def _print_end(console: Console, summary: Summary) -> None:
    """Print how much was done, and each difference with its small case."""
    end = "interrupted" if summary.was_interrupted else "done"
    console.print(
        f"{end} after {summary.seconds / 60:.1f} minutes, seed {summary.plan.seed}: {summary.n_cases:,} cases, "
        f"{summary.n_answers:,} answers, {len(summary.found)} differ. Both sides refused {summary.n_refused:,} of the "
        f"queries; {summary.n_refused_builds:,} builds were refused.",
        highlight=False,
    )
    for found in summary.found:
        again = summary.plan.command(found.number)
        console.print(f"\n{again}: {found.why}", highlight=False, markup=False)
        if found.shrunk is not None and found.path is None:
            text = text_of_test(found.shrunk, summary.plan.test_name(found.number), again, found.why)
            console.print(text, highlight=False, markup=False, soft_wrap=True)


def print_trials(trials: Iterable[Trial]) -> None:
    """Print how soon each planted fault was found."""
    table = new_table("planted faults", ["fault"], ["found after (s)", "cases"], ["shown by", "where"])
    for trial in trials:
        after = f"{trial.seconds:.1f}" if trial.is_found else "not found"
        table.add_row(trial.name, after, f"{trial.n_cases:,}", trial.shown_by, trial.where)
    print_table(wide_console(), table)
