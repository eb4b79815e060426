"""The backend that answers rays by kernels, with arrays of the host."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..backend import HitColumns, HitLists
from ..errors import InputError
from ..progress import ProgressCallback
from ..rays import RayBatch
from .columns import DeviceColumns, scan
from .device import Memory
from .records import hits_record, lists_record, rays_record
from .scene import Scene

#: At most so many hits of each ray: all of them.
ALL = 2**64 - 1


@dataclass(frozen=True)
class RaysOnDevice:
    """`DeviceRays`, and what they point to."""

    n: int
    record: Memory
    parts: tuple[Memory, ...]


@dataclass(frozen=True)
class CudaBackend:
    """Answers checked rays on a device; see `Backend`."""

    scene: Scene

    def first_hit(self, rays: RayBatch, surface: bool, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        device = self.scene.device
        columns = DeviceColumns.allocate(device, len(rays), surface)
        hits = device.upload(hits_record(columns.pointers()))
        self._launch("first_surface" if surface else "first_closest", self._upload(rays), hits.pointer)
        found = columns.download(device)
        _report_end(progress)
        return found

    def any_hit(self, rays: RayBatch, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        device = self.scene.device
        found = device.allocate(len(rays))
        self._launch("any_hit", self._upload(rays), found.pointer)
        hit = device.download(found, np.bool_, len(rays))
        _report_end(progress)
        return hit

    def count_hits(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        device = self.scene.device
        found = device.allocate(8 * len(rays))
        self._launch("count_hits", self._upload(rays), ALL, found.pointer)
        counts = device.download(found, np.int64, len(rays))
        _report_end(progress)
        return counts

    def list_hits(
        self, rays: RayBatch, surface: bool, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        device, n = self.scene.device, len(rays)
        on_device = self._upload(rays)
        # Count the hits of each ray after a zero, and add them up.
        offsets = device.upload(np.zeros(n + 1, np.int64))
        counts = offsets.pointer + 8
        self._launch("count_hits", on_device, ALL if k is None else k, counts)
        if n:
            scan(device, self.scene.kernels, counts, n)
        n_hits = int(device.download(offsets, np.int64, 1, n)[0])
        # List them.
        columns = DeviceColumns.allocate(device, n_hits, surface)
        lists = device.upload(lists_record(offsets.pointer, columns.pointers()))
        which = "all" if k is None else "near" if by_distance else "next"
        self._launch(f"{which}_{'surface' if surface else 'closest'}", on_device, lists.pointer)
        found = device.download(offsets, np.int64, n + 1), columns.download(device)
        _report_end(progress)
        return found

    def _launch(self, name: str, rays: RaysOnDevice, *arguments: int) -> None:
        if rays.n:
            self.scene.kernels.launch(name, rays.n, self.scene.record.pointer, rays.record.pointer, *arguments)

    def _upload(self, rays: RayBatch) -> RaysOnDevice:
        if rays.has_spread:
            raise InputError("the GPU does not answer rays with a spread; query them on the CPU, or leave out spread=")
        arrays = rays.origins, rays.directions, rays.radius, rays.t_min, rays.t_max
        parts = [self.scene.device.upload(array) for array in arrays]
        steps = [0 if len(array) <= 1 else array.size // len(array) for array in arrays]
        record = self.scene.device.upload(rays_record([part.pointer for part in parts], 0, len(rays), steps))
        return RaysOnDevice(len(rays), record, tuple(parts))


def _report_end(progress: ProgressCallback | None) -> None:
    if progress is not None:
        progress(1.0)
