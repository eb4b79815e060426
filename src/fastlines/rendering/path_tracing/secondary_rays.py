"""Rays that leave fibres: what they hit, and whether they hit anything.

The model of scattering takes a fibre as a whole, so a ray that leaves it starts where it leaves its surface
(`LeavingRays.start`). In dense hair, fibres overlap. A ray hits another fibre only where it comes in from outside:

- One that it enters within its own fibre is hit there.
- One that it starts in is not hit.

So does Mitsuba, whose curves cannot be hit from inside. (pbrt moves the start by twice the width of the fibre.)

Within its own fibre, a ray may enter its own primitive again, or the next one of the strand, at a joint. Such a ray goes
on behind that entry.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ...query.hits import FirstHits
from ..shading.shading_context import ShadingContext
from .leaving_rays import LeavingRays
from .path_vertices import LEAST, PathVertices, hit_vertices

#: Where rays begin to enter fibres, as a fraction of the scene's extent: past the surface that they start on, which is
#: `LEAST` away.
NEAR = 4 * LEAST


def next_vertices(context: ShadingContext, rays: LeavingRays) -> tuple[IntArray, PathVertices]:
    """Follow rays, and return which of them hit something, (m,) int64 in no order, and where."""
    found = [(rows, hit_vertices(hits, at, context)) for rows, hits, at in _entries(context, rays, None)]
    if len(found) == 1:
        return found[0]
    return np.concatenate([rows for rows, _ in found]), PathVertices.joined(*(hit for _, hit in found))


def unoccluded(context: ShadingContext, rays: LeavingRays) -> npt.NDArray[np.bool_]:
    """Return which rays hit nothing."""
    free = ~context.tree.any_hit(rays.points, rays.directions, context.radius, t_min=rays.start, at="entry")
    # Find the rays that enter something within their own fibre.
    left = np.flatnonzero(free)
    some = rays.some(left)
    for rows, _, _ in _entries(context, some, some.start):
        free[left[rows]] = False
    return free


def _entries(
    context: ShadingContext, rays: LeavingRays, end: FloatArray | None
) -> Iterator[tuple[IntArray, FirstHits, IntArray]]:
    """Yield some rays that hit something before some end, hits, and the rows of the hits of these rays."""
    near = NEAR * context.extent
    begin = np.full(len(rays), near, np.float32) if end is None else np.minimum(near, end)
    rows = np.arange(len(rays))
    while True:
        limits = {"t_min": begin} if end is None else {"t_min": begin, "t_max": end}
        hits = context.tree.first_hit(rays.points, rays.directions, context.radius, at="entry", **limits)
        entered = hits.hit
        again = np.flatnonzero(hits.t <= rays.start)
        again = again[_is_own(context, hits.prim_number[again], rays.some(again))]
        entered[again] = False
        at = np.flatnonzero(entered)
        yield rows[at], hits, at
        if not len(again):
            return
        # Go on behind entries of the own fibre.
        begin = np.nextafter(np.maximum(hits.t[again], begin[again]), np.float32(np.inf))
        rows, rays = rows[again], rays.some(again)
        end = None if end is None else np.maximum(end[again], begin)


def _is_own(context: ShadingContext, prim: IntArray, rays: LeavingRays) -> npt.NDArray[np.bool_]:
    """Return which primitives are those that rays leave, or their neighbours on the strand."""
    strand = context.tree.geometry.strands_of(prim)
    is_near = np.abs(prim - rays.prim) <= 1
    is_same = (strand == rays.strand) & (strand >= 0)
    return np.asarray(is_near & (is_same | (prim == rays.prim)))
