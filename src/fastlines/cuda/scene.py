"""A layout and its primitives in the memory of a device; uploaded once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..curves import Curves
from ..errors import FastlinesError, InputError
from ..geometry import AnyGeometry, core_data
from ..layout import Layout
from .device import Device, Kernels, Memory
from .records import scene_record

#: The kinds of primitives that kernels know, by the name of the kind in the core.
PRIMITIVES = {"segments": "DeviceSegments", "round cones": "DeviceRoundCones"}

#: Kernels are compiled for stacks of a multiple of so many entries, so that most trees share one compilation.
STACK_STEP = 64

#: The most entries of a stack. Each takes 8 bytes in each thread that a GPU can hold.
MAX_STACK = 4096


@dataclass(frozen=True)
class Scene:
    """What kernels read besides rays."""

    device: Device
    kernels: Kernels
    #: A `DeviceScene`, and what it points to.
    record: Memory
    parts: tuple[Memory, ...]
    n_bytes: int


def scene_of(layout: Layout, device: Device) -> Scene:
    """Return a layout on a device; it is uploaded once, and stays there as long as the layout lives."""
    known: Scene | None = layout.__dict__.get("_scene")
    if known is None or known.device is not device:
        known = layout.__dict__["_scene"] = upload(layout, device)
    return known


def upload(layout: Layout, device: Device) -> Scene:
    """Upload a layout and compile the kernels for it."""
    kind = require_primitives(layout.geometry)
    stack = stack_room(layout.nodes)
    if stack > MAX_STACK:
        raise FastlinesError(
            f"this tree needs {stack} entries on the stack of each ray, and a GPU has room for {MAX_STACK}; query it "
            "on the CPU, or build it with another method"
        )
    items = core_data(layout.geometry)[1]
    arrays = layout.nodes, layout.leaves, layout.refs, items
    parts = tuple(device.upload(array) for array in arrays)
    record = device.upload(scene_record([part.pointer for part in parts], layout.view.frame))
    rounded = -(-stack // STACK_STEP) * STACK_STEP
    kernels = device.compile(PRIMITIVES[kind], rounded)
    return Scene(device, kernels, record, parts, sum(array.nbytes for array in arrays))


def require_primitives(geometry: AnyGeometry) -> str:
    """Return the kind of primitive in the core; refuse what kernels do not know."""
    kind = core_data(geometry)[0]
    if kind not in PRIMITIVES:
        raise InputError(
            f"the GPU answers queries on lines, spheres and curves, and this tree is over {type(geometry).__name__}; "
            "query it on the CPU, or build a tree over the lines alone"
        )
    return kind


def require_cuda(backend: str, geometry: AnyGeometry) -> None:
    """Refuse rays in the memory of a GPU if the CPU has to answer them, or to finish the answers."""
    if backend != "cuda":
        raise InputError(
            "the rays are in the memory of a GPU, and this tree answers on the CPU; query tree.to('cuda'), or pass "
            "NumPy arrays"
        )
    if isinstance(geometry, Curves):
        raise InputError("hits of curves are put together on the CPU; pass rays as NumPy arrays")
    require_primitives(geometry)


def stack_room(nodes: npt.NDArray[np.uint8]) -> int:
    """Return how many entries the stack of a ray needs at most (cpp/fastlines/device/device_traversal.hpp)."""
    first_inner = nodes[:, 16:20].copy().view(np.uint32)[:, 0].astype(np.int64)
    n_inner = nodes[:, 24].astype(np.int64)
    # Level by level: the nodes, and the entries below each when it is taken from the stack.
    level, below, room = np.zeros(min(1, len(nodes)), np.int64), np.zeros(min(1, len(nodes)), np.int64), 1
    while len(level):
        n = n_inner[level]
        room = max(room, int((below + n).max()))
        first = np.repeat(first_inner[level], n)
        number = np.arange(len(first)) - np.repeat(np.cumsum(n) - n, n)
        level, below = first + number, np.repeat(below + n - 1, n)
    return room
