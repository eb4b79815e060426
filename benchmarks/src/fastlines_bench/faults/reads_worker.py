"""A process with the library for files loaded, in which the calls of one operation that read files fail in turn."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path
from typing import Any

from .file_operations import names_file
from .library import READS, FailingFiles
from .read_operations import ReadOperation, ReadOperations
from .turns import fail_in_turn


class ReadTrial:
    """An operation whose n-th call that reads a file fails, or reads half."""

    def __init__(self, operation: ReadOperation, folder: Path, mode: str) -> None:
        self.operation, self.folder = operation, folder
        self.error = 0 if mode == "short" else getattr(errno, mode)
        self.library = FailingFiles()
        operation.make(operation.path)
        self.expected = operation.read(operation.path)
        self.files = self._names()

    def run(self, n: int) -> tuple[bool, str, list[str]]:
        """Fail call n; return whether it was reached, which call it was, and what is wrong after it."""
        error: BaseException | None = None
        answer: Any = None
        self.library.arm(READS, self.folder, self.error, n, n)
        try:
            answer = self.operation.read(self.operation.path)
        except BaseException as caught:
            error = caught
        n_calls, call = self.library.disarm()
        if n_calls < n:
            return False, "", [] if error is None else [f"fails without a fault: {error!r}"]
        wrong = []
        if error is None and answer != self.expected:
            wrong.append("another answer without an error")
        if error is not None and not names_file(error, self.operation.path):
            wrong.append(f"no sentence: {type(error).__name__}: {str(error)!r}")
        del error, answer
        if self._names() != self.files:
            wrong.append("the folder has other files")
        if self.operation.read(self.operation.path) != self.expected:
            wrong.append("the next call answers differently")
        return True, call, [f"{call}: {each}" for each in wrong]

    def _names(self) -> list[str]:
        return sorted(str(path) for path in self.folder.rglob("*"))


def main(name: str, mode: str, first: str, folder: str) -> None:
    """Run one operation in one mode, from one call on."""
    operations = ReadOperations(Path(os.path.realpath(folder)), [name.removeprefix("read ")])
    operation = next(each for each in operations if each.name == name)
    trial = ReadTrial(operation, operations.folder, mode)
    fail_in_turn(trial.run, int(first))


if __name__ == "__main__":
    main(*sys.argv[1:])
