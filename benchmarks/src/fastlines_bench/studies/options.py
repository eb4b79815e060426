"""The gains and costs of options of the builder: the tables of docs/builder.md.

Costs have c_trav = 2 and c_prim = 1. Times are on one thread, as multiples of that of the build without the option.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import fastlines as fl

from ..engine.steps import count_steps
from ..harness.clock import clock
from ..harness.internals import REF_LIMIT, best_settings, num_threads
from ..harness.rays import random_rays

DEEP = {"method": "best", "cost": fl.Cost(2.0), "prune": True, "radius_hint": 0.0}
REINSERTED: list[tuple[str, str, dict[str, Any]]] = [
    ("spaghetti", "bvh-cl", {"method": "bvh-cl"}),
    ("spaghetti", "bvh-d2", {"method": "bvh-d2"}),
    ("spaghetti", "best, c_trav 2, pruned, no hint", DEEP),
    ("bun-hair", "bvh-cl", {"method": "bvh-cl"}),
    ("bun-hair", "median", {"splits": fl.Median(), "limits": fl.Limits(max_leaf_refs=8)}),
    ("straight-hair", "bvh-cl", {"method": "bvh-cl"}),
]
ROUNDS = (1, 2, 5, 50)
PRESPLIT: dict[str, Any] = {
    "none": None,
    "refs=2": fl.Presplit(refs=2),
    "refs=8": fl.Presplit(refs=8),
    "refs=32": fl.Presplit(refs=32),
    "area=1e-3": fl.Presplit(area=1e-3),
    "area=1e-4": fl.Presplit(area=1e-4),
    "area=1e-5": fl.Presplit(area=1e-5),
    "automatic": fl.Presplit(),
}
OVERLAPS = (0.0, 1e-5, 1e-3)
LANES = (1, 16)
APART = (0, 512, 1024, 8192, REF_LIMIT)


def timed(scene: str, **given: Any) -> tuple[fl.Tree, float]:
    """Build a tree repeatedly for a second; return it and the least processor time of a build."""
    lines, now = fl.scenes.make(scene).lines, clock(1)
    times: list[float] = []
    while sum(times) < 1:
        start = now()
        tree = fl.build(lines, **given)
        times.append(now() - start)
    return tree, min(times)


def whole() -> Iterator[list[str]]:
    """Yield the rows of `best` with whole splits in nodes of up to `gap_refs` references."""
    yield ["scene", "gap_refs", "references a line", "time"]
    (octets,) = best_settings().splits
    assert isinstance(octets, fl.BinnedPlanes)
    for scene in ("bun-hair", "straight-hair", "spaghetti"):
        first = None
        for n_refs in APART:
            tree, seconds = timed(scene, method="best", splits=replace(octets, gap_refs=n_refs))
            first = first or seconds
            bound = "no bound" if n_refs == REF_LIMIT else f"{n_refs:,}"
            yield [scene, bound, f"{tree.n_refs / tree.n_prims:.2f}", f"{seconds / first:.2f}"]


def lanes() -> Iterator[list[str]]:
    """Yield the rows of `best` with and without lanes: references per leaf, and leaves that a random ray visits."""
    yield ["scene", "lanes", "references a leaf", "layout, MB", "leaves, all hits", "first hit"]
    for scene in ("bun-hair", "straight-hair", "spaghetti", "spaghetti-2", "photon-beams"):
        lines = fl.scenes.make(scene).lines
        rays = random_rays(lines, 1 << 14)
        for n_lanes in LANES:
            tree = fl.build(lines, "best", lanes=n_lanes)
            in_leaf, size = tree.nodes["n_refs"][tree.is_leaf].mean(), tree.layout.n_bytes / 1e6
            visited = [count_steps(tree, query, rays, 0.001)[0]["leaves"] for query in ("all", "first")]
            yield [scene, f"{n_lanes}", f"{in_leaf:.1f}", f"{size:.2f}", *(f"{n:.1f}" for n in visited)]


def reinsertion() -> Iterator[list[str]]:
    """Yield the rows of costs after rounds of reinsertion."""
    yield [
        "scene",
        "tree",
        "cost",
        *(f"{n} rounds" for n in ROUNDS),
        f"gain of {ROUNDS[-1]}",
        f"time of {ROUNDS[-1]}, in builds",
    ]
    for scene, name, given in REINSERTED:
        tree, seconds = timed(scene, **given)
        after = [timed(scene, reinsertion=n, **given) for n in ROUNDS]
        last, longest = after[-1]
        last.validate()
        gain = f"{100 * (1 - last.cost() / tree.cost()):.1f} %"
        costs = [f"{one.cost():.2f}" for one in (tree, *(moved for moved, _ in after))]
        yield [scene, name, *costs, gain, f"{longest / seconds - 1:.1f}"]


def presplit() -> Iterator[list[str]]:
    """Yield the rows of references and costs with presplits."""
    yield ["scene", "presplit", "references a line", "cost of bvh-cl", "time"]
    for scene in ("spaghetti", "bun-hair", "straight-hair"):
        _, seconds = timed(scene, method="bvh-cl")
        for name, bound in PRESPLIT.items():
            tree, longer = timed(scene, method="bvh-cl", presplit=bound)
            yield [scene, name, f"{tree.n_refs / tree.n_prims:.1f}", f"{tree.cost():.1f}", f"{longer / seconds:.0f}"]


def sbvh() -> Iterator[list[str]]:
    """Yield the rows of trees with object and spatial splits."""
    yield ["scene", "min_overlap", "references a line", "cost", "time"]
    for scene in ("spaghetti", "bun-hair", "straight-hair"):
        first = None
        for share in OVERLAPS:
            tree, seconds = timed(scene, splits=(fl.ObjectSweep(), fl.PlaneGrid(16, min_overlap=share)))
            first = first or seconds
            n_refs = f"{tree.n_refs / tree.n_prims:.2f}"
            yield [scene, f"{share:g}", n_refs, f"{tree.cost():.2f}", f"{seconds / first:.2f}"]


TABLES = {"whole": whole, "lanes": lanes, "reinsertion": reinsertion, "presplit": presplit, "sbvh": sbvh}


def print_options(tables: tuple[str, ...] = tuple(TABLES)) -> None:
    """Print some of `TABLES` as Markdown."""
    with num_threads(1):
        for name in tables:
            for i, row in enumerate(TABLES[name]()):
                print(f"| {' | '.join(row)} |", flush=True)
                if i == 0:
                    print("|---" * len(row) + "|")
            print()
