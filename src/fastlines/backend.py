"""What answers queries: the engine module for an instruction set on the wide layout, or the core on a tree as built."""

from __future__ import annotations

import functools
import importlib
import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from . import _core
from .arrays import IntArray
from .errors import InputError
from .hits import HitColumns
from .progress import ProgressCallback
from .threads import get_num_threads

if TYPE_CHECKING:
    from . import _engine
    from .rays import RayBatch

#: The instruction sets that some machine has a module for, the widest first.
SIMD_NAMES = ("avx512", "avx2", "sse42", "neon", "portable")

#: The number of each kernel in the engine modules; "binary" searches the tree as it was built.
KERNELS = {"auto": 0, "single": 1, "wave": 2, "bundle": 3, "binary": -1}

_forced: str | None = None

#: What `use_engine` has put in the place of the modules.
_given: Any = None


def set_simd(name: str | None) -> None:
    """Force an instruction set for all later queries; None = the widest that the machine has.

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
    return _core.best_simd()


def available_simd() -> tuple[str, ...]:
    """List the instruction sets that this machine and this build have, the widest first."""
    at_most = SIMD_NAMES.index(_core.best_simd())
    return tuple(
        name for name in SIMD_NAMES[at_most:] if importlib.util.find_spec(f"{__package__}._engine_{name}") is not None
    )


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
    if name not in available_simd():
        raise InputError(f"{what}={name!r} is not available here; expected one of {', '.join(available_simd())}")
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
    """Whether `use_engine` is in force."""
    return _given is not None


class Backend(Protocol):
    """Answers checked rays about one set of lines, all bit for bit alike.

    With `surface`, t is where the ray enters the capsule of its radius around a segment, and ``t_out`` where it leaves;
    else t is at the closest approach. A long call reports its progress, the share that is done, and ends at Ctrl-C.
    """

    def first_hit(self, rays: RayBatch, surface: bool, progress: ProgressCallback | None) -> HitColumns:
        """Find the nearest hit of each ray; prim is -1 and t and distance are inf for a miss."""

    def any_hit(self, rays: RayBatch, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """Find out for each ray whether it hits anything."""

    def count_hits(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """Count the segments that each ray hits."""

    def list_hits(
        self, rays: RayBatch, surface: bool, k: int | None, progress: ProgressCallback | None
    ) -> tuple[IntArray, HitColumns]:
        """List all hits of each ray, or its k nearest: offsets (n_rays + 1), and columns sorted by ray, t and prim."""


@dataclass(frozen=True)
class WideBackend:
    """The kernels of the engine module, on a wide layout."""

    view: _core.LayoutView
    kernel: int

    def first_hit(self, rays: RayBatch, surface: bool, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        return engine.first_hit(self.view, rays.arrays(), surface, self.kernel, get_num_threads(), progress)

    def any_hit(self, rays: RayBatch, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        return engine.any_hit(self.view, rays.arrays(), self.kernel, get_num_threads(), progress)

    def count_hits(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        return engine.count_hits(self.view, rays.arrays(), self.kernel, get_num_threads(), progress)

    def list_hits(
        self, rays: RayBatch, surface: bool, k: int | None, progress: ProgressCallback | None
    ) -> tuple[IntArray, HitColumns]:
        """See `Backend`."""
        return engine.list_hits(self.view, rays.arrays(), surface, k, self.kernel, get_num_threads(), progress)


@dataclass(frozen=True)
class BinaryBackend:
    """The core, on a tree as it was built (by its boxes, or a KD tree by its planes), or on every segment."""

    view: _core.BinaryView

    def first_hit(self, rays: RayBatch, surface: bool, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        return _core.first_hit(self.view, rays.arrays(), surface, get_num_threads(), progress)

    def any_hit(self, rays: RayBatch, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        return _core.any_hit(self.view, rays.arrays(), get_num_threads(), progress)

    def count_hits(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        return _core.count_hits(self.view, rays.arrays(), get_num_threads(), progress)

    def list_hits(
        self, rays: RayBatch, surface: bool, k: int | None, progress: ProgressCallback | None
    ) -> tuple[IntArray, HitColumns]:
        """See `Backend`."""
        return _core.list_hits(self.view, rays.arrays(), surface, k, get_num_threads(), progress)
