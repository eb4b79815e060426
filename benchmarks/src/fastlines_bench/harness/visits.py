"""The steps of a traversal of the binary tree: counted on rays, or estimated from areas.

A visit of an inner node costs c_trav, and a test of a reference costs c_prim (thesis §3.3). The expected numbers of
both for a random line follow from areas: a line that hits the root's box hits a child's with probability
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

#: A node of the wide layout (layout/wide_bvh.hpp). The planes are low x, y, z, then high x, y, z, of 16 children each.
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
    """Mean steps of a query: visits of inner nodes, and tests of references."""

    inner: float
    tests: float

    def cost(self, model: Cost) -> float:
        """Return the cost of the steps."""
        return model.c_trav * self.inner + model.c_prim * self.tests


def descend(
    tree: Tree, n_items: int, overlaps: Callable[[IntArray, IntArray], npt.NDArray[np.bool_]]
) -> Iterator[tuple[IntArray, IntArray]]:
    """Traverse a tree with many items at once, level by level.

    Parameters
    ----------
    n_items : int
        The number of items: rays or points.
    overlaps : callable
        Returns, for arrays of items and nodes, which of these pairs overlap.

    Yields
    ------
    items, nodes : (k,) int64
        All pairs of a level that overlap.
    """
    items, nodes = np.arange(n_items), np.zeros(n_items, np.int64)
    while len(items):
        hit = overlaps(items, nodes)
        items, nodes = items[hit], nodes[hit]
        yield items, nodes
        right = tree.nodes["right"][nodes].astype(np.int64)
        inner = right > 0
        items, nodes = np.tile(items[inner], 2), np.concatenate([nodes[inner] + 1, right[inner]])


def grown_boxes(tree: Tree, radius: float) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return both corners of all boxes, (n_nodes, 3) each, enlarged by the radius of queries."""
    box = tree.nodes["box"].astype(np.float64)
    return box[:, 0] - radius, box[:, 1] + radius


def weigh(tree: Tree, nodes: IntArray) -> tuple[int, int]:
    """Return the number of inner nodes among `nodes`, and the number of references in the leaves."""
    leaf = tree.nodes["right"][nodes] == 0
    return int((~leaf).sum()), int(tree.nodes["n_refs"][nodes][leaf].sum())


def meetings(tree: Tree, rays: RayBatch, radius: float) -> Iterator[tuple[IntArray, IntArray]]:
    """Traverse a tree with rays for all hits, so that the order of children does not matter.

    Yields
    ------
    rays, nodes : (k,) int64
        All pairs of a level in which the ray hits the box.
    """
    boxes = tree.nodes["box"]
    origins = rays.origins.astype(np.float64)
    with np.errstate(divide="ignore"):
        inverse = 1.0 / rays.directions.astype(np.float64)

    def overlaps(items: IntArray, nodes: IntArray) -> npt.NDArray[np.bool_]:
        box = boxes[nodes]
        enter, leave = np.full(len(items), rays.t_min), np.full(len(items), rays.t_max)
        for axis in range(3):
            o, per = origins[items, axis], inverse[items, axis]
            with np.errstate(invalid="ignore"):
                a = (box[:, 0, axis].astype(np.float64) - radius - o) * per
                b = (box[:, 1, axis].astype(np.float64) + radius - o) * per
            # A ray in the plane of a face gives 0 · inf = NaN and hits it: fmax and fmin skip NaN.
            enter, leave = np.fmax(enter, np.minimum(a, b)), np.fmin(leave, np.maximum(a, b))
        hit: npt.NDArray[np.bool_] = enter <= leave
        return hit

    return descend(tree, len(rays), overlaps)


def count_visits(tree: Tree, rays: RayBatch, radius: float) -> Visits:
    """Return the mean steps of rays in a traversal for all hits."""
    inner = tests = 0
    for _, nodes in meetings(tree, rays, radius):
        more = weigh(tree, nodes)
        inner, tests = inner + more[0], tests + more[1]
    return Visits(inner / max(1, len(rays)), tests / max(1, len(rays)))


def visits_of_rays(tree: Tree, rays: RayBatch, radius: float) -> tuple[IntArray, IntArray]:
    """Return for each ray the number of nodes hit, with leaves, and of references in those leaves: (n,) int64 each."""
    visited, tests = np.zeros(len(rays), np.int64), np.zeros(len(rays), np.int64)
    for items, nodes in meetings(tree, rays, radius):
        visited += np.bincount(items, minlength=len(rays))
        n_refs = np.where(tree.nodes["right"][nodes] == 0, tree.nodes["n_refs"][nodes], 0)
        tests += np.bincount(items, n_refs, len(rays)).astype(np.int64)
    return visited, tests


def expect_visits(tree: Tree, radius: float) -> Visits:
    """Return the expected steps of a random line that hits the root's box, with boxes enlarged by the radius."""
    low, high = grown_boxes(tree, radius)
    chance = _chance(low, high)
    leaf = tree.is_leaf
    return Visits(float(chance[~leaf].sum()), float((chance * tree.nodes["n_refs"])[leaf].sum()))


def expect_wide(layout: Layout, radius: float) -> tuple[float, float]:
    """Return the expected numbers of nodes and leaves of the layout that are culled for such a line."""
    nodes = layout.nodes.reshape(-1).view(WIDE_NODE)
    # Coordinates are in the frame, which scales by a power of two (rays/frame.hpp).
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
    # Add the box of the root: the hull of the children of the first node.
    low, high = (
        np.concatenate([low[0][child[0]].min(axis=0)[None], low[child]]) - margin,
        np.concatenate([high[0][child[0]].max(axis=0)[None], high[child]]) + margin,
    )
    chance = _chance(low, high)
    is_node = np.concatenate([[True], inner[child]])
    return float(chance[is_node].sum()), float(chance[~is_node].sum())


def _chance(low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the probability that a line through the first box hits each box; 1 if the first box has no area."""
    x, y, z = (high - low).T
    area = x * y + x * z + y * z
    chance: npt.NDArray[np.float64] = area / area[0] if area[0] > 0 else np.ones_like(area)
    return chance
