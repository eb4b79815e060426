"""The nodes of a tree as arrays: the same of real trees and of the theory's, and consistent with what a tree says."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines import theory as th
from fastlines.inspection import outline_of

METHODS = ("best", "bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-d2")


@pytest.mark.parametrize("method", METHODS)
def test_an_outline_says_what_the_tree_says(method: str) -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines, method)
    outline = outline_of(tree)
    assert [nodes.tolist() for nodes in outline.levels] == [nodes.tolist() for nodes in tree.levels()]
    assert outline.cost_below[0] == pytest.approx(tree.cost(by="g"), rel=1e-12)
    inner = np.flatnonzero(~outline.is_leaf)
    assert np.array_equal(outline.parent[outline.right[inner]], inner)
    assert outline.end[0] == tree.n_nodes
    for node in inner[:: max(1, len(inner) // 20)]:
        assert outline.end[node + 1] == outline.right[node]
        assert outline.end[outline.right[node]] == outline.end[node]
        path = outline.path(int(node))
        assert path[0] == 0
        assert path[-1] == node
        assert np.array_equal(outline.level[path], np.arange(len(path)))


def test_each_inner_node_of_a_kd_tree_has_its_plane() -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines, "kd-d2")
    outline = outline_of(tree)
    inner = np.flatnonzero(~outline.is_leaf)
    axis, plane = outline.split_axis[inner], outline.split_plane[inner]
    assert (axis >= 0).all()
    assert np.array_equal(plane, outline.boxes[inner + 1, 1, axis])
    assert np.array_equal(plane, outline.boxes[outline.right[inner], 0, axis])
    assert (outline.split_axis[outline.is_leaf] == -1).all()


@pytest.mark.parametrize("method", METHODS)
def test_a_kd_tree_is_known_by_its_boxes(method: str) -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines, method)
    # A single node is both (thesis §3.2): bvh-ss makes one leaf of these lines.
    assert outline_of(tree).is_kd == (method.startswith("kd") or tree.n_nodes == 1)
    one_leaf = fl.build([[[0, 0, 0], [1, 1, 1]]], method)
    assert outline_of(one_leaf).is_kd


def test_overlapping_siblings_have_no_plane() -> None:
    crossing = np.array([[[0, 0, 0], [4, 4, 4]], [[1, 4, 0], [5, 0, 4]]], np.float32)
    outline = outline_of(fl.build(crossing, "bvh-cl", cost=fl.Cost(0.01)))
    assert outline.n_nodes == 3
    assert outline.split_axis[0] == -1
    assert np.isnan(outline.split_plane[0])


def test_a_tree_of_the_theory_has_the_same_outline() -> None:
    segments = fl.scenes.make("spaghetti", 12).lines.segments
    cost = fl.Cost(0.1)
    real = outline_of(fl.build(segments, "bvh-cl", cost=cost))
    lesson = outline_of(th.build(th.segments(segments), th.object_sweep, c_trav=0.1), cost)
    assert real.right.tolist() == lesson.right.tolist()
    assert np.array_equal(real.boxes, lesson.boxes)
    assert real.prims.tolist() == lesson.prims.tolist()
    assert np.array_equal(real.own_cost, lesson.own_cost)


def test_of_no_lines_there_is_one_leaf() -> None:
    outline = outline_of(fl.build(np.zeros((0, 2, 3))))
    assert outline.n_nodes == 1
    assert outline.is_leaf.all()
    assert len(outline.prims) == 0


@pytest.mark.parametrize("node", ["a", 0.5, None, True])
def test_what_is_no_number_of_a_node_is_refused(node: object) -> None:
    with pytest.raises(fl.InputError, match=r"node=.*; expected a number from 0 to 0"):
        outline_of(fl.build([[[0, 0, 0], [1, 1, 1]]])).path(node)  # type: ignore[arg-type]


def test_bad_input_is_refused_in_one_sentence() -> None:
    outline = outline_of(fl.build([[[0, 0, 0], [1, 1, 1]]]))
    with pytest.raises(fl.InputError, match="node=1; expected a number from 0 to 0"):
        outline.path(1)
    with pytest.raises(fl.InputError, match="tree is Lines; expected a Tree"):
        outline_of(fl.scenes.make("spaghetti", 3).lines)  # type: ignore[arg-type]
