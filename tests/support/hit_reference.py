"""Frames of hits on axes in NumPy: the definition of what compiled code computes, bit for bit."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from fastlines.geometry.axis_geometry import AxisGeometry
from fastlines.geometry.curves import Curves
from fastlines.geometry.offsets import NO_OFFSET
from fastlines.query.hits import AllHits, FirstHits
from fastlines.support.vectors import dot, is_zero

Array = npt.NDArray[np.float64]


class Frames(NamedTuple):
    """Of each hit, NaN for a miss."""

    points: Array
    normals: Array
    tangents: Array
    radius: Array


def frames(hits: FirstHits | AllHits) -> Frames:
    """Return the frames of hits at surfaces, flattened."""
    geometry, rays, prim = hits.geometry, hits.rays, hits.prim.reshape(-1)
    assert isinstance(geometry, AxisGeometry)
    assert rays is not None
    rows = np.flatnonzero(prim >= 0)
    ray = hits.ray[rows] if isinstance(hits, AllHits) else rows
    prim, u, t = prim[rows], hits.u.reshape(-1)[rows].astype(np.float64), hits.t.reshape(-1)[rows]
    origins, directions = rays.origins[ray].astype(np.float64), rays.directions[ray].astype(np.float64)
    t_min, t_max, ray_radius = (np.broadcast_to(of, len(rays))[ray] for of in (rays.t_min, rays.t_max, rays.radius))

    # Intersect the surface, except where a bound of the ray cut it off.
    straight, s = geometry.locate(prim, u) if isinstance(geometry, Curves) else (prim, u)
    ends = geometry.straight.segments[straight].astype(np.float64)
    start, edge = ends[:, 0], ends[:, 1] - ends[:, 0]
    end_radii = geometry.straight.end_radii[straight]
    radii = end_radii.astype(np.float64) + ray_radius.astype(np.float64)[:, None]
    t_in, s_in = enter_round_cones(start, edge, radii[:, 0], radii[:, 1] - radii[:, 0], origins, directions)
    use = (t != t_min) & (t != t_max) & np.isfinite(t_in)
    points = origins + np.where(use, t_in, t.astype(np.float64))[:, None] * directions
    away = points - (start + np.where(use, s_in, s)[:, None] * edge)
    away = np.where(is_zero(away)[:, None], -directions, away)

    if isinstance(geometry, Curves):
        curve = geometry.evaluate(prim, u)
        tangents, radius = unit(curve.tangents), curve.radius
    else:
        tangents, radius = unit(edge), (1 - u) * end_radii[:, 0] + u * end_radii[:, 1]

    def filled(values: Array) -> Array:
        full = np.full((hits.prim.size, *values.shape[1:]), np.nan)
        full[rows] = values
        return full

    points = points if geometry.offset == NO_OFFSET else points + np.array(geometry.offset)
    return Frames(*map(filled, (points, unit(away), tangents, radius)))


def unit(vectors: Array) -> Array:
    """Return unit vectors without negative zeros; NaN for those of length zero."""
    with np.errstate(invalid="ignore"):
        return np.asarray(vectors / np.sqrt(dot(vectors, vectors))[:, None] + 0.0)


def enter_round_cones(
    start: Array,
    edge: Array,
    radius0: Array,
    slope: Array,
    origins: Array,
    directions: Array,
) -> tuple[Array, Array]:
    """Find where lines enter round cones, which they hit, one ray and one round cone a row.

    Parameters
    ----------
    start, edge : (n, 3)
        The start of the axis, and its end − start.
    radius0, slope : (n,)
        The radius at the start, and how much larger it is at the end.
    origins, directions : (n, 3)

    Returns
    -------
    t, s : (n,)
        In units of the direction's length; and the place on the axis of the ball that the line touches there. NaN if
        rounding makes the line miss.

    Examples
    --------
    >>> start, edge = np.array([[0.0, 0, 0]]), np.array([[4.0, 0, 0]])
    >>> origins, directions = np.array([[2.0, 0, -5]]), np.array([[0.0, 0, 2]])
    >>> t, s = enter_round_cones(start, edge, np.ones(1), np.zeros(1), origins, directions)
    >>> print(t, s)
    [2.] [0.5]
    """
    length = np.sqrt(dot(directions, directions))
    ray = directions / length[:, None]
    # Measure depths from the point of the line that is nearest to the middle of the axis, so that nothing cancels.
    shift = dot(start + 0.5 * edge - origins, ray)
    offset = start - origins - shift[:, None] * ray
    p_r, e_r = dot(offset, ray), dot(edge, ray)
    a, b = offset - p_r[:, None] * ray, edge - e_r[:, None] * ray
    b2, m2 = dot(b, b), slope**2
    c2 = m2 - b2
    length2 = e_r**2 - c2
    is_steep = c2 >= 0
    larger_end, smaller_end = np.where(slope > 0, 1.0, 0.0), np.where(slope > 0, 0.0, 1.0)

    def ball(s: Array) -> tuple[Array, Array, Array, Array]:
        """Return the centre of the ball at s across the ray, its radius, Q(s), and half the derivative of Q there."""
        x, reach = a + s[:, None] * b, radius0 + s * slope
        return x, reach, reach**2 - dot(x, x), reach * slope - dot(x, b)

    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # The line hits if the largest Q, the squared half chord in the ball at s, is 0 or more.
        inmost = np.where(is_steep, larger_end, np.clip((dot(a, b) - radius0 * slope) / c2, 0, 1))
        _, _, c0, c1 = ball(inmost)
        hits, flat = c0 >= 0, c1**2 - c0 * c2
        # Expand Q where the radius is least, and find the ball that the line touches.
        expanded_at = np.where(b2 < 2 * m2, smaller_end, inmost)
        x, reach, c0, c1 = ball(expanded_at)
        g = slope[:, None] * x - reach[:, None] * b
        steep = dot(g, g) - dot(np.cross(x, b), ray) ** 2
        w = e_r * np.sqrt(np.maximum(np.where(is_steep, steep, flat), 0) / length2)
        step = np.where(w * c1 > 0, (c1**2 - e_r**2 * c0) / (length2 * (w + c1)), (w - c1) / c2)
        end = np.where(slope == 0, np.where(e_r < 0, 1.0, 0.0), larger_end)
        at_end = is_steep & ((e_r * slope <= 0) | (length2 <= 0))
        s = np.where(at_end, end, np.clip(np.nan_to_num(expanded_at + step), 0, 1))
        depth = np.where(hits, p_r + s * e_r - np.sqrt(np.maximum(ball(s)[2], 0)), np.nan)
    return (depth + shift) / length, s


def bits(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the bits of floats, with one NaN."""
    return np.where(np.isnan(values), np.full_like(values, np.nan), values).view(f"u{values.itemsize}")
