"""Smooth directions of polylines: those of splines through the same points, so that highlights have no steps.

At a point between two segments, the direction is the mean of both; along a segment it is interpolated between its ends.
Corners stay sharp where a strand turns by more than 60°.
"""

from __future__ import annotations

import numpy as np

from ..arrays import AnyArray, FloatArray, IntArray
from ..engines import engine


def smooth_tangents(
    segments: FloatArray, strands: IntArray, prim: IntArray, u: AnyArray, tangents: AnyArray
) -> FloatArray:
    """Return unit vectors along strands at places u of some segments, whose own directions are given, (m, 3).

    Examples
    --------
    >>> from fastlines.support.vectors import unit
    >>> bend = np.float32([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 1, 0]]])
    >>> prim, u = np.array([0, 0, 1]), np.float32([0.5, 1, 0.5])
    >>> smooth_tangents(bend, np.zeros(2, int), prim, u, unit(bend[prim, 1] - bend[prim, 0]))[:, 1].round(2)
    array([0.2 , 0.38, 0.56], dtype=float32)
    """
    return engine.smooth_tangents(segments, strands, prim, np.asarray(u, np.float32), np.asarray(tangents, np.float32))
