"""The definition of a hit in float64: slow, plain NumPy, to check the answers of the float32 core.

`closest_approach` and `capsule_interval` are for lines, `deepest_approach` is for lines with a thickness of their own.

Nothing here is a port of the core, which works in a basis of the ray. Here the closest approach is a small convex
problem solved by its candidates, and the capsule is a union of two balls and a piece of a cylinder.

Let Δ = P − o be the vector from the ray's origin to the segment's start, e the segment, d the direction and n = d × e.
The two lines are nearest to each other at::

    t = (Δ × e)·n / |n|²,      s = (Δ × d)·n / |n|²          (Jarosz et al. 2011, the beam × beam query).

The squared distance is convex in (s, t). So if this point is feasible, it is the answer. If not, the answer lies on the
border of the rectangle [0, 1] × [t_min, t_max], each side of which is a clamped projection.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]

#: ``|d × e|`` up to this times ``|d|·|e|`` counts as parallel: float64 cannot resolve smaller angles.
PARALLEL = 1e-14


def closest_approach(
    segments: npt.ArrayLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    t_min: npt.ArrayLike = 0.0,
    t_max: npt.ArrayLike = np.inf,
) -> tuple[Array, Array, Array]:
    """Find the closest approach of each ray to each segment.

    This minimises ``|P + s·e − o − t·d|`` over 0 ≤ s ≤ 1 and t_min ≤ t ≤ t_max. Where the minimum is not unique
    (a segment parallel to the ray) the smallest such t counts.

    Parameters
    ----------
    segments : (n, 2, 3) array
    origins, directions : (m, 3) array
        t is in units of the direction's length, which need not be 1.
    t_min, t_max : number or (m,) array
        Bounds on t; may be infinite.

    Returns
    -------
    distance, t, s : (m, n) float64
        The least distance, its place on the ray, and its place on the segment.

    Examples
    --------
    >>> distance, t, s = closest_approach([[[-1, -1, -1], [1, 1, 1]]], [[0, 1, -5]], [[0, 0, 2]])
    >>> print(distance.round(4), t, s)
    [[0.7071]] [[2.75]] [[0.75]]
    """
    delta, e, d, low, high = _pairs(segments, origins, directions, t_min, t_max)
    dd, ee = _dot(d, d), _dot(e, e)
    n = np.cross(d, e)
    nn = _dot(n, n)
    parallel = nn <= PARALLEL**2 * dd * ee

    def project_on_ray(s: Array) -> tuple[Array, Array]:
        return s, np.clip(_dot(delta + s[..., None] * e, d) / dd, low, high)

    def project_on_segment(t: Array) -> tuple[Array, Array]:
        finite = np.where(np.isfinite(t), t, 0.0)
        along = -_dot(delta - finite[..., None] * d, e)
        return np.clip(np.divide(along, ee, out=np.zeros_like(along), where=ee > 0), 0.0, 1.0), t

    # Take the best of the four sides of the rectangle; of those within rounding of it, the one with the smallest t.
    shape = nn.shape
    sides = [
        project_on_ray(np.zeros(shape)),
        project_on_ray(np.ones(shape)),
        project_on_segment(np.broadcast_to(low, shape)),
        project_on_segment(np.broadcast_to(high, shape)),
    ]
    s, t = (np.stack(values) for values in zip(*sides, strict=True))
    distance = np.stack([_distance(delta, e, d, *side) for side in sides])
    size = np.abs(delta).max(axis=-1) + np.sqrt(ee)
    slack = np.where(parallel, 1e-13 * size, 0.0)
    chosen = np.where(distance <= distance.min(axis=0) + slack, t, np.inf).argmin(axis=0)[None]
    s, t, distance = (np.take_along_axis(values, chosen, 0)[0] for values in (s, t, distance))

    # Take the point inside the rectangle, where there is one.
    safe = np.where(parallel, 1.0, nn)
    s_line, t_line = _dot(np.cross(delta, d), n) / safe, _dot(np.cross(delta, e), n) / safe
    inside = ~parallel & (s_line >= 0) & (s_line <= 1) & (t_line >= low) & (t_line <= high)
    at_line = _distance(delta, e, d, s_line, t_line)
    return np.where(inside, at_line, distance), np.where(inside, t_line, t), np.where(inside, s_line, s)


def capsule_interval(
    segments: npt.ArrayLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: npt.ArrayLike,
    t_min: npt.ArrayLike = 0.0,
    t_max: npt.ArrayLike = np.inf,
) -> tuple[Array, Array]:
    """Find the part of each ray that lies within a radius of each segment.

    The points within r of a segment are a capsule: two balls around the ends and a cylinder between them. A capsule is
    convex, so the ray's part in it is one interval, from the first entry into any of the three to the last exit.

    Parameters
    ----------
    segments, origins, directions, t_min, t_max
        As in `closest_approach`.
    radius : number or (m,) array

    Returns
    -------
    t_in, t_out : (m, n) float64
        Within [t_min, t_max]; both NaN where the ray misses.

    Examples
    --------
    >>> origins, directions = [[0, 0, -5], [3, 0, 0]], [[0, 0, 1], [-1, 0, 0]]
    >>> t_in, t_out = capsule_interval([[[-1, 0, 0], [1, 0, 0]]], origins, directions, 0.5)
    >>> print(t_in.ravel(), t_out.ravel())
    [4.5 1.5] [5.5 4.5]
    """
    delta, e, d, low, high = _pairs(segments, origins, directions, t_min, t_max)
    r = np.asarray(radius, np.float64).reshape(-1, 1)
    dd, length = _dot(d, d), np.sqrt(_dot(e, e))
    # Measure t from the ray's point nearest to the segment's middle, so that far origins cost no digits.
    shift = _dot(delta + 0.5 * e, d) / dd
    start = delta - shift[..., None] * d
    axis = e / np.where(length > 0, length, 1.0)[..., None]

    def ball(centre: Array) -> tuple[Array, Array]:
        return _roots(dd, _dot(centre, d), _dot(centre, centre) - r * r)

    # Intersect the cylinder around the line and the slab between the planes; a parallel ray is always or never inside.
    d_across, start_across = np.cross(d, axis), np.cross(start, axis)
    a = _dot(d_across, d_across)
    c = _dot(start_across, start_across) - r * r
    parallel = a <= PARALLEL**2 * dd
    begin, end = _roots(np.where(parallel, 1.0, a), _dot(d_across, start_across), c)
    begin, end = np.where(parallel, np.where(c <= 0, -np.inf, np.nan), begin), np.where(parallel, np.inf, end)
    slope, offset = _dot(d, axis), _dot(start, axis)
    across = np.abs(slope) <= PARALLEL * np.sqrt(dd)
    first, last = (x / np.where(across, 1.0, slope) for x in (offset, offset + length))
    in_slab = np.where((offset <= 0) & (offset + length >= 0), np.inf, np.nan)
    slab_in = np.where(across, -in_slab, np.minimum(first, last))
    slab_out = np.where(across, in_slab, np.maximum(first, last))
    begin, end = np.maximum(begin, slab_in), np.minimum(end, slab_out)
    empty = ~(begin <= end) | (length == 0)
    cylinder = (np.where(empty, np.nan, begin), np.where(empty, np.nan, end))

    entries, exits = zip(ball(start), ball(start + e), cylinder, strict=True)
    t_in = np.fmin(np.fmin(entries[0], entries[1]), entries[2]) + shift
    t_out = np.fmax(np.fmax(exits[0], exits[1]), exits[2]) + shift
    t_in, t_out = np.maximum(t_in, low), np.minimum(t_out, high)
    miss = ~(t_in <= t_out)
    return np.where(miss, np.nan, t_in), np.where(miss, np.nan, t_out)


def deepest_approach(
    segments: npt.ArrayLike,
    radii: npt.ArrayLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: npt.ArrayLike = 0.0,
    t_min: npt.ArrayLike = 0.0,
    t_max: npt.ArrayLike = np.inf,
    n_steps: int = 100,
    *,
    spread: npt.ArrayLike = 0.0,
) -> tuple[Array, Array, Array]:
    """Find where each ray lies deepest in each round cone: where D(s) − R(s) is least.

    D is the distance of the axis at s from the ray; R is the radius there, that of the query, and the spread times the
    depth of that point of the axis along the ray, from its origin. The ray hits if the least value is 0 or less. D − R
    is convex, so a search by thirds finds the minimum, without a formula.

    Parameters
    ----------
    segments, origins, directions, t_min, t_max
        As in `closest_approach`.
    radii : (n, 2) array
        The radius at both ends of each segment.
    radius : number or (m,) array
        The radius of the query, for all rays or for each.
    n_steps : int
        Each step leaves two thirds of the interval.
    spread : number or (m,) array
        By how much the reach grows for each unit of length along the ray.

    Returns
    -------
    clearance, t, s : (m, n) float64
        The least D − R, negative inside; and its places on the ray and on the axis.

    Examples
    --------
    >>> clearance, t, s = deepest_approach([[[0, 0, 0], [4, 0, 0]]], [[0.5, 1.5]], [[2, 0, -5]], [[0, 0, 1]])
    >>> print(clearance.round(4), t, s.round(4))
    [[-1.]] [[5.]] [[0.5]]
    """
    delta, e, d, t_low, t_high = _pairs(segments, origins, directions, t_min, t_max)
    dd, ends = _dot(d, d), np.asarray(radii, np.float64).reshape(-1, 2)
    extra, growth = (np.asarray(values, np.float64).reshape(-1, 1) for values in (radius, spread))

    def approach(s: Array) -> tuple[Array, Array]:
        along = _dot(delta + s[..., None] * e, d)
        t = np.clip(along / dd, t_low, t_high)
        reach = ends[:, 0] + s * (ends[:, 1] - ends[:, 0]) + extra + growth * along / np.sqrt(dd)
        return _distance(delta, e, d, s, t) - reach, t

    low, high = np.zeros(dd.shape), np.ones(dd.shape)
    for _ in range(n_steps):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        is_left = approach(a)[0] < approach(b)[0]
        low, high = np.where(is_left, low, a), np.where(is_left, b, high)
    places = np.stack([np.zeros(dd.shape), np.ones(dd.shape), (low + high) / 2])
    found = [approach(s) for s in places]
    clearance = np.stack([one[0] for one in found])
    best = clearance.argmin(axis=0)[None]
    t = np.stack([one[1] for one in found])
    clearance, t, s = (np.take_along_axis(values, best, 0)[0] for values in (clearance, t, places))
    return clearance, t, s


def _pairs(segments: npt.ArrayLike, *rays: npt.ArrayLike) -> tuple[Array, Array, Array, Array, Array]:
    """Form Δ, e and d of every ray with every segment, (m, n, 3), and the bounds on t, (m or 1, 1)."""
    ends, origins, directions, t_min, t_max = (np.asarray(values, np.float64) for values in (segments, *rays))
    ends, o, d = ends.reshape(-1, 2, 3), origins.reshape(-1, 1, 3), directions.reshape(-1, 1, 3)
    shape = np.broadcast_shapes(o.shape, d.shape, (1, len(ends), 3))
    p, e = ends[:, 0], ends[:, 1] - ends[:, 0]
    low, high = t_min.reshape(-1, 1), t_max.reshape(-1, 1)
    return p - o, np.broadcast_to(e, shape), np.broadcast_to(d, shape), low, high


def _dot(a: Array, b: Array) -> Array:
    return np.asarray((a * b).sum(axis=-1))


def _distance(delta: Array, e: Array, d: Array, s: Array, t: Array) -> Array:
    """Measure from the ray's point at t to the segment's at s; ∞ where t is."""
    finite = np.isfinite(t)
    w = delta + s[..., None] * e - np.where(finite, t, 0.0)[..., None] * d
    return np.where(finite, np.sqrt(_dot(w, w)), np.inf)


def _roots(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """Solve a·t² − 2b·t + c = 0: both roots, NaN where there are none."""
    discriminant = b * b - a * c
    root = np.sqrt(np.where(discriminant >= 0, discriminant, np.nan))
    return (b - root) / a, (b + root) / a
