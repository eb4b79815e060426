"""Optimal trees for tiny inputs, by dynamic programming over all nodes.

The best tree below a node depends only on the node, which is a list of primitives and a box. So each node is solved
once. SPLITS sets the class of trees: `planes_at` gives trees over the planes of a grid, `partitions` trees of object
splits only (3ⁿ steps), and a `union` both.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fastlines.theory import Box, BoxRule, Node, Prims, Split, Splits, at_object, at_plane, chance, f32, hull


def planes_at(planes: Sequence[Sequence[float]], rule: BoxRule) -> Splits:
    """Return the splits at given planes on each axis."""

    def splits(prims: Prims, box: Box) -> Iterator[Split]:
        for axis in range(3):
            for plane in planes[axis]:
                yield from at_plane(prims, box, axis, plane, rule)

    return splits


def even_planes(box: Box, n_planes: int) -> list[list[float]]:
    """Return evenly spaced planes on each axis of a box; unlike `plane_grid`, they are the same for all nodes."""
    steps = [i / (n_planes + 1) for i in range(1, n_planes + 1)]
    return [[f32(lo + side * step) for step in steps] for lo, side in zip(box.lo, box.sides(), strict=True)]


def partitions(prims: Prims, box: Box) -> Iterator[Split]:
    """Yield all divisions of a set in two."""
    for chosen in range(1, 2 ** max(len(prims) - 1, 0)):
        right = [prim for i, prim in enumerate(prims) if chosen >> i & 1]
        left = [prim for i, prim in enumerate(prims) if not chosen >> i & 1]
        yield at_object([*left, *right], len(left))


def optimum(prims: Prims, splits: Splits, c_trav: float = 2.0, c_prim: float = 1.0) -> Node:
    """Return the cheapest of all trees that can be made with some splits.

    Parameters
    ----------
    prims : sequence of Primitive
        One or more hashable primitives, as those of this package are.
    splits : function of (prims, box)
        SPLITS. No node may occur below itself.
    c_trav, c_prim : float
        The costs of a step to a node and of a test of a primitive.

    Examples
    --------
    >>> from fastlines import theory as th
    >>> from fastlines_bench.studies import optimum as opt
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
