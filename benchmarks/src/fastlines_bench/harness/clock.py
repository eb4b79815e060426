"""The clock of all benchmarks."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")


def clock(n_threads: int) -> Callable[[], float]:
    """Choose a clock in seconds: with one thread, the processor time of this process; with more, wall-clock time.

    Processor time does not count what other programs do.
    """
    return time.process_time if n_threads == 1 else time.perf_counter


def best_of(rounds: int, n_threads: int, do: Callable[[], Result]) -> tuple[float, Result]:
    """Do something several times; return the least of the seconds that it took, and the last result."""
    now, times = clock(n_threads), []
    for _ in range(rounds):
        start = now()
        result = do()
        times.append(now() - start)
    return min(times), result
