"""A host that emulates a GPU: the text of the kernels, compiled by a C++ compiler, one thread after the other."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from fastlines.cuda.device import ViewedArray
from fastlines.cuda.program import BLOCK, GROUP, TUNING, headers, macros

SOURCE = Path(__file__).with_suffix(".cpp")
#: Answers are defined to the bit: no contraction.
FLAGS = ["-std=c++20", "-O1", "-fPIC", "-shared", "-ffp-contract=off", "-Wall", "-Wextra"]

#: Macros for each variant of the kernels: how nodes are read, how many threads take a ray, and where its stack is.
TUNINGS: list[dict[str, int]] = [
    {"FASTLINES_NODE_ROWS": 1},
    {BLOCK: 64, "FASTLINES_SHARED_STACK": 2},
    {GROUP: 16},
    {GROUP: 16, "FASTLINES_SHARED_STACK": 2},
    {GROUP: 16, "FASTLINES_SHARED_STACK": 4096},
]


def require_compiler() -> str:
    """Return the C++ compiler; skip the test if there is none."""
    found = shutil.which(os.environ.get("CXX", "g++")) or shutil.which("clang++")
    if found is None:
        pytest.skip("there is no C++ compiler to emulate a GPU's threads on the host")
    return found


@dataclass(eq=False)
class HostMemory:
    """Memory of the host, as if it were a device's."""

    array: npt.NDArray[np.uint8]

    @property
    def pointer(self) -> int:
        return int(self.array.ctypes.data)


@dataclass(eq=False)
class DeviceArray:
    """An array in the memory of the emulated GPU, as torch or CuPy would have it."""

    array: npt.NDArray[Any]

    def __dlpack_device__(self) -> tuple[int, int]:
        return 2, 0


@dataclass(eq=False)
class EmulatedKernels:
    library: ctypes.CDLL
    launched: list[str]
    group: int

    def launch(self, name: str, n_threads: int, *arguments: int) -> None:
        self.launched.append(name)
        # A GPU runs whole blocks: some threads have no ray.
        n = -(-n_threads // TUNING[BLOCK]) * TUNING[BLOCK]
        numbers = (ctypes.c_uint64 * len(arguments))(*arguments)
        assert self.library.run(name.encode(), ctypes.c_uint64(n), numbers), name


@dataclass(eq=False)
class EmulatedDevice:
    """See `fastlines.cuda.device.Device`; `launched` has the names of all kernels, in order."""

    folder: Path
    name: str = "a host that emulates a GPU"
    launched: list[str] = field(default_factory=list)
    uploaded: list[int] = field(default_factory=list)

    def allocate(self, n_bytes: int) -> HostMemory:
        # Whatever is not written shows.
        return HostMemory(np.full(n_bytes, 0xA5, np.uint8))

    def upload(self, array: npt.NDArray[Any]) -> HostMemory:
        self.uploaded.append(array.nbytes)
        # As on a GPU, aligned to more than a block of the layout.
        room = np.empty(array.nbytes + 256, np.uint8)
        begin = -room.ctypes.data % 256
        memory = room[begin : begin + array.nbytes]
        memory[:] = np.ascontiguousarray(array).reshape(-1).view(np.uint8)
        return HostMemory(memory)

    def download(self, memory: HostMemory, dtype: npt.DTypeLike, n: int, first: int = 0) -> npt.NDArray[Any]:
        return memory.array.view(dtype)[first : first + n].copy()

    def view(self, array: Any) -> ViewedArray:
        numbers = array.array
        contiguous = bool(numbers.flags.c_contiguous)
        return ViewedArray(int(numbers.ctypes.data), numbers.shape, numbers.dtype, contiguous, array)

    def export(self, memory: HostMemory, shape: tuple[int, ...], dtype: npt.DTypeLike) -> DeviceArray:
        return DeviceArray(memory.array.view(dtype).reshape(shape))

    def compile(self, primitives: str, stack: int) -> EmulatedKernels:
        tuning = "-".join(map(str, TUNING.values()))
        library = self.folder / f"emulated-{primitives}-{stack}-{tuning}.so"
        if not library.is_file():
            defines = [f"-D{name}={value}" for name, value in macros(primitives, stack)]
            command = [require_compiler(), *FLAGS, *defines, f"-I{headers()}", str(SOURCE), "-o", str(library)]
            subprocess.run(command, check=True, capture_output=True, text=True)
        return EmulatedKernels(ctypes.CDLL(str(library)), self.launched, TUNING[GROUP])
