"""Primitives of our own, and scenes of a few of them, for the tests of the theory."""

import math
import zlib
from typing import Any, NamedTuple

import numpy as np
from support.nasty import SCENES

from fastlines import theory as th

SCENE_NAMES = (
    *("random", "crossing", "star", "equal boxes", "axis parallel", "collinear", "flat", "duplicates", "points"),
    *("some points", "nearly points", "single", "outlier", "moved 1e4", "scale 1e-8", "scale 1e8"),
)


def scene(name: str, seed: int, n: int) -> Any:
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    return SCENES[name](rng, max(8, n))[:n].astype(np.float32)


class Ball(NamedTuple):
    """What of a ball lies within a box."""

    id: int
    centre: th.Point
    radius: float
    within: th.Box = th.Box((-math.inf,) * 3, (math.inf,) * 3)

    def gaps(self):
        """Squared distance from the centre to the box, by axis."""
        return [max(lo - x, 0, x - hi) ** 2 for x, lo, hi in zip(self.centre, *self.within, strict=True)]

    def bounds(self):
        gaps = self.gaps()
        reach = [math.sqrt(max(0, self.radius**2 - (sum(gaps) - gap))) for gap in gaps]
        lo = tuple(max(x - r, edge) for x, r, edge in zip(self.centre, reach, self.within.lo, strict=True))
        hi = tuple(min(x + r, edge) for x, r, edge in zip(self.centre, reach, self.within.hi, strict=True))
        return th.Box(lo, hi)

    def clip(self, box):
        block = th.Block(0, self.within).clip(box)
        part = self._replace(within=block.box) if block else None
        return part if part and sum(part.gaps()) <= self.radius**2 else None


class Triangle(NamedTuple):
    """What of a triangle lies within a box, with the arithmetic of primitives/triangles.hpp."""

    id: int
    corners: list[th.Point]
    box: th.Box

    def bounds(self):
        return self.box

    def clip(self, box):
        block = th.Block(0, self.box).clip(box)
        if block is None:
            return None
        polygon = self.corners
        for axis in range(3):
            for sign, plane in ((1.0, block.box.hi[axis]), (-1.0, block.box.lo[axis])):
                kept = []
                for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
                    beyond_a, beyond_b = sign * (a[axis] - plane), sign * (b[axis] - plane)
                    if beyond_a <= 0:
                        kept.append(a)
                    if beyond_a * beyond_b < 0:
                        s = beyond_a / (beyond_a - beyond_b)
                        kept.append(tuple(plane if k == axis else a[k] + s * (b[k] - a[k]) for k in range(3)))
                polygon = kept
        # Round outwards, but to where it was cut.
        lo, hi = list(block.box.lo), list(block.box.hi)
        for k in range(3 if polygon else 0):
            if lo[k] == self.box.lo[k]:
                lo[k] = max(lo[k], outwards(min(point[k] for point in polygon), -1))
            if hi[k] == self.box.hi[k]:
                hi[k] = min(hi[k], outwards(max(point[k] for point in polygon), 1))
        return self._replace(box=th.Box(tuple(lo), tuple(hi)))


def outwards(x: float, sign: int) -> float:
    at = np.float32(x)
    return float(np.nextafter(at, np.float32(sign * np.inf)) if sign * (x - float(at)) > 0 else at)


def a_box(points: list[th.Point]) -> th.Box:
    return th.Box(tuple(map(min, *points)), tuple(map(max, *points)))
