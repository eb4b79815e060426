"""`Tree.validate`: every tree that is built passes; every way to break one is named, with the node and the axiom."""

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from support.nasty import boxes_of, named_scene, triangles_on

import fastlines as fl
from fastlines.structure.tree_data import TreeData
from fastlines.support.immutable import own

Blame = set[tuple[int, str]]
Broken = Iterator[tuple[fl.Tree, Blame]]
Corruption = Callable[[fl.Tree], Broken]


# ---- Broken trees: one change each, at every node or reference where it can be made ----


CORRUPTIONS: list[Corruption] = []


def corruption(how: Corruption) -> Corruption:
    """List a way to break a tree: it yields broken trees, and which nodes and axioms may be blamed for each."""
    CORRUPTIONS.append(how)
    return how


def unchecked(tree: fl.Tree, **changes: Any) -> fl.Tree:
    """A tree with other arrays, past what every new tree is checked for."""
    broken = object.__new__(fl.Tree)
    for field in dataclasses.fields(tree):
        object.__setattr__(broken, field.name, changes.get(field.name, getattr(tree, field.name)))
    return broken


def nodes_changed(tree: fl.Tree, change: Callable[[Any], None]) -> fl.Tree:
    nodes = tree.nodes.copy()
    change(nodes)
    return unchecked(tree, nodes=nodes)


def refs_changed(tree: fl.Tree, change: Callable[[Any], None]) -> fl.Tree:
    refs = tree.refs.copy()
    change(refs)
    return unchecked(tree, refs=refs)


def set_field(field: str, i: int, value: Any) -> Callable[[Any], None]:
    def change(array: Any) -> None:
        array[field][i] = value

    return change


def parents(tree: fl.Tree) -> Any:
    parent = np.full(tree.n_nodes, -1)
    for child in (tree.left, tree.right):
        parent[child[~tree.is_leaf]] = np.flatnonzero(~tree.is_leaf)
    return parent


def path_to(tree: fl.Tree, ref: int) -> list[int]:
    """The nodes that list a reference, the leaf first."""
    first, n = tree.nodes["first_ref"], tree.nodes["n_refs"]
    return np.flatnonzero((first <= ref) & (ref < first + n))[::-1].tolist()


def blame(nodes: Any, *axioms: str) -> Blame:
    return {(int(node), axiom) for node in np.atleast_1d(nodes) for axiom in axioms}


def resized(tree: fl.Tree, i: int, amount: float) -> fl.Tree:
    """Move the upper side of a box, on the longest axis, by a share of its length."""
    sides = tree.nodes["box"][i, 1] - tree.nodes["box"][i, 0]
    axis = int(np.argmax(sides))

    def change(nodes: Any) -> None:
        nodes["box"][i, 1, axis] += np.float32(amount * sides[axis])

    return nodes_changed(tree, change)


def inner_nodes(tree: fl.Tree) -> Any:
    return np.flatnonzero(~tree.is_leaf)


@corruption
def child_is_the_left_one(tree: fl.Tree) -> Broken:
    for i in inner_nodes(tree):
        yield nodes_changed(tree, set_field("right", i, i + 1)), blame(i, "axiom 1")


@corruption
def child_out_of_range(tree: fl.Tree) -> Broken:
    for i in inner_nodes(tree):
        yield nodes_changed(tree, set_field("right", i, tree.n_nodes)), blame(i, "axiom 1")


@corruption
def child_is_an_ancestor(tree: fl.Tree) -> Broken:
    for i in inner_nodes(tree)[1:]:
        yield nodes_changed(tree, set_field("right", i, parents(tree)[i] or 1)), blame(i, "axiom 1")


@corruption
def another_child(tree: fl.Tree) -> Broken:
    for i in inner_nodes(tree):
        if tree.nodes["n_refs"][tree.right[i]] > 0 and tree.nodes["n_refs"][tree.right[i] - 1] > 0:
            broken = nodes_changed(tree, set_field("right", i, tree.right[i] - 1))
            yield broken, blame(i, "axiom 1", "axiom 2")


@corruption
def children_forgotten(tree: fl.Tree) -> Broken:
    for i in inner_nodes(tree):
        yield nodes_changed(tree, set_field("right", i, 0)), blame(i, "axiom 1")


