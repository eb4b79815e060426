"""Runs the tests with each mutant of the C++ core, one at a time."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fastlines import InputError

from .cpp_build import Build
from .mutant import Mutant
from .switches import VARIABLE, Switches

#: Tests in Python that query trees, and check and change them.
FOLDERS = ("tests/query", "tests/kernels", "tests/structure", "tests/build", "tests/forest", "tests/test_refit.py")

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


def run_mutants(
    build: Build,
    mutants: Sequence[Mutant],
    seconds: float,
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
    """
    switches = Switches(build.folder / "switches")
    numbers = [mutant.number for mutant in mutants]
    programs, python = Programs(build, switches), Python(build, switches)
    try:
        compiled = programs.record(numbers, progress)
        tests = [*compiled, *_with_fixtures(python.record(numbers, progress))]
        noticed: dict[str, Counter[str]] = {}
        for i, mutant in enumerate(mutants):
            progress(f"{mutant.file}:{mutant.line}", i / len(mutants))
            history = noticed.setdefault(mutant.file, Counter())
            chosen = _choose([test for test in tests if mutant.number in test.reached], history, seconds)
            switches.only(mutant.number)
            mutant.by = ""
            for group in chosen:
                runner = programs if group[0] in compiled else python
                mutant.by = runner.failing(group) or ""
                if mutant.by:
                    history[group[0].module] += 1
                    break
            mutant.status = "killed" if mutant.by else "survived" if chosen else "not reached"
            if mutant.status != "killed":
                tell(f"{mutant.status}: {mutant.file}:{mutant.line}: {mutant.original}  →  {mutant.replacement}")
            switches.only(0)
    finally:
        python.close()


def _with_fixtures(tests: Sequence[Test]) -> list[Test]:
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
