"""The switch of the Python mutants: the shared file of switches, as mutated modules ask it."""

from __future__ import annotations

import os
from pathlib import Path

from .switches import OFF, ON, VARIABLE, WATCHED, Switches

_bytes = Switches(Path(os.environ[VARIABLE])).bytes


def at(first: int, last: int) -> bool:
    """Return whether a mutant of a place is on, whose numbers are first to last; note that the place is reached."""
    states = _bytes[first : last + 1]
    if WATCHED in states:
        _bytes[first : last + 1] = states.replace(bytes([WATCHED]), bytes([OFF]))
    return ON in states


def is_on(number: int) -> bool:
    """Return whether a mutant is on."""
    return _bytes[number] == ON