@corruption
def leaf_with_a_child(tree: fl.Tree) -> Broken:
    for i in np.flatnonzero(tree.is_leaf):
        yield nodes_changed(tree, set_field("right", i, 1)), blame(i, "axiom 1")


@corruption
def range_moved(tree: fl.Tree) -> Broken:
    for i in range(1, tree.n_nodes):
        later = nodes_changed(tree, set_field("first_ref", i, tree.nodes["first_ref"][i] + 1))
        yield later, blame(parents(tree)[i], "axiom 2")


@corruption
def range_too_long(tree: fl.Tree) -> Broken:
    yield nodes_changed(tree, set_field("n_refs", 0, tree.n_refs + 1)), blame(0, "axiom 2")
    for i in range(1, tree.n_nodes):
        longer = nodes_changed(tree, set_field("n_refs", i, tree.nodes["n_refs"][i] + 1))
        yield longer, blame(parents(tree)[i], "axiom 2")


@corruption
def box_not_finite(tree: fl.Tree) -> Broken:
    for i in range(tree.n_nodes):
        for value in (np.nan, np.inf):
            corner = tree.nodes["box"][i, 1].copy()
            corner[i % 3] = value
            broken = nodes_changed(tree, lambda nodes, i=i, corner=corner: nodes["box"][i].__setitem__(1, corner))
            yield broken, blame(i, "axiom 2")


@corruption
def box_inverted(tree: fl.Tree) -> Broken:
    for i in range(tree.n_nodes):
        yield nodes_changed(tree, set_field("box", i, tree.nodes["box"][i, ::-1])), blame(i, "axiom 2")


@corruption
def root_resized(tree: fl.Tree) -> Broken:
    for amount in (-1e-6, 1e-6, -0.5, 0.5):
        yield resized(tree, 0, amount), blame(0, "axiom 3")


@corruption
def inner_box_shrunk(tree: fl.Tree) -> Broken:
    for i in inner_nodes(tree)[1:]:
        yield resized(tree, i, -0.1), blame(i, "axiom 4")


@corruption
def box_grown(tree: fl.Tree) -> Broken:
    """Of a BVH it is loose, of a KD tree no half of its parent's."""
    for i in range(1, tree.n_nodes):
        parent = parents(tree)[i]
        if tree.settings.boxes == "cut":
            axioms = blame(parent, "axiom 4", "KD axiom") | blame(i, "KD axiom")
        else:
            axioms = blame(i, "BVH axiom", "axiom 5") | blame(parent, "axiom 4")
        yield resized(tree, i, 0.1), axioms


@corruption
def leaf_box_shrunk(tree: fl.Tree) -> Broken:
    for i in np.flatnonzero(tree.is_leaf):
        parent = parents(tree)[i]
        if tree.settings.boxes == "cut":
            yield resized(tree, i, -0.1), blame(i, "Theorem 4") | blame(parent, "KD axiom")
        else:
            yield resized(tree, i, -0.1), blame(i, "BVH axiom", "Theorem 4") | blame(parent, "axiom 5")


@corruption
def plane_moved(tree: fl.Tree) -> Broken:
    """Two leaves that still cut their parent in two, but one that lists something has become flat."""
    for i in inner_nodes(tree):
        children = [tree.left[i], tree.right[i]]
        if tree.settings.boxes == "tight" or not tree.is_leaf[children].all() or not tree.nodes["n_refs"][i]:
            continue
        left, right = tree.nodes["box"][children].copy()
        axis = int(np.flatnonzero(left[1] < tree.nodes["box"][i, 1])[0])
        flat = next(k for k in (1, 0) if tree.nodes["n_refs"][children[k]])
        left[1, axis] = right[0, axis] = (left, right)[flat][flat, axis]
        axioms = blame(children, "Theorem 4") | blame(i, "axiom 5") | blame(children, "axiom 5")
        yield nodes_changed(tree, lambda nodes, at=children, to=(left, right): nodes["box"].__setitem__(at, to)), axioms


@corruption
def reference_dropped(tree: fl.Tree) -> Broken:
    for k in range(tree.n_refs):
        path = path_to(tree, k)
        nodes = tree.nodes.copy()
        nodes["n_refs"][path] -= 1
        nodes["first_ref"][nodes["first_ref"] > k] -= 1
        broken = unchecked(tree, nodes=nodes, refs=np.delete(tree.refs, k))
        yield broken, blame(0, "axiom 3") | blame(path, "axiom 5", "BVH axiom")


