"""End-point overlap: the nodes that a query visits in vain.

After T. Aila, T. Karras, S. Laine 2013, "On quality metrics of bounding volume hierarchies". A query that ends at a
point visits all nodes whose boxes contain the point. Visits of nodes without the primitive at that point are in vain.
For triangles

    EPO = Σ over nodes of  C(node) · A((S without Q(node)) ∩ box(node)) / A(S)

with A the area, S all surfaces, Q(node) those below the node, C(node) the cost of its visit. For segments, A is the
length, Q(node) are the pieces of the references below the node, and box(node) may be enlarged by the radius of queries.
So EPO is a mean over the points of all segments: of the cost of all nodes whose boxes contain the point while no
reference below them contains it. The mean is taken over points that are evenly spaced along the segments.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fastlines import InputError, Lines, Tree

from ..harness.arrays import IntArray
from ..harness.visits import Visits, descend, grown_boxes, weigh

#: The default number of points.
POINTS = 4096


def overlap(tree: Tree, radius: float = 0.0, n_points: int = POINTS) -> Visits:
    """Return the mean visits in vain for a point of the segments: of inner nodes, and tests of references in leaves.

    Their `cost` is the end-point overlap.

    Parameters
    ----------
    tree : Tree
        A tree over lines.
    radius : float
        The radius of queries, by which boxes are enlarged.
    n_points : int
        The number of points, which are evenly spaced along all segments.
    """
    if not isinstance(tree.geometry, Lines):
        raise InputError(f"end-point overlap is for lines; this tree is over {type(tree.geometry).__name__}")
    prim, s = points_along(tree.geometry, n_points)
    if len(prim) == 0:
        return Visits(0.0, 0.0)
    ends = tree.geometry.segments[prim].astype(np.float64)
    points = ends[:, 0] + s[:, None] * (ends[:, 1] - ends[:, 0])
    ref = _ref_of(tree, prim, s)
    low, high = grown_boxes(tree, radius)
    first = tree.nodes["first_ref"].astype(np.int64)
    last = first + tree.nodes["n_refs"]

    def overlaps(items: IntArray, nodes: IntArray) -> npt.NDArray[np.bool_]:
        p = points[items]
        own = (first[nodes] <= ref[items]) & (ref[items] < last[nodes])
        held: npt.NDArray[np.bool_] = own | ((low[nodes] <= p) & (p <= high[nodes])).all(axis=1)
        return held

    inner = tests = 0
    for items, nodes in descend(tree, len(points), overlaps):
        vain = (ref[items] < first[nodes]) | (last[nodes] <= ref[items])
        more = weigh(tree, nodes[vain])
        inner, tests = inner + more[0], tests + more[1]
    return Visits(inner / len(points), tests / len(points))


def points_along(lines: Lines, n_points: int) -> tuple[IntArray, npt.NDArray[np.float64]]:
    """Return points evenly spaced along all segments: the segment of each, and its parameter 0 ≤ s < 1 on it.

    If all segments have length 0, the points are evenly divided among them.
    """
    ends = lines.segments.astype(np.float64)
    lengths = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))
    if not lengths.any():
        lengths = np.ones_like(lengths)
    ends_at = np.cumsum(lengths)
    if len(ends_at) == 0:
        return np.empty(0, np.int64), np.empty(0)
    at = (np.arange(n_points) + 0.5) / n_points * ends_at[-1]
    prim = np.minimum(np.searchsorted(ends_at, at, side="right"), len(ends) - 1)
    s = (at - (ends_at[prim] - lengths[prim])) / np.maximum(lengths[prim], 1e-300)
    return prim, np.clip(s, 0.0, np.nextafter(1.0, 0.0))


def _ref_of(tree: Tree, prim: IntArray, s: npt.NDArray[np.float64]) -> IntArray:
    """Return the reference whose piece contains each point."""
    order = np.lexsort((tree.refs["s0"], tree.refs["prim"]))
    key = tree.refs["prim"][order].astype(np.float64) + tree.refs["s0"][order]
    at: IntArray = order[np.maximum(np.searchsorted(key, prim + s, side="right") - 1, 0)]
    return at
