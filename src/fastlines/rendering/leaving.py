"""Rays that leave fibres: what they hit, and whether they hit anything.

The model of scattering takes a fibre as a whole, so a ray that leaves it starts where it leaves its surface
(`Vertices.exits`). In dense hair, fibres overlap. A ray hits another fibre only where it comes in from outside:

- One that it enters within its own fibre is hit there.
- One that it starts in is not hit.

So does Mitsuba, whose curves cannot be hit from inside. (pbrt moves the start by twice the width of the fibre.)
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..hits import AllHits
from .fragments import some_hits
from .stage import Stage
from .vertices import Vertices, hit_vertices

#: How many hits of a ray are listed, if the first is not an entry; four times as many if none of these is.
LISTED = 8


def next_vertices(stage: Stage, vertices: Vertices, directions: FloatArray) -> tuple[IntArray, Vertices]:
    """Follow a ray from each vertex, and return which rays hit something, and where.

    Parameters
    ----------
    stage : Stage
    vertices : Vertices
    directions : (n, 3) float32
        Unit vectors.

    Returns
    -------
    rows : (m,) int64
        The rows of the rays that hit, in no order.
    hit : Vertices
        One for each.
    """
    start = vertices.exits(directions, stage.extent)
    first = stage.tree.first_hit(vertices.points, directions, stage.radius, t_min=start, at="surface")
    enters = first.t > start
    plain, inside = np.flatnonzero(first.hit & enters), np.flatnonzero(first.hit & ~enters)
    found = hit_vertices(some_hits(first, plain, plain), plain, stage)
    if not len(inside):
        return plain, found
    rows, others = _entries(stage, vertices, directions, inside)
    return np.concatenate([plain, rows]), Vertices.joined(found, others)


def unoccluded(stage: Stage, vertices: Vertices, directions: FloatArray) -> npt.NDArray[np.bool_]:
    """Return from which vertices nothing is hit in some directions, unit vectors (n, 3)."""
    tree, start = stage.tree, vertices.exits(directions, stage.extent)
    free = ~tree.any_hit(vertices.points, directions, stage.radius, t_min=start)
    # Find the rays that start in a fibre, perhaps in their own, which bends.
    rows = np.flatnonzero(~free)
    points, ways, at = vertices.points[rows], directions[rows], start[rows]
    rows = rows[tree.any_hit(points, ways, stage.radius, t_min=at, t_max=at)]
    if len(rows):
        free[rows] = True
        free[_entries(stage, vertices, directions, rows)[0]] = False
    return free


def _entries(stage: Stage, vertices: Vertices, directions: FloatArray, rows: IntArray) -> tuple[IntArray, Vertices]:
    """Return which rays of some rows enter another fibre, and where the first of them is."""
    found: list[tuple[IntArray, Vertices]] = []
    k = LISTED
    while len(rows):
        some = vertices.some(rows)
        hits = stage.tree.next_hits(some.points, directions[rows], stage.radius, k, at="surface")
        ray = hits.ray
        enters = np.flatnonzero((hits.t > 0) & ~_is_own(hits, some, ray))
        where, first = np.unique(ray[enters], return_index=True)
        chosen = enters[first]
        found.append((rows[where], hit_vertices(some_hits(hits, chosen, where), where, stage)))
        is_full = hits.counts == k
        is_full[where] = False
        rows, k = rows[is_full], 4 * k
    return np.concatenate([each for each, _ in found]), Vertices.joined(*(each for _, each in found))


def _is_own(hits: AllHits, vertices: Vertices, ray: IntArray) -> npt.NDArray[np.bool_]:
    """Return which hits are of the primitive of their vertex, or of its neighbours on the strand."""
    near = np.abs(hits.prim_number - vertices.prim[ray]) <= 1
    same = (hits.strand == vertices.strand[ray]) & (hits.strand >= 0)
    return np.asarray(near & (same | (hits.prim_number == vertices.prim[ray])))
