"""The variety of strands: each is brighter or darker than the mean."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, IntArray
from ..sampling.sobol import hashed


def shade_of_strands(strands: IntArray, variation: float) -> FloatArray:
    """Return by how much each strand is brighter than the mean: from 1 − variation to 1 + variation, (n,) float32.

    Examples
    --------
    >>> shades = shade_of_strands(np.arange(10_000), 0.25)
    >>> shades.min().round(2), shades.mean().round(2), shades.max().round(2)
    (np.float32(0.75), np.float32(1.0), np.float32(1.25))
    """
    chance = hashed(strands.astype(np.uint32)) * np.float32(2.0**-32)
    return np.asarray(1 + np.float32(variation) * (2 * chance - 1), np.float32)
