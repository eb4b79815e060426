"""The clock of all benchmarks."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")


def clock(n_threads: int) -> Callable[[], float]:
    """Return a clock in seconds: the processor time of this process for one thread, wall-clock time for more.

    Processor time excludes other programs.
    """
    return time.process_time if n_threads == 1 else time.perf_counter


def best_of(rounds: int, n_threads: int, do: Callable[[], Result]) -> tuple[float, Result]:
    """Call a function several times; return the least seconds of a call, and the last result."""
    return best_in_turn(rounds, timed(do, clock(n_threads)))[0]


def best_in_turn(rounds: int, *calls: Callable[[], tuple[Result, float]]) -> list[tuple[float, Result]]:
    """Call functions in turn, several times; each returns its result and the seconds that it took.

    Returns
    -------
    list of (float, result)
        The least seconds of each function, and its last result.

    Examples
    --------
    >>> seconds = iter([3.0, 9.0, 2.0, 8.0])
    >>> best_in_turn(2, lambda: ("ours", next(seconds)), lambda: ("theirs", next(seconds)))
    [(2.0, 'ours'), (8.0, 'theirs')]
    """
    found = [[call() for call in calls] for _ in range(rounds)]
    return [(min(seconds for _, seconds in each), each[-1][0]) for each in zip(*found, strict=True)]


def timed(do: Callable[[], Result], now: Callable[[], float] = time.perf_counter) -> Callable[[], tuple[Result, float]]:
    """Return a function that returns the result of another one, and the seconds that it took."""

    def call() -> tuple[Result, float]:
        start = now()
        result = do()
        return result, now() - start

    return call
