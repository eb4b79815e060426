"""Smooth directions of polylines: those of splines through the same points, so that highlights have no steps.

At a point between two segments, the direction is the mean of both; along a segment it is interpolated between its ends.
Corners stay sharp where a strand turns by more than 60°.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, IntArray
from ...geometry.collection import parts_of
from ...geometry.lines import Lines
from ...query.hits import AllHits
from ...support.vectors import dot, unit

#: Strands have a corner where the cosine of a turn is smaller.
CORNER = 0.5


def smooth_tangents(hits: AllHits) -> FloatArray:
    """Return a unit vector along the strand of each hit, (n, 3); zero where there is none.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.lines([[[0, 0, 0], [1, 0, 0], [2, 1, 0]]]))
    >>> hits = tree.all_hits([[0.5, 0, 9], [1, 0, 9], [1.5, 0.5, 9]], [0, 0, -1], 0.01)
    >>> print(smooth_tangents(hits)[:, 1].round(2))
    [0.2  0.38 0.38 0.56]
    """
    tangents = np.nan_to_num(hits.tangents()).astype(np.float32)
    assert hits.geometry is not None
    for number, part in enumerate(parts_of(hits.geometry)):
        if isinstance(part, Lines):
            rows = np.arange(len(tangents)) if hits.part is None else np.flatnonzero(hits.part == number)
            tangents[rows] = _smooth(part, hits.prim[rows], hits.u[rows], tangents[rows])
    return tangents


def _smooth(lines: Lines, prim: IntArray, u: FloatArray, own: FloatArray) -> FloatArray:
    """Return the smooth directions at places u of some segments, whose own directions are given."""
    last = len(lines) - 1
    before, after = np.maximum(prim - 1, 0), np.minimum(prim + 1, last)
    first = unit(own + _neighbour(lines, before, prim, before, own))
    second = unit(own + _neighbour(lines, prim, after, after, own))
    place = u.astype(np.float32)[:, None]
    return unit((1 - place) * first + place * second)


def _neighbour(lines: Lines, one: IntArray, next_one: IntArray, wanted: IntArray, own: FloatArray) -> FloatArray:
    """Return the direction of a neighbour where segments are joined without a corner; zero elsewhere."""
    segments, strands = lines.segments, lines.strands
    joined = (one != next_one) & (strands[one] == strands[next_one])
    joined &= (segments[one, 1] == segments[next_one, 0]).all(axis=1)
    direction = unit(segments[wanted, 1] - segments[wanted, 0])
    return np.where((joined & (dot(direction, own) > CORNER))[:, None], direction, np.float32(0))
