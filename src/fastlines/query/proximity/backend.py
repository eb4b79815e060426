"""Backends for queries about points: a compiled module answers them, on a tree or on all primitives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np

from ...arrays import FloatArray, IntArray
from ...geometry.any_geometry import AnyGeometry
from ...progress import ProgressCallback
from ...threads import get_num_threads
from .left_out import seen
from .points import PointBatch

#: Answers: distance, prim, u.
NearColumns: TypeAlias = tuple[FloatArray, IntArray, FloatArray]

#: Lists of answers: offsets (n_points + 1,), and the columns of all.
NearLists: TypeAlias = tuple[IntArray, NearColumns]


class PointBackend(Protocol):
    """Answers checked points about one geometry; the answers of all backends are the same, bit for bit.

    Answers are ranked by distance, then by id. A long call reports the fraction that is done, and ends at Ctrl-C.
    """

    def nearest(self, points: PointBatch, k: int, progress: ProgressCallback | None) -> NearColumns:
        """Find the k nearest primitives of each point within its radius, (n·k,); distance inf and prim -1 are none."""

    def within(self, points: PointBatch, progress: ProgressCallback | None) -> NearLists:
        """List the primitives within the radius of each point."""

    def count_within(self, points: PointBatch, progress: ProgressCallback | None) -> IntArray:
        """Count the primitives within the radius of each point."""


@dataclass(frozen=True)
class CompiledPoints:
    """The functions of a compiled module: the engine on a wide layout, or the core on all primitives."""

    functions: Any
    view: Any
    geometry: AnyGeometry

    def nearest(self, points: PointBatch, k: int, progress: ProgressCallback | None) -> NearColumns:
        """See `PointBackend`."""
        given = self.view, points.points, points.radius, k
        return self._named(self.functions.nearest(*given, *self._how(points, progress)))

    def within(self, points: PointBatch, progress: ProgressCallback | None) -> NearLists:
        """See `PointBackend`."""
        given = self.view, points.points, points.radius
        offsets, columns = self.functions.within(*given, *self._how(points, progress))
        return offsets, self._named(columns)

    def count_within(self, points: PointBatch, progress: ProgressCallback | None) -> IntArray:
        """See `PointBackend`."""
        given = self.view, points.points, points.radius
        counts: IntArray = self.functions.count_within(*given, *self._how(points, progress))
        return counts

    def _how(self, points: PointBatch, progress: ProgressCallback | None) -> tuple[Any, ...]:
        return points.surface, seen(self.geometry, points), get_num_threads(), progress

    def _named(self, columns: NearColumns) -> NearColumns:
        """Replace rows of the core by their primitives, and u on a row by that on the primitive."""
        distance, row, u = columns
        if not self.geometry.in_pieces:
            return distance, row, u
        prim, u, is_found = np.full(len(row), -1), u.copy(), row >= 0
        prim[is_found], u[is_found] = self.geometry.parameter(row[is_found], u[is_found])
        return distance, prim, u
