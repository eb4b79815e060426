"""The cost of a ray as the scene grows, and the speed-up by threads.

Public calls are timed by the wall clock, with alternated thread counts. The cost of a ray is fitted as c · n^b, with n
the number of segments, by least squares over the logarithms of both.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fastlines import build
from fastlines.scenes import RADII, make

from ...harness import machine
from ...harness.preset import TimedPreset, sized
from ...harness.rays import QUESTIONS, camera_rays, random_rays
from ...harness.turns import alternate, query_function


@dataclass(frozen=True, kw_only=True)
class GrowthPreset(TimedPreset):
    """How much to measure.

    Parameters
    ----------
    scenes : tuple of str
        Names of `fastlines.scenes`.
    sizes : tuple of int
        The numbers of segments of each scene.
    threads : tuple of int
        The numbers of threads of the queries, which are alternated.
    radius : float
        The radius for all sizes; a scene keeps its extent, about 1, as it grows.
    """

    n_rays: int = sized(1 << 18, 1 << 15)
    rounds: int = sized(3, 5)
    seconds: float = sized(0.4, 0.1)
    scenes: tuple[str, ...] = ("spaghetti", "bun-hair")
    sizes: tuple[int, ...] = sized((10_000, 30_000, 100_000), (1_000, 10_000))
    threads: tuple[int, ...] = (1, 2)
    radius: float = RADII["M"]


@dataclass(frozen=True)
class Size:
    """A scene of one size, and our tree over it.

    Attributes
    ----------
    bytes : int
        The size of the layout and the segments.
    build_s, layout_s : float
        The seconds of the build and of the layout.
    limits_hit : dict of str to int
        A copy of `Tree.limits_hit`.
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
class GrowthCell:
    """The times of a kind of rays and a query, on a scene of one size.

    Attributes
    ----------
    n_hits : int
        The number of hits of all rays; of rays that hit, for first.
    seconds : tuple of float
        The least seconds of a round, for each thread count.
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
        """Millions of rays per second, for each thread count."""
        return [self.n_rays / seconds / 1e6 for seconds in self.seconds]

    @property
    def ns(self) -> list[float]:
        """Nanoseconds per ray, for each thread count."""
        return [seconds / self.n_rays * 1e9 for seconds in self.seconds]

    @property
    def speedup(self) -> float:
        """The speed-up of the last thread count over the first."""
        return self.seconds[0] / self.seconds[-1]

    @property
    def hits(self) -> float:
        """Mean hits per ray."""
        return self.n_hits / self.n_rays

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        figures = {"mrays": self.mrays, "ns_per_ray": self.ns, "speedup": self.speedup, "hits_per_ray": self.hits}
        return {**asdict(self), **figures}


@dataclass(frozen=True)
class Exponents:
    """The exponents of a kind of rays and a query on a scene.

    Attributes
    ----------
    cost : list of float
        The exponent of the cost of a ray, for each thread count.
    hits : float or None
        The exponent of the mean hits per ray; None if a size has no hits.
    """

    scene: str
    kind: str
    query: str
    cost: list[float]
    hits: float | None


@dataclass(frozen=True)
class Growth:
    """All sizes, and all cells."""

    machine: dict[str, Any]
    preset: GrowthPreset
    sizes: list[Size]
    cells: list[GrowthCell]
    seconds: float

    def groups(self) -> dict[tuple[str, str, str], list[GrowthCell]]:
        """Return the cells of each scene, kind of rays and query: one for each size."""
        found: dict[tuple[str, str, str], list[GrowthCell]] = {}
        for cell in self.cells:
            found.setdefault((cell.scene, cell.kind, cell.query), []).append(cell)
        return found

    def exponents(self) -> list[Exponents]:
        """Return the exponents of all groups; an empty list if there is only one size."""
        if len(self.preset.sizes) < 2:
            return []
        found = []
        for names, cells in self.groups().items():
            sizes = [cell.n_segments for cell in cells]
            hits = [cell.hits for cell in cells]
            cost = [exponent(sizes, costs) for costs in zip(*(cell.ns for cell in cells), strict=True)]
            found.append(Exponents(*names, cost, exponent(sizes, hits) if min(hits) > 0 else None))
        return found

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {
            "format": "fastlines-bench growth 1",
            "machine": self.machine,
            "preset": asdict(self.preset),
            "seconds": self.seconds,
            "sizes": [asdict(size) for size in self.sizes],
            "cells": [cell.to_json() for cell in self.cells],
            "exponents": [asdict(fit) for fit in self.exponents()],
        }


def exponent(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Return the exponent b of values ~ sizes^b, fitted to two sizes or more.

    Examples
    --------
    >>> round(exponent([1, 10, 100], [5, 50, 500]), 6)
    1.0
    """
    x, y = np.log(sizes), np.log(values)
    x = x - x.mean()
    return float(x @ y / (x @ x))


def run_growth(preset: GrowthPreset, progress: Callable[[str, float], None] = lambda what, share: None) -> Growth:
    """Measure all scenes at all sizes.

    Parameters
    ----------
    preset : GrowthPreset
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    start = time.perf_counter()
    where = machine.describe()
    n_cells = len(preset.scenes) * len(preset.sizes) * len(QUESTIONS)
    sizes: list[Size] = []
    cells: list[GrowthCell] = []
    for name in preset.scenes:
        for n_segments in preset.sizes:
            what = f"{name}, {n_segments:,} segments"
            progress(f"{what}: building", len(cells) / n_cells)
            scene = make(name, n_segments)
            begin = time.perf_counter()
            tree = build(scene.lines)
            built = time.perf_counter()
            layout = tree.layout
            end = time.perf_counter()
            took = built - begin, end - built
            n_refs = len(layout.refs)
            sizes.append(Size(name, n_segments, tree.method, n_refs, layout.n_bytes, *took, dict(tree.limits_hit)))
            rays = {
                "camera": camera_rays(scene.camera, preset.n_rays),
                "random": random_rays(scene.lines, preset.n_rays),
            }
            for kind, query in QUESTIONS:
                progress(f"{what}: {kind} rays, {query}", len(cells) / n_cells)
                variants = {
                    f"{n} thread{'s' if n > 1 else ''}": query_function(tree, query, preset.radius, n)
                    for n in preset.threads
                }
                timings = alternate(variants, query, rays[kind], preset.seconds, preset.rounds, time.perf_counter)
                seconds = tuple(timings.seconds.values())
                cells.append(GrowthCell(name, n_segments, kind, query, timings.n_rays, timings.n_hits, seconds))
    return Growth(where, preset, sizes, cells, time.perf_counter() - start)
