"""Our library, asked for one ray per call from C++ and from C, as a program that links with it does.

The loops over rays are compiled on first use against the installed library.
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import fastlines as fl

from ..harness.arrays import FloatArray
from ..harness.rays import RayBatch
from .compiled import compile_loops

#: The interfaces, by the end of the names of their loops.
INTERFACES = {"C++": "cpp", "C": "c"}


class _Batch(ctypes.Structure):
    _fields_ = (
        ("n", ctypes.c_size_t),
        ("origins", ctypes.c_void_p),
        ("directions", ctypes.c_void_p),
        ("t_min", ctypes.c_float),
        ("t_max", ctypes.c_float),
        ("radius", ctypes.c_float),
        ("n_threads", ctypes.c_uint),
    )


@dataclass(frozen=True)
class FirstHits:
    """The first hit of each ray."""

    t: FloatArray
    prim: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.t)

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """Whether each ray hits anything."""
        return self.prim >= 0


@dataclass(frozen=True)
class AllHits:
    """All hits of each ray."""

    offsets: npt.NDArray[np.int64]
    t: FloatArray
    prim: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.t)

    @property
    def ray(self) -> npt.NDArray[np.int64]:
        """The ray of each hit."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


@cache
def _loops() -> ctypes.CDLL:
    """Compile and load the loops over rays."""
    flags = subprocess.run([sys.executable, "-m", "fastlines", "--cflags", "--libs"], capture_output=True, text=True)
    if flags.returncode:
        raise fl.FastlinesError(flags.stderr.strip())
    loops = compile_loops(Path(__file__).with_suffix(".cpp"), "calls from C++", "-O2", *flags.stdout.split())
    loops.calls_load.restype = loops.calls_all_cpp.restype = loops.calls_all_c.restype = ctypes.c_void_p
    loops.calls_hits.restype = ctypes.c_size_t
    return loops


class Calls:
    """A tree in the library, which several threads ask at the same time."""

    def __init__(self, tree: fl.Tree, n_threads: int) -> None:
        self.n_threads = n_threads
        self._loops = _loops()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "tree.flt"
            tree.save(path)
            self._trees = ctypes.c_void_p(self._loops.calls_load(str(path).encode()))
        if not self._trees:
            raise fl.FastlinesError("the library cannot load the tree")

    def __del__(self) -> None:
        if getattr(self, "_trees", None):
            self._loops.calls_free(self._trees)

    def query(self, interface: str, query: str, radius: float, rays: RayBatch) -> Any:
        """Return the answer to a query, "first", "any" or "all", asked through the interface ray by ray."""
        loop = getattr(self._loops, f"calls_{query}_{INTERFACES[interface]}")
        origins, directions = (np.ascontiguousarray(array, np.float32) for array in (rays.origins, rays.directions))
        n = len(origins)
        batch = _Batch(n, origins.ctypes.data, directions.ctypes.data, rays.t_min, rays.t_max, radius, self.n_threads)
        if query == "any":
            found = np.empty(n, np.bool_)
            loop(self._trees, ctypes.byref(batch), _at(found))
            return found
        if query == "first":
            t, prim = np.empty(n, np.float32), np.empty(n, np.int64)
            loop(self._trees, ctypes.byref(batch), _at(t), _at(prim))
            return FirstHits(t, prim)
        lists = ctypes.c_void_p(loop(self._trees, ctypes.byref(batch)))
        n_hits = self._loops.calls_hits(lists)
        counts, t, prim = np.empty(n, np.int64), np.empty(n_hits, np.float32), np.empty(n_hits, np.int64)
        self._loops.calls_copy(lists, _at(counts), _at(t), _at(prim))
        return AllHits(np.concatenate([[0], np.cumsum(counts)]), t, prim)


def _at(array: npt.NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
