"""How long rays take, on as many of them as there is time for."""

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
    """How long a query took.

    Attributes
    ----------
    n_rays : int
        How many rays the query has.
    n_measured : int
        How many of them were asked.
    seconds : float
        What was measured, for these.
    n_hits : int
        What they hit.
    """

    n_rays: int
    n_measured: int
    seconds: float
    n_hits: int

    @property
    def ms(self) -> float:
        """Milliseconds for all rays; scaled up if not all were asked."""
        return 1e3 * self.seconds * self.n_rays / self.n_measured

    @property
    def mrays(self) -> float:
        """Millions of rays a second."""
        return self.n_measured / self.seconds / 1e6

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {**asdict(self), "ms": self.ms}


#: Answers a batch: how many hits there are, and the seconds that count.
Asked = Callable[[RayBatch], tuple[int, float]]

#: So many are asked first, to see how many there is time for.
FIRST = 4096
#: So many tests of a segment take about a second: a tree that is one huge leaf is asked fewer rays first.
TESTS_PER_SECOND = 1e8
#: The best of so many times counts, if there is time for them.
ROUNDS = 3


def measure(ask: Asked, query: str, rays: RayBatch, budget: float, expected_tests: float = 1.0) -> Timing:
    """Ask the rays of a picture, or an even part of them.

    Parameters
    ----------
    ask : callable
    query : str
        "first" or "all".
    rays : RayBatch
    budget : float
        Seconds for one round. The first, small part of the rays, asked to find out, may exceed it.
    expected_tests : float
        About so many segments are tested for a ray.
    """
    n_first = int(np.clip(budget * TESTS_PER_SECOND / max(1.0, expected_tests), 16, FIRST))
    few = some(rays, n_first)
    n_hits, seconds = ask(few)
    n_hits, seconds = min((n_hits, seconds), ask(few), key=lambda took: took[1])
    part = some(rays, int(len(few) * budget / max(seconds, 1e-7)))
    if len(part) <= len(few):
        return Timing(len(rays), len(few), seconds, n_hits)

    # One call asks all rays, but that its lists of hits stay of a size.
    size = len(part)
    if query == "all":
        size = max(1, int(MAX_HITS / max(1.0, n_hits / len(few))) // rays.block) * rays.block
    parts = [part.take(slice(i, i + size)) for i in range(0, len(part), size)]
    times: list[float] = []
    while len(times) < ROUNDS and sum(times) <= 2 * budget:
        answers = [ask(each) for each in parts]
        n_hits = sum(n for n, _ in answers)
        times.append(sum(took for _, took in answers))
    return Timing(len(rays), len(part), max(min(times), 1e-9), n_hits)


def some(rays: RayBatch, n_rays: int) -> RayBatch:
    """Take every k-th ray of every k-th row of a square picture, with the least k that leaves no more than so many.

    A few whole rows would keep neighbours together, but do not stand for the picture.
    """
    size = math.isqrt(len(rays))
    step = math.ceil(size / math.sqrt(max(n_rays, 1)))
    if step <= 1:
        return rays
    at = np.arange(step // 2, size, step)
    return rays.take((at[:, None] * size + at).ravel())


def timed_by(answer: Callable[[RayBatch], Any], count: Callable[[Any], int]) -> Asked:
    """Time a call with the clock of one thread, and count what it gave."""
    now = clock(1)

    def ask(rays: RayBatch) -> tuple[int, float]:
        start = now()
        found = answer(rays)
        seconds = now() - start
        return count(found), seconds

    return ask
