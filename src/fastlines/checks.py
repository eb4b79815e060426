"""Checks of plain arguments; each error says what was given and what was expected."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from .errors import InputError

#: The largest count that the core can take.
LARGEST = 2**63 - 1

#: The least number above 0.
LEAST = math.ulp(0.0)


def count(name: str, value: object, least: int, most: int | None = None) -> int:
    """Check a whole number; NumPy's will do."""
    given = value.item() if isinstance(value, np.integer) else value
    if isinstance(given, bool) or not isinstance(given, int) or not least <= given <= (most or LARGEST):
        too_many = isinstance(given, int) and given > LARGEST
        upto = f"to {most or LARGEST}" if most or too_many else "or more"
        raise InputError(f"{name}={value!r}; expected a whole number, {least} {upto}")
    return given


def number(name: str, value: object, expected: str, low: float, high: float = sys.float_info.max) -> float:
    """Check a number from `low` to `high`."""
    given = value.item() if isinstance(value, np.number) else value
    if isinstance(given, bool) or not isinstance(given, int | float) or not low <= given <= high:
        raise InputError(f"{name}={value!r}; expected {expected}")
    return float(given) + 0.0  # no negative zero


def instance(name: str, value: object, kind: type, expected: str) -> object:
    """Check the type of a value."""
    if not isinstance(value, kind):
        raise InputError(f"{name}={value!r}; expected {expected}")
    return value


def check_fields(made: object, names: Iterable[str], check: Callable[..., object], *bounds: object) -> None:
    """Check fields of a frozen dataclass, and keep what the check returns; None may stay where it is the default."""
    for name in names:
        value = getattr(made, name)
        if value is not None or getattr(type(made), name, ...) is not None:
            object.__setattr__(made, name, check(name, value, *bounds))


def sequence(name: str, value: object, kind: type | tuple[type, ...], expected: str) -> tuple[Any, ...]:
    """Check one thing or several of a kind."""
    several = (value,) if isinstance(value, kind) else value
    if not isinstance(several, Sequence) or not several or not all(isinstance(one, kind) for one in several):
        raise InputError(f"{name}={value!r}; expected {expected}")
    return tuple(several)


def choice(name: str, value: object, known: Iterable[str]) -> str:
    """Check one of a few words."""
    words = tuple(known)
    if not isinstance(value, str) or value not in words:
        raise InputError(f"{name}={value!r} is not a choice: use {' or '.join(map(repr, words))}")
    return value


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """End an error message about an unknown word."""
    import difflib  # only for an error: it takes longer to import than all checks

    words = tuple(known)
    close = difflib.get_close_matches(str(word).lower(), words, 1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return f"; {hint}known: {', '.join(words)}"
