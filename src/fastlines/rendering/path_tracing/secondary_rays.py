"""Rays that leave fibres: what they hit, and whether they hit anything.

The model of scattering takes a fibre as a whole, so a ray that leaves it starts where it leaves its surface
(`LeavingRays.start`). In dense hair, fibres overlap. A ray hits another fibre only where it comes in from outside:

- One that it enters within its own fibre is hit there.
- One that it starts in is not hit.

So does Mitsuba, whose curves cannot be hit from inside. (pbrt moves the start by twice the width of the fibre.)

Few rays enter anything before they leave their own fibre: its own primitive again, or the next one of the strand, at a
joint. Those rays list what they enter.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ..shading.shading_context import ShadingContext
from .leaving_rays import LeavingRays
from .path_vertices import LEAST, PathVertices, hit_vertices

#: Where rays begin to enter fibres, as a fraction of the scene's extent: past the surface that they start on, which is
#: `LEAST` away.
NEAR = 4 * LEAST

#: How many entries of a ray are listed, and four times as many if none of these counts.
LISTED = 4


def next_vertices(context: ShadingContext, rays: LeavingRays) -> tuple[IntArray, PathVertices]:
    """Follow rays, and return which of them hit something, (m,) int64 in no order, and where."""
    near = NEAR * context.extent
    first = context.tree.first_hit(rays.points, rays.directions, context.radius, t_min=near, at="entry")
    left = _is_own(first.prim_number, first.strand, first.t, rays)
    plain, again = np.flatnonzero(first.hit & ~left), np.flatnonzero(left)
    found = hit_vertices(first, plain, context)
    if not len(again):
        return plain, found
    rows, others = _entries(context, rays, again, np.inf)
    return np.concatenate([plain, rows]), PathVertices.joined(found, others)


def unoccluded(context: ShadingContext, rays: LeavingRays) -> npt.NDArray[np.bool_]:
    """Return which rays hit nothing."""
    tree = context.tree
    free = ~tree.any_hit(rays.points, rays.directions, context.radius, t_min=rays.start, at="entry")
    # Find the rays that enter something within their own fibre.
    rows = np.flatnonzero(free)
    some = rays.some(rows)
    near = np.minimum(NEAR * context.extent, some.start)
    enters = tree.any_hit(some.points, some.directions, context.radius, t_min=near, t_max=some.start, at="entry")
    rows = rows[enters]
    if len(rows):
        free[_entries(context, rays, rows, rays.start[rows])[0]] = False
    return free


def _entries(
    context: ShadingContext, rays: LeavingRays, rows: IntArray, end: float | FloatArray
) -> tuple[IntArray, PathVertices]:
    """Return which rays of some rows enter another fibre, or their own one again, and where they first do."""
    found: list[tuple[IntArray, PathVertices]] = []
    k = LISTED
    while len(rows):
        some = rays.some(rows)
        near = np.minimum(NEAR * context.extent, some.start)
        hits = context.tree.next_hits(
            some.points, some.directions, context.radius, k, t_min=near, t_max=end, at="entry"
        )
        ray = hits.ray
        entered = np.flatnonzero(~_is_own(hits.prim_number, hits.strand, hits.t, some.some(ray)))
        where, first = np.unique(ray[entered], return_index=True)
        found.append((rows[where], hit_vertices(hits, entered[first], context)))
        is_full = hits.counts == k
        is_full[where] = False
        rows, k = rows[is_full], 4 * k
        end = end if isinstance(end, float) else end[is_full]
    return np.concatenate([each for each, _ in found]), PathVertices.joined(*(each for _, each in found))


def _is_own(prim: IntArray, strand: IntArray, t: FloatArray, rays: LeavingRays) -> npt.NDArray[np.bool_]:
    """Return which entries are within the fibre that their ray leaves: its primitive, or a neighbour on the strand."""
    is_near = np.abs(prim - rays.prim) <= 1
    is_same = (strand == rays.strand) & (strand >= 0)
    return np.asarray((t <= rays.start) & is_near & (is_same | (prim == rays.prim)))
