"""How many references leaves have, and how deep they are."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np

from ..arrays import IntArray, choice
from ..errors import InputError
from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline, outline_of
from ..support.texts import counted, number_text
from .axes import COLORS, axes_of, describe, legend
from .subject import AnyTree, require_boxes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: One tree, several, or several by the names in the legend.
Trees: TypeAlias = AnyTree | Sequence[AnyTree] | Mapping[str, AnyTree]
#: What leaves count by: each as one, as a share of all, or by the chance that a ray visits it; and the axis of that.
WEIGHTS = ("number", "share", "chance")
LABELS = {"number": "leaves", "share": "share of the leaves", "chance": "visits of a ray"}
Weight: TypeAlias = Literal["number", "share", "chance"]


class Quantity(NamedTuple):
    """What leaves are ordered by: a number for each node, and its name."""

    name: str
    of: Callable[[Outline], IntArray]
    #: The most bars of single numbers; beyond, bars are ranges that double.
    max_bars: float


REFERENCES = Quantity("references", lambda outline: outline.n_refs, 40)
LEVEL = Quantity("level", lambda outline: outline.level, math.inf)


def draw_leaf_sizes(trees: Trees, *, by: Weight = "number", ax: Axes | None = None) -> Axes:
    """Draw how many leaves have how many references, of one tree or of several.

    Parameters
    ----------
    trees : Tree or theory.Node; or a sequence of them, or a mapping from labels to them
    by : {"number", "share", "chance"}
        Count leaves, or their share in all leaves of the tree; or add up the chances that a ray through the root's
        box visits them.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Each tree has one line of steps, whose label is that of the tree.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.scenes.make("spaghetti", 200).lines
    >>> trees = [fl.build(lines, method) for method in ("bvh-cl", "bvh-d2")]
    >>> fl.drawing.draw_leaf_sizes(trees).get_title()
    'Leaves by their references'
    """
    return _draw(trees, by, ax, REFERENCES)


def draw_depths(trees: Trees, *, by: Weight = "number", ax: Axes | None = None) -> Axes:
    """Draw how many leaves are on which level, of one tree or of several.

    Parameters
    ----------
    trees, by, ax
        As in `draw_leaf_sizes`.

    Returns
    -------
    Axes
        Each tree has one line of steps, whose label is that of the tree.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 200).lines, "bvh-d2")
    >>> fl.drawing.draw_depths(tree, by="chance").get_title()
    'Leaves that a ray visits, by their level'
    """
    return _draw(trees, by, ax, LEVEL)


def labelled(trees: Trees) -> dict[str, AnyTree]:
    """Return trees by their labels, which are the names of their methods unless others are given."""
    if isinstance(trees, Mapping):
        named = list(trees.items())
    else:
        several = list(trees) if isinstance(trees, Sequence) else [trees]
        named = [(outline_of(tree).name, tree) for tree in several]
    if not named:
        raise InputError("trees is empty; expected a tree, or several")
    found: dict[str, AnyTree] = {}
    for name, tree in named:
        label, number = name, 2
        while label in found:
            label, number = f"{name} ({number})", number + 1
        found[label] = tree
    return found


def _draw(trees: Trees, by: str, ax: Axes | None, quantity: Quantity) -> Axes:
    axes, weight = axes_of(ax, 6.0, 3.6), choice("by", by, WEIGHTS)
    outlines = {label: outline_of(tree) for label, tree in labelled(trees).items()}
    for outline in outlines.values():
        require_boxes(outline)
    values = {label: quantity.of(outline)[outline.is_leaf] for label, outline in outlines.items()}
    edges, names = _bins(max(int(found.max()) for found in values.values()), quantity.max_bars)
    at = np.arange(len(names) + 1) - 0.5
    opacity, highest = (0.6 if len(outlines) == 1 else 0.2), 0.0
    for i, (label, outline) in enumerate(outlines.items()):
        heights = _heights(outline, values[label], edges, weight)
        n_leaves, mean = counted(len(values[label]), "leaves"), number_text(float(values[label].mean()))
        what = f"{number_text(float(heights.sum()))} visits" if weight == "chance" else f"{n_leaves}, mean {mean}"
        color = COLORS[i % len(COLORS)]
        axes.stairs(heights, at, fill=True, color=color, alpha=opacity)
        axes.stairs(heights, at, color=color, linewidth=1.2, label=f"{label}: {what}")
        highest = max(highest, float(heights.max()))
    step = 1 + len(names) // 12
    axes.set_xticks(range(0, len(names), step), names[::step])
    axes.yaxis.set_major_formatter(lambda y, _: f"{y:,.0%}" if weight == "share" else f"{y:,g}")
    # Leave room for the legend.
    axes.set(xlim=(at[0], at[-1]), ylim=(0, highest * (1.1 + 0.1 * len(outlines))), ylabel=LABELS[weight])
    legend(axes, "upper right")
    which = "Leaves that a ray visits," if weight == "chance" else "Leaves"
    describe(axes, f"{which} by their {quantity.name}", (), quantity.name)
    return axes


def _heights(outline: Outline, values: IntArray, edges: IntArray, weight: str) -> Float64Array:
    """Return how much the leaves in each bar count together."""
    each = outline.chance[outline.is_leaf] if weight == "chance" else np.ones(len(values))
    heights = np.bincount(np.searchsorted(edges, values, "right") - 1, each, len(edges))
    return np.asarray(heights / len(values) if weight == "share" else heights)


def _bins(most: int, max_bars: float) -> tuple[IntArray, list[str]]:
    """Return the least number of each bar, and its name."""
    if most < max_bars:
        return np.arange(most + 1), [str(number) for number in range(most + 1)]
    edges = np.concatenate([[0], 2 ** np.arange(most.bit_length())])
    ends = [*edges[1:].tolist(), 2 * int(edges[-1])]
    return edges, [str(low) if low + 1 == end else f"{low}–{end - 1}" for low, end in zip(edges, ends, strict=True)]
