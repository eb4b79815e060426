"""Optimal trees over the planes of a grid, as `oracle.optimum` finds them, for grids that are too fine for it.

A node is a box of the grid's cells; a cells on an axis have (a² + a)/2 intervals. The contents of all boxes are
computed at once. Then boxes are solved by increasing number of cells, all boxes of one shape together.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fastlines.theory import Box, BoxRule, Node, Prims, at_plane, hull, segments, tight

from .bound import area_of

Array = npt.NDArray[np.float64]


def grid_optimum(
    ends: npt.ArrayLike, planes: Sequence[Sequence[float]], rule: BoxRule, c_trav: float = 2.0, c_prim: float = 1.0
) -> Node:
    """Return the cheapest tree over some segments whose splits are all at given planes.

    Parameters
    ----------
    ends : array_like, shape (n, 2, 3)
        The segments. They should be few, because each is clipped to each box of cells.
    planes : three sequences of float
        The planes on each axis, ascending, inside the box of the segments; `even_planes` places them. 11 on each take
        seconds and a third of a gigabyte.
    rule : BoxRule
        `tight` for BVHs, `cut` for KD trees.
    c_trav, c_prim : float
        The costs of a step to a node and of a test of a primitive.

    Examples
    --------
    >>> from fastlines import theory as th
    >>> from fastlines_bench.studies import optimum as opt
    >>> diagonals = [[[0, 0, 0], [8, 8, 8]], [[0, 8, 0], [8, 0, 8]], [[0, 0, 8], [8, 8, 0]], [[8, 0, 0], [0, 8, 8]]]
    >>> planes = opt.even_planes(th.hull(th.segments(diagonals)), 7)
    >>> tree = opt.grid_optimum(diagonals, planes, th.cut, c_trav=0.2)
    >>> round(th.f(tree, c_trav=0.2), 3)
    2.487
    """
    prims = segments(ends)
    root = hull(prims)
    places = [np.array([lo, *inside, hi]) for lo, inside, hi in zip(root.lo, planes, root.hi, strict=True)]
    n_refs, area = contents(np.asarray(ends, np.float32).astype(np.float64).reshape(-1, 2, 3), places, rule)
    cost = n_refs * c_prim * area  # of leaves; costs are multiplied by areas, so that those of children add up
    chosen = np.zeros(cost.shape, np.int16)  # 0, or 1 + 3·place + axis of the plane
    for shape in itertools.product(*(range(1, len(at)) for at in places)):
        starts = [np.arange(len(at) - n) for at, n in zip(places, shape, strict=True)]
        here = cells(starts, shape)
        best, by = cost[here], chosen[here]
        for axis in range(3):
            for n_left in range(1, shape[axis]):
                left = cells(starts, put(shape, axis, n_left))
                beyond = [at + n_left if k == axis else at for k, at in enumerate(starts)]
                right = cells(beyond, put(shape, axis, shape[axis] - n_left))
                found = c_trav * area[here] + cost[left] + cost[right]
                if rule is tight:
                    found[(n_refs[left] == 0) | (n_refs[right] == 0)] = np.inf
                plane = 1 + 3 * np.ix_(*beyond)[axis] + axis
                best, by = np.minimum(best, found), np.where(found < best, plane, by)
        cost[here], chosen[here] = best, by
    return tree_of(prims, root, rule, places, chosen, [(0, len(at) - 1) for at in places])


def put(shape: tuple[int, ...], axis: int, n: int) -> tuple[int, ...]:
    """Return a shape with another number on one axis."""
    return (*shape[:axis], n, *shape[axis + 1 :])


def cells(starts: Sequence[npt.NDArray[np.int64]], shape: Sequence[int]) -> tuple[npt.NDArray[np.int64], ...]:
    """Return the indices of the boxes of one shape: the first and the last cell on each axis."""
    x, y, z = np.ix_(*starts)
    return x, x + shape[0] - 1, y, y + shape[1] - 1, z, z + shape[2] - 1


def contents(ends: Array, places: Sequence[Array], rule: BoxRule) -> tuple[npt.NDArray[np.int32], Array]:
    """Return the number of pieces in each box of cells, and the area of the box or, if `tight`, of their hull."""
    numbers = [len(at) - 1 for at in places]
    dims = [n for number in numbers for n in (number, number)]
    axes = [tuple(n if k // 2 == axis else 1 for k, n in enumerate(dims)) for axis in range(3)]
    n_refs = np.zeros(dims, np.int32)
    low, high = np.full((3, *dims), np.inf), np.full((3, *dims), -np.inf)
    for p, q in ends:
        begin, end = np.zeros(dims), np.ones(dims)
        for axis in range(3):
            enters, leaves = within(p[axis], q[axis], places[axis])
            begin = np.maximum(begin, enters.reshape(axes[axis]))
            end = np.minimum(end, leaves.reshape(axes[axis]))
        inside = begin < end
        n_refs += inside
        if rule is tight:
            for axis in range(3):
                for s in (np.where(inside, begin, 0.0), np.where(inside, end, 0.0)):
                    at = p[axis] + s * (q[axis] - p[axis])
                    np.minimum(low[axis], at, out=low[axis], where=inside)
                    np.maximum(high[axis], at, out=high[axis], where=inside)
    if rule is tight:
        return n_refs, area_of(np.moveaxis(np.where(n_refs > 0, high - low, 0.0), 0, -1))
    sides = [(at[None, 1:] - at[:-1, None]).reshape(axes[axis]) for axis, at in enumerate(places)]
    return n_refs, area_of(np.stack(np.broadcast_arrays(*sides), -1))


def within(p: float, q: float, places: Array) -> tuple[Array, Array]:
    """Return the parameters at which a segment enters and leaves each interval; a segment in a plane is left of it."""
    low, high = places[:-1, None].repeat(len(places) - 1, 1), places[None, 1:].repeat(len(places) - 1, 0)
    if p == q:
        inside = ((p > low) | (low == places[0])) & (p <= high)
        return np.where(inside, 0.0, np.inf), np.where(inside, 1.0, -np.inf)
    one, other = (low - p) / (q - p), (high - p) / (q - p)
    return np.minimum(one, other), np.maximum(one, other)


def tree_of(
    prims: Prims,
    box: Box,
    rule: BoxRule,
    places: Sequence[Array],
    chosen: npt.NDArray[np.int16],
    ranges: Sequence[tuple[int, int]],
) -> Node:
    """Return the tree of the chosen planes."""
    plane = int(chosen[tuple(n for first, end in ranges for n in (first, end - 1))]) - 1
    axis, place = plane % 3, plane // 3
    split = next(at_plane(prims, box, axis, float(places[axis][place]), rule), None) if plane >= 0 else None
    if split is None:
        return Node(prims, box)
    low, high = list(ranges), list(ranges)
    low[axis], high[axis] = (ranges[axis][0], place), (place, ranges[axis][1])
    left, right = (tree_of(*part, rule, places, chosen, half) for part, half in zip(split, (low, high), strict=True))
    return Node(prims, box, left, right)
