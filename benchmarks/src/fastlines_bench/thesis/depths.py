"""The table of thesis §4.3: the gain and the cost of lookahead.

100 cylinders of length 1 in a cube of side 4; a KD tree with 16 planes on each axis, c_prim = 1 and c_trav = 1.2. The
thesis does not specify the scene further. Here each cylinder has a uniform start and an isotropic direction, and lies
wholly inside the cube: those that stick out are drawn again.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import numpy.typing as npt

from fastlines import BinnedPlanes, Cost, PlaneGrid, Tree, build

SIDE, LENGTH, N_CYLINDERS = 4.0, 1.0, 100
C_TRAV = 1.2
#: Depth, cost and milliseconds of the thesis.
THESIS_DEPTHS = {0: (100.0, 0.1), 1: (13.0, 2.0), 2: (12.7, 102.0), 3: (12.5, 8993.0)}


def cylinders(seed: int) -> npt.NDArray[np.float64]:
    """Return the axes of the cylinders, (100, 2, 3)."""
    rng = np.random.default_rng(seed)
    found = np.empty((0, 2, 3))
    while len(found) < N_CYLINDERS:
        start = rng.uniform(0, SIDE, (N_CYLINDERS, 3))
        step = rng.normal(size=(N_CYLINDERS, 3))
        ends = np.stack([start, start + LENGTH * step / np.linalg.norm(step, axis=1, keepdims=True)], axis=1)
        inside = ((ends >= 0) & (ends <= SIDE)).all(axis=(1, 2))
        found = np.concatenate([found, ends[inside]])
    return found[:N_CYLINDERS]


def build_ahead(axes: npt.NDArray[np.float64], depth: int, c_trav: float = C_TRAV, search: str = "bounded") -> Tree:
    """Return the tree of a row of the table.

    The search uses branch and bound ("bounded"), evaluates all candidates ("exhaustive"), or counts planes eight at a
    time ("octets").
    """
    splits = BinnedPlanes(16) if search == "octets" else PlaneGrid(16)
    everything = search == "exhaustive" and depth > 1
    cost = Cost(c_trav=c_trav, c_prim=1.0)
    return build(axes, splits=splits, boxes="cut", lookahead=depth, cost=cost, exhaustive=everything)


def time_depth(
    depth: int, seed: int = 0, c_trav: float = C_TRAV, repeats: int = 20, patience: float = 1.0
) -> dict[str, Any]:
    """Return a row of the table: alternate the builds of its trees for `patience` seconds, and take the least times."""
    axes = cylinders(seed)
    times: dict[str, list[float]] = {search: [] for search in ("bounded", "exhaustive", "octets")}
    trees: dict[str, Tree] = {}
    while not trees or (len(times["bounded"]) < repeats and sum(times["exhaustive"]) < patience):
        for search, taken in times.items():
            start = time.process_time()
            trees[search] = build_ahead(axes, depth, c_trav, search)
            taken.append(time.process_time() - start)
    for tree in trees.values():
        tree.validate()
    tree, exhaustive = trees["bounded"], trees["exhaustive"]
    if tree.nodes.tobytes() != exhaustive.nodes.tobytes() or tree.refs.tobytes() != exhaustive.refs.tobytes():
        raise AssertionError("branch and bound made another tree than exhaustive search")
    return {
        "depth": depth,
        "cost": tree.cost(),
        "n_nodes": tree.n_nodes,
        "build_ms": 1e3 * min(times["bounded"]),
        "carried_out": tree.searched.get("carried_out", 0),
        "exhaustive_ms": 1e3 * min(times["exhaustive"]),
        "exhaustive_carried_out": exhaustive.searched.get("carried_out", 0),
        "octets_ms": 1e3 * min(times["octets"]),
    }
