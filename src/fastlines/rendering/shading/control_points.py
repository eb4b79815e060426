"""The control points of axes: their ends, and how they begin."""

from __future__ import annotations

from typing import cast

import numpy as np

from ...arrays import FloatArray, IntArray
from ...forest.geometry import ForestGeometry
from ...geometry.any_geometry import AnyGeometry
from ...geometry.axis_geometry import AxisGeometry
from ...support.distinct import distinct


def control_points(geometry: AnyGeometry, prim: IntArray) -> tuple[IntArray, FloatArray]:
    """Return a row for each of some primitives, and the control points of these rows, (n, k, 3).

    Rows that follow each other are primitives that do. Those of a forest, which are not in memory, are gathered.

    Examples
    --------
    >>> import fastlines as fl
    >>> rows, points = control_points(fl.lines([[[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1, 0]]]), np.array([1]))
    >>> print(rows, points.shape)
    [1] (2, 2, 3)
    """
    if isinstance(geometry, AxisGeometry):
        return np.ascontiguousarray(prim), geometry.control_points
    forest = cast(ForestGeometry, geometry)
    known = distinct(np.clip(np.concatenate([prim - 1, prim, prim + 1]), 0, len(forest) - 1))
    ends = forest.ends_of(known)
    points = np.stack([ends[:, 0], ends[:, 0] + forest.first_directions_of(known), ends[:, 1]], axis=1)
    return np.searchsorted(known, prim), np.ascontiguousarray(points, np.float32)
