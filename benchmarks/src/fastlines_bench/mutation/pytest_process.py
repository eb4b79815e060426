"""A pytest process that has collected the tests and runs the requested ones."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from fastlines import InputError

from .switches import VARIABLE, Switches
from .trial import FACTOR, SECONDS_MORE, Test

#: Tests that fail without a mutant are left out, if they are a smaller share of all.
MOST_FAILED = 0.01
#: So many of the last lines of a process that ended are shown.
N_LINES = 20


class PytestProcess:
    """A process of pytest that has imported and collected the tests.

    Parameters
    ----------
    checkout : Path
        The repository, whose tests run.
    names : sequence of str
        Folders and files of tests, relative to the checkout.
    switches : Switches
        The file of switches, whose folder gets the output of pytest.
    environment : mapping
        The variables of the process.
    module : str
        The module that is the process.
    """

    def __init__(
        self,
        checkout: Path,
        names: Sequence[str],
        switches: Switches,
        environment: Mapping[str, str],
        module: str = "warm_pytest",
    ) -> None:
        names = [name for name in names if (checkout / name).exists()]
        self._log = switches.path.with_suffix(".log").open("w")
        self._process = subprocess.Popen(
            [sys.executable, "-m", f"{__package__}.{module}", *names],
            cwd=checkout,
            env={**environment, VARIABLE: str(switches.path), "PYTHONHASHSEED": "0"},
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
        )
        self._ask(None, "collected")

    def record(
        self, numbers: Sequence[int], progress: Callable[[str, float], None], without: Sequence[str] = ()
    ) -> list[Test]:
        """Run all tests without a mutant, but those of some files; return them with the numbers that they reach."""
        tests, n_failed = [], 0
        for answer in self._answers({"watch": list(numbers), "without": list(without)}, "watched"):
            if "watched" in answer:
                if answer["watched"] != "0":
                    raise InputError(f"the tests end with {answer['watched']} without a mutant; run them alone")
                break
            progress(answer["test"].split("::")[0], 0.0)
            if answer["failed"]:
                n_failed += 1
            else:
                tests.append(Test(answer["test"], answer["seconds"], frozenset(answer["reached"])))
        if n_failed > MOST_FAILED * (len(tests) + n_failed) or not (tests or without):
            raise InputError(f"{n_failed} tests of {len(tests) + n_failed} fail without a mutant; mend them first")
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
            yield answer
            if last in answer:
                return
        end = "\n".join(Path(self._log.name).read_text(errors="replace").splitlines()[-N_LINES:])
        raise InputError(f"pytest ended; the end of its output is\n{end}")
