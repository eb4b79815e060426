"""What queries need of a device: memory, copies, and kernels that it compiles and launches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt


class Memory(Protocol):
    """Memory of a device, freed when nothing refers to it."""

    @property
    def pointer(self) -> int:
        """Where it begins."""


@dataclass(frozen=True, eq=False)
class ViewedArray:
    """An array in the memory of a device, and what keeps it alive."""

    pointer: int
    shape: tuple[int, ...]
    dtype: np.dtype[Any] | None
    contiguous: bool
    owner: object


class Kernels(Protocol):
    """Compiled kernels."""

    @property
    def group(self) -> int:
        """How many threads take a ray."""

    def launch(self, name: str, n_threads: int, *arguments: int) -> None:
        """Run a kernel in at least n threads, after all that was launched before; pointers and numbers are 64 bits."""


class Device(Protocol):
    """A GPU, or a host that emulates one."""

    @property
    def name(self) -> str:
        """The name of the card."""

    def allocate(self, n_bytes: int) -> Memory:
        """Return memory that nobody has written to."""

    def upload(self, array: npt.NDArray[Any]) -> Memory:
        """Copy an array to the device."""

    def download(self, memory: Memory, dtype: npt.DTypeLike, n: int, first: int = 0) -> npt.NDArray[Any]:
        """Return n numbers from the device, from number `first` on, after all that was launched before."""

    def view(self, array: Any) -> ViewedArray:
        """View an array that is in the memory of this device, by DLPack; what was written to it before is there."""

    def export(self, memory: Any, shape: tuple[int, ...], dtype: npt.DTypeLike) -> Any:
        """Return memory as an array with ``__dlpack__``, after all that was launched before."""

    def compile(self, primitives: str, stack: int) -> Kernels:
        """Return the kernels for a kind of primitive, with stacks of `stack` entries."""
