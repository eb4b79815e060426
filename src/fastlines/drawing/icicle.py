"""The cost of a tree by node, as an icicle: each bar hangs below its parent's, and is as wide as its share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from ..arrays import IntArray, choice
from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline, outline_of
from ..support.texts import counted, number_text
from .axes import INK, INNER, LEAF, axes_of, describe, library
from .subject import AnyTree, require_boxes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: What widths can be shares of: the cost of a tree, or its references.
SHARES = ("cost", "refs")
#: The fraction of the root's width below which nodes are merged with their neighbours.
NARROW = 1 / 2000
#: Bars at least this wide have edges.
EDGED = 1 / 200
MERGED = "#b5b9bf"


def draw_icicle(tree: AnyTree, *, by: Literal["cost", "refs"] = "cost", ax: Axes | None = None) -> Axes:
    """Draw the share of each node in the cost of the tree, as an icicle.

    The root is the bar at the top, as wide as the cost of the tree. Below each inner node are its children, each as
    wide as what it and all nodes below it add to the cost (thesis §3.3, the sum g). What no child covers is the node's
    own cost: that of a step. A leaf's cost is all its own. Nodes narrower than 1/2000 of the root are merged.

    Parameters
    ----------
    tree : Tree or theory.Node
    by : {"cost", "refs"}
        What widths are shares of: the cost, or the references at or below a node.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 200).lines, "bvh-d2")
    >>> ax = fl.drawing.draw_icicle(tree)
    >>> bool(abs(ax.get_xlim()[1] - tree.cost(by="g")) < 1e-9)
    True
    """
    axes = axes_of(ax, 8.0, 4.0)
    outline = outline_of(tree)
    require_boxes(outline)
    choice("by", by, SHARES)
    width = outline.cost_below if by == "cost" else outline.n_refs.astype(np.float64)
    start, whole = starts(outline, width), float(width[0])
    is_wide = width >= NARROW * whole
    shown = np.flatnonzero(is_wide)
    bars = library("matplotlib.collections").PolyCollection
    for is_leaf, color, what in ((False, INNER, "inner nodes"), (True, LEAF, "leaves")):
        nodes = shown[outline.is_leaf[shown] == is_leaf]
        if len(nodes):
            edges = np.where(width[nodes] >= EDGED * whole, 0.5, 0.0)
            corners = _corners(start[nodes], width[nodes], outline.level[nodes])
            drawn = bars(corners, facecolors=color, edgecolors="white", linewidths=edges, label=what)
            axes.add_collection(drawn, autolim=False)
    runs = _merged(outline, start, width, ~is_wide, NARROW * whole)
    if len(runs[0]):
        n_merged = counted(int((~is_wide).sum()), "nodes")
        label = f"{n_merged}, each below 1/{1 / NARROW:.0f}"
        axes.add_collection(bars(_corners(*runs), facecolors=MERGED, label=label), autolim=False)
    n_levels = 1 + int(max(outline.level[shown].max(), runs[2].max(initial=0)))
    axes.set(xlim=(0, whole or 1.0), ylim=(n_levels - 0.0, 0), ylabel="level")
    axes.legend(loc="lower right", fontsize="small", labelcolor=INK, facecolor="white", framealpha=0.9)
    hidden = len(outline.levels) - n_levels
    notes = [f"{counted(hidden, 'levels')} below are too narrow"] if hidden else []
    what = "cost" if by == "cost" else "references"
    describe(axes, f"{outline.name}: {what} {number_text(whole)}, by node", notes, what)
    return axes


def starts(outline: Outline, width: Float64Array) -> Float64Array:
    """Return where the bar of each node begins, (n,): the left child at its parent's, the right one after the left."""
    start = np.zeros(outline.n_nodes)
    for nodes in outline.levels:
        inner = nodes[~outline.is_leaf[nodes]]
        start[inner + 1] = start[inner]
        start[outline.right[inner]] = start[inner] + width[inner + 1]
    return start


def _corners(start: Float64Array, width: Float64Array, level: IntArray) -> Float64Array:
    end, below = start + width, level + 1
    return np.stack([start, level, end, level, end, below, start, below], axis=1).reshape(-1, 4, 2)


def _merged(
    outline: Outline, start: Float64Array, width: Float64Array, is_narrow: Float64Array, most: float
) -> tuple[Float64Array, Float64Array, IntArray]:
    """Return runs of narrow nodes of a level that are less than `most` apart: starts, widths and levels."""
    begins, widths, levels = list[Float64Array](), list[Float64Array](), list[IntArray]()
    for level, nodes in enumerate(outline.levels):
        narrow = nodes[is_narrow[nodes]]
        if len(narrow):
            begin, end = start[narrow], start[narrow] + width[narrow]
            first = np.flatnonzero(np.concatenate([[True], begin[1:] - end[:-1] >= most]))
            last = np.concatenate([first[1:], [len(narrow)]]) - 1
            visible = end[last] - begin[first] >= most
            begins.append(begin[first][visible])
            widths.append((end[last] - begin[first])[visible])
            levels.append(np.full(int(visible.sum()), level))
    if not begins:
        return np.empty(0), np.empty(0), np.empty(0, np.int64)
    return np.concatenate(begins), np.concatenate(widths), np.concatenate(levels)
