"""The backend that answers rays by kernels; with arrays of the host, or of the device."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..progress import ProgressCallback
from ..query.at import At, has_exit, number_of
from ..query.backend import GatherColumns, HitColumns, HitLists
from ..query.gather import GatherRule
from ..query.rays import NO_SPREAD, RayBatch
from .columns import DeviceColumns, scan
from .device import Memory
from .records import hits_record, lists_record, rays_record
from .scene import Scene

#: The limit on the hits of a ray that keeps all of them.
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

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        found = self.find_first(self.upload(rays), at).download(self.scene.device)
        _report_end(progress)
        return found

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        hit = self.scene.device.download(self.find_any(self.upload(rays), at), np.bool_, len(rays))
        _report_end(progress)
        return hit

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        counts = self.scene.device.download(self.count(self.upload(rays), at), np.int64, len(rays))
        _report_end(progress)
        return counts

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`; these are the hits."""
        return self.count_hits(rays, "closest", progress)

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        device = self.scene.device
        lists = self.list(self.upload(rays), at, k, by_distance)
        found = device.download(lists.offsets, np.int64, len(rays) + 1), lists.columns.download(device)
        _report_end(progress)
        return found

    def gather(self, rays: RayBatch, rule: GatherRule, progress: ProgressCallback | None) -> GatherColumns | None:
        """See `Backend`; the CPU sums the lists of the device."""
        return None

    def find_first(self, rays: RaysOnDevice, at: At) -> DeviceColumns:
        """Find the first hits, on the device."""
        columns = DeviceColumns.allocate(self.scene.device, rays.n, has_exit(at))
        record = self.scene.device.upload(hits_record(columns.pointers()))
        self._launch_at("first", rays, at, record.pointer)
        return columns

    def count_steps(self, rays: RaysOnDevice) -> Memory:
        """Count the nodes, leaves and exact tests of each ray in a search for first hits: (n, 3) uint32."""
        steps = self.scene.device.allocate(12 * rays.n)
        self._launch("first_steps", rays, steps.pointer)
        return steps

    def find_any(self, rays: RaysOnDevice, at: At) -> Memory:
        """Find out whether each ray hits anything, on the device."""
        found = self.scene.device.allocate(rays.n)
        self._launch("any_entry" if at == "entry" else "any_hit", rays, found.pointer)
        return found

    def count(self, rays: RaysOnDevice, at: At) -> Memory:
        """Count the hits of each ray, on the device."""
        counts = self.scene.device.allocate(8 * rays.n)
        if self.scene.has_repeats:
            offsets, n_found = self._count_found(rays, at, None)
            prims = self.scene.device.allocate(4 * n_found)
            self._launch("count_prims", rays, number_of(at), offsets.pointer, prims.pointer, counts.pointer)
        else:
            self._launch(_counting_kernel(at), rays, ALL, counts.pointer)
        return counts

    def list(self, rays: RaysOnDevice, at: At, k: int | None, by_distance: bool) -> ListsOnDevice:
        """List hits, on the device."""
        device, has_repeats = self.scene.device, self.scene.has_repeats
        offsets, n_found = self._count_found(rays, at, k)
        lists = ListsOnDevice(offsets, DeviceColumns.allocate(device, n_found, has_exit(at)))
        lengths = self._lengths(rays) if has_repeats else None
        pointer = 0 if lengths is None else lengths.pointer + 8
        record = device.upload(lists_record(offsets.pointer, lists.columns.pointers(), pointer))
        which = "all" if k is None else "near" if by_distance else "next"
        self._launch_at(which, rays, at, record.pointer)
        if lengths is None:
            return lists
        # Close the gaps that repeats leave.
        kept = ListsOnDevice(lengths, DeviceColumns.allocate(device, self._add_up(lengths, rays.n), has_exit(at)))
        to = device.upload(lists_record(lengths.pointer, kept.columns.pointers()))
        if rays.n:
            self.scene.kernels.launch("move_lists", rays.n, record.pointer, rays.n, to.pointer)
        return kept

    def _count_found(self, rays: RaysOnDevice, at: At, k: int | None) -> tuple[Memory, int]:
        """Return where the list of each ray begins, if it has all hits that the ray finds or k, and how many are found.

        Where the scene has repeats, some are found several times.
        """
        offsets = self._lengths(rays)
        self._launch(_counting_kernel(at), rays, ALL if k is None else k, offsets.pointer + 8)
        return offsets, self._add_up(offsets, rays.n)

    def _lengths(self, rays: RaysOnDevice) -> Memory:
        """Return a zero, and after it room for the length of the list of each ray."""
        return self.scene.device.upload(np.zeros(rays.n + 1, np.int64))

    def _add_up(self, lengths: Memory, n: int) -> int:
        """Replace the lengths of n lists, after a zero, by offsets; return the last one."""
        device = self.scene.device
        if n:
            scan(device, self.scene.kernels, lengths.pointer + 8, n)
        return int(device.download(lengths, np.int64, 1, n)[0])

    def rays_on_device(self, pointers: Sequence[int], n: int, steps: Sequence[int], parts: object) -> RaysOnDevice:
        """Return rays from pointers to the arrays of `RayBatch.arrays`, and how far the next value of each is."""
        record = self.scene.device.upload(rays_record(pointers, 0, n, steps))
        return RaysOnDevice(n, record, (parts,))

    def _launch(self, name: str, rays: RaysOnDevice, *arguments: int) -> None:
        kernels = self.scene.kernels
        if rays.n:
            kernels.launch(name, rays.n * kernels.group, self.scene.record.pointer, rays.record.pointer, *arguments)

    def _launch_at(self, query: str, rays: RaysOnDevice, at: At, pointer: int) -> None:
        """Launch the kernel of a query that returns t."""
        if has_exit(at):
            self._launch(f"{query}_surface", rays, number_of(at), pointer)
        else:
            self._launch(f"{query}_closest", rays, pointer)

    def upload(self, rays: RayBatch) -> RaysOnDevice:
        """Copy checked rays to the device."""
        # Some of the rays of a batch may have no spread, when others have one.
        has_spread = rays.spread is not NO_SPREAD
        columns = rays.origins, rays.directions, rays.radius, rays.t_min, rays.t_max
        arrays = (*columns, rays.spread) if has_spread else columns
        parts = [self.scene.device.upload(array) for array in arrays]
        pointers = [part.pointer for part in parts]
        steps = [0 if len(array) <= 1 else array.size // len(array) for array in arrays]
        if not has_spread:  # kernels do not read it
            pointers, steps = [*pointers, 0], [*steps, 0]
        return self.rays_on_device(pointers, len(rays), steps, parts)


def _counting_kernel(at: At) -> str:
    return "count_entries" if at == "entry" else "count_hits"


def _report_end(progress: ProgressCallback | None) -> None:
    if progress is not None:
        progress(1.0)
