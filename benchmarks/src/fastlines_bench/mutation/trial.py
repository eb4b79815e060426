"""Runs the tests that reach each mutant, several mutants at a time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from queue import SimpleQueue
from typing import Protocol

from .mutant import Mutant

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

    @property
    def is_program(self) -> bool:
        """Whether it is a program, not a test in Python."""
        return "::" not in self.name


class Worker(Protocol):
    """What runs tests with one mutant at a time."""

    def record(self, numbers: Sequence[int], progress: Callable[[str, float], None]) -> list[Test]:
        """Run all tests without a mutant; return them with the mutants that they reach."""

    def noticed_by(self, number: int, groups: Sequence[Sequence[Test]]) -> str:
        """Run groups of tests with a mutant until one fails, or without one for 0; return which, or ""."""

    def close(self) -> None:
        """End its processes."""


def try_mutants(
    workers: Sequence[Worker],
    mutants: Sequence[Mutant],
    seconds: float,
    progress: Callable[[str, float], None],
    tell: Callable[[str], None],
) -> None:
    """Set the status of each mutant, and end the workers.

    Parameters
    ----------
    workers : sequence of Worker
        The first one records which tests reach what; all of them try mutants at the same time.
    mutants : sequence of Mutant
        Those to try.
    seconds : float
        The most time of tests for one mutant, as they take without it. Of the tests that reach it, those of files that
        noticed others of the same source come first, then those of files that reach little else. A test that fails
        without a mutant, too, after the same tests, notices nothing from then on.
    """
    free = SimpleQueue[Worker]()
    noticed: dict[str, Counter[str]] = {}
    is_reliable: dict[str, bool] = {}
    n_done = 0

    def notice(worker: Worker, mutant: Mutant, groups: list[list[Test]]) -> str:
        while by := worker.noticed_by(mutant.number, groups):
            name = by.split(", ")[0]
            if name not in is_reliable:
                is_reliable[name] = not worker.noticed_by(0, _until(groups, name))
            if is_reliable[name] or all(test.name != name for group in groups for test in group):
                return by if is_reliable[name] else ""
            groups = [[test for test in group if test.name != name] for group in groups]
        return ""

    def attempt(mutant: Mutant) -> None:
        nonlocal n_done
        history = noticed.setdefault(mutant.file, Counter())
        reaching = [test for test in tests if mutant.number in test.reached]
        groups = _choose(reaching, history, shares[mutant.file], seconds)
        worker = free.get()
        try:
            mutant.by = notice(worker, mutant, groups)
        finally:
            free.put(worker)
        history[mutant.by.split("::")[0]] += 1
        mutant.status = "killed" if mutant.by else "survived" if groups else "not reached"
        if mutant.status != "killed":
            tell(f"{mutant.status}: {mutant.file}:{mutant.line}: {mutant.original}  →  {mutant.replacement}")
        n_done += 1
        progress(f"{mutant.file}:{mutant.line}", n_done / len(mutants))

    try:
        tests = workers[0].record([mutant.number for mutant in mutants], progress)
        shares = _shares(tests, mutants)
        for worker in workers:
            free.put(worker)
        with ThreadPoolExecutor(len(workers)) as pool:
            list(pool.map(attempt, mutants))
    finally:
        for worker in workers:
            worker.close()


def with_fixtures(tests: Sequence[Test]) -> list[Test]:
    """Return tests as if each reached what the first of its file reaches, which sets up what they share."""
    first: dict[str, Test] = {}
    for test in tests:
        first.setdefault(test.module, test)
    return [replace(test, reached=test.reached | first[test.module].reached) for test in tests]


def _until(groups: Sequence[Sequence[Test]], name: str) -> list[list[Test]]:
    """Return groups of tests up to the named one; all of them if none has this name."""
    until: list[list[Test]] = []
    for group in groups:
        names = [test.name for test in group]
        until.append(list(group[: names.index(name) + 1] if name in names else group))
        if name in names:
            break
    return until


def _shares(tests: Sequence[Test], mutants: Sequence[Mutant]) -> dict[str, dict[str, float]]:
    """Return by source and file of tests which share of the mutants that these tests reach are in that source."""
    source_of = {mutant.number: mutant.file for mutant in mutants}
    shares: dict[str, dict[str, float]] = {source: {} for source in source_of.values()}
    reached: dict[str, set[int]] = {}
    for test in tests:
        reached.setdefault(test.module, set()).update(test.reached & source_of.keys())
    for module, numbers in reached.items():
        for source, n in Counter(source_of[number] for number in numbers).items():
            shares[source][module] = n / len(numbers)
    return shares


def _choose(
    tests: Sequence[Test], history: Counter[str], shares: Mapping[str, float], seconds: float
) -> list[list[Test]]:
    """Return the tests of each module that run within some time, in the order in which to try the modules."""
    modules: dict[str, list[Test]] = {}
    for test in sorted(tests, key=lambda test: test.seconds):
        modules.setdefault(test.module, []).append(test)
    ordered = sorted(modules, key=lambda name: (-history[name], -shares.get(name, 0.0)))
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
