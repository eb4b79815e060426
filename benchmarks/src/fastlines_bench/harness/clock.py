"""The clock of all benchmarks."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

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


def take_turns(
    rounds: int, sides: Mapping[str, Callable[[], Any]], now: Callable[[], float]
) -> tuple[dict[str, list[float]], dict[str, Any]]:
    """Call all sides in turn, several times; return the seconds of each round, and the last answers, by side."""
    seconds: dict[str, list[float]] = {name: [] for name in sides}
    answers = dict.fromkeys(sides)
    for _ in range(rounds):
        for name, do in sides.items():
            answers[name], took = timed(do, now)()
            seconds[name].append(max(took, 1e-9))
    return seconds, answers


def median_ratio(slower: Sequence[float], faster: Sequence[float]) -> float:
    """Return the median, over rounds, of the seconds of one side divided by those of the other.

    Examples
    --------
    >>> median_ratio([2.0, 40.0, 6.0], [1.0, 10.0, 2.0])
    3.0
    """
    return statistics.median(a / b for a, b in zip(slower, faster, strict=True))


def timed(do: Callable[[], Result], now: Callable[[], float] = time.perf_counter) -> Callable[[], tuple[Result, float]]:
    """Return a function that returns the result of another one, and the seconds that it took."""

    def call() -> tuple[Result, float]:
        start = now()
        result = do()
        return result, now() - start

    return call
