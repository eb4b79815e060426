"""Which leaves find the hits of a ray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..geometry.hit_places import Float64Array
from ..query.hits import AllHits
from ..support.ranges import is_first, ranges
from ..tree import Tree
from .outline import Outline


@dataclass(frozen=True, eq=False)
class FoundHits:
    """Pairs of a hit and a leaf that has it, in the order of the leaves.

    Attributes
    ----------
    place : (n,) int64
        The place of the leaf among the nodes that the ray enters.
    t : (n,) float64
    is_first : (n,) bool
        Whether the leaf is the first one with this hit: true of one pair of each hit.
    """

    place: IntArray
    t: Float64Array
    is_first: npt.NDArray[np.bool_]

    def limits(self, at: Float64Array) -> Float64Array:
        """Return the t of the nearest hit before each node, (n,), inf without one; `at` is where nodes are entered."""
        begin = np.flatnonzero(np.diff(self.place, prepend=-1))
        nearest = np.minimum.reduceat(self.t, begin) if len(begin) else self.t
        limit, places, limits = np.inf, [-1], [np.inf]
        for place, t in zip(self.place[begin].tolist(), nearest.tolist(), strict=True):
            if at[place] <= limit and t < limit:
                limit = t
                places.append(place)
                limits.append(t)
        return np.array(limits)[np.searchsorted(places, np.arange(len(at))) - 1]


def found_hits(tree: Tree, outline: Outline, hits: AllHits, nodes: IntArray) -> FoundHits:
    """Return the hits of each leaf among the nodes that a ray enters."""
    geometry = tree.geometry
    places = np.flatnonzero(outline.is_leaf[nodes])
    refs, place = outline.refs_of_leaves(nodes[places]), np.repeat(places, outline.n_refs[nodes[places]])
    # Keep the references of primitives that are hit.
    wanted = geometry.number(hits.part, hits.prim)
    is_hit = np.zeros(len(geometry), np.bool_)
    is_hit[wanted] = True
    kept = is_hit[geometry.owner[outline.prims[refs]]]
    refs, place = refs[kept], place[kept]
    # Rows of the core are pieces of curves; hits are on the curves.
    rows, (s0, s1) = outline.prims[refs], outline.spans[refs].T
    is_last = np.isinf(s1)
    prim, u0 = geometry.parameter(rows, s0.astype(np.float32))
    _, u1 = geometry.parameter(rows, np.where(is_last, 1.0, s1).astype(np.float32))
    # Pair each hit with the references of its primitive.
    by_prim = np.argsort(prim, kind="stable")
    begin, end = (np.searchsorted(prim[by_prim], wanted, side) for side in ("left", "right"))
    hit, ref = np.repeat(np.arange(len(hits)), end - begin), by_prim[ranges(begin, end - begin)]
    # Keep the pairs whose reference has the place of the hit; where two pieces of a curve meet, the later one.
    u, low, high = hits.u[hit], np.minimum(u0, u1)[ref], np.maximum(u0, u1)[ref]
    has = (low <= u) & ((u < high) | (is_last[ref] & (u <= high)))
    hit, ref, low = hit[has], ref[has], low[has]
    latest = np.full(len(hits), -np.inf, np.float32)
    np.maximum.at(latest, hit, low)
    has = low == latest[hit]
    hit, ref = hit[has], ref[has]
    order = np.lexsort((hit, place[ref]))
    hit, ref = hit[order], ref[order]
    return FoundHits(place[ref], hits.t[hit].astype(np.float64), is_first(hit))
