"""The frame of a scene, computed as cpp/fastlines/rays/frame_of.hpp does, to the bit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray


@dataclass(frozen=True)
class Frame:
    """Coordinates in the frame are (x − centre)·scale; `overhang` is how far a hit can lie outside its box there."""

    centre: tuple[float, float, float]
    scale: float
    overhang: float


def frame_of(box: FloatArray, max_radius: float) -> Frame:
    """Return the frame of the box around the axes of primitives with radii up to `max_radius`."""
    low, high = (np.asarray(corner, np.float32).tolist() for corner in box)
    if any(a > b for a, b in zip(low, high, strict=True)):
        return Frame((0.0, 0.0, 0.0), 1.0, 0.0)
    centre = [float(np.float32(0.5 * (a + b))) for a, b in zip(low, high, strict=True)]
    half = max(max(b - c, c - a) for a, b, c in zip(low, high, centre, strict=True))
    # With half = m·2^e and m from 0.5 to 1, C's ilogb is e − 1.
    scale = math.ldexp(1.0, min(max(-math.frexp(half)[1], -120), 120)) if half > 0 else 1.0
    side = max(b - a for a, b in zip(low, high, strict=True))
    largest = max(map(abs, (*low, *high)))
    slack = math.ldexp(largest + side, -24) + math.ldexp(1.0, -150)
    radius = np.float32(max_radius) * np.float32(scale)
    overhang = np.float32(2.0 * slack * scale) + radius * np.float32(2.0**-19)
    return Frame((centre[0], centre[1], centre[2]), scale, float(overhang))
