"""Rays that leave vertices of paths."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray


@dataclass(frozen=True)
class LeavingRays:
    """Rays from vertices of paths.

    Attributes
    ----------
    points, directions : (n, 3) float32
        Where the vertices are, and unit vectors.
    start : (n,) float32
        How far each ray is within the fibre that it leaves.
    prim, strand : (n,) int64
        What it leaves: the number of the primitive, and the strand; -1 for none.
    """

    points: FloatArray
    directions: FloatArray
    start: FloatArray
    prim: IntArray
    strand: IntArray

    def __len__(self) -> int:
        return len(self.points)

    def some(self, rows: npt.NDArray[np.bool_] | IntArray) -> LeavingRays:
        """Return the rays in some rows."""
        return LeavingRays(*(getattr(self, field.name)[rows] for field in fields(self)))
