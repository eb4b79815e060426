"""The boxes of one level of a tree over its primitives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..arrays import IntArray, count
from ..errors import InputError
from ..support.texts import counted
from .axes import axes_of, describe, library, ordered_colors
from .backdrop import draw_backdrop
from .projection import AxisOption, projection_of
from .subject import AnyTree, Subject, subject_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The most boxes that are drawn of a level, and of the leaves above it; more are represented by the largest.
MAX_BOXES = 2_000
#: The width of a box's edge in points, for few boxes and for many.
EDGE, THIN = 1.2, 0.4
#: How opaque all boxes are together, and one box at most. So boxes that overlap stay transparent.
TOGETHER, OPACITY = 0.5, 0.12
#: The number of boxes from which edges are thin.
FEW = 64


def draw_levels(tree: AnyTree, level: int, *, axis: AxisOption = None, ax: Axes | None = None) -> Axes:
    """Draw the boxes of one level over the primitives, seen along an axis.

    Boxes have colours by their order in the level, so neighbours in the tree look alike. Leaves of earlier levels are
    grey, as they are part of what the level divides.

    Parameters
    ----------
    tree : Tree or theory.Node
    level : int
        0 is the root's.
    axis : {"x", "y", "z"}, optional
        The axis of view; by default the one on which the root's box is shortest.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        ``ax.figure.savefig(path)`` writes it.

    Raises
    ------
    InputError
        If there is no such level, or the tree has no primitives.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 200).lines, "bvh-d2")
    >>> ax = fl.drawing.draw_levels(tree, 2)
    >>> ax.get_title()
    'bvh-d2, level 2: 4 boxes'
    """
    axes, subject = axes_of(ax), subject_of(tree)
    levels = subject.outline.levels
    if count("level", level, 0) >= len(levels):
        raise InputError(f"level={level}; {subject.outline.name} has levels 0 to {len(levels) - 1} here")
    view = projection_of(subject.boxes[0], axis)
    draw_backdrop(axes, subject, view)
    nodes, is_leaf = levels[level], subject.outline.is_leaf
    ended = np.concatenate([above[is_leaf[above]] for above in levels[: level + 1]])[: None if level else 0]
    ended = ended[~np.isin(ended, nodes)]
    shown, ended_shown = _largest(subject, nodes), _largest(subject, ended)
    colors = ordered_colors(len(nodes))[np.searchsorted(nodes, shown)]
    draw_boxes = library("matplotlib.collections").PolyCollection
    rectangles = view.rectangles(subject.boxes)
    width = EDGE if len(nodes) <= FEW else THIN
    grey = {"edgecolors": "#777777", "facecolors": (0.5, 0.5, 0.5, 0.06), "linewidths": THIN, "zorder": 2}
    if len(ended_shown):
        axes.add_collection(draw_boxes(rectangles[ended_shown], **grey), autolim=False)
    sides = np.ptp(rectangles, axis=1)
    covered = float((sides[shown].prod(axis=1)).sum() / max(float(sides[0].prod()), 1e-300))
    filled = colors * np.array([1, 1, 1, min(OPACITY, TOGETHER / max(covered, 1.0))])
    boxes = draw_boxes(rectangles[shown], edgecolors=colors, facecolors=filled, linewidths=width, zorder=3)
    axes.add_collection(boxes, autolim=False)
    n_boxes = len(nodes) + len(ended)
    n_drawn = len(shown) + len(ended_shown)
    notes = [*subject.notes, *([f"the {n_drawn:,} largest of {n_boxes:,} boxes"] if n_drawn < n_boxes else [])]
    grey_note = [f"grey: {counted(len(ended), 'leaves')} of earlier levels"] if len(ended) else []
    title = f"{subject.outline.name}, level {level}: {counted(len(nodes), 'boxes')}"
    describe(axes, title, [*grey_note, *notes], view.names[0])
    return axes


def _largest(subject: Subject, nodes: IntArray) -> IntArray:
    """Return the nodes with the largest boxes, in their order."""
    if len(nodes) <= MAX_BOXES:
        return nodes
    order = np.argsort(-subject.outline.chance[nodes], kind="stable")
    return np.sort(nodes[order[:MAX_BOXES]])
