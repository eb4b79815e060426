"""The numbers of primitives that a query has found: rows and strands, in the shape of the answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ..arrays import IntArray
from ..support.computed_once import computed_once
from ..support.immutable import own
from .answer import Answer


class PrimNumbers(Answer):
    """Primitives of a geometry; -1 is a miss."""

    prim: IntArray
    part: IntArray | None

    _in_pickles: ClassVar[tuple[str, ...]] = ("row", "strand")

    @computed_once
    def row(self) -> IntArray:
        """The row of the input that each segment was, int64 of the shape of ``prim``; -1 = miss. Read-only.

        It differs from ``prim`` where rows of the input were skipped.
        """
        return self._looked_up(self._known().rows_of)

    @computed_once
    def strand(self) -> IntArray:
        """The strand of each segment or curve, int64 of the shape of ``prim``; -1 = miss, or none. Read-only.

        Each part of a `Geometry` counts its own strands.
        """
        return self._looked_up(self._known().strands_of)

    def _looked_up(self, look_up: Callable[[IntArray], IntArray]) -> IntArray:
        """Return a number of each primitive that was found; -1 for a miss."""
        numbers, is_found = np.full(self.prim.shape, -1), self.prim >= 0
        numbers[is_found] = look_up(self.prim_number[is_found])
        return np.asarray(own(numbers))

    @property
    def prim_number(self) -> IntArray:
        """The primitive, counted over all parts of a `Geometry`; -1 for a miss. Else it is `prim`."""
        return self._known().number(self.part, self.prim)
