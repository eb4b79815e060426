"""Sheets: several levels of a tree, and one page that shows a tree, or several beside each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from ..inspection.outline import outline_of
from ..progress import ProgressCallback, ProgressOption, reporting, staged
from ..settings.settings import Cost
from ..structure.tree_data import TreeData
from ..support.texts import counted, number_text
from .axes import light, new_figure, share_scale
from .histograms import Trees, Weight, draw_depths, draw_leaf_sizes, labelled
from .icicle import draw_icicle
from .levels import draw_levels
from .planes import draw_planes
from .projection import AxisOption
from .subject import AnyTree, require_boxes
from .work import draw_work

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: The size of a panel in inches, and how many panels are side by side in a sheet of levels.
PANEL, COLUMNS = 3.2, 3
#: How many levels a sheet of levels shows; and which levels a page shows of one tree, and of each of several.
LEVELS, PAGE_LEVELS, ROW_LEVELS = 6, (1, 3, 6, 9), (3, 7)


def draw_level_sheet(tree: AnyTree, levels: int | Sequence[int] = LEVELS, *, axis: AxisOption = None) -> Figure:
    """Draw several levels of a tree, a panel for each.

    Parameters
    ----------
    tree : Tree or theory.Node
    levels : int or sequence of int
        How many levels from the root on, or which ones; those that the tree does not have are left out.
    axis : {"x", "y", "z"}, optional
        The axis of view; by default the one on which the root's box is shortest.

    Returns
    -------
    Figure
        ``figure.savefig(path)`` writes it.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 200).lines, "bvh-d2")
    >>> len(fl.drawing.draw_level_sheet(tree, [0, 3, 5]).axes)
    3
    """
    outline = outline_of(tree)
    wanted = range(levels) if isinstance(levels, int) else levels
    shown = [level for level in wanted if level < len(outline.levels)] or [0]
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    figure = new_figure(PANEL * columns, (PANEL + 0.4) * rows)
    with light():
        for i, level in enumerate(shown):
            draw_levels(tree, level, axis=axis, ax=figure.add_subplot(rows, columns, i + 1))
    return figure


def draw_sheet(trees: Trees, *, title: str = "", axis: AxisOption = None, progress: ProgressOption = False) -> Figure:
    """Draw a page that shows a tree: levels, cost, work, leaf sizes and depths; or several trees beside each other.

    Parameters
    ----------
    trees : Tree or theory.Node; or a sequence of them, or a mapping from labels to them
        Several trees have a row each, and their leaves are compared in the last row. Their costs are those of the
        first tree's steps and tests, so they can be compared.
    title : str
        What the trees are over.
    axis : {"x", "y", "z"}, optional
        The axis of view; by default the one on which the root's box is shortest.
    progress : bool or callable

    Returns
    -------
    Figure
        ``figure.savefig(path)`` writes it.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 200).lines, "bvh-d2")
    >>> figure = fl.drawing.draw_sheet(tree, title="spaghetti")
    >>> figure.get_suptitle().splitlines()[0]
    'spaghetti'
    """
    named = labelled(trees)
    first = next(iter(named.values()))
    model = outline_of(first).model
    for tree in named.values():
        require_boxes(outline_of(tree))
    facts = [f"{label}: {facts_of(tree, model)}" for label, tree in named.items()]
    with light(), reporting(progress, "draw") as callback:
        figure = _one(first, axis, callback) if len(named) == 1 else _several(named, model, axis, callback)
        steps = f"cost with a step of {model.c_trav:g}, a test of {model.c_prim:g}"
        figure.suptitle("\n".join(filter(None, [title, *facts, steps])))
    return figure


def facts_of(tree: AnyTree, model: Cost | None = None) -> str:
    """Return the numbers of a tree, in words."""
    outline = outline_of(tree, model)
    n_prims = tree.n_prims if isinstance(tree, TreeData) else len(tree.prims)
    counts = {"primitives": n_prims, "references": len(outline.prims), "nodes": outline.n_nodes}
    words = [counted(number, nouns) for nouns, number in counts.items()]
    return ", ".join([*words, f"cost {number_text(float(outline.cost_below[0]))}"])


def _views(tree: AnyTree, levels: Sequence[int], axis: AxisOption) -> list[Callable[..., object]]:
    """Return what draws some levels that the tree has, or else its root; for a KD tree its planes are the last."""
    outline = outline_of(tree)
    last = len(outline.levels) - 1
    views: list[Callable[..., object]]
    views = [partial(draw_levels, tree, level, axis=axis) for level in levels if level <= last]
    if outline.is_kd and last:
        views[len(levels) - 1 :] = [partial(draw_planes, tree, axis=axis)]
    return views or [partial(draw_levels, tree, 0, axis=axis)]


def _one(tree: AnyTree, axis: AxisOption, callback: ProgressCallback | None) -> Figure:
    """Draw views of the boxes, then cost and work, then the leaves."""
    figure = new_figure(12.4, 10.6)
    rows: Any = figure.subfigures(3, 1, height_ratios=(1.05, 1.1, 0.9))
    boxes, costs, leaves = rows
    views = _views(tree, PAGE_LEVELS, axis)
    for panel, draw in zip(boxes.subplots(1, len(views), squeeze=False).flat, views, strict=True):
        draw(ax=panel)
    cost, work = costs.subplots(1, 2, width_ratios=(2, 1))
    draw_icicle(tree, ax=cost)
    draw_work(tree, by="cost", ax=work, progress=callback or False)
    _draw_leaves(leaves, tree, "number")
    return figure


def _several(trees: Mapping[str, AnyTree], model: Cost, axis: AxisOption, callback: ProgressCallback | None) -> Figure:
    """Draw a row for each tree: two views of its boxes, its cost and its work; then the leaves of all."""
    figure = new_figure(13.6, 3.4 * len(trees) + 3.2)
    parts: Any = figure.subfigures(len(trees) + 1, 1)
    *rows, leaves = parts
    panels: list[Axes] = []
    for i, (row, tree) in enumerate(zip(rows, trees.values(), strict=True)):
        *views, cost, work = row.subplots(1, 4, width_ratios=(1, 1, 1.4, 1.1))
        for panel, draw in zip_longest(views, _views(tree, ROW_LEVELS, axis)):
            draw(ax=panel) if draw else panel.set_axis_off()
        draw_icicle(tree, model=model, ax=cost)
        done = staged(callback, i / len(trees), (i + 1) / len(trees))
        panels.append(draw_work(tree, by="cost", model=model, ax=work, progress=done or False))
    share_scale(panels)
    _draw_leaves(leaves, trees, "share")
    return figure


def _draw_leaves(row: Any, trees: Trees, by: Weight) -> None:
    """Draw the last row: leaf sizes by number and by the chance of a visit, and depths."""
    left, middle, right = row.subplots(1, 3)
    draw_leaf_sizes(trees, by=by, ax=left)
    draw_leaf_sizes(trees, by="chance", ax=middle)
    draw_depths(trees, by=by, ax=right)
