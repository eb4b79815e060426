"""Where primitives are along their strands, and which of them are neighbours there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...geometry.any_geometry import AnyGeometry
from ...geometry.axis_geometry import AxisGeometry
from ..ignore import strand_of_prims

Int32Array = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class StrandPlaces:
    """The place of each row of the core along its strand.

    Attributes
    ----------
    places : (n_rows, 2) int32
        The number of the strand, different for each part of a `Geometry`, or -1; and the position of the primitive
        among those of its strand, in the order of their numbers.
    periods : (n_strands,) int32
        How many primitives a closed strand has, and 0 for an open one. A strand is closed if its last primitive ends
        where its first one starts.
    """

    places: Int32Array
    periods: Int32Array

    @classmethod
    def of(cls, geometry: AnyGeometry) -> StrandPlaces | None:
        """Return the places of the primitives of a geometry; None if they are in no strands."""
        strand_of_prim = strand_of_prims(geometry)
        has = np.flatnonzero(strand_of_prim >= 0)
        if not len(has):
            return None
        strand = strand_of_prim[has]
        if (strand[1:] < strand[:-1]).any():
            order = np.argsort(strand, kind="stable")
            has, strand = has[order], strand[order]
        # Now primitives are sorted by strand. Number the strands, and the primitives of each.
        begins = np.flatnonzero(np.concatenate([[True], strand[1:] != strand[:-1]]))
        sizes = np.diff(np.append(begins, len(strand)))
        places = np.full((len(strand_of_prim), 2), -1, np.int32)
        places[has, 0] = np.repeat(np.arange(len(begins)), sizes)
        places[has, 1] = np.arange(len(strand)) - np.repeat(begins, sizes)
        first, last = has[begins], has[begins + sizes - 1]
        is_closed = np.ones(len(first), np.bool_)
        for axis in range(3):
            is_closed &= _ends_of(geometry, first, 0)[:, axis] == _ends_of(geometry, last, 1)[:, axis]
        periods = np.where(is_closed, sizes, 0).astype(np.int32)
        return cls(places[geometry.owner] if geometry.in_pieces else places, periods)


def _ends_of(geometry: AnyGeometry, prim: IntArray, end: int) -> npt.NDArray[np.float32]:
    """Return the first or the second end of each primitive, (n, 3)."""
    ends = np.full((len(prim), 3), np.nan, np.float32)
    begin = 0
    for part in geometry.each_part():
        here = (begin <= prim) & (prim < begin + len(part))
        if isinstance(part, AxisGeometry):
            ends[here] = part.ends[prim[here] - begin, end]
        begin += len(part)
    return ends
