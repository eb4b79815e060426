"""The primitives within a radius of points, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray
from ...geometry.any_geometry import AnyGeometry
from ...support.texts import counted
from ..compressed_rows import CompressedRows
from .backend import NearLists
from .near_prims import NearPrims
from .points import PointBatch


@dataclass(frozen=True, eq=False, repr=False)
class Within(CompressedRows, NearPrims):
    """All primitives within the radius of each point, each once, sorted by (point, distance, prim).

    Those of point i are entries ``offsets[i]`` to ``offsets[i + 1]`` of the other arrays (compressed sparse rows).

    Attributes
    ----------
    offsets : (n_points + 1,) int64
        The first entry of each point, in the order of the flattened input, and the end of the last.
    prim, u, distance, skipped, geometry, query_points, part
        As in `Nearest`, one entry a primitive; so are `row` and `strand`.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
    >>> found = tree.within([[0, 0, 0.25], [9, 9, 9]], 1)
    >>> print(found.offsets, found.prim, found.distance, found.point)
    [0 2 2] [0 1] [0.25 0.75] [0 0]
    """

    offsets: IntArray
    prim: IntArray
    u: FloatArray
    distance: FloatArray
    skipped: IntArray
    geometry: AnyGeometry | None = None
    query_points: PointBatch | None = None
    part: IntArray | None = None

    @classmethod
    def from_lists(cls, lists: NearLists, points: PointBatch, geometry: AnyGeometry) -> Within:
        """Wrap the lists of a backend."""
        offsets, (distance, prim, u) = lists
        if points.rows is not None:
            counts = np.zeros(points.n_given, np.int64)
            counts[points.rows] = np.diff(offsets)
            offsets = np.concatenate([[0], np.cumsum(counts)])
        part, prim = geometry.split(prim.view(np.int64))
        return cls(offsets.view(np.int64), prim, u, distance, points.skipped, geometry, points, part)

    def _point_of_found(self) -> IntArray:
        return self.point

    def __repr__(self) -> str:
        return f"<Within: {counted(len(self.offsets) - 1, 'points')}, {counted(len(self), 'primitives')}>"

    @property
    def point(self) -> IntArray:
        """The index of the point of each entry, (n_entries,) int64."""
        return self._row_of_entries

    def of(self, point: int) -> slice:
        """Return the slice of the entries of a point: ``found.prim[found.of(3)]``.

        Raises
        ------
        InputError
            If there is no such point; points count from 0.
        """
        return self._entries_of("point", point)
