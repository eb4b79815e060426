"""What rays and points leave out, as tasks carry it: numbers, and not the strand of each primitive of the forest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...arrays import IntArray
from ...query.ignore import Ignored, strand_of_prims

if TYPE_CHECKING:
    from ..forest import Forest


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Numbers of primitives, or of strands, that each row of a chunk leaves out, or that all do."""

    numbers: IntArray
    by_strand: bool

    @classmethod
    def of(cls, ignored: tuple[Ignored, ...]) -> tuple[LeftOut, ...]:
        """Return what a chunk leaves out."""
        return tuple(cls(each.numbers, each.of_prim is not None) for each in ignored)

    def ignored(self, forest: Forest) -> Ignored:
        """Return it for the queries of a forest."""
        return Ignored(self.numbers, strand_of_prims(forest.geometry) if self.by_strand else None)
