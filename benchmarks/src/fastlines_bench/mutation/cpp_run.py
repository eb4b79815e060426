"""Runs the tests with each mutant of the C++ core, several at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .cpp_build import Build
from .cpp_tests import FOLDERS, Programs
from .mutant import Mutant
from .pytest_process import PytestProcess
from .recording import Recording
from .switches import Switches
from .trial import Test, try_mutants, with_fixtures


class Worker:
    """Runs tests with one mutant at a time; each worker has switches and processes of its own."""

    def __init__(self, build: Build, index: int) -> None:
        self._build, self._switches = build, Switches(build.folder / f"switches-{index}")
        self._switches.only(0)
        self._programs = Programs(build, self._switches)
        self._python = PytestProcess(build.checkout, FOLDERS, self._switches, build.environment())
        self.close = self._python.close

    def record(self, numbers: Sequence[int], progress: Callable[[str, float], None]) -> list[Test]:
        """Run all tests without a mutant, unless a run before has; return them with the mutants that they reach.

        All mutants of the build are recorded, so that a run of some of them can use the recording of all.
        """
        sources, tests = self._build.source, self._build.checkout / "tests"
        shared = [path for path in (sources / "cpp").rglob("*.?pp") if "tests" not in path.parts]
        shared += [*(sources / "src").rglob("*.py"), *tests.glob("conftest.py"), *(tests / "support").rglob("*.py")]
        kept = Recording(
            self._build.folder / "recording.json", self._build.checkout, sorted(shared), self._build.numbers
        )
        kept.add(self._python.record(self._build.numbers, progress, kept.files))
        return [*self._programs.record(self._build.numbers, progress), *with_fixtures(kept.tests)]

    def noticed_by(self, number: int, groups: Sequence[Sequence[Test]]) -> str:
        """Run groups of tests with a mutant until one fails, or without one for 0; return which, or ""."""
        self._switches.only(number)
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
