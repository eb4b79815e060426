"""Boxes, and rounding to float32 (thesis §3.1)."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np

Point: TypeAlias = tuple[float, ...]


def f32(x: float) -> float:
    """Round a number to float32."""
    return float(np.float32(x))


def put(point: Point, axis: int, x: float) -> Point:
    """Replace one coordinate."""
    return (*point[:axis], x, *point[axis + 1 :])


class Box(NamedTuple):
    """All points from one corner to another."""

    lo: Point
    hi: Point

    def sides(self) -> Point:
        """Return the lengths of the sides."""
        return tuple(hi - lo for lo, hi in zip(self.lo, self.hi, strict=True))

    def area(self) -> float:
        """Return the surface area, SA(q)."""
        x, y, z = self.sides()
        return 2 * (x * y + x * z + y * z)

    def centre(self, axis: int) -> float:
        """Return the middle of the box on one axis."""
        return (self.lo[axis] + self.hi[axis]) / 2

    def split(self, axis: int, plane: float) -> tuple[Box, Box]:
        """Cut the box in two at a plane."""
        return Box(self.lo, put(self.hi, axis, plane)), Box(put(self.lo, axis, plane), self.hi)
