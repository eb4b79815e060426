"""Which tests reach which mutants, kept in a file: only tests of new or changed files run again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from .trial import Test


class Recording:
    """The tests of each file, with what they reach, as long as neither the file nor the sources change.

    Parameters
    ----------
    path : Path
        Where it is kept.
    checkout : Path
        The repository, to which the names of tests are relative.
    sources : iterable of Path
        What else the tests depend on: the mutated files and what the tests share.
    numbers : sequence of int
        The mutants.
    """

    def __init__(self, path: Path, checkout: Path, sources: Iterable[Path], numbers: Sequence[int]) -> None:
        self._path, self._checkout = path, checkout
        self._of = _digest(sources, json.dumps(list(numbers)))
        kept: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        files = kept["files"] if kept.get("of") == self._of else {}
        self.tests = [
            Test(name, seconds, frozenset(reached))
            for file, (digest, tests) in files.items()
            if digest == self._digest_of(file)
            for name, seconds, reached in tests
        ]

    @property
    def files(self) -> list[str]:
        """The files whose tests need not run again."""
        return sorted({test.module for test in self.tests})

    def add(self, tests: Iterable[Test]) -> None:
        """Keep more tests."""
        self.tests += tests
        files: dict[str, tuple[str, list[Any]]] = {}
        for test in self.tests:
            entry = files.setdefault(test.module, (self._digest_of(test.module), []))
            entry[1].append((test.name, test.seconds, sorted(test.reached)))
        self._path.write_text(json.dumps({"of": self._of, "files": files}), encoding="utf-8")

    def _digest_of(self, file: str) -> str:
        path = self._checkout / file
        return _digest([path] if path.exists() else [])


def _digest(paths: Iterable[Path], text: str = "") -> str:
    found = hashlib.sha256(text.encode())
    for path in paths:
        found.update(hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()
