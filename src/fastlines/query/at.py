"""The option `at` of queries: where t of a hit is taken, and which rays hit."""

from __future__ import annotations

from typing import Literal, TypeAlias, cast, get_args

from ..arrays import choice

#: The closest approach, where the ray enters the surface, or the same of rays that come in from outside.
At: TypeAlias = Literal["closest", "surface", "entry"]


def checked_at(at: str) -> At:
    """Return the option `at`.

    Raises
    ------
    InputError
        If it is another name.
    """
    return cast(At, choice("at", at, get_args(At)))


def has_exit(at: At) -> bool:
    """Return whether hits have a ``t_out``."""
    return at != "closest"


def number_of(at: At) -> int:
    """Return the number of `at` in the enumeration of C++."""
    return get_args(At).index(at)
