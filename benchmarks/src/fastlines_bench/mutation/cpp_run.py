"""Runs the tests with each mutant of the C++ core, several at a time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from queue import SimpleQueue

from .cpp_build import Build
from .cpp_tests import Programs, Python, Test
from .mutant import Mutant
from .switches import Switches


class Worker:
    """Runs tests with one mutant at a time; each worker has switches and processes of its own."""

    def __init__(self, build: Build, index: int) -> None:
        self._switches = Switches(build.folder / f"switches-{index}")
        self._switches.only(0)
        self._programs, self._python = Programs(build, self._switches), Python(build, self._switches)
        self.close = self._python.close

    def record(self, numbers: Sequence[int], progress: Callable[[str, float], None]) -> list[Test]:
        """Run all tests without a mutant; return them with the mutants that they reach."""
        programs = self._programs.record(numbers, progress)
        return [*programs, *_with_fixtures(self._python.record(numbers, progress))]

    def noticed_by(self, mutant: Mutant, groups: Sequence[Sequence[Test]]) -> str:
        """Run groups of tests with a mutant until one fails; return which, or ""."""
        self._switches.only(mutant.number)
        try:
            for group in groups:
                runner = self._programs if group[0].is_program else self._python
                if failed := runner.failing(group):
                    return failed
            return ""
        finally:
            self._switches.only(0)


def run_mutants(
    build: Build,
    mutants: Sequence[Mutant],
    seconds: float,
    n_jobs: int,
    progress: Callable[[str, float], None],
    tell: Callable[[str], None],
) -> None:
    """Set the status of each mutant.

    Parameters
    ----------
    build : Build
        The compiled copy.
    mutants : sequence of Mutant
        Those to try.
    seconds : float
        The most time of tests for one mutant, as they take without it. Of the tests that reach it, those of files that
        noticed others of the same source come first, then the fastest.
    n_jobs : int
        How many run at the same time.
    """
    workers = [Worker(build, i) for i in range(n_jobs)]
    free = SimpleQueue[Worker]()
    noticed: dict[str, Counter[str]] = {}
    n_done = 0

    def attempt(mutant: Mutant) -> None:
        nonlocal n_done
        history = noticed.setdefault(mutant.file, Counter())
        groups = _choose([test for test in tests if mutant.number in test.reached], history, seconds)
        worker = free.get()
        try:
            mutant.by = worker.noticed_by(mutant, groups)
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
        for worker in workers:
            free.put(worker)
        with ThreadPoolExecutor(n_jobs) as pool:
            list(pool.map(attempt, mutants))
    finally:
        for worker in workers:
            worker.close()


def _with_fixtures(tests: Sequence[Test]) -> list[Test]:
    """Return tests as if each reached what the first of its file reaches, which sets up what they share."""
    first: dict[str, Test] = {}
    for test in tests:
        first.setdefault(test.module, test)
    return [replace(test, reached=test.reached | first[test.module].reached) for test in tests]


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
