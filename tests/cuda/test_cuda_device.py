"""The thin class over cuda-core: what it says without a GPU, and what it calls, on a stand-in for cuda-core."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.emulated_device import EmulatedDevice

import fastlines as fl
from fastlines.cuda import cuda_device
from fastlines.cuda.choice import use_device
from fastlines.cuda.cuda_device import CudaDevice, gpu
from fastlines.cuda.program import BLOCK, TUNING


@pytest.fixture(autouse=True)
def no_gpu_is_remembered() -> Iterator[None]:
    cuda_device._open_gpu.cache_clear()
    yield
    cuda_device._open_gpu.cache_clear()


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    def optional(library: str, what: str, extra: str) -> Any:
        raise fl.MissingExtraError(what, extra)

    monkeypatch.setattr(cuda_device, "optional", optional)
    tree = fl.build([[[0, 0, 0], [1, 1, 1]]])
    for ask in (lambda: fl.set_backend("cuda"), lambda: tree.to("cuda")):
        with pytest.raises(fl.MissingExtraError, match=r"\"cuda\" needs the extra 'cuda': run  pip install '"):
            ask()
    assert fl.get_backend() == "cpu"


def test_with_an_old_version(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cuda_device, "optional", lambda *_: SimpleNamespace())
    with pytest.raises(fl.FastlinesError, match="cuda-core is older than version 1; run  pip install --upgrade"):
        fl.set_backend("cuda")


@pytest.mark.parametrize("why", ["no driver found.\nLook elsewhere.", ""])
def test_without_a_gpu_there_is_one_sentence(why: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_device() -> Any:
        raise RuntimeError(why)

    monkeypatch.setattr(cuda_device, "optional", lambda *_: SimpleNamespace(Device=no_device))
    with pytest.raises(fl.FastlinesError) as caught:
        fl.set_backend("cuda")
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith("there is no GPU that CUDA can use here (")
    assert (why.split(".")[0] or "RuntimeError") in message
    assert fl.get_backend() == "cpu"


def test_the_gpu_is_current_in_each_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    current: list[str] = []

    class Device:
        default_stream = None

        def set_current(self) -> None:
            current.append(threading.current_thread().name)

    monkeypatch.setattr(cuda_device, "optional", lambda *_: SimpleNamespace(Device=Device))
    first = gpu()
    with ThreadPoolExecutor(1, "another") as pool:
        assert pool.submit(gpu).result() is first
    assert set(current) == {threading.current_thread().name, "another_0"}


class Buffer:
    """Memory of the host that looks like a buffer of cuda-core."""

    def __init__(self, handle: int, size: int, owner: object) -> None:
        self.handle, self.size, self.owner = handle, size, owner

    @classmethod
    def from_handle(cls, ptr: int, size: int, mr: object = None, owner: object = None) -> Buffer:
        return cls(ptr, size, owner)

    def copy_from(self, src: Buffer, *, stream: object) -> None:
        assert self.size == src.size > 0
        ctypes.memmove(self.handle, src.handle, self.size)


class Card:
    """A device that looks like one of cuda-core."""

    name, arch, device_id = "a stand-in", "90", 0

    def allocate(self, size: int, *, stream: object) -> Buffer:
        assert size > 0
        memory = np.full(size + 256, 0xA5, np.uint8)
        return Buffer(memory.ctypes.data + -memory.ctypes.data % 256, size, memory)


def test_what_it_calls(emulated: EmulatedDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    kernels = emulated.compile("DeviceSegments", 64)
    compiled: list[tuple[str, str, int]] = []

    def compile_for(arch: str, primitives: str, stack: int) -> bytes:
        compiled.append((arch, primitives, stack))
        return b"code"

    def launch(stream: object, config: dict[str, int], name: str, *numbers: np.uint64) -> None:
        assert config["block"] == TUNING[BLOCK]
        assert all(type(number) is np.uint64 for number in numbers)
        kernels.launch(name, config["grid"] * TUNING[BLOCK], *map(int, numbers))

    monkeypatch.setattr(cuda_device, "compiled", compile_for)
    core = SimpleNamespace(
        Buffer=Buffer,
        LaunchConfig=dict,
        ObjectCode=SimpleNamespace(from_cubin=lambda code: SimpleNamespace(get_kernel=lambda name: name)),
        launch=launch,
    )
    lines = np.random.default_rng(5).uniform(-1, 1, (50, 2, 3))
    tree = fl.build(lines)
    rays = np.random.default_rng(6).uniform(-2, 2, (2, 300, 3))
    with use_device(CudaDevice(core, Card(), SimpleNamespace(sync=lambda: None, handle=1))):
        for query in ("first_hit", "all_hits"):
            got, expected = (getattr(placed, query)(*rays, 0.1) for placed in (tree.to("cuda"), tree))
            assert np.array_equal(got.t, expected.t)
            assert np.array_equal(got.prim, expected.prim)
        assert len(tree.to("cuda").all_hits(np.empty((0, 3)), np.empty((0, 3)), 0.1)) == 0
    assert compiled == [("sm_90", "DeviceSegments", 64)]


def test_a_gpu_without_enough_memory() -> None:
    def allocate(size: int, *, stream: object) -> Any:
        raise RuntimeError("CUDA_ERROR_OUT_OF_MEMORY: the API call failed" if size > 100 else "another reason")

    device = CudaDevice(None, SimpleNamespace(allocate=allocate, name="a stand-in"), None)
    with pytest.raises(MemoryError, match="4,000 bytes do not fit into what is free on a stand-in"):
        device.upload(np.zeros(1000, np.float32))
    with pytest.raises(RuntimeError, match="another reason"):
        device.allocate(8)


def test_the_names_are_those_of_cuda_core() -> None:
    core = pytest.importorskip("cuda.core", reason="needs fastlines[cuda]")
    utils = pytest.importorskip("cuda.core.utils")
    for owner, names in (
        (core, ("Buffer", "Device", "LaunchConfig", "ObjectCode", "Program", "ProgramOptions", "launch")),
        (core.Buffer, ("from_handle", "copy_from", "handle")),
        (core.Device, ("set_current", "default_stream", "allocate", "name", "arch", "device_id")),
        (core.Stream, ("sync", "handle")),
        (core.ObjectCode, ("from_cubin", "get_kernel")),
        (utils.StridedMemoryView, ("from_any_interface", "from_buffer", "__dlpack__", "shape", "strides", "dtype")),
    ):
        assert [name for name in names if not hasattr(owner, name)] == []
    config = core.LaunchConfig(grid=3, block=64)
    assert (tuple(config.grid), tuple(config.block)) == ((3, 1, 1), (64, 1, 1))
