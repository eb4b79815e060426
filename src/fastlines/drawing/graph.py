"""The tree as a graph, with the letters of the partition (thesis, figures 1.1 and 1.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline, outline_of
from ..support.texts import counted, listed
from .axes import INK, axes_of, describe, ordered_colors, without_frame
from .letters import Lettered, kind_of, lettered
from .subject import AnyTree, require_boxes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The frames of inner nodes and of leaves.
ROUND, SQUARE = "circle,pad=0.3", "round,pad=0.35,rounding_size=0.15"
#: The most primitives that the label of a leaf lists.
MAX_LISTED = 4


def draw_graph(tree: AnyTree, *, max_level: int | None = None, ax: Axes | None = None) -> Axes:
    """Draw a tree as a graph: inner nodes as circles, leaves as squares with the numbers of their primitives.

    Nodes have the letters of `draw_partition`. Leaves are in their order from the left to the right, and each inner
    node is above the middle of its children. So no edges cross.

    Parameters
    ----------
    tree : Tree or theory.Node
    max_level : int, optional
        The last level; by default as many levels as have at most 63 nodes.
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
    >>> [text.get_text() for text in fl.drawing.draw_graph(tree).texts]
    ['A', 'B', 'C', '2', 'D', '0', 'E', '1']
    """
    axes, outline = axes_of(ax, 5.0, 4.0), outline_of(tree)
    require_boxes(outline)
    named = lettered(outline, max_level)
    place = positions(outline, named)
    colors = ordered_colors(named.last + 1)
    for node in named.nodes[1:].tolist():
        up, down = place[int(outline.parent[node])], place[node]
        axes.plot([up[0], down[0]], [up[1], down[1]], color="#777777", linewidth=1.0, zorder=1)
    for node in named.nodes.tolist():
        _draw_node(axes, outline, named, node, place[node], colors[outline.level[node]])
    across = [x for x, _ in place.values()]
    axes.set(xlim=(min(across) - 0.7, max(across) + 0.7), ylim=(-named.last - 0.6, 0.4))
    without_frame(axes)
    notes = ["below leaves: their primitives", *named.notes]
    describe(axes, f"{kind_of(outline)}: {counted(outline.n_nodes, 'nodes')}", notes)
    return axes


def _draw_node(
    axes: Axes, outline: Outline, named: Lettered, node: int, at: tuple[float, float], color: Float64Array
) -> None:
    """Draw a node with its letter; below a leaf its primitives, and below a node of the last level what is left out."""
    is_inner = not outline.is_leaf[node]
    is_cut = is_inner and outline.level[node] == named.last
    frame = {"boxstyle": ROUND if is_inner else SQUARE, "facecolor": "white", "edgecolor": color, "linewidth": 1.4}
    frame |= {"linestyle": "--"} if is_cut else {}
    more: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "small", "fontweight": "bold", "bbox": frame}
    axes.text(*at, named.letters[node], color=color, zorder=3, **more)
    if is_cut or not is_inner:
        below: dict[str, Any] = {"textcoords": "offset points", "xytext": (0, -13), "ha": "center", "va": "top"}
        axes.annotate(_label(outline, node), at, fontsize="x-small", color=INK, zorder=3, **below)


def _label(outline: Outline, node: int) -> str:
    if not outline.is_leaf[node]:
        return counted(int(outline.end[node]) - node - 1, "nodes")
    prims = outline.prims[outline.refs_of(node)].tolist()
    return listed(map(str, prims), " ", MAX_LISTED) if prims else "∅"


def positions(outline: Outline, named: Lettered) -> dict[int, tuple[float, float]]:
    """Return where each node is drawn: leaves in their order, inner nodes above the middle of their children."""
    place = dict[int, tuple[float, float]]()
    last_row = set(named.nodes.tolist())
    n_leaves = 0
    # A parent precedes its children in preorder, so go backwards, and number leaves from the right.
    for node in sorted(last_row, reverse=True):
        children = [child for child in (node + 1, int(outline.right[node])) if not outline.is_leaf[node]]
        if children and all(child in last_row for child in children):
            x = float(np.mean([place[child][0] for child in children]))
        else:
            n_leaves += 1
            x = -float(n_leaves)
        place[node] = x, -float(outline.level[node])
    return place
