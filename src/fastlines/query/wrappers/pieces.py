"""The rows of a geometry in the core: pieces of curves, or whole primitives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from ... import _core
from ...arrays import IntArray
from ...geometry.any_geometry import AnyGeometry
from ...progress import ProgressCallback
from ...threads import get_num_threads
from ..at import At
from ..backend import Backend, HitColumns, HitLists
from ..rays import RayBatch

#: Rows as the core reads them.
View: TypeAlias = _core.LayoutView | _core.BinaryView


@dataclass(frozen=True)
class Pieces:
    """The rows of a geometry, a backend that finds them, and how they are joined."""

    backend: Backend
    geometry: AnyGeometry
    view: View

    def crossings(
        self,
        rays: RayBatch,
        found: tuple[IntArray, IntArray],
        is_complete: bool,
        at: At,
        k: int | None = None,
        by_distance: bool = False,
        progress: ProgressCallback | None = None,
    ) -> HitLists:
        """List where rays cross the primitives of some pieces, as hits of pieces; all crossings, or the best k.

        `found` are pieces that each ray hits: offsets, and the pieces. Unless they are complete, the ray is tested with
        all pieces of their primitives. The core defines a crossing (cpp/fastlines/query/crossings.hpp).
        """
        owner = self.geometry.owner if self.geometry.in_pieces else None
        offsets, pieces = found
        n_threads = get_num_threads()
        return _core.crossings(
            self.view, rays.arrays(), offsets, pieces, owner, is_complete, at, k, by_distance, n_threads, progress
        )

    def named(self, columns: HitColumns) -> HitColumns:
        """Replace pieces by their primitives, and u on a piece by that on the primitive."""
        t, piece, u, distance, t_out = columns
        return t, *self.geometry.on_prims(piece, u), distance, t_out
