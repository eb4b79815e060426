"""The number of threads of batch calls."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from .arrays import count

MAX_THREADS = 1024

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

_n_threads: int | None = None

#: What holds for one thread alone: `n_threads` of its batch calls, in those of `map_in_threads`, and `ended` of these.
_own = threading.local()


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


@contextmanager
def threads_of_this_thread(n_threads: int) -> Iterator[None]:
    """Set the number of threads of the batch calls that this thread makes, for a while; other threads keep theirs."""
    before: int | None = getattr(_own, "n_threads", None)
    _own.n_threads = n_threads
    try:
        yield
    finally:
        _own.n_threads = before


def get_num_threads() -> int:
    """Return how many threads batch calls use."""
    own: int | None = getattr(_own, "n_threads", None)
    if own is not None:
        return own
    if _n_threads is not None:
        return _n_threads
    given = os.environ.get("FASTLINES_NUM_THREADS")
    if given:
        return count("FASTLINES_NUM_THREADS", int(given) if given.strip().isdecimal() else given, 1, MAX_THREADS)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def map_in_threads(
    function: Callable[[_Item], _Result], items: Iterable[_Item], at_most: int = MAX_THREADS
) -> Iterator[_Result]:
    """Call a function with each of some items in several threads, and yield what it returns in the order of the items.

    There are no more than `at_most` calls at a time. Batch calls within them share the number of threads. If the
    iteration ends early, no further call begins, and those that run end at their next batch call.
    """
    several = list(items)
    n_calls = min(get_num_threads(), len(several), at_most)
    if n_calls <= 1:
        yield from map(function, several)
        return
    ended, each = threading.Event(), get_num_threads() // n_calls
    pool = ThreadPoolExecutor(n_calls, "fastlines", initializer=lambda: vars(_own).update(n_threads=each, ended=ended))
    try:
        yield from pool.map(function, several)
    finally:
        ended.set()
        pool.shutdown(cancel_futures=True)


def check_wanted() -> None:
    """Raise CancelledError in a call of `map_in_threads` whose result nobody waits for."""
    ended: threading.Event | None = getattr(_own, "ended", None)
    if ended is not None and ended.is_set():
        raise CancelledError
