"""A round cone as a primitive: all balls around c(s) = p + s·(q − p) with radius r(s), linear in s, for s in [0, 1].

What of it lies in a box is convex. Let g_k(s) be how far c(s) lies outside the box along axis k. The ball at s meets
the box if Σ g² ≤ r². Along axis k it then reaches up to

    h(s) = c_k + √(r² − the sum of g² over the other two axes),

but no farther than the box. h is concave. Between the places where c crosses a side of the box, each g is linear in s.
So the radicand is a polynomial Q = a·s² + b·s + c there, and h is largest at an end of an interval of balls that meet
the box, or where its derivative is 0: Q'² = 4·c_k'²·Q, which is a quadratic equation in s.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..support.texts import point_text
from .primitive import Block, Box, Point

#: x + y·s.
Linear: TypeAlias = tuple[float, float]
#: An interval of s, and g on each axis there.
Span: TypeAlias = tuple[float, float, list[Linear]]


class Cone(NamedTuple):
    """What of a round cone lies in `part`, the smallest box around it.

    A part of a part is computed from the whole cone, in float64. A box that cuts nothing off leaves every bit as it is.
    """

    id: int
    p: Point
    q: Point
    radii: tuple[float, float]
    part: Box

    def __repr__(self) -> str:
        (lo, hi), (start, end) = self.part, self.radii
        box = f"{point_text(lo)} to {point_text(hi)}"
        return f"<Cone {self.id}: radius {start:.4g} to {end:.4g}, its part in the box {box}>"

    def bounds(self) -> Box:
        """Return the box."""
        return self.part

    def clip(self, box: Box) -> Cone | None:
        """Return what of it lies in another box, too; None if nothing does."""
        both = Block(self.id, self.part).clip(box)
        if both is None or both.box == self.part:
            return both and self
        spans = [*self._spans(both.box)]
        if not spans:
            return None
        lo = tuple(-max(self._reaches(both.box, axis, -1, spans)) for axis in range(3))
        hi = tuple(max(self._reaches(both.box, axis, 1, spans)) for axis in range(3))
        return self._replace(part=Box(lo, hi))

    def _spans(self, box: Box) -> Iterator[Span]:
        """Yield the intervals of s in which balls meet a box."""
        axes = [*zip(self.p, self.q, *box, strict=True)]
        crossings = [(side - p) / (q - p) for p, q, *sides in axes if p != q for side in sides]
        ends = [0.0, *sorted(s for s in crossings if 0 < s < 1), 1.0]
        for first, last in itertools.pairwise(ends):
            gaps = list[Linear]()
            for p, q, lo, hi in axes:
                middle = p + (first + last) / 2 * (q - p)
                side = min(max(middle, lo), hi)
                gaps.append((p - side, q - p) if side != middle else (0.0, 0.0))
            inside = [s for s in _roots(*self._room(gaps)) if first < s < last]
            for a, b in zip([first, *inside], [*inside, last], strict=True):
                if self._room_at(gaps, (a + b) / 2) >= 0:
                    yield a, b, gaps

    def _reaches(self, box: Box, axis: int, sign: int, spans: Sequence[Span]) -> Iterator[float]:
        """Yield how far balls reach in a box along an axis, upwards or (−1) downwards; the largest is the most."""
        p, step = sign * self.p[axis], sign * (self.q[axis] - self.p[axis])
        near, far = sorted(sign * corner[axis] for corner in box)
        for first, last, gaps in spans:
            others = [gap for k, gap in enumerate(gaps) if k != axis]
            a, b, c = self._room(others)
            turns = _roots(4 * a * (a - step**2), 4 * b * (a - step**2), b**2 - 4 * step**2 * c)
            for s in (first, last, *turns):
                if first <= s <= last:
                    yield min(max(p + s * step + math.sqrt(max(0.0, self._room_at(others, s))), near), far)

    def _room(self, gaps: Sequence[Linear]) -> tuple[float, float, float]:
        """Return r² − Σ g² as a, b and c of a·s² + b·s + c."""
        start, step = self.radii[0], self.radii[1] - self.radii[0]
        a = step**2 - sum(y**2 for _, y in gaps)
        b = 2 * (start * step - sum(x * y for x, y in gaps))
        return a, b, start**2 - sum(x**2 for x, _ in gaps)

    def _room_at(self, gaps: Sequence[Linear], s: float) -> float:
        """Return r² − Σ g² at s, with less rounding than the polynomial has."""
        return (self.radii[0] + s * (self.radii[1] - self.radii[0])) ** 2 - sum((x + s * y) ** 2 for x, y in gaps)


def cones(ends: npt.ArrayLike, radii: npt.ArrayLike) -> list[Cone]:
    """Make primitives of the ends of axes, (n, 2, 3), and the radii there, (n, 2).

    Examples
    --------
    >>> cone, = cones([[[0, 0, 0], [4, 0, 0]]], [[1, 2]])
    >>> cone.bounds()
    Box(lo=(-1.0, -2.0, -2.0), hi=(6.0, 2.0, 2.0))
    >>> low, high = cone.bounds().split(0, -0.5)
    >>> print(cone.clip(low).bounds().hi)
    (-0.5, 0.8660254037844386, 0.8660254037844386)
    """
    rows = np.asarray(ends, np.float32).astype(np.float64).reshape(-1, 2, 3)
    widths = np.asarray(radii, np.float32).astype(np.float64).reshape(-1, 2)
    lows, highs = (rows - widths[..., None]).min(axis=1), (rows + widths[..., None]).max(axis=1)
    numbers = zip(*(array.tolist() for array in (rows, widths, lows, highs)), strict=True)
    return [
        Cone(i, tuple(p), tuple(q), (start, end), Box(tuple(low), tuple(high)))
        for i, ((p, q), (start, end), low, high) in enumerate(numbers)
    ]


def _roots(a: float, b: float, c: float) -> list[float]:
    """Return the roots of a·s² + b·s + c, rising; none where it is constant."""
    discriminant = b * b - 4 * a * c
    if discriminant < 0 or (a == 0 and b == 0):
        return []
    larger = -(b + math.copysign(math.sqrt(discriminant), b)) / 2  # without cancellation
    return sorted(top / bottom for top, bottom in ((larger, a), (c, larger)) if bottom != 0)
