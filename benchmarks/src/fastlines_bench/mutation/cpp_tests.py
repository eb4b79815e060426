"""The tests that notice mutants of the C++ core: tests in Python, in a warm process, and programs."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from fastlines import InputError

from .cpp_build import Build
from .switches import VARIABLE, Switches

#: Tests in Python that query trees, and check and change them.
FOLDERS = ("tests/query", "tests/kernels", "tests/structure", "tests/build", "tests/test_refit.py")

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


class Python:
    """The tests in Python, in a warm process."""

    def __init__(self, build: Build, switches: Switches) -> None:
        environment = {**build.environment(), VARIABLE: str(switches.path), "PYTHONHASHSEED": "0"}
        folders = [name for name in FOLDERS if (build.checkout / name).exists()]
        command = [sys.executable, "-m", f"{__package__}.warm_pytest", *folders]
        self._log = (build.folder / "pytest.log").open("w")
        self._process = subprocess.Popen(
            command,
            cwd=build.checkout,
            env=environment,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
        )
        self._ask(None, "collected")

    def record(self, numbers: Sequence[int], progress: Callable[[str, float], None]) -> list[Test]:
        """Run all tests without a mutant; return them with the numbers that they reach."""
        tests, wrong = [], []
        for answer in self._answers({"watch": list(numbers)}, "watched"):
            tests.append(Test(answer["test"], answer["seconds"], frozenset(answer["reached"])))
            progress(answer["test"].split("::")[0], 0.0)
            if answer["failed"]:
                wrong.append(answer["test"])
        if wrong or not tests:
            raise InputError(f"tests fail without a mutant, such as {', '.join(wrong[:3]) or 'all'}")
        return tests

    def failing(self, tests: Sequence[Test]) -> str | None:
        """Run tests until one fails; return which, or None."""
        if not tests:
            return None
        seconds = FACTOR * sum(test.seconds for test in tests) + SECONDS_MORE
        failed, end = None, None
        for answer in self._answers({"run": [test.name for test in tests], "seconds": seconds}, "end"):
            failed, end = answer.get("failed", failed), answer.get("end", end)
        return failed or (None if end == "0" else f"{tests[0].module} and others end: {end}")

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()
        self._log.close()

    def _ask(self, asked: Any, last: str) -> list[dict[str, Any]]:
        return list(self._answers(asked, last))

    def _answers(self, asked: Any, last: str) -> Iterable[dict[str, Any]]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        if asked is not None:
            self._process.stdin.write(json.dumps(asked) + "\n")
            self._process.stdin.flush()
        for line in self._process.stdout:
            answer: dict[str, Any] = json.loads(line)
            if last == "end" or last not in answer:
                yield answer
            if last in answer:
                return
        raise InputError(f"pytest ended; its output is in {self._log.name}")


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
