"""The time of a query, measured on as many rays as there is time for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..harness.clock import clock
from ..harness.rays import RayBatch
from ..harness.turns import MAX_HITS


@dataclass(frozen=True)
class Timing:
    """The time of a query.

    Attributes
    ----------
    n_rays : int
        The number of rays of the query.
    n_measured : int
        The number of rays that were traced.
    seconds : float
        The time of the traced rays.
    n_hits : int
        The number of hits of the traced rays.
    """

    n_rays: int
    n_measured: int
    seconds: float
    n_hits: int

    @property
    def ms(self) -> float:
        """Milliseconds for all rays, scaled up if not all were traced."""
        return 1e3 * self.seconds * self.n_rays / self.n_measured

    @property
    def mrays(self) -> float:
        """Millions of rays per second."""
        return self.n_measured / self.seconds / 1e6

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {**asdict(self), "ms": self.ms}


#: A function of a batch of rays that returns the number of hits and the seconds.
TimedQuery = Callable[[RayBatch], tuple[int, float]]

#: The maximum number of rays of the trial, which sets the number of timed rays.
TRIAL = 4096
#: The approximate number of tests per second. The trial has fewer rays if the tree is one huge leaf.
TESTS_PER_SECOND = 1e8
#: The maximum number of rounds, of which the fastest counts.
ROUNDS = 3


def measure(run: TimedQuery, query: str, rays: RayBatch, budget: float, expected_tests: float = 1.0) -> Timing:
    """Return the timing of a query on the rays of a picture, or on an evenly spaced part of them.

    Parameters
    ----------
    run : callable
    query : str
        "first" or "all".
    rays : RayBatch
    budget : float
        Seconds for one round. The trial may exceed it.
    expected_tests : float
        The approximate number of segments tested per ray.
    """
    n_trial = int(np.clip(budget * TESTS_PER_SECOND / max(1.0, expected_tests), 16, TRIAL))
    few = some(rays, n_trial)
    n_hits, seconds = min(run(few), run(few), key=lambda took: took[1])
    part = some(rays, int(len(few) * budget / max(seconds, 1e-7)))
    if len(part) <= len(few):
        return Timing(len(rays), len(few), seconds, n_hits)

    # Trace all rays in one call, unless its lists of hits would be too long.
    size = len(part)
    if query == "all":
        size = max(1, int(MAX_HITS / max(1.0, n_hits / len(few))) // rays.block) * rays.block
    parts = [part.take(slice(i, i + size)) for i in range(0, len(part), size)]
    times: list[float] = []
    while len(times) < ROUNDS and sum(times) <= 2 * budget:
        answers = [run(each) for each in parts]
        n_hits = sum(n for n, _ in answers)
        times.append(sum(took for _, took in answers))
    return Timing(len(rays), len(part), max(min(times), 1e-9), n_hits)


def some(rays: RayBatch, n_rays: int) -> RayBatch:
    """Return every k-th ray of every k-th row of a square picture, with the least k that leaves at most `n_rays`.

    A few whole rows would keep neighbours together, but not represent the picture.
    """
    size = math.isqrt(len(rays))
    step = math.ceil(size / math.sqrt(max(n_rays, 1)))
    if step <= 1:
        return rays
    at = np.arange(step // 2, size, step)
    return rays.take((at[:, None] * size + at).ravel())


def timed_by(answer: Callable[[RayBatch], Any], count: Callable[[Any], int]) -> TimedQuery:
    """Return a function that times `answer` with the clock of one thread, and counts its hits."""
    now = clock(1)

    def run(rays: RayBatch) -> tuple[int, float]:
        start = now()
        found = answer(rays)
        seconds = now() - start
        return count(found), seconds

    return run
