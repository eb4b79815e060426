"""Runs the tests with each mutant of the C++ core, several at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .cpp_build import Build
from .cpp_tests import FOLDERS, Programs
from .mutant import Mutant
from .pytest_process import Python
from .switches import Switches
from .trial import Test, try_mutants, with_fixtures


class Worker:
    """Runs tests with one mutant at a time; each worker has switches and processes of its own."""

    def __init__(self, build: Build, index: int) -> None:
        self._switches = Switches(build.folder / f"switches-{index}")
        self._switches.only(0)
        self._programs, self._python = (
            Programs(build, self._switches),
            Python(build.checkout, FOLDERS, self._switches, build.environment()),
        )
        self.close = self._python.close

    def record(self, numbers: Sequence[int], progress: Callable[[str, float], None]) -> list[Test]:
        """Run all tests without a mutant; return them with the mutants that they reach."""
        programs = self._programs.record(numbers, progress)
        return [*programs, *with_fixtures(self._python.record(numbers, progress))]

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
    """Set the status of each mutant of a compiled copy, as `try_mutants` does, by several workers."""
    try_mutants([Worker(build, i) for i in range(n_jobs)], mutants, seconds, progress, tell)
