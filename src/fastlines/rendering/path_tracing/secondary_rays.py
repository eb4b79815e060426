"""Rays that leave fibres: what they hit, and whether they hit anything.

The model of scattering takes a fibre as a whole, so a ray that leaves it starts where it leaves its surface
(`LeavingRays.start`). In dense hair, fibres overlap. A ray that starts in another fibre hits it where it comes in from
outside, within its own fibre, if there is such a place; else it does not hit it. Mitsuba's curves, too, cannot be hit
from inside. (pbrt moves the start by twice the width of the fibre.)

Within its own fibre, a ray may enter its own primitive again, or the next one of the strand, at a joint. Such a ray
goes on behind that entry.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...query.hits import FirstHits
from ..shading.shading_context import ShadingContext
from .leaving_rays import LeavingRays
from .path_vertices import LEAST, PathVertices, hit_vertices

#: Where rays begin to enter fibres, as a fraction of the scene's extent: past the surface that they start on, which is
#: `LEAST` away.
NEAR = 4 * LEAST


def next_vertices(context: ShadingContext, rays: LeavingRays) -> tuple[IntArray, PathVertices]:
    """Follow rays, and return which of them hit something, (m,) int64 in no order, and where."""
    first = context.tree.first_surface(rays.points, rays.directions, context.radius, t_min=rays.start)
    enters = first.t > rays.start
    plain, inside = np.flatnonzero(first.hit & enters), np.flatnonzero(first.hit & ~enters)
    found = [(plain, hit_vertices(first, plain, context))]
    for rows, hits, at in _entries(context, rays.some(inside)):
        found.append((inside[rows], hit_vertices(hits, at, context)))
    return np.concatenate([rows for rows, _ in found]), PathVertices.joined(*(hit for _, hit in found))


def unoccluded(context: ShadingContext, rays: LeavingRays) -> npt.NDArray[np.bool_]:
    """Return which rays hit nothing."""
    tree = context.tree
    free = ~tree.any_hit(rays.points, rays.directions, context.radius, t_min=rays.start)
    # Find the rays that start in a fibre, perhaps in their own, which bends.
    rows = np.flatnonzero(~free)
    points, directions, start = rays.points[rows], rays.directions[rows], rays.start[rows]
    inside = rows[tree.any_hit(points, directions, context.radius, t_min=start, t_max=start)]
    free[inside] = True
    for entered, _, _ in _entries(context, rays.some(inside)):
        free[inside[entered]] = False
    return free


def _entries(context: ShadingContext, rays: LeavingRays) -> Iterator[tuple[IntArray, FirstHits, IntArray]]:
    """Yield some of the rays that enter a fibre, hits, and the rows of the hits of these rays."""
    begin, rows = np.full(len(rays), NEAR * context.extent, np.float32), np.arange(len(rays))
    while len(rows):
        hits = context.tree.first_hit(rays.points, rays.directions, context.radius, t_min=begin, at="entry")
        entered = hits.hit
        again = np.flatnonzero(hits.t <= rays.start)
        again = again[_is_own(context, hits.prim_number[again], rays.some(again))]
        entered[again] = False
        at = np.flatnonzero(entered)
        yield rows[at], hits, at
        # Go on behind entries of the own fibre.
        begin = np.nextafter(np.maximum(hits.t[again], begin[again]), np.float32(np.inf))
        rows, rays = rows[again], rays.some(again)


def _is_own(context: ShadingContext, prim: IntArray, rays: LeavingRays) -> npt.NDArray[np.bool_]:
    """Return which primitives are those that rays leave, or their neighbours on the strand."""
    strand = context.tree.geometry.strands_of(prim)
    is_near = np.abs(prim - rays.prim) <= 1
    is_same = (strand == rays.strand) & (strand >= 0)
    return np.asarray(is_near & (is_same | (prim == rays.prim)))
