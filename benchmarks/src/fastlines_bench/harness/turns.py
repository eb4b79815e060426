"""Several ways to ask the same rays, in turn: as many rays as there is time for, answers compared."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fastlines import Tree

from ..package import num_threads
from .compare import same
from .rays import RayBatch

#: About so many hits are listed at a time.
MAX_HITS = 1 << 22

#: So many rays are tried to see how many there is time for; no fewer are timed.
TRIAL = 1 << 14


@dataclass(frozen=True)
class Turns:
    """What the turns took.

    Attributes
    ----------
    n_hits : int
        Of all rays; of a first hit, how many rays hit.
    seconds : dict of str to float
        The best of all rounds, of each way.
    """

    n_rays: int
    n_hits: int
    seconds: dict[str, float]


def alternate(
    ways: Mapping[str, Callable[[RayBatch], Any]],
    query: str,
    rays: RayBatch,
    seconds: float,
    rounds: int,
    now: Callable[[], float],
) -> Turns:
    """Ask as many of the rays as there is time for in each way in turn; count rays, hits and seconds.

    Parameters
    ----------
    ways : dict of str to callable
        Each answers a batch of rays; their names are for who reads that two of them differ.
    query : str
        What is asked: "first", "any" or "all".
    rays : RayBatch
    seconds : float
        About so long may one turn of the slowest way take.
    rounds : int
        Each way has so many turns.
    now : callable
        The clock.

    Raises
    ------
    RuntimeError
        If two ways answer differently.
    """

    def timed(name: str, part: RayBatch) -> tuple[Any, float]:
        start = now()
        answer = ways[name](part)
        return answer, now() - start

    # Try a few.
    few = rays.part(TRIAL)
    slowest, n_hits = 1e-6, 0
    for name in ways:
        answer, took = timed(name, few)
        slowest, n_hits = max(slowest, took), count_hits(query, answer)
    del answer
    many = rays.part(max(len(few), int(len(few) * seconds / slowest)))

    # Then in turn. One call asks all rays, but that its lists of hits stay of a size.
    parts = many.slices(int(MAX_HITS / max(1.0, n_hits / len(few)))) if query == "all" else [many]
    best = dict.fromkeys(ways, np.inf)
    n_hits = 0
    for i_round in range(rounds):
        times = dict.fromkeys(ways, 0.0)
        for part in parts:
            first: tuple[str, Any] | None = None
            for name in ways:
                answer, took = timed(name, part)
                times[name] += took
                if i_round > 0:
                    continue
                if first is None:
                    first, n_hits = (name, answer), n_hits + count_hits(query, answer)
                elif not same(first[1], answer):
                    raise RuntimeError(f"{query} hits differ between {first[0]} and {name}")
        best = {name: min(best[name], times[name]) for name in ways}
    return Turns(len(many), n_hits, {name: max(took, 1e-9) for name, took in best.items()})


def way(tree: Tree, query: str, radius: float, n_threads: int, kernel: str = "auto") -> Callable[[RayBatch], Any]:
    """Ask a tree of ours, with so many threads."""

    def ask(rays: RayBatch) -> Any:
        with num_threads(n_threads):
            return ask_tree(tree, query, rays, radius, kernel)

    return ask


def ask_tree(tree: Tree, query: str, rays: RayBatch, radius: float, kernel: str = "auto") -> Any:
    """Ask a tree of ours a query: "first", "any" or "all"."""
    ask: Any = {"first": tree.first_hit, "any": tree.any_hit, "all": tree.all_hits}[query]
    return ask(rays.origins, rays.directions, radius, t_min=rays.t_min, t_max=rays.t_max, kernel=kernel)


def count_hits(query: str, answer: Any) -> int:
    """Count all hits, or the rays that hit."""
    if query == "all":
        return len(answer)
    return int(answer.hit.sum() if query == "first" else answer.sum())
