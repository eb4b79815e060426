"""Kernels for Warp: candidates of a capsule query, and the exact test of a segment. Importing this needs Warp.

Warp reads the annotations of kernels, so they are not postponed.
"""

# Numbers that change are declared by their type.
# ruff: noqa: RUF046, UP018
# mypy: ignore-errors

import warp as wp


@wp.func
def closest_approach(o: wp.vec3, d: wp.vec3, p: wp.vec3, q: wp.vec3):
    """Return t ≥ 0 of the closest approach of a ray of unit direction to a segment, and the squared distance there."""
    w = p - o
    e = q - p
    pr = wp.dot(w, d)
    er = wp.dot(e, d)
    across_p = w - pr * d
    across_e = e - er * d
    ee = wp.dot(across_e, across_e)
    s = wp.where(er < 0.0, 1.0, 0.0)
    if ee > 0.0:
        s = wp.clamp(-wp.dot(across_p, across_e) / ee, 0.0, 1.0)
    t = pr + s * er
    if t < 0.0:
        t = 0.0
        length2 = wp.dot(e, e)
        s = 0.0
        if length2 > 0.0:
            s = wp.clamp(-wp.dot(w, e) / length2, 0.0, 1.0)
    x = w + s * e - t * d
    return wp.vec2(t, wp.dot(x, x))


@wp.kernel
def first_hit(
    bvh: wp.uint64,
    starts: wp.array(dtype=wp.vec3),
    ends: wp.array(dtype=wp.vec3),
    origins: wp.array(dtype=wp.vec3),
    directions: wp.array(dtype=wp.vec3),
    radius: float,
    t_of: wp.array(dtype=float),
    prim_of: wp.array(dtype=wp.int32),
):
    """Find the first hit of each ray; hits lower the bound of the query."""
    i = wp.tid()
    o = origins[i]
    d = directions[i]
    best = float(wp.inf)
    prim = int(-1)
    query = wp.bvh_query_capsule(bvh, o, d, radius)
    item = int(0)
    while wp.bvh_query_next(query, item, best):
        found = closest_approach(o, d, starts[item], ends[item])
        if found[1] <= radius * radius and (found[0] < best or (found[0] == best and item < prim)):
            best = found[0]
            prim = item
    t_of[i] = best
    prim_of[i] = prim


@wp.kernel
def count_hits(
    bvh: wp.uint64,
    starts: wp.array(dtype=wp.vec3),
    ends: wp.array(dtype=wp.vec3),
    origins: wp.array(dtype=wp.vec3),
    directions: wp.array(dtype=wp.vec3),
    radius: float,
    count_of: wp.array(dtype=wp.int32),
):
    """Count the hits of each ray."""
    i = wp.tid()
    n = int(0)
    query = wp.bvh_query_capsule(bvh, origins[i], directions[i], radius)
    item = int(0)
    while wp.bvh_query_next(query, item, wp.inf):
        if closest_approach(origins[i], directions[i], starts[item], ends[item])[1] <= radius * radius:
            n = n + 1
    count_of[i] = n
