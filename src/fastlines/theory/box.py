"""Boxes, and what a float32 makes of a number (thesis §3.1)."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np

Point: TypeAlias = tuple[float, ...]


def f32(x: float) -> float:
    """Round to what a float32 can hold."""
    return float(np.float32(x))


def put(point: Point, axis: int, x: float) -> Point:
    """Replace one coordinate."""
    return (*point[:axis], x, *point[axis + 1 :])


class Box(NamedTuple):
    """All points from one corner to another."""

    lo: Point
    hi: Point

    def sides(self) -> Point:
        """Return the lengths of its sides."""
        return tuple(hi - lo for lo, hi in zip(self.lo, self.hi, strict=True))

    def area(self) -> float:
        """Return the area of its surface, SA(q)."""
        x, y, z = self.sides()
        return 2 * (x * y + x * z + y * z)

    def centre(self, axis: int) -> float:
        """Return the middle of one side."""
        return (self.lo[axis] + self.hi[axis]) / 2

    def split(self, axis: int, plane: float) -> tuple[Box, Box]:
        """Cut it in two."""
        return Box(self.lo, put(self.hi, axis, plane)), Box(put(self.lo, axis, plane), self.hi)
