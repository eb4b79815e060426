"""The soak itself: cases one after the other until the time is over, and what became of them."""

from __future__ import annotations

import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import Any, TypeAlias

import fastlines as fl

from ..harness.internals import counted
from ..harness.machine import describe
from .answers import RAY_QUERIES
from .builds import builder_name
from .case import Case
from .compare import difference, is_same_kind, outcomes
from .decisions import DECIDED, check_decisions
from .draw import Choice, draw_case
from .shrink import shrink
from .tally import Tally
from .write import write_test

Progress: TypeAlias = Callable[[str, float], None]
#: What answers are counted by: geometry, query, builder, kernel, instruction set.
Answer: TypeAlias = tuple[str, str, str, str, str]

#: Of so many numbers, one is a batch of decisions, and the others are cases of a tree.
DECISIONS_EVERY = 2
#: The file in the folder of a soak that has the command of the case that runs, in case the process itself dies.
RUNNING = "running.txt"


@dataclass(frozen=True)
class Plan:
    """What a soak does, and for how long."""

    minutes: float
    seed: int = 0
    n_cases: int | None = None
    #: The number of the only case.
    case: int | None = None
    choice: Choice = field(default_factory=Choice)
    folder: Path | None = None

    def command(self, number: int) -> str:
        """Return the command that repeats a case."""
        only = "" if self.choice == Choice() else f" --only '{','.join((*self.choice.kinds, *self.choice.queries))}'"
        return f"fastlines-bench soak --seed {self.seed}{only} --case {number}"

    def test_name(self, number: int) -> str:
        """Return the name of the test of a case."""
        return f"test_soak_{self.seed}_{number}"

    def numbers(self) -> Iterator[int]:
        """Yield the numbers of the cases."""
        if self.case is not None:
            return iter([self.case])
        return iter(range(self.n_cases)) if self.n_cases is not None else count()


@dataclass(frozen=True)
class Found:
    """A difference: its case, what differs, and the small case."""

    number: int
    why: str
    #: When it was found, on the clock of `time.monotonic`.
    at: float
    shrunk: Case | None = None
    path: Path | None = None

    @property
    def size(self) -> str:
        """How large the small case is."""
        if self.shrunk is None:
            return "not shrunk"
        sizes = [counted(self.shrunk.n_prims, "primitives")]
        if self.shrunk.questions:
            question = self.shrunk.questions[0]
            if len(question):
                sizes.append(counted(len(question), question.noun))
            sizes.append(question.query)
        return ", ".join(sizes)


@dataclass
class Summary:
    """What a soak has done, and found."""

    plan: Plan
    #: How many differences are made small; of further ones, only their number is kept.
    most_shrunk: int = 10
    #: Answers by geometry, query, builder, kernel and instruction set.
    answers: Counter[Answer] = field(default_factory=Counter)
    #: Answers by number of threads, by what was done with the tree, and by option.
    threads: Counter[str] = field(default_factory=Counter)
    steps: Counter[str] = field(default_factory=Counter)
    options: Counter[str] = field(default_factory=Counter)
    n_cases: int = 0
    n_refused: int = 0
    n_refused_builds: int = 0
    tally: Tally = field(default_factory=Tally)
    found: list[Found] = field(default_factory=list)
    seconds: float = 0.0
    was_interrupted: bool = False

    @property
    def n_answers(self) -> int:
        """The number of answers that were compared."""
        return sum(self.answers.values())

    @property
    def is_clean(self) -> bool:
        """Whether nothing differs."""
        return not self.found and not self.tally.n_wrong

    def to_json(self) -> dict[str, Any]:
        """Return the summary for a file."""
        columns = ("geometry", "query", "builder", "kernel", "simd")
        tally, values = self.tally, self.tally.values
        return {
            "format": "fastlines-bench soak 1",
            "machine": describe(),
            "seed": self.plan.seed,
            "seconds": self.seconds,
            "cases": self.n_cases,
            "refused": {"builds": self.n_refused_builds, "queries": self.n_refused},
            "answers": [dict(zip(columns, key, strict=True)) | {"n": n} for key, n in sorted(self.answers.items())],
            "threads": dict(self.threads),
            "steps": dict(self.steps),
            "options": dict(self.options),
            "decisions": [
                {"shape": key[0], "scene": key[1], "simd": key[2], "n": n, "wrong": tally.wrong[key]}
                for key, n in sorted(tally.n.items())
            ],
            "values": [
                {"value": key[0], "simd": key[1], "n": n, "wrong": values.wrong[key], "largest": values.largest[key]}
                for key, n in sorted(values.n.items())
            ],
            "in_band": tally.n_in_band,
            "refused_batches": tally.n_refused,
            "found": [{"case": one.number, "why": one.why, "size": one.size} for one in self.found],
        }


