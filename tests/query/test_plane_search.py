"""KD trees searched by planes: what is special about it; `test_queries.py` compares all trees with brute force."""

from __future__ import annotations

import numpy as np
import pytest
from support import nasty
from support.answers import assert_same

import fastlines as fl
from fastlines.query.queries import QUERIES
from fastlines.settings.settings import Settings
from fastlines.structure.tree_data import MAX_DEPTH, NODE, REF
from fastlines.tree import Tree

#: A leaf of the core's nodes has this in the lowest two bits (cpp/fastlines/query/plane_tree.hpp).
LEAF = 3


def crossing_tree() -> Tree:
    return fl.build(nasty.crossing(np.random.default_rng(3), 300).astype(np.float32), "kd-d2")


def test_planes_hold_the_tree() -> None:
    tree = crossing_tree()
    nodes, prims, depth, corners, frame_corners = tree.planes
    assert frame_corners == corners
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


def chain(n_levels: int, axis: int) -> Tree:
    """A KD tree over pieces of one line along an axis, which cuts them off one by one: each left child is a leaf."""
    n = n_levels + 1
    across = [(axis + 1) % 3, (axis + 2) % 3]
    segments = np.zeros((n, 2, 3), np.float32)
    segments[1:, 0, axis] = segments[:-1, 1, axis] = np.arange(1, n) / n
    segments[-1, 1, axis] = 1
    segments[:, 1, across] = [1e-3, 2e-3]
    nodes = np.zeros(2 * n - 1, NODE)
    nodes["box"][:, 1] = segments.reshape(-1, 3).max(axis=0)
    inner, leaves = np.arange(n_levels) * 2, np.append(np.arange(n_levels) * 2 + 1, 2 * n_levels)
    nodes["right"][inner] = inner + 2
    nodes["n_refs"][inner] = n - np.arange(n_levels)
    nodes["n_refs"][leaves] = 1
    nodes["first_ref"][inner] = np.arange(n_levels)
    nodes["first_ref"][leaves] = np.arange(n)
    nodes["box"][inner, 0, axis] = segments[:-1, 0, axis]
    nodes["box"][leaves, 0, axis] = segments[:, 0, axis]
    nodes["box"][leaves[:-1], 1, axis] = segments[:-1, 1, axis]
    refs = np.array([(prim, 0, np.inf) for prim in range(n)], REF)
    return Tree(fl.Lines.from_segments(segments), nodes, refs, Settings(boxes="cut"))


@pytest.mark.slow
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("n_levels", [1, 30, MAX_DEPTH])
def test_deep_trees(n_levels: int, axis: int) -> None:
    tree = chain(n_levels, axis)
    assert tree.planes.depth == n_levels
    rng = np.random.default_rng(n_levels + axis)
    along = np.arange(3) == axis
    origins = rng.uniform(-0.5, 1.5, (200, 3)) * np.where(along, 1, 2e-3)
    directions = rng.normal(size=(200, 3))
    # From the deep end every level leaves a node for later; from the other end none does.
    origins[:100, axis], directions[:100] = 2, np.where(along, -1, rng.normal(0, 1e-4, (100, 3)))
    origins[100:150, axis], directions[100:150] = -2, along
    for query in QUERIES:
        how = {"k": 2} if query == "next_hits" else {}
        for radius in (0.0, 1e-3, 0.1):
            expected = fl.brute_force(tree.geometry, origins, directions, radius, query=query, **how)
            assert_same(getattr(tree, query)(origins, directions, radius, **how, kernel="binary"), expected)


def test_what_is_in_many_leaves_is_listed_once() -> None:
    """A segment that runs along the ray is in every leaf that the ray visits."""
    segments = np.float32([[[-1, 0, 0], [1, 0, 0]], *([[x, -1, 0], [x, 1, 0]] for x in np.linspace(-1, 1, 64))])
    tree = fl.build(segments, "kd-d2")
    assert tree.n_refs > 2 * len(segments)
    hits = tree.all_hits([-2, 0.01, 0], [1, 0, 0], 0.05, kernel="binary")
    assert len(np.unique(hits.prim)) == len(hits) == len(segments)
