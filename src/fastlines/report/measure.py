"""Trees over the same lines, side by side: built, validated, asked, and their answers compared bit for bit."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

import fastlines as fl

from ..scenes import RADII

#: One cost model for all trees of a kind, by the boxes of their settings (thesis §3.3).
COSTS = {"tight": fl.Cost(2.0), "cut": fl.Cost(0.6)}

#: The queries that are timed: first and all hits, with each of the thesis's radii.
QUERIES = tuple((query, letter) for query in ("first", "all") for letter in RADII)

#: Answers to a picture of up to so many pixels are compared, fewer where a tree tests many segments for a ray.
COMPARED, TESTS = 64, 4e7

#: About so many hits are listed at a time.
MAX_HITS = 1 << 22


class _OverLimitError(Exception):
    """Ends a build that takes too long."""


@dataclass(frozen=True)
class TreeFigures:
    """One tree over some lines.

    Attributes
    ----------
    build_s : float
        Seconds to build the tree and to lay it out for queries.
    cost : float
        With the cost model of its kind, `COSTS`.
    bytes : int
        Of what queries run on, with the segments.
    mrays : dict of str to float
        Millions of rays a second, by query: "first W" and so on.
    as_built : dict of str to float
        Likewise, at the radius M, one ray at a time through the binary tree.
    n_compared : int
        How many answers are those of the tree that it was compared with.
    over_s : float or None
        The limit that the build did not end within; then nothing else is known.
    """

    method: str
    build_s: float = 0.0
    n_refs: int = 0
    n_nodes: int = 0
    depth: int = 0
    cost: float = 0.0
    bytes: int = 0
    mrays: dict[str, float] = field(default_factory=dict)
    as_built: dict[str, float] = field(default_factory=dict)
    n_compared: int = 0
    over_s: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return asdict(self)


def build_within(lines: fl.Lines, method: str, limit: float) -> tuple[fl.Tree | None, float]:
    """Build a tree with its layout, and validate it; None if that takes more than the limit.

    Returns
    -------
    tree : Tree or None
    seconds : float
    """
    start = time.perf_counter()

    def watch(share: float) -> None:
        if time.perf_counter() - start > limit:
            raise _OverLimitError

    try:
        tree = fl.build(lines, method, progress=watch)
    except _OverLimitError:
        return None, limit
    tree.layout  # noqa: B018
    seconds = time.perf_counter() - start
    tree.validate()
    return tree, seconds


def measure_tree(
    tree: fl.Tree,
    build_s: float,
    camera: fl.Camera,
    radii: dict[str, float],
    reference: fl.Tree,
    size: int,
    budget: float,
) -> TreeFigures:
    """Compare the answers of a tree with those of a reference, then time it.

    Parameters
    ----------
    radii : dict of str to float
        By the letters of `RADII`.
    size : int
        Rays are those of a square picture of up to so many pixels a side.
    budget : float
        Seconds for one figure; the picture is smaller where it would take longer.

    Raises
    ------
    FastlinesError
        If an answer differs.
    """
    stats = tree.stats()
    cost = tree.cost(model=COSTS[tree.settings.boxes])
    n_compared = 0
    for kernel in ("auto", "binary"):
        n_compared += compare(
            tree, reference, camera, radii["M"], kernel, int(np.clip((TESTS / cost) ** 0.5, 4, COMPARED))
        )

    def rate(query: str, letter: str, kernel: str) -> float:
        return time_rays(lambda rays: ask(tree, query, rays, radii[letter], kernel), camera, size, budget)

    return TreeFigures(
        tree.method,
        build_s,
        tree.n_refs,
        tree.n_nodes,
        stats["depth"],
        cost,
        int(tree.layout.n_bytes),
        {f"{query} {letter}": rate(query, letter, "auto") for query, letter in QUERIES},
        {query: rate(query, "M", "binary") for query in ("first", "all")},
        n_compared,
    )


def ask(tree: fl.Tree, query: str, rays: tuple[Any, Any], radius: float, kernel: str) -> Any:
    """Ask for first or all hits."""
    return (tree.first_hit if query == "first" else tree.all_hits)(*rays, radius, kernel=kernel)


def compare(tree: fl.Tree, reference: fl.Tree, camera: fl.Camera, radius: float, kernel: str, size: int) -> int:
    """Refuse a tree whose answers are not those of the reference, bit for bit; return how many were compared."""
    rays = camera.rays(size, size)
    for query in ("first", "all"):
        mine, expected = ask(tree, query, rays, radius, kernel), ask(reference, query, rays, radius, "auto")
        for name in ("offsets", "t", "prim", "u", "distance"):
            if hasattr(mine, name) and not np.array_equal(getattr(mine, name), getattr(expected, name)):
                raise fl.FastlinesError(
                    f"{tree.method} and {reference.method} answer {query} hits differently ({name}); this is a bug in "
                    "fastlines, please report it"
                )
    return 2 * size * size


def time_rays(asked: Callable[[tuple[Any, Any]], Any], camera: fl.Camera, size: int, budget: float) -> float:
    """Time the rays of as large a picture as there is time for; return millions of rays a second, the best of three."""
    pixels, best = min(size, 8), 0.0
    while True:
        rays = camera.rays(pixels, pixels)
        seconds, n_hits = float("inf"), 0
        for _ in range(3):
            start = time.perf_counter()
            found = asked(rays)
            seconds = min(seconds, time.perf_counter() - start)
            n_hits = len(found) if isinstance(found, fl.AllHits) else 0
            if seconds > budget / 2:
                break
        best = pixels * pixels / max(seconds, 1e-9) / 1e6
        # Four times the rays take about four times as long.
        if pixels >= size or 4 * seconds > budget or 4 * n_hits > MAX_HITS:
            return best
        pixels = min(size, 2 * pixels)