def run_soak(plan: Plan, progress: Progress, tell: Callable[[str], None]) -> Summary:
    """Run cases until the time is over; Ctrl-C ends it earlier, with the summary so far."""
    summary, start = Summary(plan), time.monotonic()
    running = None if plan.folder is None else plan.folder / RUNNING
    if running is not None:
        running.parent.mkdir(parents=True, exist_ok=True)
    try:
        for number in plan.numbers():
            if running is not None:
                running.write_text(plan.command(number) + "\n", encoding="utf-8")
            run_case(summary, number, tell)
            summary.seconds = time.monotonic() - start
            share = summary.seconds / (60 * plan.minutes)
            if plan.case is None and share >= 1:
                break
            told = f"{summary.n_answers:,} answers, {sum(summary.tally.n.values()) / 1e6:,.0f} million decisions"
            progress(f"{told}, {len(summary.found)} differ", min(share, 1.0))
    except KeyboardInterrupt:
        summary.was_interrupted = True
    if running is not None:
        running.unlink(missing_ok=True)
    summary.seconds = time.monotonic() - start
    return summary


def run_case(summary: Summary, number: int, tell: Callable[[str], None]) -> None:
    """Run one case, and add what became of it."""
    summary.n_cases += 1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (_decide if is_decisions(number, summary.plan.choice) else _compare)(summary, number, tell)


def _decide(summary: Summary, number: int, tell: Callable[[str], None]) -> None:
    """Compare a batch of decisions with float64."""
    plan = summary.plan
    tally = check_decisions(plan.seed, number, tuple(kind for kind in plan.choice.kinds if kind in DECIDED))
    summary.tally.add(tally)
    for example in tally.examples:
        tell(f"case {number}: a wrong decision of {example}")
    for example in tally.values.examples:
        tell(f"case {number}: a wrong value: {example}")


def _compare(summary: Summary, number: int, tell: Callable[[str], None]) -> None:
    """Compare the answers of a tree with those of brute force."""
    case = draw_case(summary.plan.seed, number, summary.plan.choice)
    if not case.questions:
        return
    became = outcomes(case)
    summary.n_refused_builds += not became
    summary.n_refused += sum(one.is_refused for one in became)
    if became:
        _count(summary, case)
    for i, one in enumerate(became):
        if one.difference is not None:
            summary.found.append(_report(summary, case, i, number, one.difference, tell))


def is_decisions(number: int, choice: Choice) -> bool:
    """Return whether a number is that of a batch of decisions."""
    is_chosen = "all_hits" in choice.queries and any(kind in DECIDED for kind in choice.kinds)
    return is_chosen and number % DECISIONS_EVERY == DECISIONS_EVERY - 1


def _count(summary: Summary, case: Case) -> None:
    builder = builder_name(case.build)
    for question in case.questions:
        kernel = question.kernel if question.query in RAY_QUERIES else "no rays"
        summary.answers[case.kind, question.query, builder, kernel, question.simd or fl.simd()] += 1
        summary.threads[str(question.n_threads)] += 1
        summary.steps.update(case.steps or ("as built",))
        given = {**question.rows, **question.options}
        summary.options.update(given.keys() - {"origins", "directions", "points", "low", "high"})
        summary.options.update(
            f"{name}={given[name]}" for name in ("at", "rank", "merge", "to", "blur") if name in given
        )
    for name, is_on in (
        ("offset", case.offset is not None),
        ("frame", case.frame is not None),
        ("skipped rows", case.spoiled),
        ("presplit", "presplit" in case.build),
        ("reinsertion", case.build.get("reinsertion")),
        ("lookahead", "lookahead" in case.build),
    ):
        summary.steps[name] += len(case.questions) if is_on else 0


def _report(summary: Summary, case: Case, question: int, number: int, why: str, tell: Callable[[str], None]) -> Found:
    """Make a difference small, write it as a test, and print it."""
    query, now = case.questions[question].query if case.questions else "the build", time.monotonic()
    plan = summary.plan
    tell(f"case {number}: {query}: {why}")
    if sum(found.shrunk is not None for found in summary.found) >= summary.most_shrunk:
        return Found(number, why, now)
    alone = case.alone(case.questions[question]) if case.questions else case
    alone_why = difference(alone)
    if alone_why is None:
        tell("  the question alone does not differ; the case is kept as it is")
        return Found(number, why, now, replace(case, questions=case.questions[: question + 1]))
    small = shrink(alone, lambda smaller: is_same_kind(difference(smaller), alone_why))
    path = None
    if plan.folder is not None:
        name, command = plan.test_name(number), plan.command(number)
        path = write_test(plan.folder, small, name, command, f"{query}: {difference(small)}")
    found = Found(number, why, now, small, path)
    tell(f"  shrunk to {found.size}" + (f": {path}" if path else ""))
    return found