@corruption
def reference_twice(tree: fl.Tree) -> Broken:
    for k in range(tree.n_refs):
        path = path_to(tree, k)
        nodes = tree.nodes.copy()
        nodes["n_refs"][path] += 1
        nodes["first_ref"][nodes["first_ref"] > k] += 1
        broken = unchecked(tree, nodes=nodes, refs=np.insert(tree.refs, k, tree.refs[k]))
        yield broken, blame(path[0], "axiom 5", "axiom 2")


@corruption
def reference_in_no_leaf(tree: fl.Tree) -> Broken:
    """One that stays in the list, but which the tree no longer reaches."""
    last = path_to(tree, tree.n_refs - 1)
    nodes = tree.nodes.copy()
    nodes["n_refs"][last] -= 1
    broken = unchecked(tree, nodes=nodes)
    yield broken, blame(last, "axiom 2", "axiom 3", "axiom 5", "BVH axiom")


@corruption
def prim_out_of_range(tree: fl.Tree) -> Broken:
    for k in range(tree.n_refs):
        for prim in (tree.n_prims, 2**32 - 1):
            yield refs_changed(tree, set_field("prim", k, prim)), blame(path_to(tree, k)[0], "axiom 2")


@corruption
def another_prim(tree: fl.Tree) -> Broken:
    for k in range(tree.n_refs):
        other = (tree.refs["prim"][k] + 1) % tree.n_prims
        axioms = blame(path_to(tree, k), "Theorem 4", "axiom 5", "BVH axiom", "axiom 2") | blame(0, "axiom 3")
        axioms |= {(node, "axiom 5") for node in range(tree.n_nodes)}  # a piece of the other is elsewhere
        yield refs_changed(tree, set_field("prim", k, other)), axioms


@corruption
def references_swapped(tree: fl.Tree) -> Broken:
    rng = np.random.default_rng(0)
    for a in range(tree.n_refs):
        b = int(rng.integers(tree.n_refs))
        if path_to(tree, a)[0] == path_to(tree, b)[0] or tree.refs["prim"][a] == tree.refs["prim"][b]:
            continue
        axioms = blame(path_to(tree, a) + path_to(tree, b), "Theorem 4", "axiom 5", "BVH axiom", "axiom 2")
        refs = tree.refs.copy()
        refs[[a, b]] = refs[[b, a]]
        yield unchecked(tree, refs=refs), axioms


def next_piece(tree: fl.Tree, k: int) -> int:
    """Where the next piece of the same primitive is; the piece itself if it is the last."""
    same = np.flatnonzero((tree.refs["prim"] == tree.refs["prim"][k]) & (tree.refs["s0"] >= tree.refs["s1"][k]))
    return int(same[np.argmin(tree.refs["s0"][same])]) if len(same) else k


@corruption
def piece_begins_later(tree: fl.Tree) -> Broken:
    for k in range(tree.n_refs):
        piece = tree.refs[k]
        broken = refs_changed(tree, set_field("s0", k, piece["s0"] + (min(piece["s1"], 1) - piece["s0"]) / 2))
        yield broken, blame(path_to(tree, k)[0], "axiom 5")


@corruption
def piece_ends_sooner(tree: fl.Tree) -> Broken:
    for k in range(tree.n_refs):
        piece = tree.refs[k]
        broken = refs_changed(tree, set_field("s1", k, (piece["s0"] + min(piece["s1"], 1)) / 2))
        yield broken, blame(path_to(tree, next_piece(tree, k))[0], "axiom 5")


@corruption
def piece_is_no_piece(tree: fl.Tree) -> Broken:
    for k in range(tree.n_refs):
        for field, value in (("s0", np.nan), ("s1", np.nan), ("s0", -0.5), ("s1", -0.5)):
            yield refs_changed(tree, set_field(field, k, value)), blame(path_to(tree, k)[0], "axiom 2")


ANY_PRIMITIVE = [how for how in CORRUPTIONS if how not in (reference_twice, piece_begins_later, piece_ends_sooner)]
CUT_ONLY = [plane_moved]


