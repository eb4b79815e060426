"""The way of one ray through a binary tree, step by step.

It is the traversal of ``kernel="binary"`` (cpp/fastlines/query/binary_traversal.hpp): depth first, the nearer child
first. The first hit so far limits the ray, so nodes that the ray enters behind it are skipped. For all hits there is no
limit. A node is entered if the ray hits its box, grown by the radius of the query and the largest own radius.

Hits are those of `Tree.all_hits`; here they are only assigned to the leaves that hold them. The core grows boxes by a
bound on its rounding too. So a ray that misses a box by less than 2⁻¹⁹ of the scene's size may enter a node more there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, choice
from ..geometry.hit_places import Float64Array
from ..query.hits import AllHits
from ..support.texts import counted
from ..tree import Tree
from .outline import Outline, outline_of
from .slabs import enter

#: The queries whose traversals can be followed.
QUERIES = ("first", "all")


@dataclass(frozen=True, eq=False, repr=False)
class Traversal:
    """The nodes that a ray enters, in their order, and what it finds in them.

    Attributes
    ----------
    nodes : (k,) int64
        The nodes entered, in their order; the root first.
    enter : (k,) float64
        Where the ray enters their boxes, t.
    is_leaf : (k,) bool
        Which of them are leaves, whose references are tested.
    n_found : (k,) int64
        How many hits are in each leaf. With ``query="first"``, how many are nearer than the nearest before.
    n_steps, n_tests : int
        How many inner nodes were entered, and how many references tested.
    cost : float
        ``c_trav * n_steps + c_prim * n_tests``: what the cost of a tree is the expectation of (thesis §3.3).
    hits : AllHits
        The hits of the ray, as `Tree.all_hits` returns them; with ``query="first"``, the nearest.
    """

    nodes: IntArray
    enter: Float64Array
    is_leaf: npt.NDArray[np.bool_]
    n_found: IntArray
    n_steps: int
    n_tests: int
    cost: float
    hits: AllHits

    def __repr__(self) -> str:
        steps, tests = counted(self.n_steps, "inner nodes"), counted(self.n_tests, "tests")
        return f"<Traversal: {steps}, {tests}, cost {self.cost:.6g}, {counted(len(self.hits), 'hits')}>"


def trace_ray(
    tree: Tree,
    origin: npt.ArrayLike,
    direction: npt.ArrayLike,
    radius: float | None = None,
    *,
    query: Literal["first", "all"] = "all",
    outline: Outline | None = None,
) -> Traversal:
    """Follow one ray through a tree.

    Parameters
    ----------
    tree : Tree
    origin, direction : (3,) arrays
        In the coordinates of `Tree.all_hits`. t is in units of the direction's length.
    radius : float, optional
        As in `Tree.all_hits`.
    query : {"first", "all"}
        Whether the ray ends at its first hit.
    outline : Outline, optional
        That of the tree, if it is at hand.

    Raises
    ------
    InputError
        For rays and a radius that `Tree.all_hits` refuses.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[0, 0, 8], [1, 1, 9]]], "bvh-cl", cost=fl.Cost(0.1))
    >>> way = trace_ray(tree, [0.5, 0.5, -5], [0, 0, 1], 0.1, query="first")
    >>> way.nodes, way.n_tests, way.hits.prim
    (array([0, 1]), 1, array([0]))
    >>> trace_ray(tree, [0.5, 0.5, -5], [0, 0, 1], 0.1).nodes
    array([0, 1, 2])
    """
    choice("query", query, QUERIES)
    outline = outline_of(tree) if outline is None else outline
    ray = np.asarray(origin, np.float64).reshape(1, -1), np.asarray(direction, np.float64).reshape(1, -1)
    hits = tree.all_hits(*ray, radius)
    grow = (radius or 0.0) + tree.geometry.radius_beyond
    entered = _entered(outline, ray[0][0] - np.array(tree.geometry.offset), ray[1][0], grow)
    if tree.n_prims == 0:
        entered = {}
    nodes, n_found = _descend(outline, entered, _hits_of_leaves(tree, outline, hits, entered), query == "first")
    is_leaf = outline.is_leaf[nodes]
    n_tests = int(outline.n_refs[nodes[is_leaf]].sum())
    n_steps = int((~is_leaf).sum())
    cost = outline.model.c_trav * n_steps + outline.model.c_prim * n_tests
    if query == "first" and len(hits):
        hits = tree.next_hits(*ray, radius, 1)
    at = np.array([entered[node] for node in nodes.tolist()])
    return Traversal(nodes, at, is_leaf, n_found, n_steps, n_tests, cost, hits)


def _entered(outline: Outline, origin: Float64Array, direction: Float64Array, grow: float) -> dict[int, float]:
    """Return where the ray enters each node whose box it hits, by the number of the node."""
    entered, level = dict[int, float](), np.zeros(1, np.int64)
    while len(level):
        at = enter(outline.boxes[level], origin, direction, grow)
        hit = np.isfinite(at)
        entered.update(zip(level[hit].tolist(), at[hit].tolist(), strict=True))
        inner = level[hit & ~outline.is_leaf[level]]
        level = np.concatenate([inner + 1, outline.right[inner]])
    return entered


def _hits_of_leaves(tree: Tree, outline: Outline, hits: AllHits, entered: dict[int, float]) -> dict[int, list[float]]:
    """Return the t of the hits that are on the pieces of each leaf entered."""
    leaves = np.array([node for node in entered if outline.is_leaf[node]], np.int64)
    if not len(hits) or not len(leaves):
        return {}
    counts = outline.n_refs[leaves]
    owner = np.repeat(leaves, counts)
    refs = np.concatenate([np.arange(*outline.refs_of(leaf).indices(len(outline.prims))[:2]) for leaf in leaves])
    rows, (s0, s1) = outline.prims[refs], outline.spans[refs].T
    is_last = np.isinf(s1)
    # Rows of the core are pieces of curves; hits are on the curves.
    prim, u0 = tree.geometry.parameter(rows, s0.astype(np.float32))
    _, u1 = tree.geometry.parameter(rows, np.where(is_last, 1.0, s1).astype(np.float32))
    by_prim = np.argsort(prim, kind="stable")
    wanted = tree.geometry.number(hits.part, hits.prim)
    begin, end = (np.searchsorted(prim[by_prim], wanted, side) for side in ("left", "right"))
    found = dict[int, list[float]]()
    for t, u, first, last in zip(hits.t.tolist(), hits.u.tolist(), begin.tolist(), end.tolist(), strict=True):
        of_prim = by_prim[first:last]
        low, high = np.minimum(u0[of_prim], u1[of_prim]), np.maximum(u0[of_prim], u1[of_prim])
        on_piece = of_prim[(low <= u) & ((u < high) | (is_last[of_prim] & (u <= high)))]
        for leaf in dict.fromkeys(owner[on_piece].tolist()):
            found.setdefault(leaf, []).append(t)
    return found


def _descend(
    outline: Outline, entered: dict[int, float], found: dict[int, list[float]], is_first: bool
) -> tuple[IntArray, IntArray]:
    """Return the nodes in the order in which the ray enters them, and how many hits it finds in each."""
    nodes, n_found, limit = list[int](), list[int](), np.inf
    waiting = [0] if 0 in entered else []
    while waiting:
        node = waiting.pop()
        if not entered[node] <= limit:
            continue
        nodes.append(node)
        n_found.append(0)
        if outline.is_leaf[node]:
            nearer = [t for t in found.get(node, []) if t < limit]
            n_found[-1] = len(nearer)
            if is_first and nearer:
                limit = min(nearer)
            continue
        # The nearer child is next; of two that are equally near, the left one.
        children = [child for child in (int(outline.right[node]), node + 1) if child in entered]
        waiting += sorted(children, key=lambda child: entered[child], reverse=True)
    return np.array(nodes, np.int64), np.array(n_found, np.int64)
