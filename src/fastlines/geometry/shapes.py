"""Shapes as the core reads them: round cones, triangles and boxes in rows of one length, so that they can be mixed."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, box_of
from ..support.immutable import own

#: What the core calls shapes that are mixed.
SHAPES = "shapes"

#: The kinds of shapes, as cpp/fastlines/primitives/shapes.hpp numbers them.
ROUND_CONE, TRIANGLE, BOX, BOUND = range(4)


def shape_rows(shape: int, numbers: FloatArray) -> FloatArray:
    """Return shapes as the core reads them, (n, 10) float32: up to nine numbers of each, and its kind."""
    rows = np.zeros((len(numbers), 10), np.float32)
    rows[:, : numbers.shape[1]] = numbers
    rows[:, 9] = shape
    return np.asarray(own(rows))


def box_of_shapes(rows: FloatArray) -> FloatArray:
    """Return the box of all shapes as (2, 3), rounded as cpp/fastlines/primitives/round_cone_clip.hpp does."""
    is_cone, is_triangle = rows[:, 9] == ROUND_CONE, rows[:, 9] == TRIANGLE
    axes, radii = rows[is_cone, :6].reshape(-1, 3), rows[is_cone, 6:8].reshape(-1, 1)
    low, high = (np.nextafter(axes + sign * radii, np.float32(sign * np.inf)) for sign in (-1, 1))
    round_cones = (np.where(radii > 0, corners, axes) for corners in (low, high))
    triangles, boxes = rows[is_triangle, :9], rows[~(is_cone | is_triangle), :6]
    return box_of(np.concatenate([*round_cones, triangles.reshape(-1, 3), boxes.reshape(-1, 3)]))
