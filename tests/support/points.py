"""Points to ask of a scene: on its lines, at their joints, near them, inside, and far away."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
from support import nasty

Array = np.ndarray


def points_of(case: nasty.Case, seed: int, n: int = 40) -> Array:
    """Return about n points, (n, 3) float64; most are no float32."""
    ends = case.segments.astype(np.float64)
    size = nasty.size_of(case.segments)
    rng = np.random.default_rng([seed, zlib.crc32(ends.tobytes())])
    near = nasty.targets(rng, ends, n // 2, size)
    on = nasty.targets(rng, ends, n // 8, 0)
    joints = ends.reshape(-1, 3)[rng.integers(0, max(1, 2 * len(ends)), n // 8)] if len(ends) else on
    away = nasty.sphere(rng, n // 4) * size * 10.0 ** rng.choice([0, 0.5, 3, 6, 11], (n // 4, 1))
    middle = ends.reshape(-1, 3).mean(axis=0) if len(ends) else np.zeros(3)
    return np.concatenate([near, on, joints, middle + away])


def radii_of(points: Array, case: nasty.Case, seed: int) -> dict[str, Any]:
    """Return radii by name: one for all, and one for each, of which some just reach the nearest end of a line."""
    size = nasty.size_of(case.segments)
    rng = np.random.default_rng([seed, len(points)])
    each = size * 10.0 ** rng.uniform(-6, 0.7, len(points))
    each[rng.random(len(points)) < 0.15] = 0
    if len(case.segments):
        corners = case.segments.reshape(-1, 3).astype(np.float64)
        least = np.linalg.norm(points[:, None] - corners, axis=2).min(axis=1)
        tuned = (rng.random(len(points)) < 0.4) & (least < 1e11 * size)
        each[tuned] = least[tuned]
    return {"zero": 0.0, "small": 1e-3 * size, "medium": 0.2 * size, "large": 3 * size, "each": np.float32(each)}
