"""How lines follow each other: where one ends, and whether the next one goes on from there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray


class AxisEnds(Protocol):
    """A geometry that knows the ends of its lines."""

    def __len__(self) -> int:
        """Return the number of lines."""

    def ends_of(self, prim: IntArray) -> FloatArray:
        """Return both ends of some lines, (m, 2, 3)."""

    def first_directions_of(self, prim: IntArray) -> FloatArray:
        """Return the direction at the start of some lines, of any length, (m, 3)."""


@dataclass(frozen=True)
class Following:
    """Looks up how lines follow each other."""

    lines: AxisEnds

    def continues(self, prim: IntArray) -> npt.NDArray[np.bool_]:
        """Return whether each line begins where the one before it ends; not for numbers that no line has."""
        found = (prim > 0) & (prim < len(self.lines))
        known = prim[found]
        found[found] = (self.lines.ends_of(known)[:, 0] == self.lines.ends_of(known - 1)[:, 1]).all(axis=1)
        return found
