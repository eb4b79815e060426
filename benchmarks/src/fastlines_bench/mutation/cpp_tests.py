"""The C++ tests, which notice mutants of the core, and where those in Python are that do."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Callable, Sequence

from fastlines import InputError

from .cpp_build import Build
from .switches import VARIABLE, Switches
from .trial import FACTOR, SECONDS_MORE, Test

#: Tests in Python that query trees, check and change them, and refuse bad input.
FOLDERS = (
    "tests/query",
    "tests/kernels",
    "tests/structure",
    "tests/build",
    "tests/test_refit.py",
    "tests/test_input.py",
)


class Programs:
    """The C++ tests, each a program."""

    def __init__(self, build: Build, switches: Switches) -> None:
        self._paths = {path.name: path for path in build.programs}
        self._switches = switches

    def record(self, numbers: Sequence[int], progress: Callable[[str, float], None]) -> list[Test]:
        """Run all programs without a mutant; return them with the numbers that they reach."""
        tests = []
        for i, name in enumerate(self._paths):
            progress(name, i / len(self._paths))
            self._switches.watch(numbers)
            begin = time.perf_counter()
            end = self._run(name, None)
            seconds = time.perf_counter() - begin
            if end != "0":
                raise InputError(f"the C++ test {name} ends with {end} without a mutant")
            tests.append(Test(name, seconds, frozenset(self._switches.reached(numbers))))
        return tests

    def failing(self, tests: Sequence[Test]) -> str | None:
        """Run programs until one fails; return which, or None."""
        for test in tests:
            end = self._run(test.name, FACTOR * test.seconds + SECONDS_MORE)
            if end != "0":
                return test.name if end == "1" else f"{test.name} ends: {end}"
        return None

    def _run(self, name: str, seconds: float | None) -> str:
        process = subprocess.Popen(
            [str(self._paths[name])],
            env={**os.environ, VARIABLE: str(self._switches.path)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            code = process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return "hangs"
        return str(code) if code >= 0 else signal.Signals(-code).name
