"""The distances of points from primitives in float64, from the definition (docs/answers.md)."""

from __future__ import annotations

from typing import Any

import numpy as np

from .exact import Vector, cross, dot, less, plus, vectors
from .scenes import Array

#: The width of the band, as a fraction of the size of the scene and of the distance.
POINT_BAND = 2.0**-21


def distance_from_cones(points: Array, ends: Array, radii: Array, is_paired: bool = False) -> Array:
    """Return the least D − r of each point, (m, 3), and round cone, (m, n): negative inside.

    As for rays, the function is convex, and its least value is that of three places: both ends, and where its
    derivative is 0. If point i is paired with round cone i alone, the answer is (m, 1).
    """
    w = less(tuple(points.T[:, :, None]), vectors(ends[:, 0], is_paired))
    e = vectors(ends[:, 1] - ends[:, 0], is_paired)
    r0, r1 = (radii[:, i : i + 1] if is_paired else radii[None, :, i] for i in range(2))
    slope = r1 - r0

    def value(s: Any) -> Array:
        x = plus(w, -s, e)
        return np.asarray(np.sqrt(dot(x, x)) - (r0 + s * slope))

    ee, we = dot(e, e), dot(w, e)
    beside = cross(w, e)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (we + np.sqrt(dot(beside, beside) / np.maximum(ee - slope * slope, 0)) * slope) / ee
    stationary = np.where(np.isfinite(s), np.minimum(np.maximum(s, 0), 1), 0)
    return np.minimum(np.minimum(value(0.0), value(1.0)), value(stationary))


def distance_from_triangles(points: Array, corners: Array, is_paired: bool = False) -> Array:
    """Return the distance of each point from each triangle, (m, n): from its edges, or from its inside."""
    none, x = np.zeros((len(corners), 2)), tuple(points.T[:, :, None])
    edges = [distance_from_cones(points, corners[:, [i, (i + 1) % 3]], none, is_paired) for i in range(3)]
    sides = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    a, u, v = (vectors(of, is_paired) for of in sides)
    n, w = cross(u, v), less(x, a)
    nn = dot(n, n)
    with np.errstate(divide="ignore", invalid="ignore"):
        beta, gamma = dot(cross(w, v), n) / nn, dot(cross(u, w), n) / nn
        plane = np.abs(dot(w, n)) / np.sqrt(nn)
    is_over = (nn > 0) & (beta >= 0) & (gamma >= 0) & (beta + gamma <= 1)
    return np.minimum(np.minimum.reduce(edges), np.where(is_over, plane, np.inf))


def distance_from_boxes(points: Array, corners: Array) -> Array:
    """Return the distance of each point from each box, (m, n); 0 inside."""
    x: Vector = tuple(points.T[:, :, None])
    low, high = vectors(corners[:, 0]), vectors(corners[:, 1])
    outside: Vector = tuple(np.maximum(np.maximum(low[k] - x[k], x[k] - high[k]), 0) for k in range(3))
    return np.asarray(np.sqrt(dot(outside, outside)))
