"""How far builders are from the optimum, on inputs that are small enough to find it.

Trees of three classes are compared with the optimum of their class:

- *same planes*: `theory.build` with only the planes of the oracle. A ratio is at least 1, and any excess is due to the
  search alone.
- *sets*: builders without spatial splits, compared with the best of all classic BVHs. A ratio is at least 1.
- *builders*: the core, which places planes over each node's own box and may have object splits too, compared with the
  best tree over the planes of a fixed grid. It can use planes that the grid lacks, so a ratio may be below 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from fastlines import METHODS, Cost, Limits, ObjectSweep, PlaneEvents, PlaneGrid, Settings, build, theory
from fastlines.scenes import make

from ...harness import machine
from ...harness.arrays import FloatArray
from ...harness.preset import Preset, sized
from ...harness.tables import geometric_mean
from .lattice import grid_optimum
from .oracle import even_planes, optimum, partitions, planes_at

Rng = np.random.Generator

RULES: dict[str, theory.BoxRule] = {"tight": theory.tight, "cut": theory.cut}


def crossing(n: int, rng: Rng) -> FloatArray:
    """Return long segments between random points of a cube."""
    return rng.random((n, 2, 3), np.float32)


def hair(n: int, rng: Rng) -> FloatArray:
    """Return strands of four segments, side by side."""
    steps = np.array([0, 0, 0.25]) + 0.08 * rng.standard_normal((-(-n // 4), 4, 3))
    points = np.concatenate([np.zeros_like(steps[:, :1]), steps], 1).cumsum(1) + 0.3 * rng.random((len(steps), 1, 3))
    return np.stack([points[:, :-1], points[:, 1:]], 2).reshape(-1, 2, 3)[:n].astype(np.float32)


def beams(n: int, rng: Rng) -> FloatArray:
    """Return segments from one point in all directions."""
    ends = rng.standard_normal((n, 3))
    ends *= rng.exponential(0.5, (n, 1)) / np.linalg.norm(ends, axis=1, keepdims=True)
    return np.stack([np.zeros_like(ends), ends], 1).astype(np.float32)


def spaghetti(n: int, rng: Rng) -> FloatArray:
    """Return the thesis's scene of this name with n segments."""
    return make("spaghetti", n, int(rng.integers(1 << 30))).lines.segments


INPUTS: dict[str, Callable[[int, Rng], FloatArray]] = {
    "crossing": crossing,
    "spaghetti": spaghetti,
    "hair": hair,
    "beams": beams,
}

#: Searches over the oracle's planes, as arguments of `theory.build`.
SEARCHES: dict[str, dict[str, Any]] = {
    "1 level (SAH)": {},
    "2 levels": {"lookahead": 2},
    "1, then 2": {"lookahead": [1, 2]},
    "3 levels": {"lookahead": 3},
    "1 bad level": {"bad_levels": 1},
    "2 bad levels": {"bad_levels": 2},
    "3 bad levels": {"bad_levels": 3},
    "3 bad levels, 2 levels": {"bad_levels": 3, "lookahead": 2},
    "all bad levels": {"bad_levels": 64},
}

#: Object splits, which cut no primitive.
SETS: dict[str, theory.Splits] = {"sweep (bvh-cl)": theory.object_sweep, "median": theory.median}

_deep = Settings(splits=(PlaneGrid(16),), bad_levels=3)

#: The core's builders.
BUILDERS: dict[str, Settings] = {
    **METHODS,
    "best, c_trav 2, pruned": replace(METHODS["best"], cost=Cost(2.0), prune=True, limits=Limits()),
    "bad levels": _deep,
    "bad levels, sweep ≤ 8": replace(_deep, splits=(PlaneGrid(16), ObjectSweep(max_refs=8))),
    "bad levels, sweep ≤ 32": replace(_deep, splits=(PlaneGrid(16), ObjectSweep(max_refs=32))),
    "grid and sweep (SBVH)": Settings(splits=(PlaneGrid(16), ObjectSweep())),
    "2 levels": Settings(splits=(PlaneGrid(8),), lookahead=(2,)),
    "kd-events": replace(METHODS["kd-cl"], splits=(PlaneEvents(),)),
    "kd, bad levels": replace(_deep, boxes="cut", cost=Cost(0.6)),
    "kd, 6 bad levels": replace(_deep, boxes="cut", cost=Cost(0.6), bad_levels=6),
    "kd, 2 levels": Settings(splits=(PlaneGrid(12),), boxes="cut", lookahead=(2,), cost=Cost(0.6)),
}


@dataclass(frozen=True, kw_only=True)
class GapPreset(Preset):
    """The sizes of the inputs.

    Attributes
    ----------
    n_seeds : int
        The number of inputs of each kind.
    same_planes, sets, builders : int or (int, int)
        The segments of an input and, except for sets, the planes of the oracle on each axis.
    c_trav : float
        The constant of all but the core's builders, which have their own.
    """

    n_seeds: int = sized(5, 2)
    same_planes: tuple[int, int] = sized((16, 3), (8, 3))
    sets: int = sized(9, 6)
    builders: tuple[int, int] = sized((24, 7), (12, 5))
    c_trav: float = 0.5


