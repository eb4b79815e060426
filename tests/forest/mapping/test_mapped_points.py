"""Points as tasks: the same bits as those of one tree."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from test_mapped_rays import forest_of, on, scene

import fastlines as fl

QUERIES = {
    "nearest": ({}, {"k": 3}, {"to": "axis", "max_distance": 0.2}, {"ignore": np.arange(40)}, {"ignore_strands": [1]}),
    "within": ({"radius": 0.1}, {"radius": 0.3, "ignore": np.arange(900)[:, None] % 50}),
    "count_within": ({"radius": 0.1}, {"radius": 0.1, "to": "axis"}),
}


@pytest.fixture(scope="module")
def tree() -> fl.Tree:
    return fl.build(scene())


@pytest.fixture(scope="module", params=["a tree file", "7 tiles"])
def forest(request, tree, tmp_path_factory) -> fl.Forest:
    return forest_of(tree, tmp_path_factory.mktemp("forest"), request.param)


def assert_same(found, expected) -> None:
    if isinstance(expected, np.ndarray):
        assert np.array_equal(found, expected)
        return
    for name in ("offsets", "prim", "u", "distance", "skipped", "strand"):
        one, other = getattr(found, name, None), getattr(expected, name, None)
        assert (one is None) == (other is None), name
        if other is not None:
            assert (one.dtype, one.shape) == (other.dtype, other.shape), name
            assert one.tobytes() == other.tobytes(), name


def asked(of, query: str, options: dict, n: int = 900):
    return getattr(of, query)(np.random.default_rng(n).uniform(-1.5, 1.5, (n, 3)), **options)


@pytest.mark.parametrize("query", QUERIES)
def test_a_map_gives_the_bits_of_one_tree(tree, forest, query):
    with ThreadPoolExecutor(2) as executor:
        mapped = on(forest, executor.map)
        for options in QUERIES[query]:
            assert_same(asked(mapped, query, options), asked(tree, query, options))


def test_workers_of_dask_give_the_bits_of_one_tree(tree, forest, client):
    mapped = on(forest, client)
    for query, several in QUERIES.items():
        assert_same(asked(mapped, query, several[-1]), asked(tree, query, several[-1]))


def test_few_points_and_invalid_ones(tree, forest):
    mapped = on(forest, map)
    for n in (0, 3, 300):
        for query, several in QUERIES.items():
            assert_same(asked(mapped, query, several[0], n), asked(tree, query, several[0], n))
    points = np.random.default_rng(0).uniform(-1, 1, (500, 3))
    points[7] = np.nan
    assert_same(mapped.nearest(points, invalid="skip"), tree.nearest(points, invalid="skip"))
