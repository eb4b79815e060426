"""Scenes of strands, and how they are divided into tiles."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import fastlines as fl


def strands(n: int = 300, seed: int = 0, **more: Any) -> fl.Lines:
    """Return n segments in strands of 10; the last strand is closed. `more` has values for 11 points a strand."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (n // 10, 1, 3)) + rng.normal(0, 0.05, (n // 10, 11, 3)).cumsum(axis=1)
    points[-1, -1] = points[-1, 0]
    return fl.Lines.from_points(points.reshape(-1, 3), np.full(n // 10, 11), **more)


def tiles_of(lines: fl.Lines, n_tiles: int) -> npt.NDArray[np.int64]:
    """Return a tile for each segment, by x, so that strands lie in several tiles."""
    return np.argsort(np.argsort(lines.segments[:, 0, 0])) * n_tiles // max(1, len(lines))
