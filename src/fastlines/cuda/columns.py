"""Columns of hits in the memory of a device, and scans of counts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..query.backend import HitColumns
from .device import Device, Kernels, Memory

#: Numbers that one thread adds up (`kScanRun` in cpp/fastlines/device/kernels.hpp).
SCAN_RUN = 256


@dataclass(frozen=True)
class DeviceColumns:
    """The columns of n hits: t, prim, u, distance and t_out, which is None unless t is taken at the surface."""

    n: int
    t: Memory
    prim: Memory
    u: Memory
    distance: Memory
    t_out: Memory | None

    @classmethod
    def allocate(cls, device: Device, n: int, with_t_out: bool) -> DeviceColumns:
        """Return columns that nobody has written to."""
        t, u, distance = (device.allocate(4 * n) for _ in range(3))
        return cls(n, t, device.allocate(8 * n), u, distance, device.allocate(4 * n) if with_t_out else None)

    def pointers(self) -> list[int]:
        """Return where the columns begin, in the order of `DeviceHits`."""
        columns = self.t, self.prim, self.u, self.distance, self.t_out
        return [0 if column is None else column.pointer for column in columns]

    def download(self, device: Device) -> HitColumns:
        """Return the columns as arrays of the host."""
        t, u, distance = (device.download(column, np.float32, self.n) for column in (self.t, self.u, self.distance))
        t_out = None if self.t_out is None else device.download(self.t_out, np.float32, self.n)
        return t, device.download(self.prim, np.int64, self.n), u, distance, t_out


def scan(device: Device, kernels: Kernels, pointer: int, n: int) -> None:
    """Replace n int64 by the sums of all up to each."""
    n_runs = -(-n // SCAN_RUN)
    sums = device.allocate(8 * n_runs)
    if n_runs > 1:
        kernels.launch("sum_runs", n_runs, pointer, n, sums.pointer)
        scan(device, kernels, sums.pointer, n_runs)
    kernels.launch("scan_runs", n_runs, pointer, n, sums.pointer)
