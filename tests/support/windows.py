"""What Windows refuses and Linux does not: to replace, rename or remove a file that this process has open or mapped."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fastlines.forest.building import journal
from fastlines.support import atomic_write


def files_in_use() -> set[str]:
    """Return the files that this process has open or mapped into memory."""
    used = set()
    for number in os.listdir("/proc/self/fd"):
        try:
            used.add(os.readlink(f"/proc/self/fd/{number}"))
        except OSError:  # the descriptor that listed the folder
            continue
    maps = (line.split(maxsplit=5) for line in Path("/proc/self/maps").read_text().splitlines())
    return used | {fields[5] for fields in maps if len(fields) == 6}


def refuse_files_in_use(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let this process do to its files only what Windows permits, and lock none."""

    def guarded(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*paths: Any, **options: Any) -> Any:
            folder = os.readlink(f"/proc/self/fd/{options['dir_fd']}") if options.get("dir_fd") is not None else ""
            for path in paths:
                if os.path.realpath(os.path.join(folder, path)) in files_in_use():
                    raise PermissionError(errno.EACCES, "the file is used by a process", os.fspath(path))
            return function(*paths, **options)

        return call

    for name in ("replace", "rename", "unlink", "remove"):
        monkeypatch.setattr(os, name, guarded(getattr(os, name)))
    for module in (atomic_write, journal):
        monkeypatch.setattr(module, "fcntl", None)
