"""A lower bound for the cost of all trees over some segments, from a count of boxes (docs/theory.md proves it).

The n inner nodes whose area is more than t are the top of a binary tree. The n + 1 nodes below them cover all segments,
with boxes of area t or less, or with leaves, whose cost is counted. To bound the number of boxes of area t, mark the
cells of a grid that segments touch, and all cells near them. The segments in one such box mark at most `most_cells`
cells, so there are at least `marked / most_cells` boxes. The cost of all inner nodes is an integral over t. For each t,
the grid and the reach with the largest count are used.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from fastlines.geometry.lines import Lines, as_lines

Array = npt.NDArray[np.float64]
Cells = npt.NDArray[np.bool_]

#: The reaches of the neighbourhood of a marked cell, in cells.
REACHES = (0, 1, 2, 3, 4, 6, 8)

#: The least area t, as a share of the root's; areas are a quarter of an octave apart.
LEAST_AREA = 1e-6

#: A segment is counted if its sides add up to at most this many times the square root of its box's area.
STEEPEST = 3.0

#: The number of segments that are marked at a time.
CHUNK = 1 << 15


def lower_bound(
    lines: Lines | npt.ArrayLike,
    c_trav: float = 2.0,
    c_prim: float = 1.0,
    *,
    whole: bool = False,
    n_cells: int = 1 << 24,
) -> float:
    """Bound the cost of every tree over some segments from below.

    Parameters
    ----------
    lines : Lines or array_like, shape (n, 2, 3)
        The segments.
    c_trav, c_prim : float
        The costs of a step to a node and of a test of a primitive.
    whole : bool
        Bound only trees that cut no segment: classic BVHs.
    n_cells : int
        The approximate number of cells of the finest grid, with a byte each. More cells give a greater bound and take
        longer.

    Returns
    -------
    float
        The bound: no acceleration tree (thesis §3.2, axiom 5 for each primitive alone, as in `check`) costs less, up to
        the rounding of float64.

    Raises
    ------
    InputError
        If `lines` are not segments.

    Examples
    --------
    >>> diagonals = [[[0, 0, 0], [8, 8, 8]], [[0, 8, 0], [8, 0, 8]], [[0, 0, 8], [8, 8, 0]], [[8, 0, 0], [0, 8, 8]]]
    >>> lower_bound(diagonals, c_trav=0.2, whole=True)
    4.0
    >>> import fastlines as fl
    >>> spaghetti = fl.scenes.make("spaghetti", 500).lines
    >>> bound = lower_bound(spaghetti, n_cells=1 << 18)
    >>> 8 < bound < fl.build(spaghetti, "bvh-d2").cost() / 8
    True
    """
    ends = as_lines(lines).segments.astype(np.float64)
    n = len(ends)
    if n == 0:
        return 0.0
    low, sides = ends.min((0, 1)), np.ptp(ends, (0, 1))
    extents = np.abs(ends[:, 1] - ends[:, 0])
    area, own = float(area_of(sides)), area_of(extents)
    leaf = c_prim * n
    if area == 0:
        return min(leaf, c_trav)
    inner = c_trav * needed(ends[extents.sum(1) <= STEEPEST * np.sqrt(own)] - low, sides, c_prim / c_trav, n_cells)
    if whole:
        inner = max(inner, c_trav + c_prim * float(own.sum()) / area)
    return min(leaf, max(inner, c_trav))


def area_of(sides: Array) -> Array:
    """Return the areas of boxes, given their sides."""
    x, y, z = np.moveaxis(sides, -1, 0)
    found: Array = 2 * (x * y + x * z + y * z)
    return found


def needed(ends: Array, sides: Array, ratio: float, n_cells: int) -> float:
    """Return the integral over t of the least number of boxes of area t, less one, as a fraction of the root's area.

    `ratio` is c_prim/c_trav. It limits the count of a piece, so that a leaf's cost covers the count of its pieces.
    """
    area = float(area_of(sides))
    areas = area * np.exp2(-0.25 * np.arange(0, 4 * math.log2(1 / LEAST_AREA)))[::-1]
    counts = np.ones_like(areas)
    if len(ends):
        for cell, reach, n_marked in neighbourhoods(ends, sides, n_cells):
            width = 2 * reach + 1
            of_a_piece = width**3 + width**2 * (3 + STEEPEST * np.sqrt(areas) / cell)
            most = most_cells(areas / (2 * cell * cell), width + 1, sides / cell)
            counts = np.maximum(counts, n_marked / np.maximum(most, 2 * of_a_piece / ratio))
    return float(((counts - 1) * np.diff(areas, prepend=0.0)).sum()) / area


def most_cells(areas: Array, margin: int, sides: Array) -> Array:
    """Bound (a + m)(b + m)(c + m) for boxes whose sides a, b, c, in cells, keep to ab + ac + bc ≤ area; for each area.

    With α = a + c and β = b + c, αβ ≤ area + c² and (a + m)(b + m) = αβ + (m − c)(α + β) + (m − c)². This is greatest
    at α = β if c > m, else where one of a and b has its maximum. The maximum over the side c is taken over short
    intervals.
    """
    second, first = np.sort(sides)[1:]
    c = np.concatenate([[0.0], np.geomspace(1e-4 * first, first, 500)])
    area, c, up_to = areas[:, None], c[:-1], c[1:]
    product = area + c * c
    with np.errstate(divide="ignore"):
        alpha = np.where(c > margin, np.sqrt(product), np.minimum(area / c, second) + c)
    across = product + (margin - c) * (alpha + product / alpha) + (margin - c) ** 2
    found: Array = ((up_to + margin) * across).max(1)
    return found


def neighbourhoods(ends: Array, sides: Array, n_cells: int) -> Iterator[tuple[float, int, int]]:
    """Yield the number of marked cells for each grid, finest first, and each reach: (cell's side, reach, number)."""
    c, b, a = np.sort(sides)
    cell = max((a * b * c / n_cells) ** (1 / 3), (a * b / n_cells) ** (1 / 2), a / n_cells)
    marked = touched(ends, cell, sides)
    while True:
        for reach in REACHES:
            yield cell, reach, int(np.count_nonzero(grown(marked, reach)))
        if max(marked.shape) < 2:
            return
        cell *= 2
        marked = np.pad(marked, [(0, n % 2) for n in marked.shape])
        x, y, z = (n // 2 for n in marked.shape)
        marked = np.asarray(marked.reshape(x, 2, y, 2, z, 2).any((1, 3, 5)))


def touched(ends: Array, cell: float, sides: Array) -> Cells:
    """Return the cells that segments touch: the cell of each start, and those on both sides of each crossed plane."""
    shape = np.floor(sides / cell).astype(np.int64) + 1
    marked = np.zeros(shape, np.bool_)

    def mark(places: npt.NDArray[np.int64]) -> None:
        marked[tuple(np.clip(places, 0, shape - 1).T)] = True

    for first in range(0, len(ends), CHUNK):
        start, way = ends[first : first + CHUNK, 0] / cell, np.diff(ends[first : first + CHUNK], axis=1)[:, 0] / cell
        mark(np.floor(start).astype(np.int64))
        for axis in range(3):
            low, high = np.sort([start[:, axis], start[:, axis] + way[:, axis]], axis=0)
            plane, n = np.floor(low).astype(np.int64) + 1, (np.ceil(high) - np.floor(low) - 1).astype(np.int64).clip(0)
            row = np.repeat(np.arange(len(start)), n)
            planes = np.repeat(plane - np.cumsum(n) + n, n) + np.arange(n.sum())
            share = (planes - start[row, axis]) / way[row, axis]
            places = np.floor(start[row] + share[:, None] * way[row]).astype(np.int64)
            for side in (planes - 1, planes):
                places[:, axis] = side
                mark(places)
    return marked


def grown(marked: Cells, reach: int) -> Cells:
    """Return the cells up to `reach` cells away from marked ones on each axis, on a grid enlarged by as much."""
    for axis in range(3):
        width = 2 * reach + 1
        rows = np.moveaxis(np.pad(marked, [(2 * reach if k == axis else 0,) * 2 for k in range(3)]), axis, 0)
        done = 1  # rows[i] says whether any of `done` cells from i on is marked
        while done < width:
            step = min(done, width - done)
            rows, done = rows[:-step] | rows[step:], done + step
        marked = np.moveaxis(rows, 0, axis)
    return marked
