"""The number of threads of batch calls."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from .arrays import count

MAX_THREADS = 1024

_n_threads: int | None = None


def set_num_threads(n_threads: int | None) -> None:
    """Set the number of threads of all later batch calls; None = one for each core that this process may use.

    The environment variable ``FASTLINES_NUM_THREADS`` sets it for a whole program. Answers do not depend on it.
    A batch of up to 256 rays uses one thread, unless rays times references of the tree exceed ten million.
    """
    global _n_threads
    _n_threads = None if n_threads is None else count("n_threads", n_threads, 1, MAX_THREADS)


@contextmanager
def num_threads(n_threads: int | None) -> Iterator[None]:
    """Set the number of threads for a while."""
    global _n_threads
    before = _n_threads
    set_num_threads(n_threads)
    try:
        yield
    finally:
        _n_threads = before


def get_num_threads() -> int:
    """Return how many threads batch calls use."""
    if _n_threads is not None:
        return _n_threads
    given = os.environ.get("FASTLINES_NUM_THREADS")
    if given:
        return count("FASTLINES_NUM_THREADS", int(given) if given.strip().isdecimal() else given, 1, MAX_THREADS)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
