"""Cubic Bezier curves through the points of strands."""

from __future__ import annotations

import numpy as np

from fastlines import Lines

from ...harness.arrays import Float64Array, FloatArray
from ...harness.subjects import strands_of


def hair_curves(lines: Lines, step: int, radius: float, ratio: float = 0.2) -> tuple[FloatArray, FloatArray]:
    """Return cubic curves through about every `step`-th point of strands, which taper along each strand.

    The curves of a strand are a Catmull-Rom spline: the tangent at a point is half the vector between its neighbours.

    Parameters
    ----------
    lines : Lines
        Segments without a strand are strands of their own.
    step : int
    radius : float
        The radius where a strand begins.
    ratio : float
        The radius where a strand ends, as a fraction of `radius`.

    Returns
    -------
    control : (n, 4, 3) float32
    radius : (n, 4) float32
        The Bezier coefficients of both.
    """
    starts, counts = strands_of(lines)
    controls, radii, order = [], [], []
    for count in np.unique(counts):
        # Take the points of all strands of `count` segments.
        n_curves = max(1, round(int(count) / step))
        taken = np.round(np.linspace(0, count, n_curves + 1)).astype(np.int64)
        of_count = starts[counts == count]
        rows = of_count[:, None] + np.minimum(taken, count - 1)
        points = lines.segments[rows, (taken == count).astype(np.int64)].astype(np.float64)
        controls.append(catmull_rom(points).reshape(-1, 4, 3))
        share = (np.arange(n_curves)[:, None] + np.arange(4) / 3) / n_curves
        radii.append(np.tile(radius * (1 - (1 - ratio) * share), (len(of_count), 1)))
        order.append(rows[:, :-1].ravel())
    if not controls:
        return np.empty((0, 4, 3), np.float32), np.empty((0, 4), np.float32)
    sort = np.argsort(np.concatenate(order), kind="stable")
    return np.concatenate(controls)[sort].astype(np.float32), np.concatenate(radii)[sort].astype(np.float32)


def catmull_rom(points: Float64Array) -> Float64Array:
    """Return the Bezier control points, (s, m, 4, 3), of splines through points (s, m + 1, 3)."""
    before, after = np.roll(points, 1, axis=1), np.roll(points, -1, axis=1)
    before[:, 0], after[:, -1] = points[:, 0], points[:, -1]
    # At an end, the difference is one-sided.
    tangents = (after - before) / 2
    tangents[:, [0, -1]] *= 2
    p, q = points[:, :-1], points[:, 1:]
    return np.stack([p, p + tangents[:, :-1] / 3, q - tangents[:, 1:] / 3, q], axis=2)
