"""Alternate variants of a query on the same rays: the time sets the number of rays, and answers are compared."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fastlines import Tree

from .compare import same
from .internals import num_threads
from .rays import RayBatch

#: The approximate number of hits that one call lists.
MAX_HITS = 1 << 22

#: The number of rays of the trial, which sets the number of timed rays; the minimum of the latter.
TRIAL = 1 << 14


@dataclass(frozen=True)
class Timings:
    """The times of all variants.

    Attributes
    ----------
    n_hits : int
        The number of hits of all rays; of rays that hit, for first and any.
    seconds : dict of str to float
        The least seconds of a round, for each variant.
    """

    n_rays: int
    n_hits: int
    seconds: dict[str, float]


def alternate(
    variants: Mapping[str, Callable[[RayBatch], Any]],
    query: str,
    rays: RayBatch,
    seconds: float,
    rounds: int,
    now: Callable[[], float],
) -> Timings:
    """Alternate variants on as many of the rays as there is time for; return the numbers of rays and hits, and times.

    Parameters
    ----------
    variants : dict of str to callable
        Functions that answer a batch of rays. Their names appear in the result and in the error.
    query : str
        "first", "any" or "all".
    rays : RayBatch
    seconds : float
        The approximate time of the slowest variant in one round.
    rounds : int
        The number of rounds, in each of which all variants run once.
    now : callable
        The clock.

    Raises
    ------
    RuntimeError
        If two variants answer differently.
    """

    def timed(name: str, part: RayBatch) -> tuple[Any, float]:
        start = now()
        answer = variants[name](part)
        return answer, now() - start

    # Time a trial.
    few = rays.part(TRIAL)
    slowest, n_hits = 1e-6, 0
    for name in variants:
        answer, took = timed(name, few)
        slowest, n_hits = max(slowest, took), count_hits(query, answer)
    del answer
    many = rays.part(max(len(few), int(len(few) * seconds / slowest)))

    # Alternate. One call traces all rays, unless its lists of hits would be too long.
    parts = many.slices(int(MAX_HITS / max(1.0, n_hits / len(few)))) if query == "all" else [many]
    best = dict.fromkeys(variants, np.inf)
    n_hits = 0
    for i_round in range(rounds):
        times = dict.fromkeys(variants, 0.0)
        for part in parts:
            first: tuple[str, Any] | None = None
            for name in variants:
                answer, took = timed(name, part)
                times[name] += took
                if i_round > 0:
                    continue
                if first is None:
                    first, n_hits = (name, answer), n_hits + count_hits(query, answer)
                elif not same(first[1], answer):
                    raise RuntimeError(f"{query} hits differ between {first[0]} and {name}")
        best = {name: min(best[name], times[name]) for name in variants}
    return Timings(len(many), n_hits, {name: max(took, 1e-9) for name, took in best.items()})


def query_function(
    tree: Tree, query: str, radius: float, n_threads: int, kernel: str = "auto"
) -> Callable[[RayBatch], Any]:
    """Return a function that runs a query of our tree on a batch of rays, with `n_threads` threads."""

    def answer(rays: RayBatch) -> Any:
        with num_threads(n_threads):
            return query_tree(tree, query, rays, radius, kernel)

    return answer


def query_tree(tree: Tree, query: str, rays: RayBatch, radius: float, kernel: str = "auto", at: str = "closest") -> Any:
    """Return the answer of our tree to a query: "first", "any" or "all"."""
    method: Any = {"first": tree.first_hit, "any": tree.any_hit, "all": tree.all_hits}[query]
    more = {} if query == "any" else {"at": at}
    return method(rays.origins, rays.directions, radius, t_min=rays.t_min, t_max=rays.t_max, kernel=kernel, **more)


def count_hits(query: str, answer: Any) -> int:
    """Return the number of hits for "all", and of rays that hit for other queries."""
    if query == "all":
        return len(answer)
    return int(answer.hit.sum() if query == "first" else answer.sum())
