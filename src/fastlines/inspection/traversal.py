"""The way of one ray through a binary tree, step by step.

It is the traversal of ``kernel="binary"`` (cpp/fastlines/query/binary_traversal.hpp): depth first, the nearer child
first. The first hit so far limits the ray, so nodes that the ray enters behind it are skipped. For all hits there is no
limit. A node is entered if the ray hits its box, grown by the radius of the query and the largest own radius. A
primitive that is whole in several leaves, as triangles are, is tested in the first of them only.

Hits are those of `Tree.all_hits`; here they are only assigned to the leaves that hold them. The core grows boxes by a
bound on its rounding too. So a ray that misses a box by less than 2⁻¹⁹ of the scene's size may enter a node more there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, choice
from ..errors import InputError
from ..geometry.hit_places import Float64Array
from ..query.hits import AllHits
from ..support.ranges import is_first
from ..support.texts import counted
from ..tree import Tree
from .found_hits import found_hits
from .one_ray import check_ray
from .outline import Outline, outline_of
from .visits import visits

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
        How many hits each leaf finds; their sum is the number of hits. With ``query="first"``, how many are nearer than
        the nearest before.
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
        If `tree` is no Tree, or for a ray and a radius that `Tree.all_hits` refuses.

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
    if not isinstance(tree, Tree):
        raise InputError(f"tree is {type(tree).__name__}; expected a Tree, as fl.build makes it")
    choice("query", query, QUERIES)
    start, along = check_ray(origin, direction)
    outline = outline_of(tree) if outline is None else outline
    hits = tree.all_hits(start[None], along[None], radius)
    grow = (radius or 0.0) + tree.geometry.radius_beyond
    nodes, at = visits(outline, start - np.array(tree.geometry.offset), along, grow)
    if tree.n_prims == 0:
        nodes, at = nodes[:0], at[:0]
    found = found_hits(tree, outline, hits, nodes)
    counts = found.is_first
    if query == "first":
        limit = found.limits(at)
        counts = found.t < limit[found.place]
        hits = tree.next_hits(start[None], along[None], radius, 1) if len(hits) else hits
    n_found = np.bincount(found.place[counts], minlength=len(nodes))
    if query == "first":
        entered = at <= limit
        nodes, at, n_found = nodes[entered], at[entered], n_found[entered]
    is_leaf = outline.is_leaf[nodes]
    n_tests, n_steps = _n_tests(outline, nodes[is_leaf]), int((~is_leaf).sum())
    cost = outline.model.c_trav * n_steps + outline.model.c_prim * n_tests
    return Traversal(nodes, at, is_leaf, n_found, n_steps, n_tests, cost, hits)


def _n_tests(outline: Outline, leaves: IntArray) -> int:
    """Return how many references of leaves are tested: each piece, and each whole primitive once."""
    refs = outline.refs_of_leaves(leaves)
    whole = refs[outline.is_whole[refs]]
    return len(refs) - len(whole) + int(is_first(outline.prims[whole]).sum())
