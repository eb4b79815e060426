"""The steps of a search through the tree as it was built: counted on rays, or reckoned from areas.

A step down is a visit of an inner node and costs c_trav; a test is that of a reference and costs c_prim (thesis §3.3).
Areas say how many of both a random line makes, if lines that meet the root's box meet a child's with the chance
SA(child)/SA(root).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fastlines import Cost, Tree

from ..package import Layout
from .arrays import IntArray
from .rays import RayBatch

#: A node of the wide layout (layout/wide_bvh.hpp). Planes: low x, y, z, then high x, y, z, of its 16 children each.
WIDE_NODE = np.dtype(
    [
        ("org", "<f4", 3),
        ("scale", "<f4"),
        ("first_inner", "<u4"),
        ("first_leaf", "<u4"),
        ("n_inner", "u1"),
        ("n_children", "u1"),
        ("unused", "u1", 6),
        ("planes", "u1", (2, 3, 16)),
    ]
)


@dataclass(frozen=True)
class Visits:
    """Steps of a query, on average: inner nodes, and tests of references."""

    inner: float
    tests: float

    def cost(self, model: Cost) -> float:
        """What they cost."""
        return model.c_trav * self.inner + model.c_prim * self.tests


def descend(
    tree: Tree, n_things: int, meets: Callable[[IntArray, IntArray], npt.NDArray[np.bool_]]
) -> Iterator[tuple[IntArray, IntArray]]:
    """Go down with many things at once, level by level.

    Parameters
    ----------
    n_things : int
        Rays, points, …
    meets : callable
        Given things and nodes, which of these pairs meet.

    Yields
    ------
    things, nodes : (k,) int64
        All pairs of a level that meet.
    """
    things, nodes = np.arange(n_things), np.zeros(n_things, np.int64)
    while len(things):
        met = meets(things, nodes)
        things, nodes = things[met], nodes[met]
        yield things, nodes
        right = tree.nodes["right"][nodes].astype(np.int64)
        inner = right > 0
        things, nodes = np.tile(things[inner], 2), np.concatenate([nodes[inner] + 1, right[inner]])


def grown_boxes(tree: Tree, radius: float) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Both corners of all boxes, (n_nodes, 3) each, grown by the radius of queries."""
    box = tree.nodes["box"].astype(np.float64)
    return box[:, 0] - radius, box[:, 1] + radius


def weigh(tree: Tree, nodes: IntArray) -> tuple[int, int]:
    """Count the inner nodes among these, and the references of the leaves."""
    leaf = tree.nodes["right"][nodes] == 0
    return int((~leaf).sum()), int(tree.nodes["n_refs"][nodes][leaf].sum())


def meetings(tree: Tree, rays: RayBatch, radius: float) -> Iterator[tuple[IntArray, IntArray]]:
    """Go down with rays that are asked for all hits; from inf to inf, so the order of children is no matter.

    Yields
    ------
    rays, nodes : (k,) int64
        All pairs of a level that meet.
    """
    boxes = tree.nodes["box"]
    origins = rays.origins.astype(np.float64)
    with np.errstate(divide="ignore"):
        inverse = 1.0 / rays.directions.astype(np.float64)

    def meets(things: IntArray, nodes: IntArray) -> npt.NDArray[np.bool_]:
        box = boxes[nodes]
        enter, leave = np.full(len(things), rays.t_min), np.full(len(things), rays.t_max)
        for axis in range(3):
            o, per = origins[things, axis], inverse[things, axis]
            with np.errstate(invalid="ignore"):
                a = (box[:, 0, axis].astype(np.float64) - radius - o) * per
                b = (box[:, 1, axis].astype(np.float64) + radius - o) * per
            # A ray in the very plane of a side, 0 · inf, meets it: fmax and fmin skip NaN.
            enter, leave = np.fmax(enter, np.minimum(a, b)), np.fmin(leave, np.maximum(a, b))
        met: npt.NDArray[np.bool_] = enter <= leave
        return met

    return descend(tree, len(rays), meets)


def count_visits(tree: Tree, rays: RayBatch, radius: float) -> Visits:
    """Count the steps of rays that are asked for all hits, on average."""
    inner = tests = 0
    for _, nodes in meetings(tree, rays, radius):
        more = weigh(tree, nodes)
        inner, tests = inner + more[0], tests + more[1]
    return Visits(inner / max(1, len(rays)), tests / max(1, len(rays)))


def visits_of_rays(tree: Tree, rays: RayBatch, radius: float) -> tuple[IntArray, IntArray]:
    """Count for each ray the nodes that it meets, leaves too, and the references in those leaves: (n,) int64 each."""
    visited, tests = np.zeros(len(rays), np.int64), np.zeros(len(rays), np.int64)
    for things, nodes in meetings(tree, rays, radius):
        visited += np.bincount(things, minlength=len(rays))
        n_refs = np.where(tree.nodes["right"][nodes] == 0, tree.nodes["n_refs"][nodes], 0)
        tests += np.bincount(things, n_refs, len(rays)).astype(np.int64)
    return visited, tests


def expect_visits(tree: Tree, radius: float) -> Visits:
    """Reckon the steps of a random line that meets the root's box, from the areas of boxes grown by the radius."""
    low, high = grown_boxes(tree, radius)
    chance = _chance(low, high)
    leaf = tree.is_leaf
    return Visits(float(chance[~leaf].sum()), float((chance * tree.nodes["n_refs"])[leaf].sum()))


def expect_wide(layout: Layout, radius: float) -> tuple[float, float]:
    """Reckon likewise how many nodes and leaves of the layout are culled for a line."""
    nodes = layout.nodes.reshape(-1).view(WIDE_NODE)
    # Coordinates are those of the frame, which scales by a power of two (rays/frame.hpp).
    box = layout.box.astype(np.float64)
    centre = box.mean(axis=0).astype(np.float32)
    half = float(np.abs(box - centre).max())
    margin = radius * 2.0 ** -float(np.frexp(half)[1])
    q = nodes["planes"].astype(np.float64) * nodes["scale"][:, None, None, None].astype(np.float64)
    corners = q + nodes["org"].astype(np.float64)[:, None, :, None]
    lane = np.arange(16)
    child = lane < nodes["n_children"][:, None]
    inner = lane < nodes["n_inner"][:, None]
    low, high = (corners[:, i].transpose(0, 2, 1) for i in range(2))
    # The root: what holds the children of the first node.
    low, high = (
        np.concatenate([low[0][child[0]].min(axis=0)[None], low[child]]) - margin,
        np.concatenate([high[0][child[0]].max(axis=0)[None], high[child]]) + margin,
    )
    chance = _chance(low, high)
    is_node = np.concatenate([[True], inner[child]])
    return float(chance[is_node].sum()), float(chance[~is_node].sum())


def _chance(low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The chance that a line through the first box meets each; 1 where the first has no area to divide by."""
    x, y, z = (high - low).T
    area = x * y + x * z + y * z
    chance: npt.NDArray[np.float64] = area / area[0] if area[0] > 0 else np.ones_like(area)
    return chance
