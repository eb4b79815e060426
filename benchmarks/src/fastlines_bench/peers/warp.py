"""A peer on GPUs: Warp's bounding volume hierarchy over the boxes of segments, with an exact test in the kernel.

Warp gives candidates in no order: those whose boxes, grown by the radius, the ray meets. The test of a segment is ours
in the coordinates of the scene, so the few hits that graze a segment may differ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fastlines import Lines

from ..harness.rays import RayBatch


def warp() -> Any:
    """Return Warp, or None if it is not installed."""
    try:
        import warp as found
    except ImportError:
        return None
    found.config.quiet = True
    return found


@dataclass(frozen=True)
class WarpQuery:
    """`run` answers all rays, and waits for it; `answer` then returns the primitives of first hits, or the counts."""

    run: Callable[[], None]
    answer: Callable[[], npt.NDArray[np.int64]]


class WarpScene:
    """Segments in Warp, on a GPU or, for tests, on the CPU."""

    def __init__(self, lines: Lines, device: str = "cuda") -> None:
        self._warp, self._device = warp(), device
        segments = np.ascontiguousarray(lines.segments, np.float32)
        self._ends = [self._upload(segments[:, end]) for end in (0, 1)]
        # Kept: the tree refers to them.
        self._corners = [self._upload(segments.min(axis=1)), self._upload(segments.max(axis=1))]
        self._bvh = self._warp.Bvh(*self._corners, constructor="sah")

    def query(self, query: str, batch: RayBatch, radius: float) -> WarpQuery | None:
        """Return a query of rays in the memory of the device, or None if there is no kernel for it."""
        from . import warp_kernels

        wp, n = self._warp, len(batch)
        rays = [self._upload(batch.origins), self._upload(batch.directions)]
        prim, t = wp.zeros(n, dtype=wp.int32, device=self._device), wp.zeros(n, dtype=float, device=self._device)
        kernels = {"first_hit": (warp_kernels.first_hit, [t, prim]), "count_hits": (warp_kernels.count_hits, [prim])}
        if query not in kernels:
            return None
        kernel, outputs = kernels[query]

        def run() -> None:
            inputs = [self._bvh.id, *self._ends, *rays, radius]
            wp.launch(kernel, dim=n, inputs=inputs, outputs=outputs, device=self._device)
            wp.synchronize_device(self._device)

        return WarpQuery(run, lambda: prim.numpy().astype(np.int64))

    def _upload(self, points: npt.NDArray[np.float32]) -> Any:
        points = np.ascontiguousarray(points)
        return self._warp.array(points, dtype=self._warp.vec3, device=self._device)
