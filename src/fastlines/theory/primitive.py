"""Boxes and primitives (thesis §3.1): segments, blocks, or your own; and rounding to float32."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from ..support.texts import point_text

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


class Primitive(Protocol):
    """The contract of a primitive, and of the part of one that a node holds."""

    @property
    def id(self) -> int:
        """Return the id of this primitive, or of the one that it is a part of."""

    def bounds(self) -> Box:
        """Return the smallest box around it, AABB(p)."""

    def clip(self, box: Box) -> Primitive | None:
        """Return the part of it in a box, which is a primitive again; None if there is none."""


Prims: TypeAlias = Sequence[Primitive]


def hull(prims: Sequence[Primitive]) -> Box:
    """Return the smallest box around some primitives, AABB(∪p)."""
    los, his = zip(*(prim.bounds() for prim in prims), strict=True)
    return Box(tuple(map(min, zip(*los, strict=True))), tuple(map(max, zip(*his, strict=True))))


class Segment(NamedTuple):
    """The piece of a line p + s·(q − p) with s from s0 to s1, which goes from `start` to `end`.

    Cuts are computed from p and q, so that pieces of pieces do not drift. The last piece has s1 = ∞.
    """

    id: int
    p: Point
    q: Point
    start: Point
    end: Point
    s0: float = 0.0
    s1: float = math.inf

    def __repr__(self) -> str:
        is_piece = self.s0 > 0 or self.s1 < math.inf
        piece = f", s from {self.s0:.4g} to {min(self.s1, 1.0):.4g}" if is_piece else ""
        return f"<Segment {self.id}: {point_text(self.start)} to {point_text(self.end)}{piece}>"

    def bounds(self) -> Box:
        """Return the box of both ends."""
        return Box(tuple(map(min, self.start, self.end)), tuple(map(max, self.start, self.end)))

    def clip(self, box: Box) -> Segment | None:
        """Cut off the parts beyond each side of a box."""
        part = self
        for axis in range(3):
            lo, hi = sorted((part.start[axis], part.end[axis]))
            if hi < box.lo[axis] or lo > box.hi[axis]:
                return None
            if lo < box.lo[axis]:
                _, part = part.cut(axis, box.lo[axis])
            if hi > box.hi[axis]:
                part, _ = part.cut(axis, box.hi[axis])
        return part

    def cut(self, axis: int, plane: float) -> tuple[Segment, Segment]:
        """Cut it at a plane into the parts below and above."""
        p, q = self.p, self.q
        s = f32((plane - p[axis]) * (1 / (q[axis] - p[axis])))
        s = sorted((self.s0, s, min(self.s1, 1.0)))[1]  # the one in the middle
        at = q if s == 1 else tuple(f32(a + s * (b - a)) for a, b in zip(p, q, strict=True))
        at = tuple(sorted(three)[1] for three in zip(self.start, put(at, axis, plane), self.end, strict=True))
        first, second = self._replace(end=at, s1=s), self._replace(start=at, s0=s)
        return (first, second) if p[axis] <= q[axis] else (second, first)


def segments(ends: npt.ArrayLike) -> list[Segment]:
    """Make primitives of an (n, 2, 3) array."""
    rows = np.asarray(ends, np.float32).reshape(-1, 2, 3).tolist()
    return [Segment(i, tuple(p), tuple(q), tuple(p), tuple(q)) for i, (p, q) in enumerate(rows)]


class Block(NamedTuple):
    """A primitive that fills its box: the shortest example of one of your own."""

    id: int
    box: Box

    def bounds(self) -> Box:
        """Return the box."""
        return self.box

    def clip(self, box: Box) -> Block | None:
        """Intersect two boxes."""
        both = Box(tuple(map(max, self.box.lo, box.lo)), tuple(map(min, self.box.hi, box.hi)))
        return Block(self.id, both) if min(both.sides()) >= 0 else None
