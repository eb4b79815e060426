"""The way of one ray through the boxes of a tree."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from ..arrays import instance
from ..geometry.hit_places import Float64Array
from ..inspection.traversal import trace_ray
from ..support.texts import counted, number_text
from ..tree import Tree
from .axes import COLORS, INNER, LEAF, axes_of, describe, library
from .backdrop import draw_backdrop
from .partition import number_prims
from .placing import apart, on_sides, write
from .projection import AxisOption, Projection, projection_of
from .subject import subject_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The ray and what it hits; leaves are filled, this opaque.
RAY, HIT, FILLED = COLORS[3], COLORS[2], 0.12
#: The most boxes and primitives that have their number.
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
    draw_backdrop(axes, subject, view)
    taken = number_prims(axes, subject, view)
    boxes = library("matplotlib.collections").PolyCollection
    rectangles = view.rectangles(subject.boxes[way.nodes])
    for is_leaf, color in ((False, INNER), (True, LEAF)):
        rows = rectangles[way.is_leaf == is_leaf]
        if len(rows):
            filled = (*library("matplotlib.colors").to_rgb(color), FILLED if is_leaf else 0.0)
            drawn = boxes(rows, edgecolors=color, facecolors=filled, linewidths=1.1, zorder=2)
            axes.add_collection(drawn, autolim=False)
    numbered = rectangles[:MAX_NUMBERED]
    places = apart([on_sides(corners) for corners in numbered[::-1]], taken)[::-1]
    for number, (at, is_leaf) in enumerate(zip(places, way.is_leaf.tolist(), strict=False), 1):
        write(axes, str(number), at, LEAF if is_leaf else INNER)
    _draw_ray(axes, view, np.asarray(origin, np.float64), np.asarray(direction, np.float64), radius or 0.0)
    if len(way.hits):
        points = view.points(way.hits.points())
        axes.plot(points[:, 0], points[:, 1], "o", color=HIT, markersize=5, zorder=7)
    found = [counted(way.n_steps, "steps"), counted(way.n_tests, "tests"), counted(len(way.hits), "hits")]
    notes = ["blue: inner nodes; orange: leaves; green: hits", f"cost {number_text(way.cost)}", *subject.notes]
    describe(axes, f"{outline.name}: {', '.join(found)}", notes, view.names[0])
    return axes


def _draw_ray(axes: Axes, view: Projection, origin: Float64Array, direction: Float64Array, radius: float) -> None:
    """Draw the ray from its origin to the edge of the picture, and the space within the radius around it."""
    start, along = view.points(origin.reshape(3)), view.points(direction.reshape(3))
    length = float(np.hypot(*along))
    if length == 0:  # it runs along the axis of view
        axes.plot(*start, "x", color=RAY, zorder=6)
        return
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    middle = np.array([x0 + x1, y0 + y1]) / 2
    reach = float(np.hypot(x1 - x0, y1 - y0) + np.hypot(*(start - middle)))
    end = start + along / length * reach
    beside = radius / length * np.array([-along[1], along[0]])
    if radius:
        axes.fill(*np.array([start + beside, end + beside, end - beside, start - beside]).T, color=RAY, alpha=0.2, lw=0)
    axes.plot(*np.array([start, end]).T, color=RAY, linewidth=1.6, zorder=6)
    axes.set(xlim=(x0, x1), ylim=(y0, y1))
