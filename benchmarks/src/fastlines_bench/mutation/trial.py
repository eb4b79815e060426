"""Runs the tests that reach each mutant, one mutant at a time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from .mutant import Mutant
from .switches import Switches

#: A test hangs if it takes so many times as long as without a mutant, and so many seconds more.
FACTOR, SECONDS_MORE = 4.0, 10.0


@dataclass(frozen=True)
class Test:
    """A test in Python or a program, its time without a mutant, and the mutants that it reaches."""

    name: str
    seconds: float
    reached: frozenset[int]

    @property
    def module(self) -> str:
        """The file of tests, or the program."""
        return self.name.split("::")[0]


class Runner(Protocol):
    """What runs tests of one kind."""

    def record(self, numbers: Sequence[int], progress: Callable[[str, float], None]) -> list[Test]:
        """Run all tests without a mutant; return them with the numbers that they reach."""

    def failing(self, tests: Sequence[Test]) -> str | None:
        """Run tests until one fails; return which, or None."""


def try_mutants(
    mutants: Sequence[Mutant],
    switches: Switches,
    runners: Sequence[Runner],
    seconds: float,
    progress: Callable[[str, float], None],
    tell: Callable[[str], None],
) -> None:
    """Set the status of each mutant.

    Parameters
    ----------
    mutants : sequence of Mutant
        Those to try.
    switches : Switches
        The file by which a mutant is turned on.
    runners : sequence of Runner
        What runs the tests.
    seconds : float
        The most time of tests for one mutant, as they take without it. Of the tests that reach it, those of files that
        noticed others of the same source come first, then the fastest.
    """
    numbers = [mutant.number for mutant in mutants]
    tests = {test: runner for runner in runners for test in runner.record(numbers, progress)}
    noticed: dict[str, Counter[str]] = {}
    for i, mutant in enumerate(mutants):
        progress(f"{mutant.file}:{mutant.line}", i / len(mutants))
        history = noticed.setdefault(mutant.file, Counter())
        chosen = _choose([test for test in tests if mutant.number in test.reached], history, seconds)
        switches.only(mutant.number)
        mutant.by = ""
        for group in chosen:
            mutant.by = tests[group[0]].failing(group) or ""
            if mutant.by:
                history[group[0].module] += 1
                break
        mutant.status = "killed" if mutant.by else "survived" if chosen else "not reached"
        if mutant.status != "killed":
            tell(f"{mutant.status}: {mutant.file}:{mutant.line}: {mutant.original}  →  {mutant.replacement}")
        switches.only(0)


def with_fixtures(tests: Sequence[Test]) -> list[Test]:
    """Return tests as if each reached what the first of its file reaches, which sets up what they share."""
    first: dict[str, Test] = {}
    for test in tests:
        first.setdefault(test.module, test)
    return [Test(test.name, test.seconds, test.reached | first[test.module].reached) for test in tests]


def _choose(tests: Sequence[Test], history: Counter[str], seconds: float) -> list[list[Test]]:
    """Return the tests of each module that run within some time, in the order in which to try the modules."""
    modules: dict[str, list[Test]] = {}
    for test in sorted(tests, key=lambda test: test.seconds):
        modules.setdefault(test.module, []).append(test)
    ordered = sorted(modules, key=lambda name: (-history[name], sum(t.seconds for t in modules[name])))
    chosen, left = [], seconds
    for name in ordered:
        group = []
        for test in modules[name]:
            if test.seconds <= left:
                group.append(test)
                left -= test.seconds
        if group:
            chosen.append(group)
    return chosen
