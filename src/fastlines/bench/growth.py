"""What a ray costs as the scene grows, and whether threads help: the public calls, wall clock, thread counts in turn.

The cost of a ray is fitted as c · n^b, with n the number of segments: least squares over the logarithms of both.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..builder import build
from ..demo.machine import describe_machine, load
from ..scenes import RADII, make
from .alternate import alternate, way
from .rays import QUESTIONS, camera_rays, random_rays


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Parameters
    ----------
    scenes : tuple of str
        Names of `fastlines.scenes`.
    sizes : tuple of int
        How many segments each of them has, in turn.
    threads : tuple of int
        How many threads the queries use, in turn.
    radius : float
        The same at all sizes; a scene keeps its extent, about 1, as it grows.
    n_rays : int
        At most so many rays, or a few more.
    rounds : int
        The thread counts take turns so often; the best time of each counts.
    seconds : float
        About so long may one turn of the slowest take; fewer rays are asked if all would take longer.
    """

    scenes: tuple[str, ...] = ("spaghetti", "bun-hair")
    sizes: tuple[int, ...] = (10_000, 30_000, 100_000)
    threads: tuple[int, ...] = (1, 2)
    radius: float = RADII["M"]
    n_rays: int = 1 << 18
    rounds: int = 3
    seconds: float = 0.4


#: Ends in some seconds.
QUICK = Plan(sizes=(1_000, 10_000), n_rays=1 << 15, rounds=5, seconds=0.1)


@dataclass(frozen=True)
class Size:
    """A scene of one size, and our tree over it.

    Attributes
    ----------
    bytes : int
        Of the layout and the segments.
    build_s, layout_s : float
        How long it took to build the tree, and to lay it out for queries.
    limits_hit : dict of str to int
        As `Tree.limits_hit` has it.
    """

    scene: str
    n_segments: int
    method: str
    n_refs: int
    bytes: int
    build_s: float
    layout_s: float
    limits_hit: dict[str, int]


@dataclass(frozen=True)
class Cell:
    """One kind of rays and query, on a scene of one size.

    Attributes
    ----------
    n_hits : int
        Of all rays; of a first hit, how many rays hit.
    seconds : tuple of float
        The best of all rounds, with each of the thread counts.
    """

    scene: str
    n_segments: int
    kind: str
    query: str
    n_rays: int
    n_hits: int
    seconds: tuple[float, ...]

    @property
    def mrays(self) -> list[float]:
        """Millions of rays a second, with each of the thread counts."""
        return [self.n_rays / seconds / 1e6 for seconds in self.seconds]

    @property
    def ns(self) -> list[float]:
        """What a ray costs in nanoseconds, with each of the thread counts."""
        return [seconds / self.n_rays * 1e9 for seconds in self.seconds]

    @property
    def speedup(self) -> float:
        """How many times faster the last thread count is than the first."""
        return self.seconds[0] / self.seconds[-1]

    @property
    def hits(self) -> float:
        """Mean hits a ray."""
        return self.n_hits / self.n_rays

    def to_json(self) -> dict[str, Any]:
        """Everything."""
        figures = {"mrays": self.mrays, "ns_per_ray": self.ns, "speedup": self.speedup, "hits_per_ray": self.hits}
        return {**asdict(self), **figures}


@dataclass(frozen=True)
class Fit:
    """How a kind of rays and query grows on a scene.

    Attributes
    ----------
    cost : list of float
        The exponent of the cost of a ray, with each of the thread counts.
    hits : float or None
        That of the mean hits a ray; None where there are none.
    """

    scene: str
    kind: str
    query: str
    cost: list[float]
    hits: float | None


@dataclass(frozen=True)
class Growth:
    """All that was measured."""

    machine: dict[str, Any]
    plan: Plan
    sizes: list[Size]
    cells: list[Cell]
    seconds: float

    def groups(self) -> dict[tuple[str, str, str], list[Cell]]:
        """The cells of each scene, kind of rays and query: one for each size."""
        found: dict[tuple[str, str, str], list[Cell]] = {}
        for cell in self.cells:
            found.setdefault((cell.scene, cell.kind, cell.query), []).append(cell)
        return found

    def fits(self) -> list[Fit]:
        """The exponents of all groups; none if there is one size only."""
        if len(self.plan.sizes) < 2:
            return []
        found = []
        for names, cells in self.groups().items():
            sizes = [cell.n_segments for cell in cells]
            hits = [cell.hits for cell in cells]
            cost = [exponent(sizes, costs) for costs in zip(*(cell.ns for cell in cells), strict=True)]
            found.append(Fit(*names, cost, exponent(sizes, hits) if min(hits) > 0 else None))
        return found

    def to_json(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "format": "fastlines bench growth 1",
            "machine": self.machine,
            "plan": asdict(self.plan),
            "seconds": self.seconds,
            "sizes": [asdict(size) for size in self.sizes],
            "cells": [cell.to_json() for cell in self.cells],
            "exponents": [asdict(fit) for fit in self.fits()],
        }


def exponent(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Fit b of values ~ sizes^b, from two sizes or more.

    Examples
    --------
    >>> round(exponent([1, 10, 100], [5, 50, 500]), 6)
    1.0
    """
    x, y = np.log(sizes), np.log(values)
    x = x - x.mean()
    return float(x @ y / (x @ x))


def run_growth(plan: Plan, progress: Callable[[str, float], None] = lambda what, share: None) -> Growth:
    """Measure all scenes at all sizes.

    Parameters
    ----------
    plan : Plan
    progress : callable
        Called with what is being done, and which share of all is done.
    """
    start = time.perf_counter()
    machine = {**describe_machine(), "load": load()}
    n_cells = len(plan.scenes) * len(plan.sizes) * len(QUESTIONS)
    sizes: list[Size] = []
    cells: list[Cell] = []
    for name in plan.scenes:
        for n_segments in plan.sizes:
            what = f"{name}, {n_segments:,} segments"
            progress(f"{what}: building", len(cells) / n_cells)
            scene = make(name, n_segments)
            begin = time.perf_counter()
            tree = build(scene.lines)
            built = time.perf_counter()
            layout = tree.layout
            laid = time.perf_counter()
            took = built - begin, laid - built
            n_refs = len(layout.refs)
            sizes.append(Size(name, n_segments, tree.method, n_refs, layout.n_bytes, *took, dict(tree.limits_hit)))
            rays = {
                "camera": camera_rays(scene.camera, plan.n_rays),
                "random": random_rays(scene.lines, plan.n_rays),
            }
            for kind, query in QUESTIONS:
                progress(f"{what}: {kind} rays, {query}", len(cells) / n_cells)
                ways = {f"{n} thread{'s' if n > 1 else ''}": way(tree, query, plan.radius, n) for n in plan.threads}
                turns = alternate(ways, query, rays[kind], plan.seconds, plan.rounds, time.perf_counter)
                seconds = tuple(turns.seconds.values())
                cells.append(Cell(name, n_segments, kind, query, turns.n_rays, turns.n_hits, seconds))
    return Growth(machine, plan, sizes, cells, time.perf_counter() - start)
