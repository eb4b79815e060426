"""Trees and lines are their own: nobody can change them, and what is made by hand leads out of no array."""

from __future__ import annotations

import dataclasses

import nasty
import numpy as np
import pytest

import fastlines as fl


def crossing(n=24):
    return nasty.crossing(np.random.default_rng(0), n).astype(np.float32)


@pytest.fixture(scope="module")
def tree():
    return fl.build(crossing(), "bvh-d2", cost=fl.Cost(c_trav=1.0))


RAYS = ([0, 0, -5], np.random.default_rng(0).normal(size=(500, 3)) * [1, 1, 0] + [0, 0, 5])


def test_what_a_tree_was_built_on_can_be_changed_afterwards():
    ends = crossing()
    lines = fl.Lines(ends, np.arange(24), np.ones(24, np.float32), {"a": np.arange(24)})
    flat = ends.reshape(-1, 6)
    trees = [fl.build(given) for given in (lines, ends, ends[::1], flat)]
    boxes, triangles = fl.Boxes(ends[:1] * 0), fl.Triangles(np.repeat(ends, 2, axis=1)[:, :3])
    expected = trees[0].all_hits(*RAYS, 0.2)
    before = ends.copy()
    ends[...] = np.nan
    assert (lines.segments == before).all()
    assert len(expected) > 100
    for tree in trees:
        assert tree.all_hits(*RAYS, 0.2).prim.tolist() == expected.prim.tolist()
    arrays = [lines.segments, lines.strands, lines.radius, lines.attributes["a"], boxes.corners, triangles.corners]
    for array in (*arrays, trees[0].nodes, trees[0].refs):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_triangles_and_boxes_are_copies():
    for kind, shape in ((fl.Triangles, (2, 3, 3)), (fl.Boxes, (2, 2, 3))):
        corners = np.zeros(shape, np.float32)
        assert not np.shares_memory(kind(corners).corners, corners)


def test_read_only_memory_is_not_copied(tmp_path):
    np.save(tmp_path / "a.npy", crossing())
    mapped = np.load(tmp_path / "a.npy", mmap_mode="r")
    assert np.shares_memory(fl.Lines.from_segments(mapped).segments, mapped)
    view = crossing().view()
    view.flags.writeable = False  # but what it shows is not
    assert not np.shares_memory(fl.Lines.from_segments(view).segments, view)


def test_an_empty_array_stays_the_callers():
    empty = np.empty((0, 2, 3), np.float32)
    fl.build(empty)
    assert empty.flags.writeable


# ---- Made by hand ----


def test_a_tree_made_by_hand_is_its_own(tree):
    nodes, refs = tree.nodes.copy(), tree.refs.copy()
    by_hand = dataclasses.replace(tree, nodes=nodes, refs=refs)
    nodes["right"], refs["prim"] = 2**31, 2**31
    assert by_hand.all_hits(*RAYS, 0.2).prim.tolist() == tree.all_hits(*RAYS, 0.2).prim.tolist()


def test_a_tree_made_by_hand_leads_out_of_no_array(tree):
    """The core would follow it: whatever number is changed, the tree is refused, or can be asked."""
    values = [0, 1, 2, tree.n_nodes - 1, tree.n_nodes, tree.n_refs, tree.n_prims, 2**31, 2**32 - 1]
    n_refused = n_asked = 0
    for section, field in (("nodes", "right"), ("nodes", "first_ref"), ("nodes", "n_refs"), ("refs", "prim")):
        for row in range(0, len(getattr(tree, section)), 7):
            for value in values:
                array = getattr(tree, section).copy()
                array[field][row] = value
                try:
                    made = dataclasses.replace(tree, **{section: array})
                except fl.InvalidTreeError:
                    n_refused += 1
                    continue
                n_asked += 1
                hits = made.all_hits(RAYS[0], RAYS[1][:9], 0.1)
                assert hits.prim.max(initial=0) < tree.n_prims
    assert min(n_refused, n_asked) > 100


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"geometry": fl.Lines.from_segments(np.zeros((3, 2, 3)))}, "names none of the 3 primitives"),
        ({"nodes": np.zeros((3, 9), np.uint32)}, "nodes are not a 1-d array"),
        ({"nodes": None}, "nodes are not a 1-d array"),
        ({"refs": np.zeros(3)}, "refs are not a 1-d array"),
        ({"settings": "bvh-d2"}, "settings are a str"),
    ],
)
def test_fields_that_do_not_go_together(tree, change, words):
    with pytest.raises((fl.InputError, fl.InvalidTreeError), match=words):
        dataclasses.replace(tree, **change)


# ---- Skipped segments ----


def test_rows_lead_from_hits_to_the_input(tmp_path):
    ends = crossing(40)
    ends[[0, 3, 4, 39], 1, 2] = np.nan
    lines = fl.Lines.from_segments(ends, invalid="skip")
    assert lines.rows.tolist() == [row for row in range(40) if row not in (0, 3, 4, 39)]
    assert (ends[lines.rows] == lines.segments).all()
    tree = fl.build(ends, invalid="skip")
    tree.save(tmp_path / "a.flt")
    for asked in (tree, fl.load(tmp_path / "a.flt")):
        hits = asked.all_hits(*RAYS, 0.2)
        assert asked.geometry.rows.tolist() == lines.rows.tolist()
        assert (ends[asked.geometry.rows[hits.prim]] == asked.geometry.segments[hits.prim]).all()
    assert fl.Lines.from_segments(crossing()).rows.tolist() == list(range(24))
