"""KD trees searched by planes: what is special about it; `test_queries.py` compares all trees with brute force."""

from __future__ import annotations

import nasty
import numpy as np
import pytest
from test_queries import assert_same

import fastlines as fl
from fastlines.query import QUERIES
from fastlines.settings import Settings
from fastlines.structure import MAX_DEPTH, NODE, REF
from fastlines.tree import Tree

#: A leaf of the core's nodes has this in the lowest two bits (cpp/fastlines/query/plane_search.hpp).
LEAF = 3


def crossing_tree() -> Tree:
    return fl.build(nasty.crossing(np.random.default_rng(3), 300).astype(np.float32), "kd-d2")


def test_planes_hold_the_tree() -> None:
    tree = crossing_tree()
    nodes, prims, depth, corners = tree.planes
    assert depth == tree.stats()["depth"]
    assert np.array_equal(prims, tree.refs["prim"])
    assert np.array_equal(np.reshape(corners, (2, 3)), tree.nodes["box"][0])
    # Go down the planes as a search does, and list the references of the leaves.
    listed, n_nodes, stack = [], 0, [0]
    while stack:
        word, link = map(int, nodes[stack.pop()])
        n_nodes += 1
        if link & 3 < LEAF:
            stack += [2 * (link >> 2), 2 * (link >> 2) + 1]
        elif link >> 2 == 1:
            listed.append(word)
        else:
            listed += prims[word : word + (link >> 2)].tolist()
    assert n_nodes == tree.n_nodes
    assert sorted(listed) == sorted(prims.tolist())


def test_planes_can_not_be_changed() -> None:
    nodes, prims, *_ = crossing_tree().planes
    for array in (nodes, prims):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_a_tree_that_was_asked_is_pickled() -> None:
    import pickle

    tree = crossing_tree()
    rays = [0.5, 0.5, -1], [0, 0, 1], 0.1
    expected = tree.count_hits(*rays, kernel="binary")
    assert pickle.loads(pickle.dumps(tree)).count_hits(*rays, kernel="binary") == expected


def empty_space(segment: list[list[float]], axis: int, n_cuts: int) -> Tree:
    """A KD tree over two equal segments that cuts off empty leaves, one behind the other, on the lower or upper side.

    As deep as a tree may be, each cut halves what is left, or where floats end, cuts off nothing.
    """
    segments = np.repeat(np.float32([segment]), 2, axis=0)
    segments = np.concatenate([segments, np.float32([[[-1, -1, -1], [1, 1, 1]]])])
    nodes = np.zeros(2 * n_cuts + 1, NODE)
    box = np.float32([[-1, -1, -1], [1, 1, 1]])
    for i in range(n_cuts):
        nodes["box"][2 * i] = box
        nodes["right"][2 * i] = 2 * i + 2
        nodes["n_refs"][2 * i] = 3
        # The left child, the lower half, is empty; the right child holds all.
        nodes["box"][2 * i + 1] = box
        nodes["box"][2 * i + 1, 1, axis] = box[0, axis]
    nodes["box"][-1] = box
    nodes["n_refs"][-1] = 3
    refs = np.array([(prim, 0, np.inf) for prim in range(3)], REF)
    return Tree(fl.Lines.from_segments(segments), nodes, refs, Settings(boxes="cut"))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("n_cuts", [1, 30, MAX_DEPTH])
def test_deep_trees_of_empty_space(n_cuts: int, axis: int) -> None:
    tree = empty_space([[-0.5, 0.25, 0], [0.5, 0.5, 0.25]], axis, n_cuts)
    rng = np.random.default_rng(n_cuts + axis)
    origins, directions = rng.uniform(-1.5, 1.5, (200, 3)), rng.normal(size=(200, 3))
    directions[:50, axis] = 0  # along the planes
    directions[50:100] = np.eye(3)[rng.integers(3, size=50)] * rng.choice([-1, 1], (50, 1))
    for query in QUERIES:
        how = {"k": 2} if query == "next_hits" else {}
        expected = fl.brute_force(tree.geometry, origins, directions, 0.2, query=query, **how)
        assert_same(getattr(tree, query)(origins, directions, 0.2, **how, kernel="binary"), expected)


def test_what_is_in_many_leaves_is_listed_once() -> None:
    """A segment that runs along the ray is in every leaf that the ray visits."""
    segments = np.float32([[[-1, 0, 0], [1, 0, 0]], *([[x, -1, 0], [x, 1, 0]] for x in np.linspace(-1, 1, 64))])
    tree = fl.build(segments, "kd-d2")
    assert tree.n_refs > 2 * len(segments)
    hits = tree.all_hits([-2, 0.01, 0], [1, 0, 0], 0.05, kernel="binary")
    assert len(np.unique(hits.prim)) == len(hits) == len(segments)
