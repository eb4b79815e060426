"""Runs the tests with each mutant of the Python package, one at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from fastlines import InputError

from .mutant import Mutant
from .pytest_process import Python
from .python_sources import package_folder
from .switches import Switches
from .trial import try_mutants

#: Tests of what is checked and refused, read and kept.
FOLDERS = (
    "tests/build/test_build_memory.py",
    "tests/build/test_builders.py",
    "tests/geometry",
    "tests/io",
    "tests/query",
    "tests/structure",
    "tests/test_input.py",
)


def run_mutants(
    checkout: Path,
    folder: Path,
    mutants: Sequence[Mutant],
    seconds: float,
    progress: Callable[[str, float], None],
    tell: Callable[[str], None],
) -> None:
    """Set the status of each mutant of the installed package, by tests of at most so many seconds for each."""
    switches = Switches(folder / "switches")
    python = Python(checkout, FOLDERS, switches, os.environ, "python_pytest")
    try:
        try_mutants(mutants, switches, (python,), seconds, progress, tell)
    finally:
        python.close()


def check_same(checkout: Path) -> None:
    """Raise an error unless the installed package is that of a checkout, whose tests run."""
    sources, installed = checkout / "src" / "fastlines", package_folder()
    for path in sorted(sources.rglob("*.py")):
        other = installed / path.relative_to(sources)
        if not other.exists() or other.read_bytes() != path.read_bytes():
            raise InputError(f"{other} differs from {path}: install the package of the checkout, whose tests run")
