"""A layout and its primitives in the memory of a device; uploaded once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..errors import FastlinesError, InputError
from ..geometry.any_geometry import AnyGeometry
from ..structure.layout import Layout
from ..support.computed_once import held
from .device import Device, Kernels, Memory
from .records import scene_record

#: The kinds of primitives that kernels know, by the name of the kind in the core.
PRIMITIVES = {
    "segments": "DeviceSegments",
    "round cones": "DeviceRoundCones",
    "spread cones": "DeviceSpreadCones",
    "shapes": "DeviceShapes",
}

#: Kernels are compiled for stacks of a multiple of this many entries, so that most trees share one compilation.
STACK_STEP = 64

#: The most entries of a stack. Each takes 8 bytes in each thread that a GPU can hold.
MAX_STACK = 4096


@dataclass(frozen=True)
class Scene:
    """What kernels read besides rays."""

    device: Device
    kernels: Kernels
    #: A `DeviceScene`, and what it points to: nodes, leaves, references and primitives.
    record: Memory
    parts: tuple[Memory, ...]
    n_bytes: int
    #: Whether a ray may find a primitive several times: it is in several leaves, without pieces that own hits.
    has_repeats: bool


def scene_of(layout: Layout, device: Device, has_spread: bool = False, seen: tuple[int, ...] | None = None) -> Scene:
    """Return a layout on a device; it is uploaded once, and stays there as long as the layout lives.

    For rays with a spread, the primitives are others. For rays that see some parts, they are uploaded again, and kept
    until rays see other parts.
    """
    with held(layout, "_scenes"):
        scenes: dict[tuple[bool, bool], tuple[Scene, tuple[int, ...] | None]]
        scenes = layout.__dict__.setdefault("_scenes", {})
        key = has_spread, seen is not None
        known, parts = scenes.get(key, (None, None))
        if known is None or known.device is not device or parts != seen:
            same = [scene.parts[:3] for scene, _ in scenes.values() if scene.device is device]
            known = upload(layout, device, has_spread, same[0] if same else None, seen)
            scenes[key] = known, seen
        return known


def upload(
    layout: Layout,
    device: Device,
    has_spread: bool,
    blocks: tuple[Memory, ...] | None,
    seen: tuple[int, ...] | None = None,
) -> Scene:
    """Upload a layout, unless its blocks are there, with its primitives; compile the kernels for them."""
    layout.geometry.require_gpu()
    kind, items = layout.geometry.spread_data() if has_spread else layout.geometry.seen_data(seen)
    if kind not in PRIMITIVES:
        raise InputError(f"a GPU has no kernels for {kind}, only for {', '.join(PRIMITIVES)}; query them on the CPU")
    stack = stack_room(layout.nodes)
    if stack > MAX_STACK:
        raise FastlinesError(
            f"this tree needs {stack} entries on the stack of each ray, and a GPU has room for {MAX_STACK}; query it "
            "on the CPU, or build it with another method"
        )
    arrays = layout.nodes, layout.leaves, layout.refs
    parts = (*(blocks or [device.upload(array) for array in arrays]), device.upload(items))
    view = layout.spread_view if has_spread else layout.view
    record = device.upload(scene_record([part.pointer for part in parts], view.frame))
    rounded = -(-stack // STACK_STEP) * STACK_STEP
    kernels = device.compile(PRIMITIVES[kind], rounded)
    n_bytes = sum(array.nbytes for array in (*arrays, items))
    return Scene(device, kernels, record, parts, n_bytes, kind == "shapes" and len(layout.refs) > len(items))


def require_cuda(backend: str, geometry: AnyGeometry) -> None:
    """Refuse rays in the memory of a GPU if the CPU has to answer them, or to finish the answers."""
    if backend != "cuda":
        raise InputError(
            "the rays are in the memory of a GPU, and this tree answers on the CPU; query tree.to('cuda'), or pass "
            "NumPy arrays"
        )
    geometry.require_gpu_rays()


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
