"""The versions of files that this process has verified, which it trusts from then on."""

from __future__ import annotations

from pathlib import Path

#: Without and with their checksums.
_verified: dict[bool, set[tuple[str, int, int, int]]] = {False: set(), True: set()}


def is_verified(path: Path, verify: bool | None) -> bool:
    """Return whether this process has verified the file as it is: of its size, time of change and inode.

    Without ``verify=False``, a file that was opened with that is not.
    """
    version = _version_of(path)
    return version in _verified[True] or (verify is False and version in _verified[False])


def set_verified(path: Path, verify: bool | None) -> None:
    """Trust the file as it is."""
    _verified[verify is not False].add(_version_of(path))


def _version_of(path: Path) -> tuple[str, int, int, int]:
    facts = path.stat()
    return str(path.resolve()), facts.st_size, facts.st_mtime_ns, facts.st_ino
