"""Boxes to ask of a scene, and what is in them as a matrix."""

from __future__ import annotations

from typing import Any

import numpy as np

import fastlines as fl


def boxes_on(segments: Any, seed: int = 0, n: int = 40) -> tuple[Any, Any]:
    """Return boxes of all sizes, with corners at ends of lines: many touch; some are points or have infinite sides."""
    rng = np.random.default_rng(seed)
    ends = np.asarray(segments, np.float64).reshape(-1, 3)
    if not len(ends):
        ends = np.zeros((1, 3))
    size = float(np.ptp(ends, axis=0).max()) or 1.0
    start = ends[rng.integers(len(ends), size=n)]
    reach = size * 10.0 ** rng.uniform(-5, 0.5, (n, 1)) * rng.random((n, 3))
    other = np.where(rng.random((n, 1)) < 0.4, ends[rng.integers(len(ends), size=n)], start + reach)
    other[::8] = start[::8]
    low, high = np.minimum(start, other), np.maximum(start, other)
    low[1::8, rng.integers(3)] = -np.inf
    high[2::8, rng.integers(3)] = np.inf
    return low, high


def matrix(found: fl.InBox, n: int) -> Any:
    """Return whether each primitive is in each box, (n_boxes, n) bool."""
    is_in = np.zeros((len(found.counts), n), bool)
    is_in[found.box, found.prim_number] = True
    return is_in
