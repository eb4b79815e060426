"""Lower bounds for a search below a split, from counts of the node's primitives relative to pairs of planes.

The proof is in docs/theory.md (theorem 9). cpp/fastlines/build/lookahead_bounds.hpp implements it in C++ for all splits
of a node at once. That version also supports boxes enlarged by a margin, and is sharper for references that end in a
plane.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

from fastlines.theory import Box, Prims, f32


class _Sides(NamedTuple):
    """The numbers of primitives surely on the left and on the right, with cut ones in both, and of others."""

    left: int
    right: int
    unsure: int


def at_least_of_pairs(
    prims: Prims,
    box: Box,
    axis: int,
    plane: float,
    n_planes: int,
    lookahead: int,
    c_trav: float = 2.0,
    c_prim: float = 1.0,
) -> tuple[float, float]:
    """Return lower bounds of V(k) for both halves of a box, over `plane_grid` with cut boxes; no primitive is cut.

    Parts of a primitive must end where it ends or at the plane, as those of segments do.

    Parameters
    ----------
    prims : sequence of Primitive
        The node's primitives.
    box : Box
        The node's box.
    axis, plane : int, float
        The plane of the cut, which is one of the grid's.
    n_planes : int
        The number of planes of the grid on each axis.
    lookahead : int
        k, 1 or 2.
    c_trav, c_prim : float
        The costs of a step to a node and of a test of a primitive.

    Returns
    -------
    tuple of two floats
        The bounds of the left and the right half.
    """
    planes = [
        [f32(lo + side * i / (n_planes + 1)) for i in range(1, n_planes + 1)]
        for lo, side in zip(box.lo, box.sides(), strict=True)
    ]
    bounds = [prim.bounds() for prim in prims]
    behind = [each for each in bounds if each.hi[axis] <= plane]
    ahead = [each for each in bounds if each.lo[axis] >= plane and each.hi[axis] > plane]
    cut = [each for each in bounds if each.lo[axis] < plane < each.hi[axis]]
    low, high = box.split(axis, plane)

    def least(whole: list[Box], half: Box) -> float:
        n, area = len(whole) + len(cut), half.area()
        if area == 0:
            return min(c_prim * n, c_trav)
        cuts = [
            _weigh(half, across, at, sides, lookahead, c_trav, c_prim)
            for across in range(3)
            for at, sides in (
                _between(whole, cut, half, axis, planes[axis])
                if across == axis
                else _beside(whole, cut, half, across, planes[across])
            )
        ]
        return min(c_prim * n, c_trav + min(cuts) / area)

    return least(behind, low), least(ahead, high)


def _beside(
    whole: list[Box], cut: list[Box], half: Box, axis: int, planes: list[float]
) -> Iterator[tuple[float, _Sides]]:
    """Yield the parent's planes inside a half and the counts; the place of a part of a cut primitive is unknown."""
    for plane in planes:
        if not half.lo[axis] < plane < half.hi[axis]:
            continue
        left = sum(each.lo[axis] < plane or each.hi[axis] <= plane for each in whole)
        right = sum(each.hi[axis] > plane for each in whole)
        left_of_cut = sum(each.hi[axis] < plane for each in cut)
        right_of_cut = sum(each.lo[axis] > plane for each in cut)
        yield plane, _Sides(left + left_of_cut, right + right_of_cut, len(cut) - left_of_cut - right_of_cut)


def _between(
    whole: list[Box], cut: list[Box], half: Box, axis: int, planes: list[float]
) -> Iterator[tuple[float, _Sides]]:
    """Yield counts that hold for all planes between two of the parent's; the cost is least at one of the two."""
    known = [half.lo[axis], *(plane for plane in planes if half.lo[axis] < plane < half.hi[axis]), half.hi[axis]]
    for first, last in pairwise(known):
        left = [each.lo[axis] < first for each in whole + cut]
        right = [each.hi[axis] > last for each in whole + cut]
        unsure = sum(not on_left and not on_right for on_left, on_right in zip(left, right, strict=True))
        for plane in (first, last):
            yield plane, _Sides(sum(left), sum(right), unsure)


def _weigh(box: Box, axis: int, plane: float, sides: _Sides, lookahead: int, c_trav: float, c_prim: float) -> float:
    """Return a lower bound of the sum of both halves' costs times their areas."""
    low, high = box.split(axis, plane)
    if lookahead == 1:
        areas = low.area(), high.area()
        return c_prim * (areas[0] * sides.left + areas[1] * sides.right + min(areas) * sides.unsure)

    def least(half: Box, n: int) -> float:
        return min(half.area() * c_prim * n, half.area() * c_trav + _two_faces(half) * c_prim * n)

    unsure = c_prim * min(_two_faces(low), _two_faces(high)) * sides.unsure
    return least(low, sides.left) + least(high, sides.right) + unsure


def _two_faces(box: Box) -> float:
    """Return the area of the two smallest faces of a box."""
    x, y, z = box.sides()
    return 2 * min(x * y, x * z, y * z)
