"""The boxes of the nodes of a level, and the planes that split them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline
from ..rendering.card.sketch import spaced_rows
from ..rendering.color.palette import hexadecimal
from ..rendering.color.tone import linear
from ..rendering.levels import EDGES, box_color
from ..support.texts import counted

#: The most boxes, and the most planes, on the page.
MAX_BOXES, MAX_PLANES = 4_000, 1_000
#: The colour of leaves above the level, linear.
LEAF_ABOVE = hexadecimal("#8a8f98")


@dataclass(frozen=True, eq=False)
class LevelBoxes:
    """The nodes of a level and the leaves above it, thinned.

    Attributes
    ----------
    nodes : (n,) int64
        Those that are shown.
    colors : (n, 3) float32
        Their colours, linear: by their order in the level; leaves above are grey.
    caption : str
        How many there are, and how many are shown.
    """

    nodes: IntArray
    colors: FloatArray
    caption: str


def level_boxes(outline: Outline, level: int, most: int = MAX_BOXES) -> LevelBoxes:
    """Return what is shown of a level; of one below the deepest, its leaves.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.inspection import outline_of
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "bvh-cl", cost=fl.Cost(0.1))
    >>> level_boxes(outline_of(tree), 1).caption
    'level 1 of 1: 2 nodes, 2 of them leaves'
    """
    levels = outline.levels
    here = levels[level] if level < len(levels) else np.empty(0, np.int64)
    above = [nodes[outline.is_leaf[nodes]] for nodes in levels[:level]]
    leaves = np.concatenate([np.empty(0, np.int64), *above])
    nodes = np.concatenate([here, leaves])
    rows = spaced_rows(len(nodes), most)
    hues = [box_color(int(row), len(here), 1.0)[:3] for row in rows[rows < len(here)]]
    colors = np.full((len(rows), 3), LEAF_ABOVE, np.float32)
    if hues:
        colors[: len(hues)] = linear(np.array(hues) / 255)
    n_leaves = int(outline.is_leaf[here].sum())
    caption = f"level {level} of {len(levels) - 1}: {counted(len(here), 'nodes')}, {n_leaves:,} of them leaves"
    caption += f"; {counted(len(leaves), 'leaves')} above, in grey" if len(leaves) else ""
    caption += f"; {len(rows):,} of {len(nodes):,} boxes are shown" if len(rows) < len(nodes) else ""
    return LevelBoxes(nodes[rows], colors, caption)


def box_edges(boxes: Float64Array) -> Float64Array:
    """Return the twelve edges of each box (n, 2, 3), as (12 n, 2, 3).

    Examples
    --------
    >>> box_edges(np.array([[[0, 0, 0], [1, 2, 3]]]))[0].tolist()
    [[0, 0, 0], [1, 0, 0]]
    """
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    corners = boxes[:, bits, np.arange(3)]
    return np.asarray(corners[:, EDGES].reshape(-1, 2, 3))


def split_planes(outline: Outline, level: int, most: int = MAX_PLANES) -> tuple[Float64Array, str]:
    """Return the rectangles in which planes separate the children of the nodes of a level, (n, 4, 3), and how many.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.inspection import outline_of
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "kd-cl", cost=fl.Cost(0.1))
    >>> split_planes(outline_of(tree), 0)[1]
    '1 split plane'
    """
    here = outline.levels[level] if level < len(outline.levels) else np.empty(0, np.int64)
    split = here[outline.split_axis[here] >= 0]
    nodes = split[spaced_rows(len(split), most)]
    axes, boxes = outline.split_axis[nodes].astype(np.int64), outline.boxes[nodes]
    rows, across = np.arange(len(nodes))[:, None], (axes[:, None] + [1, 2]) % 3
    quads = np.empty((len(nodes), 4, 3))
    quads[rows, :, axes[:, None]] = outline.split_plane[nodes][:, None, None]
    for i, (one, other) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        quads[rows[:, 0], i, across[:, 0]] = boxes[rows[:, 0], one, across[:, 0]]
        quads[rows[:, 0], i, across[:, 1]] = boxes[rows[:, 0], other, across[:, 1]]
    n_inner = int((~outline.is_leaf[here]).sum())
    caption = counted(len(split), "split planes")
    caption += (
        f" of {counted(n_inner, 'inner nodes')}: the boxes of other children overlap" if len(split) < n_inner else ""
    )
    caption += f"; {len(nodes):,} are shown" if len(nodes) < len(split) else ""
    return quads, caption
