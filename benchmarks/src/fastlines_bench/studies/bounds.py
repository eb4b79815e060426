"""The costs of trees relative to a lower bound for all trees, on the thesis's five scenes.

The trees have three bad levels and 16 planes per axis (BVHs also object splits of up to 8 references), and are pruned.
c_trav is 2.0 for BVHs and 0.6 for KD trees. The bound is `optimum.lower_bound`, proved in docs/theory.md. "whole"
compares `bvh-cl` with the bound for trees that cut nothing.
"""

from __future__ import annotations

from typing import Any

import fastlines as fl

from ..harness.clock import best_of
from . import optimum

SPLITS = (fl.PlaneGrid(16), fl.ObjectSweep(max_refs=8))
TREES: dict[str, tuple[fl.Settings, bool]] = {
    "BVH": (fl.Settings(SPLITS, bad_levels=3), False),
    "KD": (fl.Settings((fl.PlaneGrid(16),), "cut", bad_levels=3, cost=fl.Cost(0.6)), False),
    "whole": (fl.METHODS["bvh-cl"], True),
}


def compare_with_bounds(segments: int | None = None) -> list[dict[str, Any]]:
    """Print the table, line by line, and return its rows; `segments` replaces the size of all scenes."""
    rows: list[dict[str, Any]] = []
    print(f"{'scene':14} {'tree':5} {'cost':>9} {'bound':>9} {'cost/bound':>11} {'bound s':>8}")
    for name in fl.scenes.NAMES:
        lines = fl.scenes.make(name, segments).lines
        for kind, (settings, whole) in TREES.items():
            names = ("splits", "boxes", "lookahead", "cost", "limits", "bad_levels", "prune")
            tree = fl.build(lines, **{name: getattr(settings, name) for name in names})
            seconds, bound = best_of(
                1,
                1,
                lambda lines=lines, c=settings.cost.c_trav, w=whole: optimum.lower_bound(lines, c, whole=w),  # type: ignore[misc]
            )
            rows.append({"scene": name, "tree": kind, "cost": tree.cost(), "bound": bound, "s": seconds})
            ratio = tree.cost() / bound
            print(f"{name:14} {kind:5} {tree.cost():9.1f} {bound:9.1f} {ratio:11.2f} {seconds:8.1f}", flush=True)
    return rows
