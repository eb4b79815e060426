"""The backend that answers rays by kernels; with arrays of the host, or of the device."""

from __future__ import annotations

from collections.abc import Sequence
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
    parts: tuple[object, ...]


@dataclass(frozen=True)
class ListsOnDevice:
    """Lists of hits: n + 1 offsets, and columns."""

    offsets: Memory
    columns: DeviceColumns


@dataclass(frozen=True)
class CudaBackend:
    """Answers checked rays on a device; see `Backend`."""

    scene: Scene

    def first_hit(self, rays: RayBatch, surface: bool, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        found = self.find_first(self.upload(rays), surface).download(self.scene.device)
        _report_end(progress)
        return found

    def any_hit(self, rays: RayBatch, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        hit = self.scene.device.download(self.find_any(self.upload(rays)), np.bool_, len(rays))
        _report_end(progress)
        return hit

    def count_hits(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        counts = self.scene.device.download(self.count(self.upload(rays)), np.int64, len(rays))
        _report_end(progress)
        return counts

    def list_hits(
        self, rays: RayBatch, surface: bool, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        device = self.scene.device
        lists = self.list(self.upload(rays), surface, k, by_distance)
        found = device.download(lists.offsets, np.int64, len(rays) + 1), lists.columns.download(device)
        _report_end(progress)
        return found

    def find_first(self, rays: RaysOnDevice, surface: bool) -> DeviceColumns:
        """Find the first hits, on the device."""
        columns = DeviceColumns.allocate(self.scene.device, rays.n, surface)
        record = self.scene.device.upload(hits_record(columns.pointers()))
        self._launch("first_surface" if surface else "first_closest", rays, record.pointer)
        return columns

    def count_steps(self, rays: RaysOnDevice) -> Memory:
        """Count the nodes, leaves and exact tests of each ray in a search for first hits: (n, 3) uint32."""
        steps = self.scene.device.allocate(12 * rays.n)
        self._launch("first_steps", rays, steps.pointer)
        return steps

    def find_any(self, rays: RaysOnDevice) -> Memory:
        """Find out whether each ray hits anything, on the device."""
        found = self.scene.device.allocate(rays.n)
        self._launch("any_hit", rays, found.pointer)
        return found

    def count(self, rays: RaysOnDevice) -> Memory:
        """Count the hits of each ray, on the device."""
        counts = self.scene.device.allocate(8 * rays.n)
        self._launch("count_hits", rays, ALL, counts.pointer)
        return counts

    def list(self, rays: RaysOnDevice, surface: bool, k: int | None, by_distance: bool) -> ListsOnDevice:
        """List hits, on the device."""
        device = self.scene.device
        # Count the hits of each ray after a zero, and add them up.
        offsets = device.upload(np.zeros(rays.n + 1, np.int64))
        counts = offsets.pointer + 8
        self._launch("count_hits", rays, ALL if k is None else k, counts)
        if rays.n:
            scan(device, self.scene.kernels, counts, rays.n)
        n_hits = int(device.download(offsets, np.int64, 1, rays.n)[0])
        # List them.
        columns = DeviceColumns.allocate(device, n_hits, surface)
        record = device.upload(lists_record(offsets.pointer, columns.pointers()))
        which = "all" if k is None else "near" if by_distance else "next"
        self._launch(f"{which}_{'surface' if surface else 'closest'}", rays, record.pointer)
        return ListsOnDevice(offsets, columns)

    def rays_on_device(self, pointers: Sequence[int], n: int, steps: Sequence[int], parts: object) -> RaysOnDevice:
        """Return rays from pointers to origins, directions, radius, t_min and t_max, and how far the next value is."""
        record = self.scene.device.upload(rays_record(pointers, 0, n, steps))
        return RaysOnDevice(n, record, (parts,))

    def _launch(self, name: str, rays: RaysOnDevice, *arguments: int) -> None:
        kernels = self.scene.kernels
        if rays.n:
            kernels.launch(name, rays.n * kernels.group, self.scene.record.pointer, rays.record.pointer, *arguments)

    def upload(self, rays: RayBatch) -> RaysOnDevice:
        """Copy checked rays to the device."""
        if rays.has_spread:
            raise InputError("the GPU does not answer rays with a spread; query them on the CPU, or leave out spread=")
        arrays = rays.origins, rays.directions, rays.radius, rays.t_min, rays.t_max
        parts = [self.scene.device.upload(array) for array in arrays]
        steps = [0 if len(array) <= 1 else array.size // len(array) for array in arrays]
        return self.rays_on_device([part.pointer for part in parts], len(rays), steps, parts)


def _report_end(progress: ProgressCallback | None) -> None:
    if progress is not None:
        progress(1.0)
