"""A few primitives in the plane, and how a tree divides them (thesis, figures 1.1 and 1.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..geometry.hit_places import Float64Array
from ..geometry.lines import AXES
from ..support.texts import counted
from .axes import INK, axes_of, describe, library, ordered_colors
from .letters import Lettered, lettered
from .planes import plane_segments
from .projection import AxisOption, Projection, projection_of
from .subject import AnyTree, Subject, subject_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: How much farther out each box is drawn than those a level below, as a fraction of the root's longest side.
APART = 0.012
#: The most primitives that are numbered.
MAX_NUMBERED = 40


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
    subject.draw_prims(axes, view, INK, 1.4)
    _number_prims(axes, subject, view)
    kind = "KD tree" if subject.outline.is_kd else "BVH"
    notes = draw_cells(axes, subject, named, view) if subject.outline.is_kd else _draw_boxes(axes, subject, named, view)
    describe(axes, f"{kind}: the partition", [*notes, *named.notes, *subject.notes], view.names[0])
    return axes


def grown(subject: Subject, named: Lettered) -> Float64Array:
    """Return the boxes of the lettered nodes, each drawn outside of those below it."""
    root = subject.boxes[0]
    step = APART * float((root[1] - root[0]).max())
    outwards = step * (named.last - subject.outline.level[named.nodes])
    return subject.boxes[named.nodes] + outwards[:, None, None] * np.array([-1.0, 1.0])[:, None]


def _draw_boxes(axes: Axes, subject: Subject, named: Lettered, view: Projection) -> list[str]:
    """Draw boxes with a letter at the upper left corner, and widen the limits for those that are drawn apart."""
    rectangles = view.rectangles(grown(subject, named))
    colors = ordered_colors(named.last + 1)[subject.outline.level[named.nodes]]
    boxes = library("matplotlib.collections").PolyCollection
    filled = colors * np.array([1, 1, 1, 0.05])
    axes.add_collection(
        boxes(rectangles, edgecolors=colors, facecolors=filled, linewidths=1.1, zorder=2), autolim=False
    )
    for node, corners, color in zip(named.nodes.tolist(), rectangles, colors, strict=True):
        _letter(axes, named.letters[node], corners[3], color, "left", "top")
    low, high = rectangles[0][0], rectangles[0][2]
    margin = 0.03 * float((high - low).max()) or 1.0
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    return []


def draw_cells(axes: Axes, subject: Subject, named: Lettered, view: Projection) -> list[str]:
    """Draw the planes of inner nodes and the letters of leaves; return what cannot be drawn, in words."""
    outline, level = subject.outline, subject.outline.level
    boxes = library("matplotlib.collections").PolyCollection
    corners = view.rectangles(subject.boxes)
    axes.add_collection(boxes(corners[:1], edgecolors=INK, facecolors="none", linewidths=1.1, zorder=2), autolim=False)
    has_plane = ~outline.is_leaf[named.nodes] & (level[named.nodes] < named.last)
    inner = named.nodes[has_plane]
    seen = inner[outline.split_axis[inner] != view.axis]
    colors = ordered_colors(named.last + 1)
    segments = plane_segments(subject, view, seen)
    lines = library("matplotlib.collections").LineCollection
    axes.add_collection(lines(list(segments), colors=colors[level[seen]], linewidths=1.8, zorder=3), autolim=False)
    for node, (start, end) in zip(seen.tolist(), segments, strict=True):
        _letter(axes, named.letters[node], start + 0.9 * (end - start), colors[level[node]], "center", "center")
    for node in named.nodes[~has_plane].tolist():
        middle = corners[node].mean(axis=0)
        _letter(axes, named.letters[node], middle, colors[level[node]], "center", "center")
    n_facing = len(inner) - len(seen)
    return [f"{counted(n_facing, 'planes')} across {AXES[view.axis]} would face the viewer"] if n_facing else []


def _letter(axes: Axes, text: str, at: Float64Array, color: Float64Array, across: str, upwards: str) -> None:
    box = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
    more = {"ha": across, "va": upwards, "fontsize": "small", "fontweight": "bold", "color": color, "bbox": box}
    axes.text(at[0], at[1], text, zorder=5, **more)


def _number_prims(axes: Axes, subject: Subject, view: Projection) -> None:
    """Write the numbers of primitives beside their middles, if they are few and each has one stroke."""
    strokes = subject.strokes[0] if len(subject.strokes) == 1 else np.empty((0, 2, 3))
    if not len(strokes) == subject.n_prims <= MAX_NUMBERED:
        return
    for number, middle in enumerate(view.points(strokes.mean(axis=1))):
        more = {"textcoords": "offset points", "xytext": (3, -3), "va": "top", "fontsize": "small", "color": INK}
        axes.annotate(str(number), (middle[0], middle[1]), zorder=4, **more)
