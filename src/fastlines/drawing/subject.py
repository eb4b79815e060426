"""What is drawn: the nodes of a tree, its boxes where the input has them, and strokes that show its primitives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.boxes import Boxes
from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline, outline_of
from ..rendering.card.sketch import sketch
from ..structure.tree_data import TreeData
from ..theory.node import Node
from ..theory.primitive import Primitive, Segment

#: A tree of the core or of the theory.
AnyTree: TypeAlias = TreeData | Node

#: About the most primitives that are drawn; more are represented by some that are spaced evenly.
MAX_PRIMS = 20_000
#: The corners of the circles that show a sphere.
CORNERS = 32


@dataclass(frozen=True, eq=False)
class Subject:
    """The nodes and the primitives of a tree, in the coordinates of the input.

    Attributes
    ----------
    outline : Outline
    boxes : (n, 2, 3) float64
        Those of the nodes.
    strokes : tuple of (m, k, 3) float64
        Polygons of k points, or segments for k = 2.
    n_drawn, n_prims : int
        How many primitives the strokes show, and how many there are.
    """

    outline: Outline
    boxes: Float64Array
    strokes: tuple[Float64Array, ...]
    n_drawn: int
    n_prims: int

    @property
    def notes(self) -> list[str]:
        """Whether only some of the primitives are drawn, in words."""
        return [f"{self.n_drawn:,} of {self.n_prims:,} primitives drawn"] if self.n_drawn < self.n_prims else []


def subject_of(tree: AnyTree, most: int = MAX_PRIMS) -> Subject:
    """Return what is drawn of a tree.

    Raises
    ------
    InputError
        If it is not a tree, has no primitives, or a box that is not finite.
    """
    outline = outline_of(tree)
    require_boxes(outline)
    if isinstance(tree, TreeData):
        drawn = sketch(tree.geometry.without_offset(), most)
        strokes, n_drawn, n_prims = _outlines(drawn.parts), drawn.n_drawn, drawn.n_prims
        offset = np.array(tree.geometry.offset)
    else:
        n_prims, offset = len(tree.prims), np.zeros(3)
        some = tree.prims if n_prims <= most else [tree.prims[i * n_prims // most] for i in range(most)]
        strokes, n_drawn = _of_theory(some), len(some)
    moved = tuple(part + offset for part in strokes if len(part))
    return Subject(outline, outline.boxes + offset, moved, n_drawn, n_prims)


def require_boxes(outline: Outline) -> None:
    """Refuse a tree without primitives, and one without a size."""
    if not len(outline.prims):
        raise InputError("the tree has no primitives, so there is nothing to draw; build it over one or more")
    if not np.isfinite(outline.boxes[0]).all():
        raise InputError(f"the root's box is {outline.boxes[0].tolist()}; only finite boxes can be drawn")


def _outlines(parts: tuple[AnyGeometry, ...]) -> list[Float64Array]:
    """Return strokes and polygons; of spheres, which are strokes without a length, three rings."""
    found = list[Float64Array]()
    for part in parts:
        strokes, radii = part.outlines()
        is_ball = (strokes == strokes[:, :1]).all(axis=(1, 2)) & (radii[:, 0] > 0)
        found += [strokes[~is_ball], _rings(strokes[is_ball, 0], radii[is_ball, 0])]
    return found


def _rings(centres: Float64Array, radii: Float64Array) -> Float64Array:
    """Return a circle around each centre in each of three planes, as polygons: (3n, CORNERS, 3)."""
    angles = np.linspace(0, 2 * np.pi, CORNERS, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(CORNERS)], axis=1)
    rings = np.stack([np.roll(circle, axis, axis=1) for axis in range(3)])
    return np.asarray(centres[:, None, None] + radii[:, None, None, None] * rings).reshape(-1, CORNERS, 3)


def _of_theory(prims: Sequence[Primitive]) -> list[Float64Array]:
    """Return segments as such, and other primitives as the sides of their boxes."""
    ends = [(prim.start, prim.end) for prim in prims if isinstance(prim, Segment)]
    boxes = [prim.bounds() for prim in prims if not isinstance(prim, Segment)]
    strokes = [np.array(ends, np.float64).reshape(-1, 2, 3)]
    return [*strokes, Boxes(np.array(boxes)).outlines()[0]] if boxes else strokes
