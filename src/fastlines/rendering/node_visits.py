"""The work of a query: the nodes of the binary tree that rays visit.

A ray visits a node if it hits the node's box, grown on all sides by the radius of the query and the largest own radius
of the lines. The root counts too, and so do leaves. That is what a traversal for all hits of the tree as it was built
(``kernel="binary"``) goes through: it tests the boxes of both children of each inner node that it visits.

The core works in float32, and grows boxes by a bound on its rounding too (cpp/fastlines/query/slabs.hpp). Here float64
needs none. So a ray that misses a box by less than 2⁻¹⁹ of the scene's size may visit one node more in the core.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..geometry.hit_places import Float64Array
from ..inspection.slabs import enter
from ..tree import Tree

#: The most pairs of a ray and a node that are tested at a time.
MAX_PAIRS = 1 << 18


def visited_nodes(tree: Tree, origins: npt.ArrayLike, directions: npt.ArrayLike, radius: float = 0.0) -> IntArray:
    """Count the nodes of a tree that rays visit in a query for all hits.

    Parameters
    ----------
    tree : Tree
    origins, directions : (n, 3) arrays
    radius : float
        That of the query.

    Returns
    -------
    (n,) int64

    Notes
    -----
    All rays descend together, as pairs of a ray and a node. The pairs that wait take some 16 bytes for each of
    `MAX_PAIRS` and each level of the tree, however many rays there are.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "bvh-cl", cost=fl.Cost(0.1))
    >>> visited_nodes(tree, [[0.5, 0.5, -9], [4, 4, -9], [99, 0, 0]], [[0, 0, 1]] * 3)
    array([2, 1, 0])
    """
    origins, directions = (np.array(a, np.float64).reshape(-1, 3) for a in (origins, directions))
    if tree.n_prims == 0:
        return np.zeros(len(origins), np.int64)
    origins -= tree.geometry.offset
    grow = radius + tree.geometry.radius_beyond
    return sum_over_visits(tree.nodes["box"], tree.nodes["right"], origins, directions, grow).astype(np.int64)


def sum_over_visits(
    boxes: npt.NDArray[np.floating],
    right: npt.NDArray[np.integer],
    origins: Float64Array,
    directions: Float64Array,
    grow: float,
    weights: Float64Array | None = None,
    progress: Callable[[float], object] | None = None,
) -> Float64Array:
    """Add up a weight of each node that rays visit, (n,) float64; without weights, count the nodes.

    Parameters
    ----------
    boxes : (n_nodes, 2, 3) array
    right : (n_nodes,) array
        The right child of each node in preorder; 0 for a leaf.
    origins, directions : (n, 3) float64
    grow : float
        How far boxes are grown on all sides.
    weights : (n_nodes,) float64, optional
    progress : callable, optional
        Called with the fraction of the rays that are done.
    """
    sums = np.zeros(len(origins))
    # Start in parts that leave room for both children of each node.
    parts = np.array_split(np.arange(len(origins)), max(1, -(-len(origins) // (MAX_PAIRS // 2))))
    for i, part in enumerate(parts):
        waiting = [(part, np.zeros(len(part), np.int64))]
        while waiting:
            rays, nodes = waiting.pop()
            hit = np.isfinite(enter(boxes[nodes], origins[rays], directions[rays], grow))
            rays, nodes = rays[hit], nodes[hit]
            sums += np.bincount(rays, None if weights is None else weights[nodes], minlength=len(sums))
            # Go on with both children.
            inner = right[nodes] > 0
            rays = np.tile(rays[inner], 2)
            nodes = np.concatenate([nodes[inner] + 1, right[nodes[inner]].astype(np.int64)])
            if len(rays):
                n_parts = -(-len(rays) // MAX_PAIRS)
                waiting += zip(np.array_split(rays, n_parts), np.array_split(nodes, n_parts), strict=True)
        if progress is not None:
            progress((i + 1) / len(parts))
    return sums
