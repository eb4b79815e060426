"""How far trees are from a bound that no tree can undercut, on the thesis's five scenes.

    python benchmarks/lower_bounds.py --json lower_bounds.json

The trees go through three bad levels with 16 planes an axis (BVHs also divide sets of up to 8) and are pruned; c_trav
is 2.0 for BVHs and 0.6 for KD trees. The bound is `fastlines.theory.lower_bound`, proved in docs/theory.md; "whole" is
the one for trees that cut nothing, beside `bvh-cl`.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import fastlines as fl

SPLITS = (fl.PlaneGrid(16), fl.ObjectSweep(max_refs=8))
TREES: dict[str, tuple[fl.Settings, bool]] = {
    "BVH": (fl.Settings(SPLITS, bad_levels=3), False),
    "KD": (fl.Settings((fl.PlaneGrid(16),), "cut", bad_levels=3, cost=fl.Cost(0.6)), False),
    "whole": (fl.METHODS["bvh-cl"], True),
}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="write the figures")
    parser.add_argument("--segments", type=int, help="of each scene, instead of the thesis's number")
    given = parser.parse_args()
    rows = []
    print(f"{'scene':14} {'tree':5} {'cost':>9} {'bound':>9} {'cost/bound':>11} {'bound s':>8}")
    for name in fl.scenes.NAMES:
        lines = fl.scenes.make(name, given.segments).lines
        for kind, (settings, whole) in TREES.items():
            names = ("splits", "boxes", "lookahead", "cost", "limits", "bad_levels", "prune")
            tree = fl.build(lines, **{name: getattr(settings, name) for name in names})
            start = time.perf_counter()
            bound = fl.theory.lower_bound(lines, settings.cost.c_trav, whole=whole)
            row = {"scene": name, "tree": kind, "cost": tree.cost(), "bound": bound, "s": time.perf_counter() - start}
            rows.append(row)
            ratio = row["cost"] / bound
            print(f"{name:14} {kind:5} {row['cost']:9.1f} {bound:9.1f} {ratio:11.2f} {row['s']:8.1f}", flush=True)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
