"""Rays that leave fibres: what they hit, and whether they hit anything.

The model of scattering takes a fibre as a whole, so a ray that leaves it starts where it leaves its surface
(`PathVertices.exits`). In dense hair, fibres overlap. A ray hits another fibre only where it comes in from outside:

- One that it enters within its own fibre is hit there.
- One that it starts in is not hit.

So does Mitsuba, whose curves cannot be hit from inside. (pbrt moves the start by twice the width of the fibre.)

What a ray enters before it leaves its own fibre is few: its own primitive again, or the next one of the strand, at a
joint. Those rays list what they enter.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ..shading.fragments import some_hits
from ..shading.shading_context import ShadingContext
from .path_vertices import LEAST, PathVertices, hit_vertices

#: Where rays begin to enter fibres, as a fraction of the scene's extent: past the surface that they start on, which is
#: `LEAST` away.
NEAR = 4 * LEAST

#: How many entries of a ray are listed, and four times as many if none of these counts.
LISTED = 4


def next_vertices(
    context: ShadingContext, vertices: PathVertices, directions: FloatArray
) -> tuple[IntArray, PathVertices]:
    """Follow a ray from each vertex, and return which rays hit something, and where.

    Parameters
    ----------
    context : ShadingContext
    vertices : PathVertices
    directions : (n, 3) float32
        Unit vectors.

    Returns
    -------
    rows : (m,) int64
        The rows of the rays that hit, in no order.
    hit : PathVertices
        One for each.
    """
    start = vertices.exits(directions, context.extent)
    near = NEAR * context.extent
    first = context.tree.first_hit(vertices.points, directions, context.radius, t_min=near, at="entry")
    left = _is_own(first.prim_number, first.strand, first.t, vertices, start)
    plain, again = np.flatnonzero(first.hit & ~left), np.flatnonzero(left)
    found = hit_vertices(some_hits(first, plain, plain), plain, context)
    if not len(again):
        return plain, found
    rows, others = _entries(context, vertices, directions, start, again, np.inf)
    return np.concatenate([plain, rows]), PathVertices.joined(found, others)


def unoccluded(context: ShadingContext, vertices: PathVertices, directions: FloatArray) -> npt.NDArray[np.bool_]:
    """Return from which vertices nothing is hit in some directions, unit vectors (n, 3)."""
    tree, start = context.tree, vertices.exits(directions, context.extent)
    free = ~tree.any_hit(vertices.points, directions, context.radius, t_min=start, at="entry")
    # Find the rays that enter something within their own fibre.
    rows = np.flatnonzero(free)
    near = np.minimum(NEAR * context.extent, start[rows])
    points, ways, end = vertices.points[rows], directions[rows], start[rows]
    rows = rows[tree.any_hit(points, ways, context.radius, t_min=near, t_max=end, at="entry")]
    if len(rows):
        free[_entries(context, vertices, directions, start, rows, start[rows])[0]] = False
    return free


def _entries(
    context: ShadingContext,
    vertices: PathVertices,
    directions: FloatArray,
    start: FloatArray,
    rows: IntArray,
    end: float | FloatArray,
) -> tuple[IntArray, PathVertices]:
    """Return which rays of some rows enter another fibre, or their own one again, and where they first do."""
    found: list[tuple[IntArray, PathVertices]] = []
    k = LISTED
    while len(rows):
        some, ways = vertices.some(rows), directions[rows]
        near = np.minimum(NEAR * context.extent, start[rows])
        hits = context.tree.next_hits(some.points, ways, context.radius, k, t_min=near, t_max=end, at="entry")
        ray = hits.ray
        entered = np.flatnonzero(~_is_own(hits.prim_number, hits.strand, hits.t, some.some(ray), start[rows[ray]]))
        where, first = np.unique(ray[entered], return_index=True)
        chosen = entered[first]
        found.append((rows[where], hit_vertices(some_hits(hits, chosen, where), where, context)))
        is_full = hits.counts == k
        is_full[where] = False
        rows, k = rows[is_full], 4 * k
        end = end if isinstance(end, float) else end[is_full]
    return np.concatenate([each for each, _ in found]), PathVertices.joined(*(each for _, each in found))


def _is_own(
    prim: IntArray, strand: IntArray, t: FloatArray, vertices: PathVertices, start: FloatArray
) -> npt.NDArray[np.bool_]:
    """Return which entries are within the fibre of their vertex: of its primitive, or its neighbours on the strand."""
    is_near = np.abs(prim - vertices.prim) <= 1
    is_same = (strand == vertices.strand) & (strand >= 0)
    return np.asarray((t <= start) & is_near & (is_same | (prim == vertices.prim)))
