"""Queries on curves: the core answers for their pieces, and here a hit gets the curve and its parameter.

A ray may meet several pieces of a curve where it crosses the curve once. Hits of one curve whose intervals at the
surface overlap are one crossing; its first piece is the hit. Rays with a spread have no such intervals: there,
neighbouring pieces are one crossing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...geometry.any_geometry import AnyGeometry
from ...progress import ProgressCallback
from ..backend import Backend, HitColumns, HitLists
from ..crossings import crossings, first_hits_of
from ..hit_lists import count_by_listing, first_of_each, offsets_of
from ..rays import RayBatch


@dataclass(frozen=True)
class CurveBackend:
    """Answers rays about curves, alone or with other geometry; see `Backend`."""

    pieces: Backend
    geometry: AnyGeometry

    @property
    def _owner(self) -> IntArray:
        """The primitive of each row of the core, counted over all parts."""
        return self.geometry.owner

    def first_hit(self, rays: RayBatch, surface: bool, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        return self._named(self.pieces.first_hit(rays, surface, progress))

    def any_hit(self, rays: RayBatch, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        return self.pieces.any_hit(rays, progress)

    def count_hits(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        # A list at the surface needs one search of the pieces, one at the closest approach needs two.
        surface = not rays.has_spread
        return count_by_listing(rays, lambda some: self.list_hits(some, surface, None, False, None), progress)

    def list_hits(
        self, rays: RayBatch, surface: bool, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        offsets, (t, piece, u, distance, t_out) = self.pieces.list_hits(rays, surface, None, False, progress)
        ray = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        if t_out is not None:
            crossing = crossings(ray, self._owner[piece], t, t_out)
        elif rays.has_spread:
            crossing = self._runs(ray, piece)
        else:
            # The same pieces are hit at their surface, in another order.
            entry, other, _, _, leave = self.pieces.list_hits(rays, True, None, False, progress)[1]
            assert leave is not None
            crossing = np.empty(len(ray), np.int64)
            at_surface = crossings(ray, self._owner[other], entry, leave)
            crossing[np.lexsort((piece, ray))] = at_surface[np.lexsort((other, ray))]
        first, ends = first_hits_of(crossing, t_out)
        columns = self._named((t[first], piece[first], u[first], distance[first], ends))
        return first_of_each(offsets_of(ray[first], len(rays)), columns, k, by_distance)

    def _runs(self, ray: IntArray, piece: IntArray) -> IntArray:
        """Number runs of neighbouring pieces of a curve: the crossings of rays with a spread, which meet no surface."""
        order = np.lexsort((piece, ray))
        ray, piece, owner = ray[order], piece[order], self._owner[piece[order]]
        begins = np.ones(len(order), bool)
        begins[1:] = (ray[1:] != ray[:-1]) | (owner[1:] != owner[:-1]) | (piece[1:] != piece[:-1] + 1)
        crossing = np.empty(len(order), np.int64)
        crossing[order] = np.cumsum(begins) - 1
        return crossing

    def _named(self, columns: HitColumns) -> HitColumns:
        """Replace pieces by their curves, and u on a piece by the parameter of the curve."""
        t, piece, u, distance, t_out = columns
        prim, u, hit = np.full(len(piece), -1), u.copy(), piece >= 0
        prim[hit], u[hit] = self.geometry.parameter(piece[hit], u[hit])
        return t, prim, u, distance, t_out
