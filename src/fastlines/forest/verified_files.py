"""The versions of files that this process has verified, which it trusts from then on."""

from __future__ import annotations

from pathlib import Path

_verified: set[tuple[str, int, int, int]] = set()


def is_verified(path: Path) -> bool:
    """Return whether this process has verified the file as it is: of its size, time of change and inode."""
    return _version_of(path) in _verified


def set_verified(path: Path) -> None:
    """Trust the file as it is."""
    _verified.add(_version_of(path))


def _version_of(path: Path) -> tuple[str, int, int, int]:
    facts = path.stat()
    return str(path.resolve()), facts.st_size, facts.st_mtime_ns, facts.st_ino
