"""Backends: the engine of an instruction set, on the wide layout, or the core, on a tree as it was built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _core
from ..arrays import FloatArray, IntArray
from ..progress import ProgressCallback
from ..threads import check_wanted, get_num_threads
from .at import At

if TYPE_CHECKING:
    from .gather import GatherRule
    from .rays import RayBatch

#: Hits: t, prim, u, distance, and t_out unless t is at the closest approach.
HitColumns: TypeAlias = tuple[FloatArray, IntArray, FloatArray, FloatArray, FloatArray | None]

#: Lists of hits: offsets (n_rays + 1,), and the columns of all hits.
HitLists: TypeAlias = tuple[IntArray, HitColumns]

#: Of each ray: sums (n_rays, n_channels) float64, sums of squares or None, and how many hits have contributed.
GatherColumns: TypeAlias = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64] | None, IntArray]

#: The number of each kernel in the engine modules; "binary" searches the tree as it was built.
KERNELS = {"auto": 0, "single": 1, "wave": 2, "bundle": 3, "binary": -1}


class Backend(Protocol):
    """Answers checked rays about one set of lines; the answers of all backends are the same, bit for bit.

    With ``at="closest"``, t is at the closest approach. With ``"surface"``, it is where the ray enters the capsule of
    its radius around a segment, and ``t_out`` where it leaves. With ``"entry"``, only rays that enter hit. A long call
    reports the fraction that is done, and ends at Ctrl-C.
    """

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """Find the nearest hit of each ray; prim is -1 and t and distance are inf for a miss."""

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """Find out for each ray whether it hits anything."""

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """Count the segments that each ray hits."""

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """Count what a list of all hits of each ray holds while it is made: hits, and what is dropped or joined."""

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """List all hits of each ray by t and prim; or the first k of them; or the k nearest to the ray by distance."""

    def gather(self, rays: RayBatch, rule: GatherRule, progress: ProgressCallback | None) -> GatherColumns | None:
        """Sum over all hits of each ray; None where they have to be listed first, as by default."""
        return None


@dataclass(frozen=True)
class CompiledBackend:
    """The functions of a compiled module: the engine on a wide layout, or the core on a binary tree or all segments."""

    functions: Any
    view: _core.LayoutView | _core.BinaryView
    #: The number of the kernel, for a module that has kernels.
    kernel: tuple[int, ...] = ()

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        found: HitColumns = self.functions.first_hit(self.view, rays.arrays(), at, *self._how(progress))
        return found

    @property
    def joins_pieces(self) -> bool:
        """Whether it has `first_crossing`: the engine does."""
        return bool(self.kernel)

    def first_crossing(self, rays: RayBatch, owner: IntArray, at: At, progress: ProgressCallback | None) -> HitColumns:
        """Find the first crossing of each ray at the surface, as a hit of the piece that begins it.

        `owner` has the primitive of each piece; `distance` and ``t_out`` are those of the whole crossing.
        """
        how = self._how(progress)
        found: HitColumns = self.functions.first_crossing(self.view, rays.arrays(), owner, at, *how)
        return found

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        found: npt.NDArray[np.bool_] = self.functions.any_hit(self.view, rays.arrays(), at, *self._how(progress))
        return found

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        counts: IntArray = self.functions.count_hits(self.view, rays.arrays(), at, *self._how(progress))
        return counts

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`; these are the hits."""
        return self.count_hits(rays, "closest", progress)

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        how = self._how(progress)
        lists: HitLists = self.functions.list_hits(self.view, rays.arrays(), at, k, by_distance, *how)
        return lists

    def gather(self, rays: RayBatch, rule: GatherRule, progress: ProgressCallback | None) -> GatherColumns | None:
        """See `Backend`; a module without kernels lists hits."""
        if not self.kernel:
            return None
        how = self._how(progress)
        sums: GatherColumns | None = self.functions.gather(self.view, rays.arrays(), rule.arrays(), rule.squares, *how)
        return sums

    def _how(self, progress: ProgressCallback | None) -> tuple[Any, ...]:
        """Return the last arguments of every function of a module, if the answer is wanted."""
        check_wanted()
        return (*self.kernel, get_num_threads(), progress)
