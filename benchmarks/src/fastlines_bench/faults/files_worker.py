"""A process with the library for files loaded, in which the calls of one operation that change files fail in turn."""

from __future__ import annotations

import errno
import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .file_operations import FileOperation, FileOperations, names_file
from .library import ALL, CHANGES, FailingFiles
from .turns import fail_in_turn

#: A disk that is full stays full; the other faults happen once.
STAYS = ("ENOSPC",)


class FileTrial:
    """An operation whose n-th call that changes a file fails."""

    def __init__(self, operation: FileOperation, folder: Path, mode: str) -> None:
        self.operation, self.folder, self.mode = operation, folder / "written", mode
        self.library = FailingFiles()
        self.path = self.folder / operation.target
        self.saved = folder / "before"
        self.contents: list[Any] = []
        for i in (1, 0):
            self._clear()
            operation.write(self.path, i)
            self.contents.insert(0, operation.read(self.path))
        shutil.copytree(self.folder, self.saved)
        self.unraised: list[str] = []
        sys.unraisablehook = lambda what: self.unraised.append(f"{type(what.exc_value).__name__}: {what.exc_value}")

    def run(self, n: int) -> tuple[bool, str, Sequence[str]]:
        """Fail call n; return whether it was reached, which call it was, and what is wrong after it."""
        self._clear()
        if not self.operation.goes_on:
            shutil.copytree(self.saved, self.folder, dirs_exist_ok=True)
        error: BaseException | None = None
        self.unraised.clear()
        self.library.arm(CHANGES, self.folder, getattr(errno, self.mode), n, ALL if self.mode in STAYS else n)
        try:
            self.operation.write(self.path, 1)
        except BaseException as caught:
            error = caught
        n_calls, call = self.library.disarm()
        if n_calls < n:
            return False, "", [] if error is None else [f"fails without a fault: {error!r}"]
        wrong = self._check(error)
        del error
        return True, call, [f"{call}: {each}" for each in (*wrong, *self._check_next())]

    def _clear(self) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir()

    def _check(self, error: BaseException | None) -> list[str]:
        wrong = [f"a traceback is printed: {each}" for each in self.unraised]
        if error is not None and not names_file(error, self.path):
            wrong.append(f"no sentence: {type(error).__name__}: {str(error)!r}")
        if self.operation.goes_on:
            return wrong if error is not None else [*wrong, *self._check_content([1])]
        left = sorted({each.name for each in self.folder.iterdir()} - {self.operation.target})
        wrong += [f"left over: {name}" for name in left]
        return [*wrong, *self._check_content([1] if error is None else [0, 1])]

    def _check_content(self, expected: Sequence[int]) -> list[str]:
        """Return what is wrong with what stands there; expected is version 0, the one before, or 1, the new one."""
        try:
            content = self.operation.read(self.path)
        except Exception as error:
            return [f"the file cannot be read: {error}"]
        if any(content == self.contents[i] for i in expected):
            return []
        return ["the file is another one" if content not in self.contents else "the old file without an error"]

    def _check_next(self) -> list[str]:
        """Return what is wrong with the next call, after which there is the new file alone."""
        try:
            self.operation.write(self.path, 1)
        except Exception as error:
            return [f"the next call fails: {error}"]
        left = sorted(path.name for path in self.folder.rglob("*.partial"))
        return [*self._check_content([1]), *(f"left over after the next call: {name}" for name in left)]


def main(name: str, mode: str, first: str, folder: str) -> None:
    """Run one operation in one mode, from one call on."""
    operations = FileOperations(Path(os.path.realpath(folder)), [name.removeprefix("write ")])
    operation = next(each for each in operations if each.name == name)
    trial = FileTrial(operation, Path(os.path.realpath(folder)), mode)
    fail_in_turn(trial.run, int(first))


if __name__ == "__main__":
    main(*sys.argv[1:])
