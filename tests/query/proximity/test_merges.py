"""Answers of the parts of a whole, merged: what NumPy makes of them by sorting all."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fastlines import _core


def random_pairs(rng: np.random.Generator, n: int, most: int) -> list[Any]:
    """Return the columns of n different pairs."""
    i, j = np.divmod(rng.choice(most * most, n, replace=False).astype(np.int64), most)
    return [i, j, *rng.random((3, n), np.float32)]


@pytest.mark.parametrize("most", [3, 300, 100_000])
@pytest.mark.parametrize("n_lists", [1, 2, 7])
def test_merged_pairs(most: int, n_lists: int) -> None:
    rng = np.random.default_rng(most + n_lists)
    columns = random_pairs(rng, min(most * most, 50_000), most)
    which = rng.integers(0, n_lists, len(columns[0]))
    lists = []
    for part in range(n_lists):
        here = np.flatnonzero(which == part)
        here = here[np.lexsort((columns[1][here], columns[0][here]))]
        lists.append(tuple(column[here] for column in columns))
    order = np.lexsort((columns[1], columns[0]))
    for n_threads in (1, 3):
        for found, column in zip(_core.merge_pairs(lists, n_threads, None), columns, strict=True):
            assert found.tolist() == column[order].tolist()


def test_pairs_of_one_primitive_are_merged_too() -> None:
    n, zeros = 30_000, np.zeros(30_000, np.float32)
    j = np.arange(n)
    lists = [(np.zeros(n // 2, np.int64), j[half::2], *[zeros[: n // 2]] * 3) for half in (0, 1)]
    assert _core.merge_pairs(lists, 2, None)[1].tolist() == j.tolist()
    assert [len(column) for column in _core.merge_pairs([], 1, None)] == [0] * 5


@pytest.mark.parametrize("has_distance", [True, False])
def test_merged_lists(has_distance: bool) -> None:
    rng = np.random.default_rng(1)
    n_points, parts, rows = 40, [], []
    for part in range(4):
        points = rng.permutation(n_points)[: 10 * part]
        counts = rng.integers(0, 5, len(points))
        prim = 4 * rng.permutation(counts.sum()) + part
        distance = rng.integers(-2, 3, len(prim)).astype(np.float32)  # many ties
        s = rng.random(len(prim), np.float32)
        offsets = np.concatenate([[0], np.cumsum(counts)])
        parts.append((points, offsets, prim, *((distance, s) if has_distance else (None, None))))
        of_part = np.repeat(points, counts), distance if has_distance else 0 * distance, prim, s
        rows += list(zip(*map(np.ndarray.tolist, of_part), strict=True))
    rows.sort()
    offsets, prim, distance, s = _core.merge_lists(n_points, parts, has_distance, 2, None)
    assert np.repeat(np.arange(n_points), np.diff(offsets)).tolist() == [row[0] for row in rows]
    assert prim.tolist() == [row[2] for row in rows]
    assert distance.tolist() == ([row[1] for row in rows] if has_distance else [])
    assert s.tolist() == ([row[3] for row in rows] if has_distance else [])


@pytest.mark.parametrize("k", [1, 3, 10])
def test_merged_nearest(k: int) -> None:
    rng = np.random.default_rng(k)
    n = 20
    best = np.full(n * k, np.inf, np.float32), np.full(n * k, -1), np.zeros(n * k, np.float32)
    expected: list[list[tuple[float, int, float]]] = [[] for _ in range(n)]
    for part in range(6):
        points, m = rng.permutation(n)[:12], int(rng.integers(0, 6))
        prim = 6 * np.sort(rng.permuted(np.tile(np.arange(20), (12, 1)), axis=1)[:, :m], axis=1) + part
        distance = np.sort(rng.integers(-2, 3, (12, m)), axis=1).astype(np.float32)
        s = rng.random((12, m), np.float32)
        missing = np.arange(m) >= rng.integers(0, m + 1, 12)[:, None]
        prim[missing], distance[missing], s[missing] = -1, np.inf, 0
        _core.merge_nearest(best, k, points, (distance.reshape(-1), prim.reshape(-1), s.reshape(-1)))
        for row, point in enumerate(points):
            found = zip(distance[row].tolist(), prim[row].tolist(), s[row].tolist(), strict=True)
            expected[point] += [entry for entry in found if entry[1] >= 0]
    for point in range(n):
        nearest = (sorted(expected[point]) + [(np.inf, -1, 0.0)] * k)[:k]
        here = slice(point * k, point * k + k)
        assert list(zip(*(column[here].tolist() for column in best), strict=True)) == nearest
