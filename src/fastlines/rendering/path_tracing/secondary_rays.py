"""Rays that leave fibres: what they hit, and whether they hit anything.

The model of scattering takes a fibre as a whole, so a ray that leaves it starts where it leaves its surface
(`LeavingRays.start`). In dense hair, fibres overlap. A ray hits another fibre only where it comes in from outside:

- One that it enters within its own fibre is hit there.
- One that it starts in is not hit.

So does Mitsuba, whose curves cannot be hit from inside. (pbrt moves the start by twice the width of the fibre.)
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...query.hits import AllHits
from ..shading.fragments import some_hits
from ..shading.shading_context import ShadingContext
from .leaving_rays import LeavingRays
from .path_vertices import PathVertices, hit_vertices

#: How many hits of a ray are listed, if the first is not an entry; four times as many if none of these is.
LISTED = 8


def next_vertices(context: ShadingContext, rays: LeavingRays) -> tuple[IntArray, PathVertices]:
    """Follow rays, and return which of them hit something, (m,) int64 in no order, and where."""
    first = context.tree.first_hit(rays.points, rays.directions, context.radius, t_min=rays.start, at="surface")
    enters = first.t > rays.start
    plain, inside = np.flatnonzero(first.hit & enters), np.flatnonzero(first.hit & ~enters)
    found = hit_vertices(some_hits(first, plain, plain), plain, context)
    if not len(inside):
        return plain, found
    rows, others = _entries(context, rays, inside)
    return np.concatenate([plain, rows]), PathVertices.joined(found, others)


def unoccluded(context: ShadingContext, rays: LeavingRays) -> npt.NDArray[np.bool_]:
    """Return which rays hit nothing."""
    tree = context.tree
    free = ~tree.any_hit(rays.points, rays.directions, context.radius, t_min=rays.start)
    # Find the rays that start in a fibre, perhaps in their own, which bends.
    rows = np.flatnonzero(~free)
    some = rays.some(rows)
    rows = rows[tree.any_hit(some.points, some.directions, context.radius, t_min=some.start, t_max=some.start)]
    if len(rows):
        free[rows] = True
        free[_entries(context, rays, rows)[0]] = False
    return free


def _entries(context: ShadingContext, rays: LeavingRays, rows: IntArray) -> tuple[IntArray, PathVertices]:
    """Return which rays of some rows enter another fibre, and where the first of them is."""
    found: list[tuple[IntArray, PathVertices]] = []
    k = LISTED
    while len(rows):
        some = rays.some(rows)
        hits = context.tree.next_hits(some.points, some.directions, context.radius, k, at="surface")
        ray = hits.ray
        enters = np.flatnonzero((hits.t > 0) & ~_is_own(hits, some, ray))
        where, first = np.unique(ray[enters], return_index=True)
        chosen = enters[first]
        found.append((rows[where], hit_vertices(some_hits(hits, chosen, where), where, context)))
        is_full = hits.counts == k
        is_full[where] = False
        rows, k = rows[is_full], 4 * k
    return np.concatenate([each for each, _ in found]), PathVertices.joined(*(each for _, each in found))


def _is_own(hits: AllHits, rays: LeavingRays, ray: IntArray) -> npt.NDArray[np.bool_]:
    """Return which hits are of the primitive that their ray leaves, or of its neighbours on the strand."""
    near = np.abs(hits.prim_number - rays.prim[ray]) <= 1
    same = (hits.strand == rays.strand[ray]) & (hits.strand >= 0)
    return np.asarray(near & (same | (hits.prim_number == rays.prim[ray])))
