"""Pairs of atoms that are near enough to be bonded.

Two atoms count as bonded if they are nearer than the sum of their covalent radii and a tolerance: the rule of Open
Babel (https://openbabel.org, ``ConnectTheDots``), with its 0.45 Å. Atoms nearer than 0.4 Å are two places of one atom.
A grid of cells as wide as the longest bond finds the pairs: of each cell, the atoms in it and in 13 of its 26
neighbours.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray

Float64Array = npt.NDArray[np.float64]

#: Atoms nearer than this, in Å, are not bonded.
NEAREST = 0.4
#: The most cells along an axis.
_MAX_CELLS = 1 << 20
#: How many others are looked at for each atom on average, and how many more in all; in molecules it is about 40.
_MAX_NEAR, _MORE = 1000, 1_000_000
#: How many pairs are looked at together.
_BATCH = 1 << 20


class CrowdedError(ValueError):
    """Atoms that are spread too far, or packed too densely, to be those of molecules."""


def bonded(points: Float64Array, radii: Float64Array, places: npt.NDArray[np.uint8], tolerance: float) -> IntArray:
    """Return the pairs of atoms that are bonded, (n, 2), the lower number first.

    Atoms at places that exclude each other, which are other numbers than 0, are never bonded.

    Examples
    --------
    >>> bonded(np.array([[0, 0, 0], [1.5, 0, 0], [9, 0, 0]]), np.full(3, 0.73), np.zeros(3, np.uint8), 0.45)
    array([[0, 1]])
    """
    usable = np.flatnonzero(np.isfinite(points).all(axis=1))
    if len(usable) < 2:
        return np.empty((0, 2), np.int64)
    cutoff = 2 * float(radii.max()) + tolerance
    found = [np.empty((0, 2), np.int64)]
    for pairs in _near(points[usable], cutoff):
        i, j = usable[pairs].T
        distance = np.sqrt(((points[i] - points[j]) ** 2).sum(axis=1))
        good = (distance > NEAREST) & (distance < radii[i] + radii[j] + tolerance)
        good &= (places[i] == places[j]) | (places[i] == 0) | (places[j] == 0)
        found.append(np.sort(usable[pairs[good]], axis=1))
    return np.concatenate(found)


def _near(points: Float64Array, cutoff: float) -> Iterator[IntArray]:
    """Yield all pairs of points in the same cell or in neighbouring ones, in batches."""
    # Sort the atoms by the number of their cell; a margin of one cell keeps neighbours from wrapping around.
    low, high = points.min(axis=0), points.max(axis=0)
    with np.errstate(over="ignore"):
        sizes = np.floor((high - low) / cutoff) + 3
    if not (sizes <= _MAX_CELLS).all():
        raise CrowdedError("its atoms are too far apart to be those of molecules")
    strides = np.array([sizes[1] * sizes[2], sizes[2], 1]).astype(np.int64)
    cell = (np.floor((points - low) / cutoff).astype(np.int64) + 1) @ strides
    order = np.argsort(cell, kind="stable")
    cells, starts, counts = np.unique(cell[order], return_index=True, return_counts=True)

    # Pair each cell with itself and with half of its neighbours.
    steps = [(x, y, z) for x in (0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) >= (0, 0, 0)]
    lefts, rights = [], []
    for step in steps:
        wanted = cells + np.array(step) @ strides
        at = np.minimum(np.searchsorted(cells, wanted), len(cells) - 1)
        has = np.flatnonzero(cells[at] == wanted)
        lefts.append(has)
        rights.append(at[has])
    left, right = np.concatenate(lefts), np.concatenate(rights)
    n_pairs = counts[left] * counts[right]
    if n_pairs.sum() > _MAX_NEAR * len(points) + _MORE:
        raise CrowdedError("its atoms are packed too densely to be those of molecules")

    # List the pairs of atoms of some pairs of cells at a time.
    ends = np.cumsum(n_pairs)
    for first in range(0, int(ends[-1]), _BATCH):
        number = np.arange(first, min(first + _BATCH, int(ends[-1])))
        pair = np.searchsorted(ends, number, side="right")
        within = number - (ends[pair] - n_pairs[pair])
        a, b = left[pair], right[pair]
        i, j = within // counts[b], within % counts[b]
        keep = (a != b) | (i < j)
        yield order[np.stack([starts[a] + i, starts[b] + j], axis=1)[keep]]
