"""Optimal trees for tiny inputs, by dynamic programming over all that can be left of a node.

The best tree below a node depends on the node alone, not on how the node came about. So each node, that is a list of
primitives and a box, is solved once. SPLITS says which class of trees the answer is the best of: with `planes_at` trees
over the planes of a grid, with `partitions` those that divide sets and cut nothing (3ⁿ steps), with a `union` both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fastlines.theory import Box, BoxRule, Node, Prims, Split, Splits, at_object, at_plane, chance, f32, hull


def planes_at(planes: Sequence[Sequence[float]], rule: BoxRule) -> Splits:
    """Split only at these planes, given for each axis."""

    def splits(prims: Prims, box: Box) -> Iterator[Split]:
        for axis in range(3):
            for plane in planes[axis]:
                yield from at_plane(prims, box, axis, plane, rule)

    return splits


def even_planes(box: Box, n_planes: int) -> list[list[float]]:
    """Place so many planes on each axis, evenly over a box; `plane_grid` places them over each node's own."""
    steps = [i / (n_planes + 1) for i in range(1, n_planes + 1)]
    return [[f32(lo + side * step) for step in steps] for lo, side in zip(box.lo, box.sides(), strict=True)]


def partitions(prims: Prims, box: Box) -> Iterator[Split]:
    """All ways to divide a set in two."""
    for chosen in range(1, 2 ** max(len(prims) - 1, 0)):
        right = [prim for i, prim in enumerate(prims) if chosen >> i & 1]
        left = [prim for i, prim in enumerate(prims) if not chosen >> i & 1]
        yield at_object([*left, *right], len(left))


def optimum(prims: Prims, splits: Splits, c_trav: float = 2.0, c_prim: float = 1.0) -> Node:
    """Find the cheapest of all trees that can be made with some splits.

    Parameters
    ----------
    prims : sequence of Primitive
        P, one or more; hashable, as those of this package are.
    splits : function of (prims, box)
        SPLITS. No node may come back below itself.
    c_trav, c_prim : float
        What a step to a node and a test of a primitive cost.

    Examples
    --------
    >>> from fastlines import theory as th
    >>> from fastlines_bench import optimum as opt
    >>> diagonals = [[[0, 0, 0], [8, 8, 8]], [[0, 8, 0], [8, 0, 8]], [[0, 0, 8], [8, 8, 0]], [[8, 0, 0], [0, 8, 8]]]
    >>> lines = th.segments(diagonals)
    >>> planes = opt.planes_at(opt.even_planes(th.hull(lines), 1), th.cut)
    >>> round(th.f(opt.optimum(lines, planes, c_trav=0.2), c_trav=0.2), 6)
    2.8
    """
    solved: dict[tuple[Prims, Box], tuple[float, Node]] = {}

    def solve(prims: Prims, box: Box) -> tuple[float, Node]:
        key = tuple(prims), box
        if key not in solved:
            best = len(prims) * c_prim, Node(prims, box)
            for (lp, lb), (rp, rb) in splits(prims, box) if best[0] > c_trav else ():
                left, right = solve(lp, lb), solve(rp, rb)
                cost = c_trav + chance(lb, box) * left[0] + chance(rb, box) * right[0]
                if cost < best[0]:
                    best = cost, Node(prims, box, left[1], right[1])
            solved[key] = best
        return solved[key]

    return solve(prims, hull(prims))[1]
