"""Records of pointers and numbers, as kernels read them (cpp/fastlines/device/records.hpp)."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt


def scene_record(pointers: Sequence[int], frame: tuple[Sequence[float], float, float]) -> npt.NDArray[np.uint8]:
    """Pack a `DeviceScene`: nodes, leaves, references, primitives, and the frame: its centre, scale and overhang."""
    centre, scale, overhang = frame
    return _record("<4Q5f4x", *pointers, *centre, scale, overhang)


def rays_record(pointers: Sequence[int], order: int, n: int, steps: Sequence[int]) -> npt.NDArray[np.uint8]:
    """Pack `DeviceRays`: pointers to origins, directions, radius, t_min, t_max and spread, and steps to next values."""
    return _record("<8Q6I", *pointers, order, n, *steps)


def limits_record(low: Sequence[float], high: Sequence[float], largest_radius: float) -> npt.NDArray[np.uint8]:
    """Pack `DeviceLimits`: the box of the scene, and the largest radius of a query."""
    return _record("<7d", *low, *high, largest_radius)


def hits_record(columns: Sequence[int]) -> npt.NDArray[np.uint8]:
    """Pack `DeviceHits`: pointers to t, prim, u, distance and t_out."""
    return _record("<5Q", *columns)


def lists_record(offsets: int, columns: Sequence[int], n_hits: int = 0) -> npt.NDArray[np.uint8]:
    """Pack `DeviceLists`: a pointer to the offsets, those of `hits_record`, and one to the lengths in the end, or 0."""
    return _record("<7Q", offsets, *columns, n_hits)


def _record(form: str, *values: float) -> npt.NDArray[np.uint8]:
    return np.frombuffer(struct.pack(form, *values), np.uint8)
