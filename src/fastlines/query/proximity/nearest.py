"""The nearest primitives of points, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray, IntArray
from ...geometry.any_geometry import AnyGeometry
from ...support.texts import counted
from .backend import NearColumns
from .near_prims import NearPrims
from .points import PointBatch


@dataclass(frozen=True, eq=False, repr=False)
class Nearest(NearPrims):
    """The nearest primitives of each point; every array has the shape of the points, and (…, k) unless k is 1.

    Attributes
    ----------
    prim : int64
        The index of the segment, curve, triangle or other primitive; -1 = miss. If rows of the input were skipped, it
        counts only the rows that are left, and `row` is the index in the input.
    u : float32
        The position of the nearest point on the segment or curve, from 0 to 1; 0 for what has no axis.
    distance : float32
        The distance from the axis or, with ``to="surface"``, from the surface: negative inside; inf = miss.
    skipped : (m,) int64
        With ``invalid="skip"``, the invalid points, which count as misses.
    geometry : Lines, Geometry or another container, or None
        What the tree is over. A pickle leaves out the geometry and the points, and keeps `row` and `strand`.
    query_points : PointBatch or None
        The points of the query, for `points`.
    part : int64 or None
        The part of a `Geometry`, -1 = miss; `prim` counts within it. None for a single container.
    k : int
        How many primitives were asked for.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 5, 0], [1, 5, 0]]])
    >>> found = fl.build(lines).nearest([[1.5, 0.5, 0], [0.5, 4, 0], [9, 9, 9]], max_distance=2)
    >>> print(found.prim, found.strand, found.distance)
    [ 1  2 -1] [ 0  1 -1] [0.5 1.  inf]
    """

    prim: IntArray
    u: FloatArray
    distance: FloatArray
    skipped: IntArray
    geometry: AnyGeometry | None = None
    query_points: PointBatch | None = None
    part: IntArray | None = None
    k: int = 1

    @classmethod
    def from_columns(cls, columns: NearColumns, k: int, points: PointBatch, geometry: AnyGeometry) -> Nearest:
        """Return the columns of a backend in the shape of the points."""
        shape = points.shape if k == 1 else (*points.shape, k)
        n, n_found = points.n_given, columns[0].size // max(1, len(points))
        rows = slice(None) if points.rows is None else points.rows

        def shaped(column: AnyArray, missing: float) -> AnyArray:
            """Return a column with misses for skipped points, and where there are fewer than k primitives."""
            found = column.reshape(len(points), n_found)
            if found.shape == (n, k):
                return found.reshape(shape)
            filled = np.full((n, k), missing, column.dtype)
            filled[rows, :n_found] = found
            return filled.reshape(shape)

        distance, prim, u = shaped(columns[0], np.inf), shaped(columns[1], -1), shaped(columns[2], 0)
        part, prim = geometry.split(prim.view(np.int64))
        return cls(prim, u, distance, points.skipped, geometry, points, part, k)

    def _point_of_found(self) -> IntArray:
        return np.flatnonzero(self.hit) // max(1, self.k)

    @property
    def counts(self) -> IntArray:
        """How many primitives each point has, int64 of the shape of the points."""
        return np.asarray(self.hit if self.k == 1 else self.hit.sum(axis=-1), np.int64)

    def __repr__(self) -> str:
        return f"<Nearest: {counted(self.counts.size, 'points')}, {counted(int(self.hit.sum()), 'answers')}>"

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """Whether there is a primitive, bool of the shape of ``prim``."""
        return self.prim >= 0
