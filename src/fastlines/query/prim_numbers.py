"""The numbers of primitives that a query has found: rows and strands, in the shape of the answer."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

import numpy as np

from ..arrays import IntArray
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..support.computed_once import computed_once
from ..support.display import Shown
from ..support.immutable import own

Self = TypeVar("Self")


class PrimNumbers(Shown):
    """Primitives of a geometry; -1 is a miss."""

    prim: IntArray
    geometry: AnyGeometry | None
    part: IntArray | None

    #: The fields that pickles leave out, besides what is computed once from them.
    unpickled: ClassVar[tuple[str, ...]] = ("geometry",)

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

    def _known(self) -> AnyGeometry:
        if self.geometry is None:
            raise InputError(
                "these hits do not know their geometry: a pickle has `row` and `strand` in its place; query again"
            )
        return self.geometry

    def __copy__(self: Self) -> Self:
        copied = object.__new__(type(self))
        copied.__dict__.update(self.__dict__)
        return copied

    def __deepcopy__(self: Self, memo: dict[int, Any]) -> Self:
        copied = copy.copy(self)
        shared = (*self.unpickled, "row", "strand")  # type: ignore[attr-defined]  # which no answer changes
        copied.__dict__.update({k: copy.deepcopy(v, memo) for k, v in self.__dict__.items() if k not in shared})
        return copied

    def __getstate__(self) -> dict[str, Any]:
        # Pickle the row and the strand of each primitive instead of the geometry.
        known = {"row": self.row, "strand": self.strand} if self.geometry is not None else {}
        kept = {name: value for name, value in self.__dict__.items() if name != "_outwards"}
        return kept | known | dict.fromkeys(self.unpickled)

    def __setstate__(self, state: dict[str, Any]) -> None:
        frozen = {name: own(state[name]) for name in ("row", "strand") if name in state}
        self.__dict__.update(state | frozen)
