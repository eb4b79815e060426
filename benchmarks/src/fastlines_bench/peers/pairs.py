"""Peers that find all pairs of segments within a radius: two loops over all pairs, and a k-d tree over samples.

All return (n, 2) int64, sorted, the lower number first.
"""

from __future__ import annotations

import ctypes
import importlib
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from fastlines import Lines, Tree, get_num_threads

from ..harness.arrays import Float64Array, IntArray
from ..harness.internals import check_pairs, compiled_engine, row_arrays, strand_places
from .closest_points import sample
from .compiled import compile_loops

#: The number of pairs that are tested at once.
CHUNK = 1 << 18


@cache
def load_textbook() -> ctypes.CDLL:
    """Compile and load the loop with the formula of textbooks."""
    loops = compile_loops(Path(__file__).with_name("textbook_pairs.cpp"), "textbook pairs", "-O3", "-march=native")
    loops.textbook_pairs.restype = ctypes.c_size_t
    return loops


class AllPairs:
    """Our brute force: every segment with every later one, 16 pairs at a time, by the test that defines the answers."""

    def __init__(self, tree: Tree, radius: float, skip_neighbours: int) -> None:
        self._view, self._n = tree.layout.view, len(tree.geometry)
        self._query = check_pairs(tree.geometry, None, radius, skip_neighbours, False, "axis")
        rows = row_arrays(tree.geometry, strand_places(tree.geometry) if skip_neighbours else None)
        self._known = rows, rows

    def find(self) -> IntArray:
        """Return the pairs within the radius, but for neighbours."""
        options = self._query.options(0, self._n, 1 << 62)
        found = compiled_engine.brute_force_pairs(self._view, None, self._known, options, get_num_threads(), None)
        return np.stack(found[:2], axis=1)


class TextbookPairs:
    """The same by the formula of textbooks, on one thread; pairs that are about as near are tested in float64.

    The formula is faster than ours, but cancels in float32 where segments are nearly parallel.
    """

    def __init__(self, lines: Lines) -> None:
        self._ends = np.ascontiguousarray(lines.segments, np.float32)
        self._strands = np.ascontiguousarray(lines.strands, np.int64)
        self._room = 1 << 16
        load_textbook()

    def find(self, radius: float, skip_neighbours: int) -> IntArray:
        """Return the pairs within the radius, but for those of a strand that are so many apart."""
        while True:
            found = np.empty((self._room, 2), np.int64)
            arrays = [ctypes.c_void_p(array.ctypes.data) for array in (self._ends, self._strands, found)]
            n = load_textbook().textbook_pairs(
                ctypes.c_size_t(len(self._ends)),
                *arrays[:2],
                ctypes.c_float(radius),
                ctypes.c_int64(skip_neighbours),
                ctypes.c_size_t(self._room),
                arrays[2],
            )
            if n <= self._room:
                return found[:n]
            self._room = n


class SampledPairs:
    """The k-d tree of scipy over samples, whose pairs are candidates, and an exact test in NumPy.

    Parameters
    ----------
    lines : Lines
    radius : float
    skip_neighbours : int
    spacing : float
        The largest distance of samples. Nearest points of two segments within the radius are at most half of it away
        from samples, so these are within the radius plus the spacing.

    Attributes
    ----------
    n_samples : int
    build_s : float
        The seconds of the clock for the samples and the tree.
    """

    def __init__(self, lines: Lines, radius: float, skip_neighbours: int, spacing: float) -> None:
        start = perf_counter()
        samples, self._of = sample(lines, spacing)
        self._tree: Any = importlib.import_module("scipy.spatial").cKDTree(samples)
        self.build_s = perf_counter() - start
        self.n_samples = len(samples)
        self._ends = lines.segments.astype(np.float64)
        self._strands = lines.strands
        self._radius, self._skip, self._spacing = radius, skip_neighbours, spacing

    def find(self) -> IntArray:
        """Return the pairs within the radius, but for neighbours."""
        near = self._of[self._tree.query_pairs(self._radius + self._spacing, output_type="ndarray")]
        near.sort(axis=1)
        i, j = near.T
        is_pair = (i != j) & ~((self._strands[i] >= 0) & (self._strands[i] == self._strands[j]) & (j - i <= self._skip))
        n = len(self._ends)
        keys = np.unique(i[is_pair] * n + j[is_pair])
        pairs = np.stack([keys // n, keys % n], axis=1)
        parts = [pairs[first : first + CHUNK] for first in range(0, len(pairs), CHUNK)]
        kept = [part[segment_distances(*self._ends[part.T]) <= self._radius] for part in parts]
        return np.concatenate([pairs[:0], *kept])


def segment_distances(first: Float64Array, second: Float64Array) -> Float64Array:
    """Return the distance of each segment of (n, 2, 3) from that of the same row of another array.

    It is the least of the distances of the four ends from the other segment, and of the two lines where their nearest
    points are inside both.
    """
    edges = first[:, 1] - first[:, 0], second[:, 1] - second[:, 0]
    squares = [
        _square_from_points(of[:, end], other[:, 0], edge)
        for of, other, edge in ((first, second, edges[1]), (second, first, edges[0]))
        for end in (0, 1)
    ]
    d, e, r = *edges, first[:, 0] - second[:, 0]
    dd, ee, de, dr, er = (_dot(*both) for both in ((d, d), (e, e), (d, e), (d, r), (e, r)))
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (de * er - dr * ee) / (dd * ee - de * de)
        t = (de * s + er) / ee
    is_inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    s, t = np.where(is_inside, s, 0)[:, None], np.where(is_inside, t, 0)[:, None]
    apart = r + s * d - t * e
    return np.asarray(np.sqrt(np.minimum.reduce([*squares, _dot(apart, apart)])))


def _square_from_points(points: Float64Array, starts: Float64Array, edges: Float64Array) -> Float64Array:
    """Return the squares of the distances of points from segments."""
    w, length2 = points - starts, _dot(edges, edges)
    s = np.clip(_dot(w, edges) / np.where(length2 > 0, length2, 1), 0, 1)
    r = w - s[:, None] * edges
    return _dot(r, r)


def _dot(x: Float64Array, y: Float64Array) -> Float64Array:
    return np.asarray(np.einsum("ij,ij->i", x, y))
