"""The tree of Embree's builder, obtained through its builder interface.

Embree has no call that returns the tree of a scene. But `rtcBuildBVH` builds a tree over given boxes by the same binned
SAH, and passes its nodes and leaves to callbacks. With binary nodes and the cost model of our trees, its nodes and cost
are comparable with theirs. The wider tree of a scene is made of such splits.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from fastlines import Cost, FastlinesError, Lines

from .embree import libraries, load

#: RTC_BUILD_QUALITY_MEDIUM: binned SAH, no spatial splits.
MEDIUM = 1
#: Embree's own defaults.
MAX_DEPTH, MAX_LEAF = 32, 32

_Create = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint, ctypes.c_void_p)
_Children = ctypes.CFUNCTYPE(None, ctypes.c_size_t, ctypes.POINTER(ctypes.c_size_t), ctypes.c_uint, ctypes.c_void_p)
_Bounds = ctypes.CFUNCTYPE(
    None, ctypes.c_size_t, ctypes.POINTER(ctypes.POINTER(ctypes.c_float * 8)), ctypes.c_uint, ctypes.c_void_p
)
_Leaf = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)


class _Arguments(ctypes.Structure):
    """RTCBuildArguments of Embree 4."""

    _fields_: ClassVar[Any] = [
        ("byte_size", ctypes.c_size_t),
        ("quality", ctypes.c_int),
        ("flags", ctypes.c_int),
        ("max_branching_factor", ctypes.c_uint),
        ("max_depth", ctypes.c_uint),
        ("sah_block_size", ctypes.c_uint),
        ("min_leaf_size", ctypes.c_uint),
        ("max_leaf_size", ctypes.c_uint),
        ("traversal_cost", ctypes.c_float),
        ("intersection_cost", ctypes.c_float),
        ("bvh", ctypes.c_void_p),
        ("primitives", ctypes.c_void_p),
        ("n_primitives", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("create_node", _Create),
        ("set_children", _Children),
        ("set_bounds", _Bounds),
        ("create_leaf", _Leaf),
        ("split", ctypes.c_void_p),
        ("progress", ctypes.c_void_p),
        ("user", ctypes.c_void_p),
    ]


#: RTCBuildPrimitive.
_PRIMITIVE = np.dtype([("low", "<f4", 3), ("geometry", "<u4"), ("high", "<f4", 3), ("prim", "<u4")])


@dataclass(frozen=True)
class EmbreeTree:
    """The numbers of primitives and of nodes, leaves included, and the cost (thesis §3.3)."""

    n_prims: int
    n_nodes: int
    cost: float


def embree_tree(lines: Lines, model: Cost, piece_length: float = 0.0) -> EmbreeTree:
    """Return Embree's tree over the boxes of lines, cut into equal pieces of at most `piece_length`; 0 = whole."""
    low, high = piece_boxes(lines, piece_length)
    primitives = np.zeros(len(low) + 1, _PRIMITIVE)
    # Align the primitives to 32 bytes, as Embree requires.
    skip = -primitives.ctypes.data % 32
    aligned = primitives.view(np.uint8)[skip : skip + 32 * len(low)].view(_PRIMITIVE)
    aligned["low"], aligned["high"], aligned["prim"] = low, high, np.arange(len(low))

    # A handle is one more than the index in `n_refs`, where inner nodes have 0; the parent fills `areas`.
    n_refs: list[int] = []
    areas: dict[int, list[float]] = {}
    children: dict[int, list[int]] = {}

    def create_node(allocator: int, n_children: int, user: int) -> int:
        n_refs.append(0)
        return len(n_refs)

    def create_leaf(allocator: int, prims: int, n_prims: int, user: int) -> int:
        n_refs.append(n_prims)
        return len(n_refs)

    def set_children(node: int, nodes: Any, n_children: int, user: int) -> None:
        children[node] = nodes[:n_children]

    def set_bounds(node: int, boxes: Any, n_children: int, user: int) -> None:
        areas[node] = [_half_area(boxes[i].contents) for i in range(n_children)]

    arguments = _Arguments(
        byte_size=ctypes.sizeof(_Arguments),
        quality=MEDIUM,
        max_branching_factor=2,
        max_depth=MAX_DEPTH,
        sah_block_size=1,
        min_leaf_size=1,
        max_leaf_size=MAX_LEAF,
        traversal_cost=model.c_trav,
        intersection_cost=model.c_prim,
        primitives=aligned.ctypes.data,
        n_primitives=len(low),
        capacity=len(low),
        create_node=_Create(create_node),
        set_children=_Children(set_children),
        set_bounds=_Bounds(set_bounds),
        create_leaf=_Leaf(create_leaf),
    )
    root = _run(arguments)

    # Compute the cost by theorem 1: the sum over all nodes of cost times area, as fractions of the root's area.
    sides = (high.max(axis=0) - low.min(axis=0)).astype(np.float64)
    whole = float(sides[0] * sides[1] + sides[1] * sides[2] + sides[2] * sides[0])
    area = dict.fromkeys([root], whole)
    for node, below in children.items():
        area.update(zip(below, areas[node], strict=True))
    cost = sum((model.c_prim * n if n else model.c_trav) * area[node + 1] for node, n in enumerate(n_refs))
    return EmbreeTree(len(low), len(n_refs), cost / whole if whole > 0 else float(model.c_prim * len(low)))


def piece_boxes(lines: Lines, piece_length: float) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return both corners of the boxes of pieces, (n, 3) each; lines are cut as in embree_scene.cpp."""
    p, q = lines.segments[:, 0].astype(np.float64), lines.segments[:, 1].astype(np.float64)
    n_cuts = np.ones(len(lines), np.int64)
    if piece_length > 0:
        lengths = np.sqrt(((q - p) ** 2).sum(axis=1))
        n_cuts = np.clip(np.ceil(lengths / piece_length), 1, 65535).astype(np.int64)
    segment = np.repeat(np.arange(len(lines)), n_cuts)
    place = np.arange(len(segment)) - np.repeat(np.cumsum(n_cuts) - n_cuts, n_cuts)
    ends = [p[segment] + ((place + k) / n_cuts[segment])[:, None] * (q - p)[segment] for k in (0, 1)]
    return np.minimum(*ends).astype(np.float32), np.maximum(*ends).astype(np.float32)


def _half_area(box: Any) -> float:
    x, y, z = box[4] - box[0], box[5] - box[1], box[6] - box[2]
    return float(x * y + y * z + z * x)


def _run(arguments: _Arguments) -> int:
    """Build on one thread; return the handle of the root."""
    load(1)
    rtc = [ctypes.CDLL(path) for path in libraries() if path][-1]
    for name in ("rtcNewDevice", "rtcNewBVH", "rtcBuildBVH"):
        getattr(rtc, name).restype = ctypes.c_void_p
    device = ctypes.c_void_p(rtc.rtcNewDevice(b"threads=1"))
    bvh = ctypes.c_void_p(rtc.rtcNewBVH(device))
    try:
        arguments.bvh = bvh
        root = rtc.rtcBuildBVH(ctypes.byref(arguments))
        if not root:
            raise FastlinesError(f"Embree's builder made no tree: error {rtc.rtcGetDeviceError(device)}")
        return int(root)
    finally:
        rtc.rtcReleaseBVH(bvh)
        rtc.rtcReleaseDevice(device)
