"""A GPU by cuda.core. Nothing here is imported before a GPU is used."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import FastlinesError, InputError
from ..support.optional import optional
from .device import Kernels, Memory, ViewedArray
from .program import BLOCK, GROUP, TUNING, compiled


def gpu() -> CudaDevice:
    """Return the GPU, and make it the current one of the calling thread.

    Raises
    ------
    MissingExtraError
        If the extra "cuda" is not installed.
    FastlinesError
        If there is no GPU, or no driver.
    """
    found = _open_gpu()
    found.device.set_current()
    return found


@functools.cache
def _open_gpu() -> CudaDevice:
    core = optional("cuda.core", 'the backend "cuda"', "cuda")
    optional("cuda.bindings.nvrtc", 'the backend "cuda"', "cuda")
    if not hasattr(core, "Device"):  # before version 1, they were elsewhere
        raise FastlinesError("cuda-core is older than version 1; run  pip install --upgrade 'cuda-core>=1.0'")
    try:
        device = core.Device()
        device.set_current()
    except Exception as error:  # cuda.core and its loader of libraries raise many kinds
        why = str(error).strip().splitlines() or [type(error).__name__]
        raise FastlinesError(
            f"there is no GPU that CUDA can use here ({why[0].rstrip('.')}); install NVIDIA's driver on a machine with "
            "a GPU, or query on the CPU"
        ) from error
    return CudaDevice(core, device, device.default_stream)


@dataclass(frozen=True, eq=False)
class _Buffer:
    """Memory of a GPU; cuda.core frees it in the order of the stream."""

    buffer: Any

    @property
    def pointer(self) -> int:
        return int(self.buffer.handle)


@dataclass(frozen=True, eq=False)
class CudaDevice:
    """See `Device`. All work goes to the default stream, in order."""

    core: Any
    device: Any
    stream: Any

    @property
    def name(self) -> str:
        """See `Device`."""
        return str(self.device.name)

    def allocate(self, n_bytes: int) -> Memory:
        """See `Device`."""
        try:
            return _Buffer(self.device.allocate(max(1, n_bytes), stream=self.stream))
        except Exception as error:
            if "OUT_OF_MEMORY" in str(error):
                raise MemoryError(f"{n_bytes:,} bytes do not fit into what is free on {self.name}") from error
            raise

    def upload(self, array: npt.NDArray[Any]) -> Memory:
        """See `Device`."""
        flat = np.ascontiguousarray(array)
        to = self.allocate(flat.nbytes)
        assert isinstance(to, _Buffer)
        if flat.nbytes:
            self._part(to.buffer, 0, flat.nbytes).copy_from(self._host(flat), stream=self.stream)
            self.stream.sync()  # the array may change after this call
        return to

    def download(self, memory: Memory, dtype: npt.DTypeLike, n: int, first: int = 0) -> npt.NDArray[Any]:
        """See `Device`."""
        to = np.empty(n, dtype)
        assert isinstance(memory, _Buffer)
        if to.nbytes:
            part = self._part(memory.buffer, first * to.itemsize, to.nbytes)
            self._host(to).copy_from(part, stream=self.stream)
            self.stream.sync()
        return to

    def view(self, array: Any) -> ViewedArray:
        """See `Device`."""
        from cuda.core.utils import StridedMemoryView

        view = StridedMemoryView.from_any_interface(array, int(self.stream.handle))
        if view.device_id != self.device.device_id:
            raise InputError(
                f"the array is on GPU {view.device_id}, and the tree on GPU {self.device.device_id}; copy one of them"
            )
        shape = tuple(view.shape)
        rows = np.cumprod([1, *reversed(shape)])[-2::-1] if shape else ()
        contiguous = view.strides is None or 0 in shape or tuple(view.strides) == tuple(map(int, rows))
        return ViewedArray(int(view.ptr), shape, view.dtype, contiguous, view)

    def export(self, memory: Any, shape: tuple[int, ...], dtype: npt.DTypeLike) -> Any:
        """See `Device`."""
        from cuda.core.utils import StridedMemoryView

        self.stream.sync()  # the consumer's stream is not known here
        return StridedMemoryView.from_buffer(memory.buffer, shape, dtype=np.dtype(dtype))

    def compile(self, primitives: str, stack: int) -> Kernels:
        """See `Device`."""
        code = self.core.ObjectCode.from_cubin(compiled(f"sm_{self.device.arch}", primitives, stack))
        return _Kernels(self, code, TUNING[BLOCK], TUNING[GROUP])

    def _host(self, array: npt.NDArray[Any]) -> Any:
        return self.core.Buffer.from_handle(array.ctypes.data, array.nbytes, owner=array)

    def _part(self, buffer: Any, first: int, n_bytes: int) -> Any:
        return self.core.Buffer.from_handle(int(buffer.handle) + first, n_bytes, owner=buffer)


@dataclass(frozen=True, eq=False)
class _Kernels:
    device: CudaDevice
    code: Any
    block: int
    group: int

    def launch(self, name: str, n_threads: int, *arguments: int) -> None:
        """See `Kernels`."""
        core = self.device.core
        config = core.LaunchConfig(grid=-(-n_threads // self.block), block=self.block)
        numbers = [np.uint64(argument) for argument in arguments]
        core.launch(self.device.stream, config, self.code.get_kernel(name), *numbers)
