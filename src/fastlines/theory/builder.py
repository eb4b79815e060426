"""The algorithm (thesis §4.1), bad levels, and the exact prune that takes back those that did not pay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ..support.texts import number_text
from .node import Node, f
from .primitive import Box, Prims, hull
from .splits import Split, Splits


class Best(NamedTuple):
    """The cost of the cheapest tree of some levels, and its first split; None for a leaf."""

    cost: float
    split: Split | None

    def __repr__(self) -> str:
        return f"<Best: cost {number_text(self.cost)}, {self.split or 'a leaf'}>"


def best_split(
    prims: Prims, box: Box, splits: Splits, lookahead: int, c_trav: float, c_prim: float, limit: float | None = None
) -> Best:
    """Find the cheapest tree of `lookahead` levels (§4.1): its cost and its first split, None for a leaf.

    With a limit, the tree must cost less than that, instead of less than a leaf.
    """
    best_cost, best = len(prims) * c_prim if limit is None else limit, None
    if lookahead == 0:
        return Best(best_cost, best)
    for split in splits(prims, box):
        (_, lb), (_, rb) = split
        left, right = (best_split(*part, splits, lookahead - 1, c_trav, c_prim)[0] for part in split)
        area = box.area()
        cost = c_trav + ((lb.area() * left + rb.area() * right) / area if area > 0 else left + right)
        if cost < best_cost:
            best_cost, best = cost, Split(*split)
    return Best(best_cost, best)


def prune(node: Node, c_trav: float = 2.0, c_prim: float = 1.0) -> Node:
    """Return the cheapest of all prunings: from the bottom up, keep children that cost less than a leaf."""
    leaf = Node(node.prims, node.box)
    if not (node.left and node.right):
        return leaf
    whole = Node(node.prims, node.box, prune(node.left, c_trav, c_prim), prune(node.right, c_trav, c_prim))
    return min(leaf, whole, key=lambda tree: f(tree, c_trav, c_prim))


def build(
    prims: Prims,
    splits: Splits,
    lookahead: int | Sequence[int] = 1,
    c_trav: float = 2.0,
    c_prim: float = 1.0,
    *,
    max_depth: int = 64,
    leaf_refs: int = 1,
    leaf_size: float = 0.0,
    bad_levels: int = 0,
    pruned: bool = True,
) -> Node:
    """Build a tree over one primitive or more (§4.1).

    Parameters
    ----------
    prims : sequence of Primitive
        The set P.
    splits : callable
        SPLITS, called as ``splits(prims, box)``; yields ((left prims, left box), (right prims, right box)) for each
        candidate.
    lookahead, c_trav, c_prim, max_depth, leaf_refs, leaf_size, bad_levels, pruned
        As in `fastlines.Settings`, its `Cost` and its `Limits`; `pruned` is ``prune`` there.
    """
    turns = [lookahead] if isinstance(lookahead, int) else lookahead

    def build_node(prims: Prims, box: Box, depth: int, n_bad: int) -> Node:
        if depth == max_depth or len(prims) <= leaf_refs or max(box.sides()) <= leaf_size:
            return Node(prims, box)
        leaf, split, good = len(prims) * c_prim, None, False
        may_be_bad = n_bad < bad_levels and leaf > c_trav
        for levels in turns:
            cost, split = best_split(prims, box, splits, levels, c_trav, c_prim, math.inf if may_be_bad else leaf)
            good = split is not None and cost < leaf
            if good:
                break
        if split is None:
            return Node(prims, box)
        node = Node(prims, box, *(build_node(*part, depth + 1, 0 if good else n_bad + 1) for part in split))
        takes_back = pruned and f(node, c_trav, c_prim) >= leaf
        return Node(prims, box) if takes_back else node

    return build_node(prims, hull(prims), 0, 0)
