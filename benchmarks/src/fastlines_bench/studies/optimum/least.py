"""The gain of a plane, and lower bounds for a search below a node, with which branch and bound prunes.

The proofs are in docs/theory.md. V(k) is the cost that `best_split` finds in k levels.
"""

from __future__ import annotations

from collections.abc import Sequence

from fastlines.theory import Box, BoxRule, Prims, divide, tight


def face_share(box: Box, axis: int) -> float:
    """Return φ, the share of a box's area in the two faces across an axis, which both halves of a cut have too."""
    one, other = (side for k, side in enumerate(box.sides()) if k != axis)
    return 2 * one * other / box.area()


def sides_of(prims: Prims, axis: int, plane: float) -> tuple[int, int, int]:
    """Return the numbers of primitives left of a plane, cut by it and right of it, as `at_plane` divides them."""
    bounds = [prim.bounds() for prim in prims]
    n_left = sum(box.hi[axis] <= plane for box in bounds)
    n_right = sum(box.lo[axis] >= plane and box.hi[axis] > plane for box in bounds)
    return n_left, len(prims) - n_left - n_right, n_right


def gain(prims: Prims, box: Box, axis: int, plane: float, c_trav: float = 2.0, c_prim: float = 1.0) -> float:
    """Return the cost of a leaf less that of the two leaves into which a plane cuts it.

    With l primitives left of a plane at share x of the box, r right of it and m cut by it,
    c_prim·((1 − φ)·((1 − x)·l + x·r) − φ·m) − c_trav.

    Examples
    --------
    >>> from fastlines import theory as th
    >>> from fastlines_bench.studies import optimum as opt
    >>> box = th.Box((0, 0, 0), (1, 1, 1))
    >>> lines = th.segments([[[0, 0, 0], [0.25, 1, 1]]] * 8 + [[[0.5, 0, 0], [1, 1, 1]]] * 4)
    >>> round(opt.gain(lines, box, 0, 0.375), 9), round(opt.gain(lines, box, 0, 0.125), 9)
    (2.333333333, -4.333333333)
    """
    share, x = face_share(box, axis), (plane - box.lo[axis]) / box.sides()[axis]
    n_left, n_cut, n_right = sides_of(prims, axis, plane)
    return c_prim * ((1 - share) * ((1 - x) * n_left + x * n_right) - share * n_cut) - c_trav


def at_least_cut(prims: Prims, box: Box, lookahead: int, c_trav: float = 2.0, c_prim: float = 1.0) -> float:
    """Return a lower bound of V(k) for any planes that cut the box; O(1) from the sums of the primitives' sides.

    With e the sum of the primitives' sides along an axis, as fractions of the box's side,
    V(1) ≥ min(c_prim·n, c_trav + c_prim·(φ·n + (1 − φ)·e)) on the axis where this is least, and for k > 1
    V(k) ≥ min(c_prim·n, c_trav + φ·min(c_prim·n, c_trav)).
    """
    leaf, axes = c_prim * len(prims), [axis for axis in range(3) if box.sides()[axis] > 0]
    if lookahead == 0 or box.area() == 0:
        return leaf if lookahead == 0 else min(leaf, c_trav)
    shares = [face_share(box, axis) for axis in axes]
    if lookahead > 1:
        return min(leaf, c_trav + min(shares) * min(leaf, c_trav))
    sums = [sum(prim.bounds().sides()[axis] for prim in prims) / box.sides()[axis] for axis in axes]
    most = zip(shares, sums, strict=True)
    return min(leaf, *(c_trav + c_prim * (share * len(prims) + (1 - share) * e) for share, e in most))


def at_least(
    prims: Prims,
    box: Box,
    planes: Sequence[Sequence[float]],
    witnesses: Prims,
    lookahead: int,
    c_trav: float = 2.0,
    c_prim: float = 1.0,
    *,
    rule: BoxRule = tight,
) -> float:
    """Return a lower bound of V(k) over some planes, for which only the witnesses are cut.

    All primitives are counted on both sides of each plane, but boxes are those of the witnesses' parts. A child's box
    contains those of its witnesses, so it is no smaller. No tree costs less than the lesser of a leaf of its primitives
    and one step. This takes O(n + planes × witnesses), while V(1) cuts each primitive at each plane.

    Parameters
    ----------
    prims : sequence of Primitive
        The node's primitives.
    box : Box
        The node's box.
    planes : three sequences of float
        The planes on each axis.
    witnesses : sequence of Primitive
        Some of the primitives. More of them make the bound greater; with all of them and k = 1 it is V(1).
    lookahead : int
        k, 1 or more.
    c_trav, c_prim : float
        The costs of a step to a node and of a test of a primitive.
    rule : BoxRule
        `tight`, or `cut`, which needs no witness.
    """
    found, area = c_prim * len(prims), box.area()
    if area == 0:
        return min(found, c_trav)
    for axis, plane in ((k, plane) for k in range(3) for plane in planes[k]):
        if not box.lo[axis] < plane < box.hi[axis]:
            continue
        n_left, n_cut, n_right = sides_of(prims, axis, plane)
        if rule is tight and not (n_left + n_cut and n_right + n_cut):
            continue
        halves = zip(divide(witnesses, box, axis, plane), box.split(axis, plane), strict=True)
        areas = [child.area() if (child := rule(*half)) else 0.0 for half in halves]
        costs = [c_prim * (n + n_cut) for n in (n_left, n_right)]
        if lookahead > 1:
            costs = [min(cost, c_trav) for cost in costs]
        found = min(found, c_trav + (areas[0] * costs[0] + areas[1] * costs[1]) / area)
    return found
