"""A process that has collected the tests, and forks for each list of them that is to run.

It reads lines of JSON from stdin. ``{"watch": [numbers], "without": [files]}`` runs all tests but those of some files,
and tells for each the mutants that it reaches and its processor time. ``{"run": [tests], "seconds": limit}`` runs some
until one fails. It answers in lines of JSON. The caller turns a mutant on, in the file of switches.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import resource
import select
import signal
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from .switches import VARIABLE, Switches

#: Bytes that tests may take on top of what the process has: a mutant may ask for any number.
MEMORY = 6 << 30

#: A process may wait, or share the processors with others, so that it takes so many times its processor time.
BUSY = 10.0


class Server:
    """A plugin of pytest that runs the tests that stdin asks for, instead of each one once."""

    def __init__(self, answers: int) -> None:
        self._answers = answers
        self._report: list[tuple[str, str]] = []

    def pytest_collection(self) -> None:
        """Let hypothesis draw the same examples each time, and not make them smaller."""
        if "hypothesis" in sys.modules:
            from hypothesis import Phase, settings

            phases = (Phase.explicit, Phase.generate)
            settings.register_profile("mutation", deadline=None, derandomize=True, database=None, phases=phases)
            settings.load_profile("mutation")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a failure of any phase."""
        if report.failed:
            self._report.append((report.nodeid, report.when or ""))

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Answer lines until there are no more."""
        gc.collect()
        gc.freeze()  # so that forks go on sharing this memory
        self._tell({"collected": len(session.items)})
        for line in sys.stdin:
            asked = json.loads(line)
            if "watch" in asked:
                end = self._in_fork(lambda asked=asked: self._watch(session, asked["watch"], asked["without"]), None)
                self._tell({"watched": end})
            else:
                of = {item.nodeid: item for item in session.items}
                items = [of[name] for name in asked["run"] if name in of]
                self._tell({"end": self._in_fork(lambda items=items: self._run(items), asked["seconds"])})
        return True

    def _tell(self, answer: dict[str, Any]) -> None:
        os.write(self._answers, (json.dumps(answer) + "\n").encode())

    def _watch(self, session: pytest.Session, numbers: Sequence[int], without: Sequence[str]) -> int:
        switches = Switches(Path(os.environ[VARIABLE]))
        for item, following in _pairs([item for item in session.items if item.nodeid.split("::")[0] not in without]):
            switches.watch(numbers)
            begin = _processor_seconds()
            self._report.clear()
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            seconds = _processor_seconds() - begin
            found = {"test": item.nodeid, "reached": switches.reached(numbers), "seconds": seconds}
            self._tell({**found, "failed": bool(self._report)})
        return 0

    def _run(self, items: Sequence[pytest.Item]) -> int:
        for item, following in _pairs(items):
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            if self._report:
                self._tell({"failed": "{}, {}".format(*self._report[0])})
                return 1
        return 0

    def _in_fork(self, work: Any, seconds: float | None) -> str:
        """Run in a fork; return "0", "1", the name of the signal that ended it, or "hangs"."""
        folder = tempfile.TemporaryDirectory(prefix="mutation-", ignore_cleanup_errors=True)
        process = os.fork()
        if process == 0:
            os.setsid()
            _set_limits(folder.name, seconds or 0.0)
            code = 3
            with contextlib.suppress(BaseException):
                nothing = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nothing, 1)
                os.dup2(nothing, 2)
                code = work()
            os._exit(code)
        watched = os.pidfd_open(process)
        ended = select.select([watched], [], [], seconds and seconds * BUSY)[0]
        os.close(watched)
        # Whatever a test has left running ends with it.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process, signal.SIGKILL)
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        folder.cleanup()
        if not ended or status == -signal.SIGPROF:
            return "hangs"
        return str(status) if status >= 0 else signal.Signals(-status).name


def _processor_seconds() -> float:
    """Return the processor time of this process, and of those that it has waited for."""
    return sum(os.times()[:4])


def _set_limits(folder: str, seconds: float) -> None:
    """Keep the files of tests in a folder, and memory and processor time within bounds; 0 seconds are no bound."""
    signal.setitimer(signal.ITIMER_PROF, seconds)
    os.environ["PYTEST_DEBUG_TEMPROOT"] = os.environ["TMPDIR"] = tempfile.tempdir = folder
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _pairs(items: Sequence[pytest.Item]) -> Iterator[tuple[pytest.Item, pytest.Item | None]]:
    return zip(items, [*items[1:], None][: len(items)], strict=True)


def main(names: Sequence[str]) -> int:
    """Collect the tests of files and folders, and answer until stdin ends."""
    channel = os.dup(1)
    sys.stdout.flush()
    os.dup2(2, 1)
    options = ["-q", "-s", "-p", "no:cacheprovider", "-p", "no:randomly", "-m", "not slow", "--hypothesis-seed=0"]
    return int(pytest.main([*options, *names], plugins=[Server(channel)]))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
