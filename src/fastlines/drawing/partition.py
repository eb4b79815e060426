"""A few primitives in the plane, and how a tree divides them (thesis, figures 1.1 and 1.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..geometry.hit_places import Float64Array
from ..geometry.lines import AXES
from ..support.texts import counted
from .axes import INK, axes_of, describe, library, ordered_colors
from .backdrop import draw_backdrop
from .letters import Lettered, kind_of, lettered
from .placing import along_strokes, apart, inside, on_line, on_sides, write
from .planes import plane_segments
from .projection import AxisOption, Projection, projection_of
from .subject import AnyTree, Subject, subject_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: How much farther out each box is drawn than those a level below, as a fraction of the root's longest side.
APART = 0.014
#: The space around the outermost box, and from the middle of a primitive to its number; fractions of the same.
MARGIN, BESIDE = 0.03, 0.028
#: How opaque boxes are, and the most primitives that are numbered.
OPACITY, MAX_NUMBERED = 0.05, 40


def draw_partition(
    tree: AnyTree, *, max_level: int | None = None, axis: AxisOption = None, ax: Axes | None = None
) -> Axes:
    """Draw a few primitives in the plane, and the boxes of a BVH or the planes of a KD tree, with letters.

    `draw_graph` draws the tree with the same letters. Boxes of a BVH are drawn a little apart, so that sides that
    coincide are visible. In a KD tree, a letter at a line is that of the node which the plane divides, and a letter in
    a cell that of a leaf.

    Parameters
    ----------
    tree : Tree or theory.Node
        Best flat (z = 0) and with few primitives, which then have their numbers.
    max_level : int, optional
        The last level; by default as many levels as have at most 63 nodes.
    axis : {"x", "y", "z"}, optional
        The axis of view; by default the one on which the root's box is shortest.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes

    Raises
    ------
    InputError
        If the levels have more than 63 nodes.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines import theory as th
    >>> segments = [[[0, 0, 0], [1, 1, 0]], [[2, 0, 0], [3, 1, 0]], [[6, 0, 0], [7, 1, 0]]]
    >>> tree = th.build(th.segments(segments), th.object_sweep, c_trav=0.1)
    >>> [text.get_text() for text in fl.drawing.draw_partition(tree).texts]
    ['0', '1', '2', 'A', 'B', 'C', 'D', 'E']
    """
    axes, subject = axes_of(ax), subject_of(tree)
    named, view = lettered(subject.outline, max_level), projection_of(subject.boxes[0], axis)
    draw_backdrop(axes, subject, view)
    taken = number_prims(axes, subject, view)
    draw = _draw_cells if subject.outline.is_kd else _draw_boxes
    notes = draw(axes, subject, named, view, taken)
    describe(axes, f"{kind_of(subject.outline)}: the partition", [*notes, *named.notes, *subject.notes], view.names[0])
    return axes


def grown(subject: Subject, named: Lettered) -> Float64Array:
    """Return the boxes of the lettered nodes, each drawn outside of those below it."""
    root = subject.boxes[0]
    step = APART * float((root[1] - root[0]).max())
    outwards = step * (named.last - subject.outline.level[named.nodes])
    return np.asarray(subject.boxes[named.nodes] + outwards[:, None, None] * np.array([-1.0, 1.0])[:, None])


def _draw_boxes(axes: Axes, subject: Subject, named: Lettered, view: Projection, taken: Float64Array) -> list[str]:
    """Draw boxes with letters on their sides, and widen the limits for those that are drawn apart."""
    rectangles = view.rectangles(grown(subject, named))
    colors = ordered_colors(named.last + 1)[subject.outline.level[named.nodes]]
    boxes = library("matplotlib.collections").PolyCollection
    filled = colors * np.array([1, 1, 1, OPACITY])
    style = {"linewidths": 1.1, "zorder": 2}
    axes.add_collection(boxes(rectangles, edgecolors=colors, facecolors=filled, **style), autolim=False)
    letters = [named.letters[node] for node in named.nodes.tolist()]
    # The smallest boxes have the least choice.
    backwards = apart([on_sides(corners) for corners in rectangles[::-1]], taken)
    for text, at, color in zip(letters, backwards[::-1], colors, strict=True):
        write(axes, text, at, color)
    low, high = rectangles[0][0], rectangles[0][2]
    margin = MARGIN * float((high - low).max()) or 1.0
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    axes.set(xlim=(min(x0, low[0] - margin), max(x1, high[0] + margin)))
    axes.set(ylim=(min(y0, low[1] - margin), max(y1, high[1] + margin)))
    return []


def _draw_cells(axes: Axes, subject: Subject, named: Lettered, view: Projection, taken: Float64Array) -> list[str]:
    """Draw the planes of inner nodes and the letters of leaves; return what cannot be drawn, in words."""
    outline, level = subject.outline, subject.outline.level
    boxes = library("matplotlib.collections").PolyCollection
    corners = view.rectangles(subject.boxes)
    axes.add_collection(boxes(corners[:1], edgecolors=INK, facecolors="none", linewidths=1.1, zorder=2), autolim=False)
    has_plane = ~outline.is_leaf[named.nodes] & (level[named.nodes] < named.last)
    inner = named.nodes[has_plane]
    seen = inner[outline.split_axis[inner] != view.axis]
    segments = plane_segments(subject, view, seen)
    colors = ordered_colors(named.last + 1)
    lines = library("matplotlib.collections").LineCollection
    axes.add_collection(lines(list(segments), colors=colors[level[seen]], linewidths=1.8, zorder=3), autolim=False)
    cells = named.nodes[~has_plane][::-1]
    lettered_nodes = [*cells.tolist(), *seen[::-1].tolist()]
    choices = [inside(corners[node]) for node in cells.tolist()] + [on_line(*ends) for ends in segments[::-1]]
    for node, at in zip(lettered_nodes, apart(choices, taken), strict=True):
        write(axes, named.letters[node], at, colors[level[node]])
    n_facing = len(inner) - len(seen)
    return [f"{counted(n_facing, 'planes')} across {AXES[view.axis]} would face the viewer"] if n_facing else []


def number_prims(axes: Axes, subject: Subject, view: Projection) -> Float64Array:
    """Write the numbers of primitives beside their middles, if they are few; return points that are taken now, (n, 2).

    Primitives of several strokes each, such as curves, have no numbers.
    """
    strokes = [view.points(part) for part in subject.strokes]
    taken = np.concatenate([np.empty((0, 2)), *map(along_strokes, strokes)])
    if len(strokes) != 1 or not len(strokes[0]) == subject.n_prims <= MAX_NUMBERED:
        return taken
    middles = strokes[0].mean(axis=1)
    low, high = view.points(subject.boxes[0])
    beside = middles + BESIDE * float((high - low).max()) * _across(strokes[0])
    for number, (x, y) in enumerate(beside.tolist()):
        axes.text(x, y, str(number), ha="center", va="center", fontsize="medium", color=INK, zorder=4)
    return np.concatenate([taken, beside])


def _across(strokes: Float64Array) -> Float64Array:
    """Return the direction across each stroke that points to the right, (n, 2), or downwards if it lies flat."""
    along = strokes[:, 1] - strokes[:, 0]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    across = np.divide(along[:, ::-1] * (1, -1), length, out=np.full(along.shape, 0.7), where=length > 0)
    return np.asarray(np.where((across[:, :1] < 0) | ((across[:, :1] == 0) & (across[:, 1:] > 0)), -across, across))
