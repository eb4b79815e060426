"""Smooth directions of polylines: those of splines through the same points, so that highlights have no steps.

At a point between two segments, the direction is the mean of both; along a segment it is interpolated between its ends.
Corners stay sharp where a strand turns by more than 60°.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..support.vectors import dot, unit

#: Strands have a corner where the cosine of a turn is smaller.
CORNER = 0.5


def smooth_tangents(
    segments: FloatArray, strands: IntArray, prim: IntArray, u: FloatArray, tangents: FloatArray
) -> FloatArray:
    """Return unit vectors along strands at places u of some segments, whose own directions are given, (m, 3).

    Examples
    --------
    >>> bend = np.float32([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 1, 0]]])
    >>> prim, u = np.array([0, 0, 1]), np.float32([0.5, 1, 0.5])
    >>> smooth_tangents(bend, np.zeros(2, int), prim, u, unit(bend[prim, 1] - bend[prim, 0]))[:, 1].round(2)
    array([0.2 , 0.38, 0.56], dtype=float32)
    """
    before, after = np.maximum(prim - 1, 0), np.minimum(prim + 1, len(segments) - 1)
    first = unit(tangents + _neighbour(segments, strands, before, prim, before, tangents))
    second = unit(tangents + _neighbour(segments, strands, prim, after, after, tangents))
    place = u.astype(np.float32)[:, None]
    return unit((1 - place) * first + place * second)


def _neighbour(
    segments: FloatArray, strands: IntArray, one: IntArray, next_one: IntArray, wanted: IntArray, tangents: FloatArray
) -> FloatArray:
    """Return the direction of a neighbour where segments are joined without a corner; zero elsewhere."""
    joined = (one != next_one) & (strands[one] == strands[next_one])
    joined &= (segments[one, 1] == segments[next_one, 0]).all(axis=1)
    direction = unit(segments[wanted, 1] - segments[wanted, 0])
    return np.where((joined & (dot(direction, tangents) > CORNER))[:, None], direction, np.float32(0))
