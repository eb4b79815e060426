"""Peers of a gather in C++: a uniform grid, and brute force."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import astuple
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fastlines import Lines

from ..harness.arrays import FloatArray
from ..harness.rays import RayBatch
from .compiled import compile_loops
from .gathering import Gathering


class _Gather(ctypes.Structure):
    """The struct Gather of gather.hpp."""

    _fields_ = [(name, ctypes.c_float) for name in ("radius", "sigma", "line_sigma", "g", "t_min", "t_max")]


@cache
def load_loops() -> ctypes.CDLL:
    """Compile and load the loops for this processor.

    Raises
    ------
    FastlinesError
        If there is no compiler.
    """
    source = Path(__file__).with_name("beam_loops.cpp")
    loops = compile_loops(source, "the grid and the brute force of beams", "-O3", "-march=native", "-pthread")
    loops.grid_build.restype = ctypes.c_void_p
    loops.grid_bytes.restype = ctypes.c_size_t
    return loops


class BeamGrid:
    """A uniform grid over beams.

    Parameters
    ----------
    lines : Lines
    radius : float
        The radius for which beams are listed in cells.
    resolution : int
        The number of cells along the longest side of the beams' box.
    """

    def __init__(self, lines: Lines, radius: float, resolution: int) -> None:
        self._loops = load_loops()
        segments = np.ascontiguousarray(lines.segments, np.float32)
        built = self._loops.grid_build(_pointer(segments), _size(len(segments)), ctypes.c_float(radius), resolution)
        self._grid = ctypes.c_void_p(built)

    def __del__(self) -> None:
        if hasattr(self, "_grid"):
            self._loops.grid_free(self._grid)

    @property
    def bytes(self) -> int:
        """The memory of the grid and of its beams."""
        return int(self._loops.grid_bytes(self._grid))

    def gather(self, given: Gathering, rays: RayBatch, powers: FloatArray, n_threads: int) -> FloatArray:
        """Return the sums, (n_rays, 3) float32."""
        return _call(lambda *args: self._loops.grid_gather(self._grid, *args), given, rays, powers, n_threads)


def brute_force(lines: Lines, given: Gathering, rays: RayBatch, powers: FloatArray, n_threads: int) -> FloatArray:
    """Return the sums of all pairs of a ray and a beam, (n_rays, 3) float32."""
    segments = np.ascontiguousarray(lines.segments, np.float32)
    loops = load_loops()
    call = lambda *args: loops.brute_gather(_pointer(segments), _size(len(segments)), *args)  # noqa: E731
    return _call(call, given, rays, powers, n_threads)


def _call(call: Callable[..., Any], given: Gathering, rays: RayBatch, powers: FloatArray, n_threads: int) -> FloatArray:
    origins, directions = (np.ascontiguousarray(each, np.float32) for each in (rays.origins, rays.directions))
    gather = _Gather(*astuple(given), rays.t_min, rays.t_max)
    sums = np.empty((len(rays), 3), np.float32)
    arrays = _pointer(origins), _pointer(directions), _size(len(rays)), ctypes.byref(gather), _pointer(powers)
    call(*arrays, n_threads, _pointer(sums))
    return sums


def _pointer(array: FloatArray) -> Any:
    return array.ctypes.data_as(ctypes.c_void_p)


def _size(n: int) -> ctypes.c_size_t:
    return ctypes.c_size_t(n)
