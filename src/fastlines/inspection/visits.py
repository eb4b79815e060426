"""The nodes of a tree whose boxes a ray hits, in the order of a traversal without a limit.

The order is depth first, the nearer child first; of two that are equally near, the left one. It comes from the number
of nodes entered at or below each: the nearer child follows its parent, and the farther one all nodes of the nearer.
Both passes handle a level of the tree at a time, so that some 10⁵ nodes take a fraction of a second.
"""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray
from ..geometry.hit_places import Float64Array
from .outline import Outline
from .slabs import enter


def visits(
    outline: Outline, origin: Float64Array, direction: Float64Array, grow: float
) -> tuple[IntArray, Float64Array]:
    """Return the nodes that a ray enters, in their order, and where it enters their boxes.

    Parameters
    ----------
    outline : Outline
    origin, direction : (3,) float64
        Without the offset of the lines.
    grow : float
        How far boxes are grown on all sides.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.inspection import outline_of
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[0, 0, 8], [1, 1, 9]]], "bvh-cl", cost=fl.Cost(0.1))
    >>> visits(outline_of(tree), np.array([0.5, 0.5, 20]), np.array([0.0, 0.0, -1.0]), 0.0)
    (array([0, 2, 1]), array([11., 11., 19.]))
    """
    at, levels = _enter(outline, origin, direction, grow)
    if not levels:
        return np.zeros(0, np.int64), np.zeros(0)
    order = _order(outline, at, levels)
    return order, at[order]


def _enter(
    outline: Outline, origin: Float64Array, direction: Float64Array, grow: float
) -> tuple[Float64Array, list[IntArray]]:
    """Return where the ray enters the box of each node, inf for a miss, and the nodes entered, level by level."""
    at, levels, level = np.full(outline.n_nodes, np.inf), list[IntArray](), np.zeros(1, np.int64)
    while len(level):
        entered = enter(outline.boxes[level], origin, direction, grow)
        at[level] = entered
        level = level[np.isfinite(entered)]
        levels.extend([level] if len(level) else [])
        inner = level[~outline.is_leaf[level]]
        level = np.concatenate([inner + 1, outline.right[inner]])
    return at, levels


def _order(outline: Outline, at: Float64Array, levels: list[IntArray]) -> IntArray:
    """Return the nodes entered, in their order."""
    inner_of = [level[~outline.is_leaf[level]] for level in levels]
    # Count the nodes entered at or below each, from the leaves upwards.
    n_below = np.isfinite(at).astype(np.int64)
    for inner in reversed(inner_of):
        n_below[inner] += n_below[inner + 1] + n_below[outline.right[inner]]
    # Give each node its place, from the root downwards.
    place = np.zeros(len(at), np.int64)
    for inner in inner_of:
        left, right = inner + 1, outline.right[inner]
        is_right = at[right] < at[left]
        near, far = np.where(is_right, right, left), np.where(is_right, left, right)
        place[near] = place[inner] + 1
        place[far] = place[inner] + 1 + n_below[near]
    order = np.empty(int(n_below[0]), np.int64)
    for level in levels:
        order[place[level]] = level
    return order
