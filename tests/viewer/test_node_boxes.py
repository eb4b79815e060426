"""Boxes and planes of levels, and paths to nodes."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.inspection import outline_of
from fastlines.viewer.node_boxes import box_edges, level_boxes, split_planes
from fastlines.viewer.node_path import path_table, reference_strokes, references_text

TREE = fl.build(fl.scenes.make("spaghetti", 400).lines, "kd-d2")
OUTLINE = outline_of(TREE)


def test_the_edges_of_a_box() -> None:
    edges = box_edges(np.array([[[0, 0, 0], [1, 2, 3]]], float))
    lengths = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    assert np.sort(lengths).tolist() == [1] * 4 + [2] * 4 + [3] * 4


@pytest.mark.parametrize("level", [0, 3, 9])
def test_a_level_and_the_leaves_above_fill_the_root(level: int) -> None:
    shown = level_boxes(OUTLINE, level, 10**6)
    assert len(shown.nodes) == len(shown.colors)
    sides = OUTLINE.boxes[shown.nodes, 1] - OUTLINE.boxes[shown.nodes, 0]
    root = OUTLINE.boxes[0, 1] - OUTLINE.boxes[0, 0]
    if level == 0:
        assert sides.tolist() == [root.tolist()]
    assert sides.prod(axis=1).sum() <= root.prod() * (1 + 1e-6)
    assert f"level {level} of" in shown.caption
    assert "shown" not in shown.caption


def test_many_boxes_are_thinned_and_it_is_said() -> None:
    level = len(OUTLINE.levels) - 1
    shown = level_boxes(OUTLINE, level, 50)
    assert len(shown.nodes) <= 50
    assert "boxes are shown" in shown.caption
    assert "leaves above, in grey" in shown.caption


def test_planes_are_inside_their_nodes_and_square_to_their_axis() -> None:
    quads, caption = split_planes(OUTLINE, 2)
    nodes = OUTLINE.levels[2]
    assert len(quads) == len(nodes)
    assert caption == f"{len(nodes)} split planes"
    for node, quad in zip(nodes, quads, strict=True):
        axis = int(OUTLINE.split_axis[node])
        assert quad[:, axis] == pytest.approx(OUTLINE.split_plane[node])
        for other in {0, 1, 2} - {axis}:
            assert np.sort(quad[:, other]).tolist() == np.repeat(OUTLINE.boxes[node, :, other], 2).tolist()


def test_a_bvh_says_which_boxes_overlap() -> None:
    outline = outline_of(fl.build(fl.scenes.make("spaghetti", 400).lines, "bvh-cl"))
    assert "overlap" in split_planes(outline, 0)[1]


def test_the_path_begins_at_the_root() -> None:
    leaf = int(np.flatnonzero(OUTLINE.is_leaf)[10])
    rows = path_table(OUTLINE, leaf).rows
    assert [int(row[0]) for row in rows] == OUTLINE.path(leaf).tolist()
    assert [int(row[1]) for row in rows] == list(range(len(rows)))
    assert rows[0][3:] == [f"{len(OUTLINE.prims):,}", "100 %"]


def test_references_are_pieces_of_their_segments() -> None:
    node = OUTLINE.levels[6][3]
    refs = OUTLINE.refs_of(node)
    ends = reference_strokes(TREE.geometry, OUTLINE, [node])
    assert len(ends) == OUTLINE.n_refs[node]
    low, high = OUTLINE.boxes[node]
    assert (ends >= low - 1e-4).all()
    assert (ends <= high + 1e-4).all()
    whole = TREE.geometry.segments[OUTLINE.prims[refs]]
    assert (np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) <= np.linalg.norm(whole[:, 1] - whole[:, 0], axis=1)).all()


def test_references_of_shapes_are_whole() -> None:
    tree = fl.build(
        fl.Geometry([fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]), fl.lines([[[0, 0, 0], [1, 1, 1]]])])
    )
    assert len(reference_strokes(tree.geometry, outline_of(tree), [0])) == 4


def test_many_references_are_thinned_and_it_is_said() -> None:
    assert len(reference_strokes(TREE.geometry, OUTLINE, [0], 100)) == 100
    assert references_text(OUTLINE, 0, 100).endswith("; 100 are shown")
