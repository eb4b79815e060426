"""Drawings of boxes and planes hold those of the tree, for trees of the core and of the theory alike."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

import fastlines as fl
from fastlines import theory as th

LINES = fl.scenes.make("spaghetti", 200).lines
BVH, KD = fl.build(LINES, "bvh-d2"), fl.build(LINES, "kd-d2")


def corners(ax: Any) -> list[list[list[float]]]:
    """Return the corners of all boxes on some axes."""
    polygons = [collection for collection in ax.collections if isinstance(collection, PolyCollection)]
    return [path.vertices[:4].tolist() for collection in polygons for path in collection.get_paths()]


def lines_of(ax: Any) -> list[Any]:
    return [collection for collection in ax.collections if isinstance(collection, LineCollection)]


@pytest.mark.parametrize("tree", [BVH, KD], ids=["bvh", "kd"])
def test_a_level_has_a_box_for_each_node_and_each_leaf_above(tree: fl.Tree) -> None:
    level = 6
    ax = fl.drawing.draw_levels(tree, level)
    above = np.concatenate(tree.levels()[:level])
    assert len(corners(ax)) == len(tree.levels()[level]) + tree.is_leaf[above].sum()
    assert len(lines_of(ax)[0].get_paths()) == len(LINES)


def test_boxes_are_seen_along_an_axis() -> None:
    low, high = BVH.box.astype(np.float64)
    for axis, across, upwards in (("x", 1, 2), ("y", 0, 2), ("z", 0, 1)):
        ax = fl.drawing.draw_levels(BVH, 0, axis=axis)
        assert corners(ax)[0][0] == [low[across], low[upwards]]
        assert corners(ax)[0][2] == [high[across], high[upwards]]
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("xyz"[across], "xyz"[upwards])


def test_boxes_are_where_the_input_has_them() -> None:
    far = LINES.segments.astype(np.float64) + np.array([5e5, 0, 0])
    ax = fl.drawing.draw_levels(fl.build(fl.lines(far, offset="auto")), 0)
    assert corners(ax)[0][0][0] == pytest.approx(far[..., 0].min(), abs=0.01)
    assert ax.get_xlim()[0] == pytest.approx(5e5, abs=0.1)


def test_a_tree_of_the_theory_has_the_same_picture() -> None:
    some = LINES.segments[:12]
    real = fl.build(some, "bvh-cl", cost=fl.Cost(0.1))
    lesson = th.build(th.segments(some), th.object_sweep, c_trav=0.1)
    assert real.n_nodes > 7
    draws = [fl.drawing.draw_planes, fl.drawing.draw_partition, lambda tree: fl.drawing.draw_levels(tree, 2)]
    for draw in draws:
        one, other = draw(real), draw(lesson)
        assert corners(one) == corners(other)
        assert [t.get_text() for t in one.texts] == [t.get_text() for t in other.texts]
        strokes = [[c.get_segments() for c in lines_of(ax)] for ax in (one, other)]
        assert all(np.array_equal(a, b) for a, b in zip(*strokes, strict=True))


def test_each_plane_is_drawn_or_counted() -> None:
    ax = fl.drawing.draw_planes(KD, max_level=4)
    outline = fl.inspection.outline_of(KD)
    nodes = np.flatnonzero((outline.level <= 4) & ~outline.is_leaf)
    drawn = [len(collection.get_segments()) for collection in lines_of(ax)[1:]]
    axes = outline.split_axis[nodes]
    assert drawn == [(axes == 0).sum(), (axes == 1).sum()]
    assert f"{(axes == 2).sum()} planes across z" in ax.get_xlabel()


def test_overlapping_siblings_are_counted() -> None:
    tree = fl.build(LINES, "bvh-cl", cost=fl.Cost(0.5))
    outline = fl.inspection.outline_of(tree)
    inner = ~outline.is_leaf & (outline.level <= 8)
    said = " ".join(fl.drawing.draw_planes(tree).get_xlabel().split())
    assert f"{(outline.split_axis[inner] < 0).sum()} nodes have children that overlap" in said


def test_many_primitives_are_thinned_and_become_pixels() -> None:
    ax = fl.drawing.draw_levels(fl.build(fl.scenes.make("spaghetti", 30_000).lines, "bvh-cl"), 1)
    (drawn,) = lines_of(ax)
    assert drawn.get_rasterized()
    assert f"{len(drawn.get_paths()):,} of 30,000 primitives drawn" in ax.get_xlabel().replace("\n", " ")


@pytest.mark.parametrize(
    "shapes",
    [
        fl.Spheres.from_centres([[0, 0, 0], [4, 0, 0]], [0.5, 1]),
        fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[5, 0, 1], [6, 0, 1], [5, 1, 1]]]),
        fl.Boxes([[[0, 0, 0], [1, 1, 1]], [[3, 3, 3], [4, 4, 4]]]),
        fl.Geometry([fl.Boxes([[[0, 0, 0], [1, 1, 1]]]), fl.Lines.from_segments(LINES.segments[:3])]),
    ],
    ids=["spheres", "triangles", "boxes", "parts"],
)
def test_other_shapes_are_drawn(shapes: Any) -> None:
    tree = fl.build(shapes)
    for draw in (fl.drawing.draw_planes, fl.drawing.draw_partition):
        ax = draw(tree)
        points = np.concatenate([segment for drawn in lines_of(ax) for segment in drawn.get_segments()])
        limits = np.array([ax.get_xlim(), ax.get_ylim()])
        assert (points.min(axis=0) > limits[:, 0]).all()
        assert (points.max(axis=0) < limits[:, 1]).all()
        assert (np.ptp(points, axis=0) >= 0.99 * np.ptp(tree.box, axis=0)[:2]).all()


def test_blocks_of_the_theory_are_drawn() -> None:
    blocks = [th.Block(i, th.Box((i, 0, 0), (i + 0.5, 1, 1))) for i in range(4)]
    ax = fl.drawing.draw_partition(th.build(blocks, th.object_sweep, c_trav=0.1))
    assert len(lines_of(ax)[0].get_paths()) == 4 * 6


def test_degenerate_trees_are_drawn() -> None:
    for segments in ([[[1, 2, 3], [1, 2, 3]]], [[[0, 0, 0], [1, 0, 0]]] * 3):
        tree = fl.build(np.array(segments, np.float32))
        for draw in (fl.drawing.draw_planes, fl.drawing.draw_partition, fl.drawing.draw_icicle):
            draw(tree).figure.draw_without_rendering()


def test_axes_of_the_caller_are_drawn_on() -> None:
    panel = Figure().subplots()
    assert fl.drawing.draw_levels(BVH, 1, ax=panel) is panel


def test_bad_input_is_refused_in_a_sentence() -> None:
    bad: list[tuple[Any, str]] = [
        (lambda: fl.drawing.draw_levels(BVH, 99), r"level=99; bvh-d2 has levels 0 to \d+ here"),
        (lambda: fl.drawing.draw_levels(BVH, -1), "level=-1; expected a whole number, 0 or more"),
        (lambda: fl.drawing.draw_levels(BVH, 0, axis="w"), "axis='w' is not a choice"),
        (lambda: fl.drawing.draw_levels(BVH, 0, ax="here"), "ax is str; expected Axes of matplotlib"),
        (lambda: fl.drawing.draw_levels(LINES, 0), "tree is Lines; expected a Tree"),
        (lambda: fl.drawing.draw_icicle(fl.build(np.empty((0, 2, 3)))), "the tree has no primitives"),
    ]
    for call, sentence in bad:
        with pytest.raises(fl.InputError, match=sentence):
            call()


def test_without_matplotlib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    with pytest.raises(fl.MissingExtraError, match="a drawing of a tree needs the extra 'plot'"):
        fl.drawing.draw_levels(BVH, 0)
