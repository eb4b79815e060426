"""Checks of plain arguments; each error says what was given and what was expected."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from .errors import InputError

#: The largest count that the core can take.
LARGEST = 2**63 - 1


def count(name: str, value: object, least: int, most: int | None = None) -> int:
    """Check a whole number; NumPy's will do."""
    given = value.item() if isinstance(value, np.integer) else value
    if isinstance(given, bool) or not isinstance(given, int) or not least <= given <= (most or LARGEST):
        upto = f"to {most}" if most else "or more"
        raise InputError(f"{name}={value!r}; expected a whole number, {least} {upto}")
    return given


def number(name: str, value: object, expected: str, low: float) -> float:
    """Check a finite number above `low`."""
    given = value.item() if isinstance(value, np.number) else value
    if isinstance(given, bool) or not isinstance(given, int | float) or not low < given <= sys.float_info.max:
        raise InputError(f"{name}={value!r}; expected {expected}")
    return float(given)


def sequence(name: str, value: object, kind: type | tuple[type, ...], expected: str) -> tuple[Any, ...]:
    """Check one thing or several of a kind."""
    several = (value,) if isinstance(value, kind) else value
    if not isinstance(several, Sequence) or not several or not all(isinstance(one, kind) for one in several):
        raise InputError(f"{name}={value!r}; expected {expected}")
    return tuple(several)
