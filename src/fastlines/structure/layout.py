"""The wide layout, which queries run on. It is made from a tree, and keeps all references."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..engines import engine
from ..geometry.any_geometry import AnyGeometry
from ..progress import ProgressCallback, ProgressOption, reporting
from ..support.computed_once import computed_once
from ..support.immutable import Immutable, frozen, own
from ..support.texts import counted
from ..threads import get_num_threads

#: Boxes are measured grown by this fraction of the scene's longest side, because queries have a radius.
RADIUS_HINT = 0.001

#: The size of a block in bytes, and its alignment in memory.
BLOCK = 128


@dataclass(frozen=True, eq=False, repr=False)
class Layout(Immutable):
    """The form of a tree that queries run on: 16 children a node, boxes and pieces of segments in bytes.

    Attributes
    ----------
    geometry : Lines, Geometry or another container
        What the tree is over.
    box : (2, 3) float32
        The box of the tree's root.
    nodes, leaves : (n, 128) uint8
        Blocks of 128 bytes.
    refs : (n, 2) uint32
        Of each reference, in the order of the leaves, the primitive, and s0 and s1 as multiples of 1/65536 (the low and
        the high half). The last piece of a segment has an s1 of 65535.
    mean_extent : float
        The mean extent of the leaves, in the frame of the scene, which spans −1 to 1.
    frame : (2, 3) float32, optional
        The box whose frame the blocks are in; without it, `box`.
    """

    geometry: AnyGeometry
    box: npt.NDArray[np.float32]
    nodes: npt.NDArray[np.uint8]
    leaves: npt.NDArray[np.uint8]
    refs: npt.NDArray[np.uint32]
    mean_extent: float
    frame: npt.NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        for name in ("box", "refs", "frame"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        for name in ("nodes", "leaves"):
            object.__setattr__(self, name, _aligned(frozen(getattr(self, name))))

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self.__post_init__()

    def __repr__(self) -> str:
        each = {"nodes": len(self.nodes), "leaves": len(self.leaves), "references": len(self.refs)}
        what = ", ".join(counted(n, nouns) for nouns, n in each.items())
        return f"<Layout: {what}, {self.n_bytes:,} bytes with primitives>"

    @property
    def n_bytes(self) -> int:
        """The memory of the layout and of the primitives."""
        return self.nodes.nbytes + self.leaves.nbytes + self.refs.nbytes + self.geometry.core_rows.nbytes

    @computed_once
    def view(self) -> _core.LayoutView:
        """The layout in the form that the engine reads."""
        return self._view_over(*self.geometry.core_data())

    @computed_once
    def spread_view(self) -> _core.LayoutView:
        """The same for rays with a spread. Lines without a radius are copied for it, 32 bytes a segment."""
        return self._view_over(*self.geometry.spread_data())

    def view_of_parts(self, parts: tuple[int, ...] | None) -> _core.LayoutView:
        """The layout for rays that see some parts of a `Geometry`."""
        return self.view if parts is None else self._view_over(*self.geometry.seen_data(parts))

    def _view_over(self, kind: str, data: npt.NDArray[np.float32]) -> _core.LayoutView:
        corners = self.box.reshape(-1).tolist()
        frame = corners if self.frame is None else self.frame.reshape(-1).tolist()
        largest = self.geometry.max_radius if "max_radius" in self.geometry.derived else None
        blocks = self.nodes, self.leaves, self.refs
        return _core.LayoutView(kind, data, *blocks, corners, frame, self.mean_extent, largest)


def _aligned(blocks: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return blocks that begin at a multiple of their size, as the kernels require; copy them if they do not."""
    if blocks.ctypes.data % BLOCK == 0:
        return blocks
    room = np.empty(blocks.nbytes + BLOCK, np.uint8)
    begin = -room.ctypes.data % BLOCK
    copied = room[begin : begin + blocks.nbytes].reshape(blocks.shape)
    copied[:] = blocks
    return own(copied)


def build_layout(
    geometry: AnyGeometry,
    nodes: npt.NDArray[np.uint32],
    refs: npt.NDArray[np.uint32],
    box: npt.NDArray[np.float32],
    progress: ProgressOption = False,
    *,
    frame: npt.NDArray[np.float32] | None = None,
) -> Layout:
    """Lay out a tree, given as rows of 32-bit words."""
    corners = (box if frame is None else frame).reshape(-1).tolist()
    with reporting(progress, "layout") as callback:
        made = engine.build_layout(
            *geometry.core_data(), nodes, refs, corners, RADIUS_HINT, get_num_threads(), callback
        )
    wide_nodes, leaves, wide_refs, mean_extent = made
    return Layout(geometry, box, own(wide_nodes), own(leaves), own(wide_refs), mean_extent, frame)


def refit_layout(
    layout: Layout, lines: AnyGeometry, box: npt.NDArray[np.float32], n_threads: int, progress: ProgressCallback | None
) -> Layout:
    """Fit a layout to segments that have moved: the same children and pieces, other boxes (`BlockEncoder`)."""
    moved = replace(layout, geometry=lines, box=box)
    nodes, leaves, mean_extent = engine.refit_layout(moved.view, n_threads, progress)
    return Layout(lines, box, own(nodes), own(leaves), layout.refs, mean_extent, layout.frame)
