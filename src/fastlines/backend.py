"""Backends: the engine module of an instruction set, on the wide layout, or the core, on a tree as it was built."""

from __future__ import annotations

import functools
import importlib
import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _core
from .arrays import FloatArray, IntArray
from .errors import FastlinesError, InputError
from .progress import ProgressCallback
from .threads import get_num_threads

if TYPE_CHECKING:
    from . import _engine
    from .rays import RayBatch

#: Hits: t, prim, u, distance, and with ``at="surface"`` t_out.
HitColumns: TypeAlias = tuple[FloatArray, IntArray, FloatArray, FloatArray, FloatArray | None]

#: Lists of hits: offsets (n_rays + 1,), and the columns of all hits.
HitLists: TypeAlias = tuple[IntArray, HitColumns]

#: The instruction sets that modules can be compiled for, the widest first.
SIMD_NAMES = ("avx512", "avx2", "sse42", "neon", "portable")

#: The number of each kernel in the engine modules; "binary" searches the tree as it was built.
KERNELS = {"auto": 0, "single": 1, "wave": 2, "bundle": 3, "binary": -1}

_forced: str | None = None

#: The module that `use_engine` has put in the place of the others.
_given: Any = None


def set_simd(name: str | None) -> None:
    """Force an instruction set for all later queries; None = the first of `available_simd`.

    The environment variable ``FASTLINES_SIMD`` does it for a whole program. Answers do not depend on it.

    Parameters
    ----------
    name : {"avx512", "avx2", "sse42", "neon", "portable"} or None
    """
    global _forced
    if name is not None:
        _check(name, "simd")
    _forced = name


def simd() -> str:
    """Return which instruction set queries use: "avx512", "avx2", "sse42", "neon" or "portable"."""
    if _forced is not None:
        return _forced
    given = os.environ.get("FASTLINES_SIMD")
    if given:
        return _check(given, "FASTLINES_SIMD")
    return _require_simd()[0]


@functools.cache
def available_simd() -> tuple[str, ...]:
    """List the instruction sets that this machine and this build have, the widest first."""
    at_most = SIMD_NAMES.index(_core.best_simd())
    return tuple(name for name in SIMD_NAMES[at_most:] if _is_compiled(name))


def _is_compiled(name: str) -> bool:
    return importlib.util.find_spec(f"{__package__}._engine_{name}") is not None


def _require_simd() -> tuple[str, ...]:
    """Return the available instruction sets; raise an error if there are none."""
    available = available_simd()
    if not available:
        best, compiled = _core.best_simd(), ", ".join(filter(_is_compiled, SIMD_NAMES)) or "no instruction set"
        raise FastlinesError(
            f"this build of fastlines is for {compiled}, and the widest set of this machine is {best}; install it "
            f"again with -C cmake.define.FASTLINES_SIMD={best}, or without that option for all sets"
        )
    return available


class _Engine:
    """The functions of the module for the instruction set in use; `_engine.pyi` has their types."""

    def __getattr__(self, name: str) -> Any:
        return getattr(_given or _module(simd()), name)


if TYPE_CHECKING:
    engine = _engine
else:
    engine = _Engine()


@functools.cache
def _module(name: str) -> Any:
    return importlib.import_module(f"{__package__}._engine_{name}")


def _check(name: str, what: str) -> str:
    available = _require_simd()
    if name not in available:
        raise InputError(f"{what}={name!r} is not available here; expected one of {', '.join(available)}")
    return name


@contextmanager
def use_engine(module: Any) -> Iterator[None]:
    """Answer queries with another module for a while, such as one that counts its steps; one thread at a time."""
    global _given
    before, _given = _given, module
    try:
        yield
    finally:
        _given = before


def is_given() -> bool:
    """Return whether `use_engine` is in force."""
    return _given is not None


class Backend(Protocol):
    """Answers checked rays about one set of lines; the answers of all backends are the same, bit for bit.

    With `surface`, t is where the ray enters the capsule of its radius around a segment, and ``t_out`` where it leaves;
    else t is at the closest approach. A long call reports the fraction that is done, and ends at Ctrl-C.
    """

    def first_hit(self, rays: RayBatch, surface: bool, progress: ProgressCallback | None) -> HitColumns:
        """Find the nearest hit of each ray; prim is -1 and t and distance are inf for a miss."""

    def any_hit(self, rays: RayBatch, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """Find out for each ray whether it hits anything."""

    def count_hits(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """Count the segments that each ray hits."""

    def list_hits(
        self, rays: RayBatch, surface: bool, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """List all hits of each ray by t and prim; or the first k of them; or the k nearest to the ray by distance."""


@dataclass(frozen=True)
class CompiledBackend:
    """The functions of a compiled module: the engine on a wide layout, or the core on a binary tree or all segments."""

    functions: Any
    view: _core.LayoutView | _core.BinaryView
    #: The number of the kernel, for a module that has kernels.
    kernel: tuple[int, ...] = ()

    def first_hit(self, rays: RayBatch, surface: bool, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        found: HitColumns = self.functions.first_hit(self.view, rays.arrays(), surface, *self._how(progress))
        return found

    def any_hit(self, rays: RayBatch, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        found: npt.NDArray[np.bool_] = self.functions.any_hit(self.view, rays.arrays(), *self._how(progress))
        return found

    def count_hits(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        counts: IntArray = self.functions.count_hits(self.view, rays.arrays(), *self._how(progress))
        return counts

    def list_hits(
        self, rays: RayBatch, surface: bool, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        how = self._how(progress)
        lists: HitLists = self.functions.list_hits(self.view, rays.arrays(), surface, k, by_distance, *how)
        return lists

    def _how(self, progress: ProgressCallback | None) -> tuple[Any, ...]:
        """Return the last arguments of every function of a module."""
        return (*self.kernel, get_num_threads(), progress)
