"""What pairs are sought in: the primitives of a tree, or those of the tiles of a forest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ... import _core
from ...arrays import FloatArray, IntArray
from ...geometry.any_geometry import AnyGeometry
from .pair_query import RowArrays
from .strand_places import Int32Array


@dataclass(frozen=True, eq=False)
class PairSet:
    """Primitives that a search for pairs reads at once."""

    #: That of the layout.
    view: _core.LayoutView
    geometry: AnyGeometry
    #: The number of each primitive in the whole, rising; None if it is its own.
    ids: IntArray | None = None
    #: See `strand_places`; None where they are not needed, or without strands.
    places: Int32Array | None = None

    def rows(self, *, of_whole: bool) -> RowArrays:
        """Return what the core reads of each row; numbers in the whole if pairs are those of two parts of it."""
        return row_arrays(self.geometry, self.places, self._numbers if of_whole else None)

    @property
    def _numbers(self) -> IntArray:
        return np.arange(len(self.geometry)) if self.ids is None else self.ids

    def number(self, prim: int) -> int:
        """Return the number of a primitive in the whole."""
        return int(self._numbers[prim])

    def range(self, begin: int, end: int) -> tuple[int, int]:
        """Return the range of primitives whose numbers in the whole are from begin up to end."""
        if self.ids is None:
            return begin, end
        first, last = np.searchsorted(self.ids, [begin, end])
        return int(first), int(last)

    def named(self, rows: IntArray, s: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the numbers in the whole of the primitives of rows of the core, and the places on them."""
        prim, u = self.geometry.parameter(rows, s) if self.geometry.in_pieces else (rows, s)
        return prim if self.ids is None else self.ids[prim], u


def row_arrays(geometry: AnyGeometry, places: Int32Array | None, numbers: IntArray | None = None) -> RowArrays:
    """Return what the core reads of each row of a geometry."""
    return np.ascontiguousarray(geometry.owner) if geometry.in_pieces else None, numbers, places


class PairSets(Protocol):
    """Sets of primitives that make up a whole."""

    def __len__(self) -> int:
        """Return the number of sets."""

    def boxes(self) -> FloatArray:
        """Return the boxes of the sets, with radii, (n_sets, 2, 3); the lowest corner is inf for an empty set."""

    def near(self, low: FloatArray, high: FloatArray) -> tuple[IntArray, IntArray]:
        """List the sets whose boxes, with radii, may meet each of some boxes: offsets, and the numbers of sets."""

    def open(self, number: int, *, with_places: bool) -> PairSet:
        """Return a set; with places along strands, if there are any."""


@dataclass(frozen=True, eq=False)
class TreeSet:
    """The one set of a tree."""

    geometry: AnyGeometry
    view: Callable[[], _core.LayoutView]
    places: Callable[[], Int32Array | None]

    def __len__(self) -> int:
        return 1

    def boxes(self) -> FloatArray:
        """See `PairSets`."""
        radius = np.float32(self.geometry.max_radius)
        low, high = self.geometry.bounds
        return np.stack([low - radius, high + radius])[None]

    def near(self, low: FloatArray, high: FloatArray) -> tuple[IntArray, IntArray]:
        """See `PairSets`; it may always be near."""
        return np.arange(len(low) + 1), np.zeros(len(low), np.int64)

    def open(self, number: int, *, with_places: bool) -> PairSet:
        """See `PairSets`."""
        return PairSet(self.view(), self.geometry, None, self.places() if with_places else None)
