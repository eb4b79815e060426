"""Halves of a scene: segments are halved at medians of a sample of their centroids, until there are enough leaves.

A node with k leaves is cut across the longest side of the box of its sample, so that k // 2 of k parts of the sample
lie on its left. Centroids are doubled, a + b: their order is the same, and no digit is lost to the division.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import AnyArray, FloatArray, IntArray

#: How many samples a leaf has, if that is not more than the most of all.
SAMPLES_A_LEAF, LEAST_SAMPLES, MOST_SAMPLES = 4096, 1 << 16, 1 << 20

#: Leaves are planned to be so full at most, and by so many standard deviations less than full.
FULL, DEVIATIONS = 0.95, 3.0


@dataclass(frozen=True)
class Halving:
    """A binary tree of cuts.

    Attributes
    ----------
    axis : (n_cuts,) int8
    place : (n_cuts,) float32
        Twice the centroids at most this go to the left.
    children : (n_cuts, 2) int64
        The left and the right child: a cut, or ``~leaf``. Without cuts, there is one leaf.
    """

    axis: AnyArray
    place: FloatArray
    children: IntArray

    @property
    def n_leaves(self) -> int:
        """The number of leaves."""
        return len(self.axis) + 1

    @classmethod
    def of(cls, centroids: FloatArray, n_leaves: int) -> Halving:
        """Return the cuts of a sample of centroids (3, m); fewer leaves where too few of these differ."""
        cuts: list[tuple[int, float]] = []
        children: list[list[int]] = []
        n_found = 0
        # A node to make: its rows, its share of the leaves, and whose child it is.
        todo: list[tuple[IntArray, int, int, int]] = [(np.arange(centroids.shape[1]), n_leaves, -1, 0)]
        while todo:
            rows, share, parent, side = todo.pop()
            cut = _median(np.take(centroids, rows, axis=1), share) if share > 1 else None
            if cut is None:
                number, n_found = ~n_found, n_found + 1
            else:
                number = len(cuts)
                cuts.append(cut)
                children.append([0, 0])
                is_right = centroids[cut[0], rows] > cut[1]
                todo.append((rows[is_right], share - share // 2, number, 1))
                todo.append((rows[~is_right], share // 2, number, 0))
            if parent >= 0:
                children[parent][side] = number
        return cls(
            np.array([axis for axis, _ in cuts], np.int8),
            np.array([place for _, place in cuts], np.float32),
            np.array(children, np.int64).reshape(-1, 2),
        )

    def sort(self, centroids: FloatArray) -> tuple[IntArray, IntArray]:
        """Sort centroids (3, n) by their leaves.

        Returns
        -------
        order : (n,) int64
            The rows of each leaf, one leaf after the other, rising.
        counts : (n_leaves,) int64
        """
        counts = np.zeros(self.n_leaves, np.int64)
        parts: list[IntArray] = []
        todo = [(0 if len(self.axis) else ~0, np.arange(centroids.shape[1]))]
        axes, places, children = self.axis.tolist(), self.place, self.children.tolist()
        while todo:
            number, rows = todo.pop()
            if not len(rows):
                continue
            if number < 0:
                counts[~number] = len(rows)
                parts.append(rows)
                continue
            is_right = centroids[axes[number]][rows] > places[number]
            left, right = children[number]
            todo.append((right, rows[is_right]))
            todo.append((left, rows[~is_right]))
        return np.concatenate(parts) if parts else np.empty(0, np.int64), counts


def _median(centroids: FloatArray, share: int) -> tuple[int, float] | None:
    """Return the axis and the place of the cut of a node with so many leaves; None if its centroids are all equal."""
    n_rows = centroids.shape[1]
    if n_rows < 2:
        return None
    axis = int(np.ptp(centroids, axis=1).argmax())
    values = centroids[axis]
    n_left = max(1, n_rows * (share // 2) // share)
    place = np.partition(values, n_left - 1)[n_left - 1]
    # Equal values stay together, on the side where that changes the halves less.
    below = values[values < place]
    n_below, n_up_to = len(below), int((values <= place).sum())
    if n_below and (n_left - n_below < n_up_to - n_left or n_up_to == n_rows):
        place = below.max()
    elif n_up_to == n_rows:
        return None
    return axis, float(place)


def centroids_of(segments: FloatArray) -> FloatArray:
    """Return twice the centroids of segments (n, 2, 3), as (3, n)."""
    centroids = np.empty((3, len(segments)), np.float32)
    for axis in range(3):
        np.add(segments[:, 0, axis], segments[:, 1, axis], out=centroids[axis])
    return centroids


def n_leaves_for(n_rows: int, most: int) -> int:
    """Return how many leaves hold so many rows, of which few have more than `most`.

    The count of a leaf with s samples has a standard deviation of about one part in √s.
    """
    if n_rows <= most:
        return 1
    a_leaf = min(SAMPLES_A_LEAF, max(1.0, MOST_SAMPLES * most / n_rows))
    full = min(FULL, max(0.5, 1 - DEVIATIONS / math.sqrt(a_leaf))) if n_rows > MOST_SAMPLES else FULL
    return math.ceil(n_rows / (full * most))


def n_samples(n_rows: int, n_leaves: int) -> int:
    """Return how many of the rows to sample for so many leaves."""
    return min(n_rows, MOST_SAMPLES, max(LEAST_SAMPLES, SAMPLES_A_LEAF * n_leaves)) if n_leaves > 1 else 0


def sampled(n_rows: int, n_wanted: int) -> IntArray:
    """Return the rows of a sample, rising: one of each of so many equal runs, picked by a hash of the run's number.

    Examples
    --------
    >>> sampled(10, 4)
    array([0, 2, 6, 7])
    """
    bounds = np.arange(n_wanted + 1) * n_rows // max(1, n_wanted)
    run = np.arange(n_wanted, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    run ^= run >> np.uint64(29)
    run *= np.uint64(0xBF58476D1CE4E5B9)
    run >>= np.uint64(33)
    return np.asarray(bounds[:-1] + (run % np.diff(bounds).astype(np.uint64)).astype(np.int64))
