"""Where primitives are along their strands, as the core reads it to leave out neighbours there."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...geometry.any_geometry import AnyGeometry
from ...geometry.axis_geometry import AxisGeometry
from ..ignore import strand_numbers

Int32Array = npt.NDArray[np.int32]


def strand_places(geometry: AnyGeometry) -> Int32Array | None:
    """Return the place of each row of the core along its strand, (n_rows, 3) int32; None if there are no strands.

    The columns are the number of the strand, different for each part of a `Geometry`, or -1; the position of the
    primitive among those of its strand, in the order of their numbers; and how many primitives the strand has if it is
    closed, or 0. A strand is closed if its last primitive ends where its first one starts.
    """
    strand_of_prim = strand_numbers(geometry, np.arange(len(geometry)))
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
    first, last = has[begins], has[begins + sizes - 1]
    is_closed = np.ones(len(first), np.bool_)
    for axis in range(3):
        is_closed &= _ends_of(geometry, first, 0)[:, axis] == _ends_of(geometry, last, 1)[:, axis]
    places = np.full((len(strand_of_prim), 3), (-1, -1, 0), np.int32)
    places[has, 0] = np.repeat(np.arange(len(begins)), sizes)
    places[has, 1] = np.arange(len(strand)) - np.repeat(begins, sizes)
    places[has, 2] = np.repeat(np.where(is_closed, sizes, 0), sizes)
    return places[geometry.owner] if geometry.in_pieces else places


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
