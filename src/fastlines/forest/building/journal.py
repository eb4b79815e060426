"""The journal of a build: what is built, in ``build.json``, and the files of its stages, in ``.building``.

A stage is done once its file is there. All files appear whole or not at all, so that a build that was killed goes on.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

from ...errors import InputError
from ...support.atomic_write import atomic_write
from ...support.texts import counted
from ..manifest import BUILD, BUILDING
from ..manifest import FILE as MANIFEST

try:
    import fcntl
except ImportError:  # without these locks two builds at a time are not noticed
    fcntl = None  # type: ignore[assignment]

#: Errors of a disk that is full.
FULL = (errno.ENOSPC, errno.EDQUOT)

#: The files whose locks this process holds.
_locks: set[TextIO] = set()


def _close_locks() -> None:
    """Close the locks that a fork has copied: else workers of a pool would hold them after the build was killed."""
    for file in _locks:
        file.close()
    _locks.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_close_locks)


@dataclass(frozen=True)
class Journal:
    """The files of a build in the folder of its forest."""

    folder: Path

    @property
    def _stages(self) -> Path:
        return self.folder / BUILDING

    @property
    def spilled(self) -> Path:
        """The file that says that all chunks are there."""
        return self._stages / "spilled"

    @property
    def plan(self) -> Path:
        """The file of the plan."""
        return self._stages / "plan"

    @property
    def partitioned(self) -> Path:
        """The file with the tiles: all parts are there."""
        return self._stages / "tiles"

    def chunk(self, number: int) -> Path:
        """Return the file of a chunk of the source."""
        return self._stages / "chunks" / f"{number:06d}"

    def part(self, number: int) -> Path:
        """Return the file of several chunks that are sorted by their leaves."""
        return self._stages / "parts" / f"{number:06d}"

    def built(self, tile: int) -> Path:
        """Return the file with what the manifest will say of a tile."""
        return self._stages / "built" / f"{tile:06d}"

    def column(self, name: str) -> Path:
        """Return the file of a column of the index."""
        return self._stages / name

    @property
    def is_finished(self) -> bool:
        """Whether the forest is whole."""
        return (self.folder / MANIFEST).exists()

    def begin(self, plan: Mapping[str, Any]) -> None:
        """Begin a build, or go on with the one that this folder holds, which is locked and was checked."""
        if not self.check(plan):
            with atomic_write(self.folder / BUILD) as partial:
                partial.write_text(json.dumps(plan, indent=2) + "\n", encoding="utf-8")

    def check(self, plan: Mapping[str, Any]) -> bool:
        """Make the folder, or check the one that is there; return whether it holds this build, which has begun.

        Parameters
        ----------
        plan : mapping
            What is built, ready for JSON: each entry is text, a number or a mapping of these.

        Raises
        ------
        InputError
            If the folder holds something else, or what differs in one of the entries.
        """
        if not self.folder.parent.is_dir():
            raise FileNotFoundError(
                errno.ENOENT, f"there is no folder {self.folder.parent}; make it first", str(self.folder)
            )
        if self.folder.exists() and not self.folder.is_dir():
            raise InputError(f"{self.folder} is a file; expected a new folder for a forest")
        self.folder.mkdir(exist_ok=True)
        path, wanted = self.folder / BUILD, json.loads(json.dumps(plan))
        others = sorted(name for name in os.listdir(self.folder) if not name.startswith((BUILD, BUILDING)))
        if path.exists() and (others or self.chunk(0).exists() or self.spilled.exists()):
            self._compare(path, wanted)
            is_begun = True
        elif others:
            what = "a forest that fl.build_forest did not build" if MANIFEST in others else "other files"
            more = f" and {len(others) - 3} more" if len(others) > 3 else ""
            raise InputError(
                f"{self.folder} holds {what}: {', '.join(others[:3])}{more}; name a new or an empty folder"
            )
        else:
            is_begun = False
        for name in ("chunks", "parts", "built"):
            (self._stages / name).mkdir(parents=True, exist_ok=True)
        return is_begun

    def _compare(self, path: Path, wanted: dict[str, Any]) -> None:
        """Refuse to go on with another build."""
        begun = "holds" if self.is_finished else "has begun"
        advice = "pass the same to go on, or delete the folder to begin anew"
        if self.is_finished:
            advice = "fl.Forest opens it; delete the folder to build another, or name a new one"
        try:
            known = json.loads(path.read_text(encoding="utf-8"))
            names = [name for name in {**known, **wanted} if known.get(name) != wanted.get(name)]
        except (ValueError, TypeError, AttributeError):
            raise InputError(f"{path} is damaged; delete the folder {self.folder}, and build the forest anew") from None
        for name in names:
            was, now = (json.dumps(of.get(name), ensure_ascii=False) for of in (known, wanted))
            if name == "source":
                was, now = _first_difference(known.get(name), wanted.get(name))
            raise InputError(f"{self.folder} {begun} a forest with {name} {was}, and {now} was given; {advice}")

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the folder against other builds, which a process that ends gives free."""
        file = (self._stages / "lock").open("w")
        try:
            if fcntl is not None:
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    raise InputError(
                        f"another process builds the forest {self.folder}; wait for it, or name another folder"
                    ) from None
                except OSError:  # files cannot be locked here
                    pass
            _locks.add(file)
            yield
        finally:
            _locks.discard(file)
            with contextlib.suppress(OSError):  # nothing was written to it
                file.close()

    @contextmanager
    def explaining(self) -> Iterator[None]:
        """Say how to go on after a disk was full, and name the folder where an error names no file."""
        try:
            yield
        except OSError as error:
            if error.errno not in FULL:
                if error.errno and error.filename is None:
                    raise OSError(error.errno, error.strerror, str(self.folder)) from None
                raise
            left = shutil.disk_usage(self.folder).free
            why = (
                f"there is not enough space on the disk ({left / 1e6:.0f} MB are free) to build {self.folder}; what is "
                "done is kept: free some more, and call fl.build_forest again, which goes on"
            )
            raise OSError(error.errno, why, error.filename) from None

    def reopen(self) -> None:
        """Make a forest that was whole one that is half built."""
        (self.folder / MANIFEST).unlink()

    def clear(self) -> None:
        """Remove the files of the stages: the forest is whole."""
        with contextlib.suppress(FileNotFoundError):
            shutil.rmtree(self._stages)


def _first_difference(known: Any, wanted: Any) -> tuple[str, str]:
    """Return the first of several sources that differs, before and now."""
    if isinstance(known, list) and isinstance(wanted, list):
        if len(known) != len(wanted):
            return counted(len(known), "files"), counted(len(wanted), "files")
        known, wanted = next((was, now) for was, now in zip(known, wanted, strict=True) if was != now)
    return json.dumps(known, ensure_ascii=False), json.dumps(wanted, ensure_ascii=False)