@pytest.fixture(scope="module")
def trees() -> dict[str, fl.Tree]:
    ends = named_scene("crossing", 24)
    options: dict[str, Any] = {"cost": fl.Cost(c_trav=1.0)}
    return {
        "bvh-cl": fl.build(ends, "bvh-cl", **options),
        "bvh-d2": fl.build(ends, "bvh-d2", **options),
        "kd-d2": fl.build(ends, "kd-d2", cost=fl.Cost(c_trav=0.4)),
        "triangles bvh": fl.build(triangles_on(ends), "bvh-cl", **options),
        "boxes bvh": fl.build(boxes_of(ends), "bvh-cl", **options),
        "triangles kd": fl.build(triangles_on(ends), "kd-d2", cost=fl.Cost(c_trav=0.1), limits=fl.Limits(max_depth=7)),
    }


def test_the_trees_to_break_are_whole(trees):
    for tree in trees.values():
        assert tree.n_nodes > 10
        tree.validate()


@pytest.mark.parametrize("how", CORRUPTIONS, ids=lambda how: how.__name__)
@pytest.mark.parametrize("name", ["bvh-cl", "bvh-d2", "kd-d2"])
def test_broken_trees_over_lines(trees, name, how):
    assert_named(trees[name], how)


@pytest.mark.parametrize("how", ANY_PRIMITIVE, ids=lambda how: how.__name__)
@pytest.mark.parametrize("name", ["triangles bvh", "boxes bvh", "triangles kd"])
def test_broken_trees_over_other_primitives(trees, name, how):
    assert_named(trees[name], how)


def assert_named(tree: fl.Tree, how: Corruption) -> None:
    cases = list(how(tree))
    assert cases or (how in CUT_ONLY and tree.settings.boxes == "tight")
    for broken, expected in cases:
        with pytest.raises(fl.InvalidTreeError) as error:
            broken.validate()
        assert (error.value.node, error.value.axiom) in expected, error.value


@pytest.mark.parametrize("how", [reference_twice, piece_begins_later, piece_ends_sooner], ids=lambda how: how.__name__)
@pytest.mark.parametrize("name", ["triangles bvh", "boxes bvh", "triangles kd"])
def test_references_to_primitives_without_pieces(trees, name, how):
    """Each is [0, inf), and a leaf lists a set."""
    tree = trees[name]
    for k, (broken, _) in enumerate(how(tree)):
        with pytest.raises(fl.InvalidTreeError) as error:
            broken.validate()
        assert (error.value.node, error.value.axiom) == (path_to(tree, k)[0], "axiom 2")


@pytest.mark.parametrize("make", [lambda ends: ends, triangles_on, boxes_of], ids=["lines", "triangles", "boxes"])
def test_a_single_leaf_that_forgets_a_reference(make):
    tree = fl.build(make(named_scene("crossing", 24)), lookahead=0)
    [(broken, _)] = reference_in_no_leaf(tree)
    with pytest.raises(fl.InvalidTreeError) as error:
        broken.validate()
    assert error.value.node == 0


def test_a_broken_tree_without_nodes(trees):
    with pytest.raises(fl.InvalidTreeError, match="node 0 breaks axiom 1: there is no root"):
        unchecked(trees["bvh-cl"], nodes=trees["bvh-cl"].nodes[:0]).validate()


def test_leaves_have_no_children() -> None:
    tree = fl.build(np.random.default_rng(0).uniform(size=(20, 2, 3)))
    assert (tree.left[tree.is_leaf] == -1).all()
    assert (tree.right[tree.is_leaf] == -1).all()
    assert (tree.left[~tree.is_leaf] == np.flatnonzero(~tree.is_leaf) + 1).all()


@pytest.mark.parametrize("name", ["nodes", "refs"])
def test_arrays_that_are_not_contiguous_are_refused_unless_they_are_copied(name: str) -> None:
    tree = fl.build(np.random.default_rng(0).uniform(size=(20, 2, 3)))
    parts = {"nodes": tree.nodes, "refs": tree.refs}
    doubled = np.repeat(parts[name], 2)
    copied = TreeData(tree.geometry, settings=tree.settings, **parts | {name: doubled[::2]})
    assert getattr(copied, name).tobytes() == parts[name].tobytes()
    with pytest.raises(fl.InputError, match=f"{name} are not contiguous"):
        TreeData(tree.geometry, settings=tree.settings, **parts | {name: own(doubled)[::2]})
