"""Shapes as the core reads them: round cones, triangles and boxes in rows of one length, so that they can be mixed."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..support.immutable import own

#: The kinds of shapes, as cpp/fastlines/primitives/shapes.hpp numbers them.
ROUND_CONE, TRIANGLE, BOX, BOUND = range(4)


def shape_rows(shape: int, numbers: FloatArray) -> FloatArray:
    """Return shapes as the core reads them, (n, 10) float32: up to nine numbers of each, and its kind."""
    rows = np.zeros((len(numbers), 10), np.float32)
    rows[:, : numbers.shape[1]] = numbers
    rows[:, 9] = shape
    return np.asarray(own(rows))
