"""What queries about points leave out, as the core reads it: rows that no point sees, and numbers for each point."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...geometry.any_geometry import AnyGeometry
from ...support.distinct import is_among
from .points import PointBatch

#: For each row of the core whether no point sees it, and its primitive, where they differ. Then what each point leaves
#: out: numbers (n_points, m), and the number of each row that they are compared with, if it is not that of the row.
Seen: TypeAlias = tuple[npt.NDArray[np.uint8] | None, IntArray | None, list[tuple[IntArray, IntArray | None]]]


def seen(geometry: AnyGeometry, points: PointBatch) -> Seen:
    """Return which rows of the core the points see, and how rows are joined to primitives."""
    owner = geometry.owner if geometry.in_pieces or geometry.has_user_code else None
    hidden, per_point = None, []
    if points.parts is not None:
        hidden = _hidden_by_parts(geometry, points.parts)
    for ignored in points.ignored:
        of_row = owner
        if ignored.are_strands:
            of_row = ignored.compared(geometry, np.arange(len(geometry)) if owner is None else owner)
        if ignored.is_per_ray:
            per_point.append((np.ascontiguousarray(ignored.numbers), of_row))
        elif ignored.numbers.size:
            numbers = ignored.numbers[ignored.numbers >= 0]
            dropped: Any = numbers if of_row is None else is_among(of_row, numbers)
            hidden = np.zeros(len(geometry.core_rows), np.uint8) if hidden is None else hidden
            hidden[dropped] = 1
    return hidden, owner, per_point


def _hidden_by_parts(geometry: AnyGeometry, parts: tuple[int, ...]) -> npt.NDArray[np.uint8]:
    """Return 1 for each row of the core that belongs to another part."""
    # The rows of a part follow each other, and so do their primitives.
    ends = np.cumsum([len(part) for part in geometry.each_part()])
    n_rows = np.diff(np.searchsorted(geometry.owner, ends), prepend=0)
    is_hidden = np.ones(len(n_rows), np.uint8)
    is_hidden[list(parts)] = 0
    return np.repeat(is_hidden, n_rows)
