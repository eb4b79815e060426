"""The file of switches that all processes map: a byte for each mutant (see mutants.hpp)."""

from __future__ import annotations

import mmap
from collections.abc import Sequence
from pathlib import Path

#: The variable that names the file, and its size.
VARIABLE, SIZE = "FASTLINES_MUTANTS", 1 << 16
OFF, ON, WATCHED = 0, 1, 2


class Switches:
    """A file of switches, which it makes unless it is there."""

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.exists():
            path.write_bytes(bytes(SIZE))
        with path.open("r+b") as file:
            self.bytes = mmap.mmap(file.fileno(), SIZE)

    def only(self, number: int) -> None:
        """Turn one mutant on, and all others off; 0 turns all off."""
        self.bytes[:] = bytes(SIZE)
        if number:
            self.bytes[number] = ON

    def watch(self, numbers: Sequence[int]) -> None:
        """Turn all off, and from now on note which of these are reached."""
        self.bytes[:] = bytes(SIZE)
        for number in numbers:
            self.bytes[number] = WATCHED

    def reached(self, numbers: Sequence[int]) -> list[int]:
        """Return which of the watched were reached."""
        return [number for number in numbers if self.bytes[number] == OFF]
