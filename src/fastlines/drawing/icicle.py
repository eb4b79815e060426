"""The cost of a tree by node, as an icicle: each bar hangs below its parent's, and is as wide as its share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, choice
from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline, outline_of
from ..settings.settings import Cost
from ..support.texts import counted, number_text
from .axes import INNER, LEAF, axes_of, describe, legend, library
from .subject import AnyTree, require_boxes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: What widths can be shares of: the cost of a tree, or its references.
SHARES = ("cost", "refs")
#: How many columns the root is wide. Nodes narrower than a column are merged with their neighbours.
COLUMNS = 2000
#: Bars at least this wide, as a fraction of the root, have white edges.
EDGED = 1 / 200
#: The width of an entry of the legend in inches.
LEGEND_WIDTH = 1.5
#: The colours of merged inner nodes and leaves.
PALE_INNER, PALE_LEAF = "#99c7e0", "#eebf99"


class Bars(NamedTuple):
    """Where bars begin, how wide they are, and on which levels."""

    start: Float64Array
    width: Float64Array
    level: IntArray


def draw_icicle(
    tree: AnyTree, *, by: Literal["cost", "refs"] = "cost", model: Cost | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the share of each node in the cost of the tree, as an icicle.

    The root is the bar at the top, as wide as the cost of the tree. Below each inner node are its children, each as
    wide as what it and all nodes below it add to the cost (thesis §3.3, the sum g). What no child covers is the node's
    own cost: that of a step. A leaf's cost is all its own. Nodes narrower than 1/2000 of the root are merged into pale
    bars.

    Parameters
    ----------
    tree : Tree or theory.Node
    by : {"cost", "refs"}
        What widths are shares of: the cost, or the references at or below a node.
    model : Cost, optional
        The costs of a step and of a test; by default those of the build.
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
    axes, outline = axes_of(ax, 8.0, 4.0), outline_of(tree, model)
    require_boxes(outline)
    width = outline.cost_below if choice("by", by, SHARES) == "cost" else outline.n_refs.astype(np.float64)
    start, whole = starts(outline, width), float(width[0])
    narrow = width * COLUMNS < whole
    n_levels = 0
    for is_leaf, color, pale, what in ((False, INNER, PALE_INNER, "inner nodes"), (True, LEAF, PALE_LEAF, "leaves")):
        nodes = np.flatnonzero(~narrow & (outline.is_leaf == is_leaf))
        wide = Bars(start[nodes], width[nodes], outline.level[nodes])
        columns = merged(outline, start, width, narrow, is_leaf)
        for bars, shade, label in ((wide, color, what), (columns, pale, f"narrow {what}")):
            if len(bars.start):
                _draw(axes, bars, whole, shade, label)
                n_levels = max(n_levels, 1 + int(bars.level.max()))
    # Leave room for the legend below.
    rows = legend(axes, "lower right", LEGEND_WIDTH)
    axes.set(xlim=(0, whole), ylim=((1.02 + 0.08 * rows) * n_levels + 0.5, 0), ylabel="level")
    labelled_levels = np.arange(n_levels)[:: 1 + n_levels // 12]
    axes.set_yticks(labelled_levels + 0.5, labelled_levels)
    what = "cost" if by == "cost" else "references"
    notes = _notes(outline, by, narrow, n_levels)
    describe(axes, f"{outline.name}: {what} {number_text(whole)}, by node", notes, what)
    return axes


def _notes(outline: Outline, by: str, narrow: npt.NDArray[np.bool_], n_levels: int) -> list[str]:
    """Return how the cost is divided, and what is merged or too narrow to see, in words."""
    tests = float(outline.own_cost[outline.is_leaf].sum() / outline.cost_below[0])
    notes = [f"steps in inner nodes {1 - tests:.0%}, tests in leaves {tests:.0%}"] if by == "cost" else []
    kinds = {"inner nodes": narrow & ~outline.is_leaf, "leaves": narrow & outline.is_leaf}
    counts = [counted(int(which.sum()), nouns) for nouns, which in kinds.items() if which.any()]
    notes += [f"pale: {' and '.join(counts)}, each narrower than 1/{COLUMNS}"] if counts else []
    hidden = len(outline.levels) - n_levels
    if hidden:
        notes.append(f"{counted(hidden, 'levels')} further down {'is' if hidden == 1 else 'are'} too narrow to see")
    return notes


def starts(outline: Outline, width: Float64Array) -> Float64Array:
    """Return where the bar of each node begins, (n,): the left child at its parent's, the right one after the left."""
    start = np.zeros(outline.n_nodes)
    for nodes in outline.levels:
        inner = nodes[~outline.is_leaf[nodes]]
        start[inner + 1] = start[inner]
        start[outline.right[inner]] = start[inner] + width[inner + 1]
    return start


def merged(
    outline: Outline, start: Float64Array, width: Float64Array, narrow: npt.NDArray[np.bool_], leaves: bool
) -> Bars:
    """Return bars of the columns that narrow nodes of a level fill at least by half, mostly with leaves or with others.

    Neighbouring columns are one bar.
    """
    column, begins, widths, levels = float(width[0]) / COLUMNS, list[IntArray](), list[IntArray](), list[IntArray]()
    for level, nodes in enumerate(outline.levels):
        few = nodes[narrow[nodes]]
        at = np.minimum((start[few] + width[few] / 2) / column, COLUMNS - 1).astype(np.int64)
        filled = [
            np.bincount(at[mine], width[few][mine], COLUMNS)
            for mine in (outline.is_leaf[few] == leaves, outline.is_leaf[few] != leaves)
        ]
        is_seen = (filled[0] + filled[1] >= column / 2) & (
            (filled[0] > filled[1]) | (leaves & (filled[0] == filled[1]))
        )
        edges = np.flatnonzero(np.diff(np.concatenate([[False], is_seen, [False]])))
        begins.append(edges[::2])
        widths.append(edges[1::2] - edges[::2])
        levels.append(np.full(len(edges) // 2, level))
    begin, wide = (np.asarray(np.concatenate(parts) * column, np.float64) for parts in (begins, widths))
    return Bars(begin, wide, np.concatenate(levels))


def _draw(axes: Axes, bars: Bars, whole: float, color: str, label: str) -> None:
    start, end, below = bars.start, bars.start + bars.width, bars.level + 1
    corners = np.stack([start, bars.level, end, bars.level, end, below, start, below], axis=1).reshape(-1, 4, 2)
    edges = np.where(bars.width >= EDGED * whole, 0.5, 0.0)
    collection = library("matplotlib.collections").PolyCollection
    drawn = collection(corners, facecolors=color, edgecolors="white", linewidths=edges, label=label)
    axes.add_collection(drawn, autolim=False)
