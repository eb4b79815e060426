"""Runs the tests with each mutant of the Python package, several at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from fastlines import InputError

from .mutant import Mutant
from .pytest_process import PytestProcess
from .python_sources import package_folder
from .recording import Recording
from .switches import Switches
from .trial import Test, try_mutants, with_fixtures

#: Tests of what is checked and refused, read and kept.
FOLDERS = (
    "tests/build/test_build_memory.py",
    "tests/build/test_builders.py",
    "tests/build/test_settings.py",
    "tests/geometry",
    "tests/io",
    "tests/query",
    "tests/structure",
    "tests/test_arrays.py",
    "tests/test_input.py",
)


class Worker:
    """Runs tests with one mutant at a time, in a process that has imported the mutated package."""

    def __init__(self, checkout: Path, names: Sequence[str], switches: Path, numbers: Sequence[int]) -> None:
        self._checkout, self._switches, self._numbers = checkout, Switches(switches), numbers
        self._switches.only(0)
        self._python = PytestProcess(checkout, names, self._switches, os.environ, "python_pytest")
        self.close = self._python.close

    def record(self, numbers: Sequence[int], progress: Callable[[str, float], None]) -> list[Test]:
        """Run all tests without a mutant, unless a run before has; return them with the mutants that they reach.

        All drawn mutants are recorded, so that a run of some of them can use the recording of all.
        """
        tests = self._checkout / "tests"
        shared = [*package_folder().rglob("*.py"), *tests.glob("conftest.py"), *(tests / "support").rglob("*.py")]
        kept = Recording(self._switches.path.with_suffix(".json"), self._checkout, sorted(shared), self._numbers)
        kept.add(self._python.record(self._numbers, progress, kept.files))
        return with_fixtures(kept.tests)

    def noticed_by(self, number: int, groups: Sequence[Sequence[Test]]) -> str:
        """Run groups of tests with a mutant until one fails, or without one for 0; return which, or ""."""
        self._switches.only(number)
        try:
            return self._python.failing([test for group in groups for test in group]) or ""
        finally:
            self._switches.only(0)


def run_mutants(
    checkout: Path,
    folder: Path,
    drawn: Sequence[Mutant],
    mutants: Sequence[Mutant],
    seconds: float,
    n_jobs: int,
    progress: Callable[[str, float], None],
    tell: Callable[[str], None],
) -> None:
    """Set the status of some of the drawn mutants of the package, as `try_mutants` does, by several workers."""
    numbers = [mutant.number for mutant in drawn]
    workers = [Worker(checkout, FOLDERS, folder / f"switches-{i}", numbers) for i in range(n_jobs)]
    try_mutants(workers, mutants, seconds, progress, tell)


def check_same(checkout: Path) -> None:
    """Raise an error unless the installed package is that of a checkout, whose tests run."""
    sources, installed = checkout / "src" / "fastlines", package_folder()
    for path in sorted(sources.rglob("*.py")):
        other = installed / path.relative_to(sources)
        if not other.exists() or other.read_bytes() != path.read_bytes():
            raise InputError(f"{other} differs from {path}: install the package of the checkout, whose tests run")
