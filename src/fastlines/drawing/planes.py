"""The split planes of a tree over its primitives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..arrays import IntArray, count
from ..geometry.hit_places import Float64Array
from ..geometry.lines import AXES
from ..support.texts import counted
from .axes import COLORS, axes_of, describe, legend, library
from .backdrop import draw_backdrop
from .projection import AxisOption, Projection, projection_of
from .subject import AnyTree, Subject, subject_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The width of the root's plane in points, and of the thinnest; each level has this fraction of the width above.
WIDEST, THINNEST, NARROWER = 3.0, 0.3, 0.78
#: The last level whose planes are drawn by default.
MAX_LEVEL = 8


def draw_planes(tree: AnyTree, *, max_level: int = MAX_LEVEL, axis: AxisOption = None, ax: Axes | None = None) -> Axes:
    """Draw the planes that separate the boxes of siblings, seen along an axis: thick near the root.

    A KD tree has a plane at each inner node, and a BVH wherever the boxes of siblings do not overlap. Planes have a
    colour for each axis. Those that face the viewer would cover the picture; they are only counted, as are nodes
    without a plane.

    Parameters
    ----------
    tree : Tree or theory.Node
    max_level : int
        The last level whose planes are drawn.
    axis : {"x", "y", "z"}, optional
        The axis of view; by default the one on which the root's box is shortest.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 200).lines, "kd-d2")
    >>> fl.drawing.draw_planes(tree, max_level=3).get_title()
    'kd-d2, planes of levels 0 to 3'
    """
    axes, subject = axes_of(ax), subject_of(tree)
    outline, view = subject.outline, projection_of(subject.boxes[0], axis)
    last = min(count("max_level", max_level, 0), len(outline.levels) - 1)
    draw_backdrop(axes, subject, view)
    nodes = np.flatnonzero((outline.level <= last) & ~outline.is_leaf)
    split = outline.split_axis[nodes]
    for side, name, color in zip(view.plane, view.names, COLORS, strict=False):
        seen = nodes[split == side]
        if len(seen):
            width = np.maximum(THINNEST, WIDEST * NARROWER ** outline.level[seen])
            lines = library("matplotlib.collections").LineCollection
            drawn = plane_segments(subject, view, seen)
            axes.add_collection(lines(list(drawn), colors=color, linewidths=width, zorder=3), autolim=False)
            axes.plot([], [], color=color, label=f"{name}: {counted(len(seen), 'planes')}")
    legend(axes, "upper right")
    facing, without = int((split == view.axis).sum()), int((split < 0).sum())
    notes = [f"{counted(facing, 'planes')} across {AXES[view.axis]} would face the viewer"] if facing else []
    notes += [f"{counted(without, 'nodes')} have children that overlap"] if without else []
    which = f"planes of levels 0 to {last}" if len(nodes) else "one leaf, without planes"
    describe(axes, f"{outline.name}, {which}", [*notes, *subject.notes], view.names[0])
    return axes


def plane_segments(subject: Subject, view: Projection, nodes: IntArray) -> Float64Array:
    """Return where the planes of some nodes cross the picture, (n, 2, 2): from side to side of their boxes."""
    outline, rows = subject.outline, np.arange(len(nodes))
    axis = outline.split_axis[nodes].astype(np.int64)
    offset = subject.boxes[0, 0] - outline.boxes[0, 0]
    ends = subject.boxes[nodes].copy()
    ends[rows, :, axis] = (outline.split_plane[nodes] + offset[axis])[:, None]
    return view.points(ends)
