"""Trees and lines are their own: nobody can change them, and what is made by hand leads out of no array."""

from __future__ import annotations

import copy
import dataclasses
import pickle

import numpy as np
import pytest
from support import nasty

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
    trees = [fl.build(lines, own_radius=False), *(fl.build(given) for given in (ends, ends[::1], flat))]
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


def test_memory_that_nobody_can_write_to_is_not_copied(tmp_path):
    ends = crossing()
    np.save(tmp_path / "a.npy", ends)
    data = ends.tobytes()
    kept = {
        "map": np.load(tmp_path / "a.npy", mmap_mode="r"),
        "view of a map": np.load(tmp_path / "a.npy", mmap_mode="r")[3:],
        "bytes": np.frombuffer(data, np.float32).reshape(-1, 2, 3),
        "view of bytes": np.ndarray(ends.shape, np.float32, memoryview(data)),
        "our own": fl.Lines.from_segments(ends).segments[3:],
    }
    for name, array in kept.items():
        assert np.shares_memory(fl.Lines.from_segments(array).segments, array), name


def thawing(kind, tmp_path):
    """Return read-only segments, and what writes NaN into them all the same."""
    ends, data = crossing(), bytearray(crossing().tobytes())
    if kind == "owner":
        ends.flags.writeable = False
        return ends, lambda: ends.setflags(write=True) or ends.fill(np.nan)
    if kind == "view":
        view = ends.view()
        view.flags.writeable = False
        return view, lambda: ends.fill(np.nan)
    if kind == "view of a frozen array":
        ends.flags.writeable = False
        return ends[:], lambda: ends.setflags(write=True) or ends.fill(np.nan)
    if kind == "converted":
        wide = ends.astype(np.float64)
        wide.flags.writeable = False
        return wide, lambda: wide.setflags(write=True) or wide.fill(np.nan)
    if kind == "bytearray":
        view = np.frombuffer(memoryview(data).toreadonly(), np.float32).reshape(ends.shape)
        return view, lambda: data.__setitem__(slice(None), b"\xff" * len(data))
    if kind == "exporter":  # __array__ may give what it keeps
        return Exporter(ends), lambda: ends.setflags(write=True) or ends.fill(np.nan)
    ends.tofile(tmp_path / "a")
    shared = np.memmap(tmp_path / "a", np.float32, kind, shape=ends.shape)
    view = shared.view()
    view.flags.writeable = False
    return view, lambda: shared.fill(np.nan)


class Exporter:
    def __init__(self, array):
        array.flags.writeable = False
        self.array = array

    def __array__(self, dtype=None, copy=None):
        return self.array


@pytest.mark.parametrize(
    "kind", ["owner", "view", "view of a frozen array", "converted", "bytearray", "exporter", "r+", "c"]
)
def test_read_only_memory_that_somebody_can_write_to_is_copied(kind, tmp_path):
    ends, thaw = thawing(kind, tmp_path)
    column = np.asarray(ends, np.float32).reshape(24, 6)[:, 0]
    column.flags.writeable = False
    trees = [fl.build(ends), fl.build(fl.Lines.from_segments(ends, attributes={"a": column}))]
    boxes = fl.Boxes(np.asarray(ends)[:0])
    thaw()
    for tree in trees:
        assert (tree.geometry.segments == crossing()).all()
        assert tree.first_hit(*RAYS, 0.2).hit.any()
    assert (trees[1].geometry.attributes["a"] == crossing()[:, 0, 0]).all()
    assert len(boxes) == 0


def arrays_of(kept):
    """Return all arrays that something immutable has, by name."""
    if isinstance(kept, fl.Tree):
        own = {"nodes": kept.nodes, "refs": kept.refs, "box": kept.layout.box, "wide": kept.layout.nodes}
        return own | {"leaves": kept.layout.leaves, "wide refs": kept.layout.refs} | arrays_of(kept.geometry)
    if isinstance(kept, fl.Lines):
        names = ("segments", "strands", "radius", "skipped")
        return {name: getattr(kept, name) for name in names} | dict(kept.attributes)
    return {"corners": kept.corners}


@pytest.fixture(scope="module")
def immutables(tmp_path_factory):
    ends = crossing()
    ends[3] = np.nan
    more = {"radius": np.ones((24, 2)), "strands": np.arange(24), "attributes": {"a": np.arange(24.0)}}
    lines = fl.Lines.from_segments(ends, invalid="skip", **more)
    tree = fl.build(lines)
    path = tmp_path_factory.mktemp("trees") / "a.flt"
    tree.save(path)
    return {
        "lines": lines,
        "strands": fl.Lines.from_strands([ends[:3, 0], ends[4:9, 0]]),
        "tree": tree,
        "refitted": tree.refit(np.delete(crossing(), 3, axis=0) + 1),
        "loaded": fl.load(path),
        "triangles": fl.Triangles(np.zeros((2, 3, 3))),
        "boxes": fl.Boxes(np.zeros((2, 2, 3))),
    }


KINDS = ["lines", "strands", "tree", "refitted", "loaded", "triangles", "boxes"]


def no_array_can_be_written_to(kept):
    for name, array in arrays_of(kept).items():
        if array is None:
            continue
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
        assert not array.flags.writeable, name


@pytest.mark.parametrize("kind", KINDS)
def test_nobody_can_make_them_writeable(immutables, kind):
    no_array_can_be_written_to(immutables[kind])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_pickles_are_as_immutable(immutables, kind, protocol):
    kept = immutables[kind]
    back = pickle.loads(pickle.dumps(kept, protocol))
    assert repr(back) == repr(kept)
    no_array_can_be_written_to(back)
    for name, array in arrays_of(kept).items():
        assert np.array_equal(array, arrays_of(back)[name]), name
    if isinstance(kept, fl.Tree):
        assert "layout" in vars(back), "the layout is not made twice"
        assert back.layout.geometry is back.geometry
        assert back.all_hits(*RAYS, 0.2).prim.tolist() == kept.all_hits(*RAYS, 0.2).prim.tolist()