@dataclass(frozen=True)
class GapCell:
    """One builder and one input."""

    group: str
    boxes: str
    c_trav: float
    builder: str
    scene: str
    seed: int
    cost: float
    optimum: float

    @property
    def ratio(self) -> float:
        """The cost as a multiple of the optimum."""
        return self.cost / self.optimum


@dataclass(frozen=True)
class Gaps:
    """All cells."""

    machine: dict[str, Any]
    preset: GapPreset
    cells: list[GapCell]

    def groups(self) -> dict[tuple[str, str, float], dict[str, list[GapCell]]]:
        """Return the cells of each builder, for each class, box rule and c_trav."""
        found: dict[tuple[str, str, float], dict[str, list[GapCell]]] = {}
        for cell in self.cells:
            group = found.setdefault((cell.group, cell.boxes, cell.c_trav), {})
            group.setdefault(cell.builder, []).append(cell)
        return found

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        cells = [{**asdict(cell), "ratio": cell.ratio} for cell in self.cells]
        return {
            "format": "fastlines-bench gap 1",
            "machine": self.machine,
            "preset": asdict(self.preset),
            "cells": cells,
        }


def mean_and_worst(cells: list[GapCell]) -> tuple[float, float]:
    """Return the geometric mean and the maximum of the ratios."""
    ratios = [cell.ratio for cell in cells]
    return geometric_mean(ratios) or math.nan, max(ratios)


def run_gap(preset: GapPreset, progress: Callable[[str, float], None] = lambda what, share: None) -> Gaps:
    """Compare all builders with the optimum on all inputs."""
    cells: list[GapCell] = []
    for i, name in enumerate(INPUTS):
        for seed in range(preset.n_seeds):
            progress(f"{name}, input {seed + 1} of {preset.n_seeds}", (i + seed / preset.n_seeds) / len(INPUTS))
            for compare in (_same_planes, _sets, _builders):
                cells += compare(preset, name, seed)
    return Gaps(machine.describe(), preset, cells)


def _segments(name: str, n: int, seed: int) -> FloatArray:
    return INPUTS[name](n, np.random.default_rng([seed, n]))


def _same_planes(preset: GapPreset, name: str, seed: int) -> list[GapCell]:
    n, n_planes = preset.same_planes
    ends = _segments(name, n, seed)
    prims = theory.segments(ends)
    planes = even_planes(theory.hull(prims), n_planes)
    cells = []
    for boxes, rule in RULES.items():
        splits = _cached(planes_at(planes, rule))
        least = theory.f(grid_optimum(ends, planes, rule, preset.c_trav), preset.c_trav)
        for search, given in SEARCHES.items():
            tree = theory.build(prims, splits, c_trav=preset.c_trav, leaf_refs=0, **given)
            cost = theory.f(tree, preset.c_trav)
            cells.append(GapCell("same planes", boxes, preset.c_trav, search, name, seed, cost, least))
    return cells


def _cached(splits: theory.Splits) -> theory.Splits:
    """Return the splits with a cache, because searches return to the same nodes."""
    known = cache(lambda prims, box: [((tuple(lp), lb), (tuple(rp), rb)) for (lp, lb), (rp, rb) in splits(prims, box)])
    return lambda prims, box: known(tuple(prims), box)


def _sets(preset: GapPreset, name: str, seed: int) -> list[GapCell]:
    prims = theory.segments(_segments(name, preset.sets, seed))
    least = theory.f(optimum(prims, partitions, preset.c_trav), preset.c_trav)
    trees = {search: theory.build(prims, splits, c_trav=preset.c_trav) for search, splits in SETS.items()}
    return [
        GapCell("sets", "tight", preset.c_trav, search, name, seed, theory.f(tree, preset.c_trav), least)
        for search, tree in trees.items()
    ]


def _builders(preset: GapPreset, name: str, seed: int) -> list[GapCell]:
    n, n_planes = preset.builders
    ends = _segments(name, n, seed)
    planes = even_planes(theory.hull(theory.segments(ends)), n_planes)

    @cache
    def least(boxes: str, c_trav: float) -> float:
        return theory.f(grid_optimum(ends, planes, RULES[boxes], c_trav), c_trav)

    cells = []
    for builder, given in BUILDERS.items():
        c_trav = given.cost.c_trav / given.cost.c_prim
        tree = build(ends, **_arguments(given))
        cost = tree.cost() / given.cost.c_prim
        cells.append(GapCell("builders", given.boxes, c_trav, builder, name, seed, cost, least(given.boxes, c_trav)))
    return cells


def _arguments(given: Settings) -> dict[str, Any]:
    """Return the arguments of `build`: nodes of one segment may be split, and there are no lanes, as for the oracle."""
    limits: Limits = replace(given.limits, leaf_refs=0)
    names = ("splits", "boxes", "lookahead", "cost", "bad_levels", "prune", "radius_hint")
    return {**{name: getattr(given, name) for name in names}, "limits": limits}
