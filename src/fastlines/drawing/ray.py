"""The way of one ray through the boxes of a tree."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from ..arrays import instance
from ..inspection.traversal import trace_ray
from ..support.texts import counted, number_text
from ..tree import Tree
from .axes import COLORS, FAINT, INK, axes_of, describe, library
from .projection import AxisOption, projection_of
from .subject import subject_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The most boxes that have their number.
MAX_NUMBERED = 63


def draw_ray(
    tree: Tree,
    origin: npt.ArrayLike,
    direction: npt.ArrayLike,
    radius: float | None = None,
    *,
    query: Literal["first", "all"] = "all",
    axis: AxisOption = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the boxes that a ray enters, with numbers in their order, and what it hits.

    Parameters
    ----------
    tree : Tree
    origin, direction, radius, query
        As in `fastlines.inspection.trace_ray`.
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
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 0]], [[4, 0, 0], [5, 1, 0]]], "bvh-cl", cost=fl.Cost(0.1))
    >>> fl.drawing.draw_ray(tree, [-1, 0.5, 0], [1, 0, 0], 0.1).get_title()
    'custom: 1 step, 2 tests, 2 hits'
    """
    instance("tree", tree, Tree, "a Tree, as fl.build makes it; a tree of fl.theory has no rays")
    axes, subject = axes_of(ax), subject_of(tree)
    outline = subject.outline
    way = trace_ray(tree, origin, direction, radius, query=query, outline=outline)
    view = projection_of(subject.boxes[0], axis)
    subject.draw_prims(axes, view, INK if subject.n_drawn <= MAX_NUMBERED else FAINT, 1.0)
    boxes = library("matplotlib.collections").PolyCollection
    rectangles = view.rectangles(subject.boxes[way.nodes])
    for is_leaf, color in ((False, COLORS[0]), (True, COLORS[1])):
        if (way.is_leaf == is_leaf).any():
            rows = rectangles[way.is_leaf == is_leaf]
            filled = (*library("matplotlib.colors").to_rgb(color), 0.12 if is_leaf else 0.0)
            drawn = boxes(rows, edgecolors=color, facecolors=filled, linewidths=1.1, zorder=2)
            axes.add_collection(drawn, autolim=False)
    for number, corners in enumerate(rectangles[:MAX_NUMBERED], 1):
        color = COLORS[1] if way.is_leaf[number - 1] else COLORS[0]
        axes.text(*corners[3], str(number), color=color, fontsize="small", fontweight="bold", va="top", zorder=5)
    start, along = np.asarray(origin, np.float64).reshape(3), np.asarray(direction, np.float64).reshape(3)
    _draw_line(axes, view.points(start), view.points(along))
    if len(way.hits):
        points = view.points(way.hits.points())
        axes.plot(points[:, 0], points[:, 1], "o", color=COLORS[2], markersize=5, zorder=6, label="hits")
    found = [counted(way.n_steps, "steps"), counted(way.n_tests, "tests"), counted(len(way.hits), "hits")]
    notes = ["blue: inner nodes; orange: leaves; green: hits", f"cost {number_text(way.cost)}", *subject.notes]
    describe(axes, f"{outline.name}: {', '.join(found)}", notes, view.names[0])
    return axes


def _draw_line(axes: Axes, start: npt.NDArray[np.float64], along: npt.NDArray[np.float64]) -> None:
    """Draw the ray from its origin, or from the edge of the picture, to the other edge."""
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    length = float(np.hypot(*along))
    if length == 0:
        axes.plot(*start, "x", color=COLORS[3], zorder=6)
        return
    reach = float(np.hypot(x1 - x0, y1 - y0)) + float(np.hypot(start[0] - (x0 + x1) / 2, start[1] - (y0 + y1) / 2))
    end = start + along / length * reach
    axes.plot(
        [start[0], end[0]], [start[1], end[1]], color=COLORS[3], linewidth=1.6, zorder=6, scalex=False, scaley=False
    )
