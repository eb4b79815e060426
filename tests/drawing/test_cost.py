"""Drawings of cost, leaves and work add up to what the tree says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

import fastlines as fl
from fastlines import theory as th
from fastlines.inspection import outline_of
from fastlines.rendering.node_visits import visited_nodes

LINES = fl.scenes.make("spaghetti", 60).lines
TREES = {method: fl.build(LINES, method) for method in ("bvh-cl", "bvh-d2", "kd-d2")}
DEEP = fl.build(fl.scenes.make("spaghetti", 500).lines, "bvh-d2")


def bars(ax: Any) -> np.ndarray:
    """Return the start, the end and the level of each bar of an icicle."""
    paths = [path.vertices for c in ax.collections if isinstance(c, PolyCollection) for path in c.get_paths()]
    return np.array([(v[0, 0], v[1, 0], v[0, 1]) for v in paths])


@pytest.mark.parametrize("method", TREES)
def test_the_widths_of_an_icicle_add_up_to_the_cost(method: str) -> None:
    tree, outline = TREES[method], outline_of(TREES[method])
    found = bars(fl.drawing.draw_icicle(tree))
    widths = found[:, 1] - found[:, 0]
    assert widths[found[:, 2] == 0] == pytest.approx([tree.cost(by="g")])
    # Each level is as wide as what its nodes add to the cost with all below them, up to columns of 1/2000.
    for level, nodes in enumerate(outline.levels):
        wide = nodes[outline.cost_below[nodes] * 2000 >= outline.cost_below[0]]
        shown = widths[found[:, 2] == level].sum()
        assert shown >= outline.cost_below[wide].sum() - 1e-9
        assert shown <= outline.cost_below[nodes].sum() + 1e-3 * outline.cost_below[0] * len(nodes)


def test_bars_lie_below_their_parents_and_not_on_each_other() -> None:
    found = bars(fl.drawing.draw_icicle(TREES["bvh-d2"], by="refs"))
    assert found[:, 1].max() <= TREES["bvh-d2"].n_refs + 1e-9
    for level in range(1, int(found[:, 2].max()) + 1):
        row, above = (found[found[:, 2] == at] for at in (level, level - 1))
        row = row[np.argsort(row[:, 0])]
        assert (row[1:, 0] >= row[:-1, 1] - 1e-6).all()
        assert row[:, 1].max() <= above[:, 1].max() + 1e-6


def test_an_icicle_merges_narrow_nodes_and_says_so() -> None:
    ax = fl.drawing.draw_icicle(DEEP)
    outline = outline_of(DEEP)
    is_narrow = outline.cost_below * 2000 < outline.cost_below[0]
    n_leaves = int((is_narrow & outline.is_leaf).sum())
    assert n_leaves > 100
    assert len(bars(ax)) < outline.n_nodes
    said = " ".join(ax.get_xlabel().split())
    assert f"pale: {is_narrow.sum() - n_leaves:,} inner nodes and {n_leaves:,} leaves, each narrower" in said


def test_an_icicle_of_the_theory_is_the_same() -> None:
    some = LINES.segments[:12]
    real = fl.build(some, "bvh-cl", cost=fl.Cost(0.1))
    lesson = th.build(th.segments(some), th.object_sweep, c_trav=0.1)
    one, other = fl.drawing.draw_icicle(real, by="refs"), fl.drawing.draw_icicle(lesson, by="refs")
    assert np.array_equal(bars(one), bars(other))


def test_costs_can_be_those_of_other_steps_and_tests() -> None:
    model = fl.Cost(c_trav=7, c_prim=3)
    assert fl.drawing.draw_icicle(DEEP, model=model).get_xlim()[1] == pytest.approx(DEEP.cost(model=model))
    whole = np.asarray(fl.drawing.draw_work(DEEP, by="cost", size=2, model=model).images[0].get_array())
    parts = [fl.Cost(c_trav=7, c_prim=1e-9), fl.Cost(c_trav=1e-9, c_prim=3)]
    images = [fl.drawing.draw_work(DEEP, by="cost", size=2, model=part).images[0] for part in parts]
    assert whole == pytest.approx(sum(np.asarray(image.get_array()) for image in images), rel=1e-6)


def heights(ax: Any) -> list[np.ndarray]:
    """Return the heights of each labelled line of steps."""
    return [patch.get_data().values for patch in ax.patches if patch.get_label()]


@pytest.mark.parametrize("draw", [fl.drawing.draw_leaf_sizes, fl.drawing.draw_depths])
def test_histograms_count_every_leaf(draw: Any) -> None:
    outlines = [outline_of(tree) for tree in TREES.values()]
    for by, sums in (
        ("number", [outline.is_leaf.sum() for outline in outlines]),
        ("share", [1, 1, 1]),
        ("chance", [outline.chance[outline.is_leaf].sum() for outline in outlines]),
    ):
        ax = draw(TREES, by=by)
        assert [found.sum() for found in heights(ax)] == pytest.approx(sums)
        labels = [text.get_text() for text in ax.get_legend().get_texts()]
        assert [label.partition(":")[0] for label in labels] == list(TREES)


def test_bars_are_those_of_their_leaves() -> None:
    tree = TREES["bvh-d2"]
    outline = outline_of(tree)
    (sizes,) = heights(fl.drawing.draw_leaf_sizes(tree))
    assert np.array_equal(sizes, np.bincount(outline.n_refs[outline.is_leaf]))
    (depths,) = heights(fl.drawing.draw_depths(tree))
    assert np.array_equal(depths, np.bincount(outline.level[outline.is_leaf]))


def test_large_leaves_are_in_ranges_that_double() -> None:
    one_leaf = fl.build(fl.scenes.make("spaghetti", 300).lines, "kd-cl")
    ax = fl.drawing.draw_leaf_sizes([one_leaf, TREES["bvh-d2"]])
    assert heights(ax)[0].tolist() == [0] * 9 + [1]  # 256 to 511
    assert ax.get_xticklabels()[-1].get_text() == "256–511"
    labels = [text.get_text().partition(":")[0] for text in ax.get_legend().get_texts()]
    assert labels == ["kd-cl", "bvh-d2"]


def test_trees_of_one_name_have_labels_of_their_own() -> None:
    labels = [text.get_text() for text in fl.drawing.draw_depths([DEEP, DEEP]).get_legend().get_texts()]
    assert [label.partition(":")[0] for label in labels] == ["bvh-d2", "bvh-d2 (2)"]
    with pytest.raises(fl.InputError, match="trees is empty"):
        fl.drawing.draw_depths([])


def test_work_is_that_of_the_rays() -> None:
    tree = TREES["bvh-d2"]
    camera = fl.default_camera(LINES)
    origins, directions = camera.rays(width=8, height=8)
    image = fl.drawing.draw_work(tree, camera=camera, size=8, radius=0.01).images[0].get_array()
    assert np.array_equal(image.ravel(), visited_nodes(tree, origins, directions, 0.01))
    cost = fl.drawing.draw_work(tree, by="cost", size=8).images[0].get_array()
    outline = outline_of(tree)
    ways = [fl.inspection.trace_ray(tree, o, d, 0.0, outline=outline) for o, d in zip(origins, directions, strict=True)]
    assert np.asarray(cost).ravel() == pytest.approx([way.cost for way in ways])


def test_work_of_the_theory_is_the_same() -> None:
    some = LINES.segments[:12]
    lesson = th.build(th.segments(some), th.object_sweep, c_trav=0.1)
    real = fl.build(some, "bvh-cl", cost=fl.Cost(0.1))
    one, other = (fl.drawing.draw_work(tree, size=16).images[0].get_array() for tree in (real, lesson))
    assert one.max() > 3
    assert np.array_equal(one, other)


def test_two_pictures_of_work_can_have_one_scale() -> None:
    assert fl.drawing.draw_work(DEEP, size=2, most=50).images[0].get_clim() == (0, 50)
    for bad in ({"most": 0}, {"size": 0}, {"radius": -1}, {"by": "time"}, {"camera": "front"}):
        with pytest.raises(fl.InputError):
            fl.drawing.draw_work(DEEP, **bad)  # type: ignore[arg-type]