def test_a_pickle_with_memory_of_its_own_is_copied(immutables):
    """Out of band, the buffers are whoever's they are."""
    buffers = []
    data = pickle.dumps(immutables["tree"], 5, buffer_callback=buffers.append)
    given = [bytearray(buffer.raw()) for buffer in buffers]
    back = pickle.loads(data, buffers=given)
    for buffer in given:
        buffer[:] = b"\xff" * len(buffer)
    assert (back.nodes == immutables["tree"].nodes).all()
    assert back.first_hit(*RAYS, 0.2).hit.sum() == immutables["tree"].first_hit(*RAYS, 0.2).hit.sum()


def test_an_array_in_the_same_pickle_is_no_way_in(immutables):
    lines = immutables["lines"]
    array, back = pickle.loads(pickle.dumps((lines.segments, lines), 4))
    array.fill(np.nan)
    assert (back.segments == lines.segments).all()


@pytest.mark.parametrize("kind", KINDS)
def test_a_copy_is_the_same(immutables, kind):
    kept = immutables[kind]
    assert copy.copy(kept) is kept
    assert copy.deepcopy([kept])[0] is kept
    if isinstance(kept, fl.Tree):
        assert copy.deepcopy(kept.layout) is kept.layout


def test_mappings_can_not_be_changed(immutables):
    for mapping in (immutables["lines"].attributes, immutables["tree"].limits_hit, immutables["tree"].searched):
        with pytest.raises(TypeError, match="does not support item assignment"):
            mapping["a"] = 1


def test_a_layout_made_by_hand_is_its_own(immutables):
    layout = immutables["tree"].layout
    nodes = layout.nodes.copy()
    by_hand = dataclasses.replace(layout, nodes=nodes)
    nodes[...] = 0
    assert (by_hand.nodes == layout.nodes).all()


def test_objects_as_attributes_are_kept():
    lines = fl.Lines.from_segments(crossing(2), attributes={"name": np.array(["a", None], object)})
    back = pickle.loads(pickle.dumps(lines))
    assert back.attributes["name"].tolist() == ["a", None]
    assert not back.attributes["name"].flags.writeable


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
    """The core would follow it: whatever number is changed, the tree is refused, or it is the same as before."""
    values = [0, 1, 2, tree.n_nodes - 1, tree.n_nodes, tree.n_refs, tree.n_prims, 2**31, 2**32 - 1]
    n_refused = 0
    for section, field in (("nodes", "right"), ("nodes", "first_ref"), ("nodes", "n_refs"), ("refs", "prim")):
        for row in range(0, len(getattr(tree, section)), 7):
            for value in values:
                array = getattr(tree, section).copy()
                array[field][row] = value
                try:
                    dataclasses.replace(tree, **{section: array})
                except fl.InvalidTreeError:
                    n_refused += 1
                else:
                    assert array.tobytes() == getattr(tree, section).tobytes()
    assert n_refused > 100


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"geometry": fl.Lines.from_segments(np.zeros((3, 2, 3)))}, "names none of the 3 primitives"),
        ({"nodes": np.zeros((3, 9), np.uint32)}, "nodes are not a 1-d array"),
        ({"nodes": None}, "nodes are not a 1-d array"),
        ({"refs": np.zeros(3)}, "refs are not a 1-d array"),
        ({"settings": "bvh-d2"}, "settings='bvh-d2'; expected fl.Settings"),
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
        assert (ends[hits.row] == asked.geometry.segments[hits.prim]).all()
    assert fl.Lines.from_segments(crossing()).rows.tolist() == list(range(24))


# ---- Strands ----


@pytest.mark.parametrize(
    "strands", [[], [-1, -1], [0, 0, 1, 1, 2], [5, 5, -1, 7, 7], [3, 1, 3, 2], [10**12, 5, 10**12, -1], [2**62 - 1]]
)
def test_how_many_strands_there_are(strands):
    lines = fl.Lines.from_segments(np.zeros((len(strands), 2, 3)), strands=np.array(strands, np.int64))
    assert lines.n_strands == len({strand for strand in strands if strand >= 0})
    assert type(lines.n_strands) is int


def test_printing_lines_sorts_no_strands(monkeypatch):
    strands = np.arange(1000)
    orders = [strands, strands // 7, np.random.default_rng(0).permutation(strands)]
    made = [fl.Lines.from_segments(np.zeros((1000, 2, 3)), strands=order) for order in orders]
    monkeypatch.setattr(np, "unique", None)
    assert [repr(lines) for lines in made] == [f"<Lines: 1,000 segments, {n:,} strands>" for n in (1000, 143, 1000)]


def test_blocks_of_a_layout_are_aligned(immutables):
    """Pickles, and arrays made by hand, come anywhere in memory."""
    layout = immutables["tree"].layout
    room = np.zeros(layout.nodes.nbytes + 1, np.uint8)
    odd = room[1:].reshape(layout.nodes.shape)
    odd[:] = layout.nodes
    for same in (
        layout,
        dataclasses.replace(layout, nodes=odd),
        *(pickle.loads(pickle.dumps(layout)) for _ in range(9)),
    ):
        assert same.nodes.ctypes.data % 128 == same.leaves.ctypes.data % 128 == 0
        assert np.array_equal(same.nodes, layout.nodes)
        assert not same.nodes.flags.writeable
