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
    now, times = clock(n_threads), []
    for _ in range(rounds):
        start = now()
        result = do()
        times.append(now() - start)
    return min(times), result
