"""How many threads the batch calls use."""

from __future__ import annotations

import os

from .errors import InputError

_n_threads: int | None = None


def set_num_threads(n_threads: int | None) -> None:
    """Set the number of threads of all later batch calls; None = one for each core that this process may use.

    The environment variable ``FASTLINES_NUM_THREADS`` sets it for a whole program. Answers do not depend on it.
    """
    global _n_threads
    _n_threads = None if n_threads is None else _checked(n_threads, "n_threads")


def get_num_threads() -> int:
    """Tell how many threads batch calls use."""
    if _n_threads is not None:
        return _n_threads
    given = os.environ.get("FASTLINES_NUM_THREADS")
    if given:
        return _checked(int(given) if given.isdigit() else given, "FASTLINES_NUM_THREADS")
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _checked(value: object, name: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 1024:
        raise InputError(f"{name}={value!r}; expected a whole number of threads, 1 to 1024")
    return value
