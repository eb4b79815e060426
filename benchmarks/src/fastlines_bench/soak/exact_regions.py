"""Which primitives are in boxes of space, in numbers of 80 bits or float64, and where that is certain.

A primitive is in a box if they share a point (docs/answers.md). A line or a triangle is certain if it is in the box
that is smaller by the band on all sides, or is not in the larger one. A round cone is certain if the least distance
of its axis from the box, less the radius there, is farther from 0 than the band.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from .exact_pairs import GOLDEN, N_STEPS
from .scenes import Array

#: The width of the band, as a fraction of the largest coordinate; and of thick lines, as one of the scene's size.
REGION_BAND, THICK_BAND = 2.0**-48, 1e-12


def decide_in_boxes(kind: str, corners: Array, radii: Array | None, low: Array, high: Array) -> tuple[Array, Array]:
    """Return whether n primitives, (n, 2 or 3, 3) float32, are in m boxes, and where that is certain: (m, n) each."""
    wide, lows, highs = (np.asarray(of, np.longdouble) for of in (corners, low, high))
    finite = [np.abs(of[np.isfinite(of)]).max(initial=0.0) for of in (wide, lows, highs)]
    band = np.longdouble(REGION_BAND * max(map(float, finite)))
    if radii is not None and radii.any():
        size = float(np.ptp(wide.reshape(-1, 3), axis=0).max(initial=0.0) + 2 * radii.max())
        # The band of thick lines is wide enough for float64, relative to the centre of the scene.
        centre = wide.mean(axis=(0, 1))
        ends, low, high = ((of - centre).astype(np.float64) for of in (wide, lows, highs))
        depth = _depth_of_cones(ends, low, high, radii.astype(np.float64))
        return depth <= 0, np.abs(depth) > band + THICK_BAND * size
    test = {"boxes": _has_box, "triangles": _has_triangle}.get(kind, _has_line)
    exact, larger, smaller = (test(wide, lows - grow, highs + grow) for grow in (0 * band, band, -band))
    return exact, larger == smaller


def _has_line(ends: Array, low: Array, high: Array) -> Array:
    """Clip lines to the sides of boxes."""
    begin, end = np.zeros((len(low), len(ends)), ends.dtype), np.ones((len(low), len(ends)), ends.dtype)
    is_in = np.ones(begin.shape, bool)
    for k in range(3):
        p, e = ends[None, :, 0, k], ends[None, :, 1, k] - ends[None, :, 0, k]
        first, last = low[:, k, None] - p, high[:, k, None] - p
        with np.errstate(divide="ignore", invalid="ignore"):
            at = np.where(e > 0, first, last) / e, np.where(e > 0, last, first) / e
        is_across = e != 0
        begin = np.maximum(begin, np.where(is_across, at[0], 0))
        end = np.minimum(end, np.where(is_across, at[1], 1))
        is_in &= is_across | ((first <= 0) & (last >= 0))
    return is_in & (begin <= end)


def _has_box(corners: Array, low: Array, high: Array) -> Array:
    return np.asarray(((corners[None, :, 0] <= high[:, None]) & (corners[None, :, 1] >= low[:, None])).all(axis=2))


def _has_triangle(corners: Array, low: Array, high: Array) -> Array:
    """Look for an axis that separates triangles from boxes: of the sides, the normal, or an edge with a side."""
    edges = np.roll(corners, -1, axis=1) - corners
    axes: list[Array] = [np.eye(3, dtype=corners.dtype)[None, k] for k in range(3)]
    axes += [np.cross(edges[:, 0], edges[:, 1])]
    axes += [np.cross(edges[:, i], np.eye(3, dtype=corners.dtype)[k]) for i, k in product(range(3), range(3))]
    is_apart = np.repeat(np.any(low > high, axis=1, keepdims=True), len(corners), axis=1)
    for axis in axes:
        along = np.einsum("nik,nk->ni", corners, np.broadcast_to(axis, (len(corners), 3)))
        with np.errstate(invalid="ignore"):
            sides = np.stack([low[:, None] * axis, high[:, None] * axis])
        sides = np.where(np.broadcast_to(axis, sides.shape) == 0, 0, sides)  # 0 times an infinite side
        is_apart |= along.min(axis=1) > sides.max(axis=0).sum(axis=2)
        is_apart |= along.max(axis=1) < sides.min(axis=0).sum(axis=2)
    return ~is_apart


def _depth_of_cones(ends: Array, low: Array, high: Array, radii: Array) -> Array:
    """Return the least distance of axes from boxes, less the radius there, (m, n): the function of s is convex."""
    p, e = ends[None, :, 0], (ends[:, 1] - ends[:, 0])[None]
    slope = (radii[:, 1] - radii[:, 0])[None]

    def value(s: Any) -> Array:
        x = p + s[..., None] * e
        away = np.maximum(np.maximum(low[:, None] - x, x - high[:, None]), 0)
        return np.asarray(np.sqrt((away**2).sum(axis=2)) - (radii[None, :, 0] + s * slope))

    first = np.zeros((len(low), len(ends)), ends.dtype)
    last = first + 1
    least = np.minimum(value(first), value(last))
    for _ in range(N_STEPS):
        s, t = last - GOLDEN * (last - first), first + GOLDEN * (last - first)
        at_s, at_t = value(s), value(t)
        least = np.minimum(least, np.minimum(at_s, at_t))
        is_left = at_s < at_t
        first, last = np.where(is_left, first, s), np.where(is_left, t, last)
    return np.asarray(least)
