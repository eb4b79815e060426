"""Pairs as tasks: the same as those of one tree."""

from __future__ import annotations

import numpy as np
import pytest
from test_mapped_rays import forest_of, on, scene

import fastlines as fl
from fastlines.forest.mapping import mapped_pairs

NAMES = ("i", "j", "s", "t", "distance")


@pytest.fixture(scope="module")
def tree() -> fl.Tree:
    return fl.build(scene())


@pytest.fixture(scope="module", params=["a tree file", "7 tiles"])
def forest(request, tree, tmp_path_factory) -> fl.Forest:
    return forest_of(tree, tmp_path_factory.mktemp("forest"), request.param)


@pytest.fixture(autouse=True)
def _few_are_tasks(monkeypatch):
    monkeypatch.setattr(mapped_pairs, "HERE", 10)


def assert_same(found: fl.Pairs, expected: fl.Pairs) -> None:
    assert len(expected) > 10
    for name in NAMES:
        assert getattr(found, name).tobytes() == getattr(expected, name).tobytes(), name


@pytest.mark.parametrize("options", [{}, {"skip_neighbours": 0}, {"skip_strand": True}, {"to": "axis"}])
def test_a_map_finds_the_pairs_of_one_tree(tree, forest, options):
    done = []
    found = on(forest, map).pairs(0.05, **options, progress=done.append)
    assert_same(found, tree.pairs(0.05, **options))
    assert done == sorted(done)
    assert len(done) > 4


def test_pairs_of_two(tree, forest, tmp_path):
    other = fl.build(scene(50))
    second = forest_of(other, tmp_path, "7 tiles")
    expected = tree.pairs(0.05, other)
    assert_same(on(forest, map).pairs(0.05, second), expected)
    # What is in memory is not sent.
    assert_same(on(forest, map).pairs(0.05, other), expected)


def test_workers_of_dask_find_the_pairs_of_one_tree(tree, forest, client):
    assert_same(on(forest, client).pairs(0.05), tree.pairs(0.05))


def test_parts_of_pairs_fit_into_memory(tree, forest):
    expected = tree.pairs(0.05)
    parts = list(on(forest, map).iter_pairs(0.05, max_bytes=68 * len(expected) // 5))
    assert len(parts) > 4
    assert max(map(len, parts)) <= len(expected) // 5
    for name in NAMES:
        assert np.array_equal(np.concatenate([getattr(part, name) for part in parts]), getattr(expected, name)), name
