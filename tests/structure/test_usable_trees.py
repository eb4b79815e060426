"""What a search relies on, of trees made by hand and in files: what is accepted answers as brute force does."""

from __future__ import annotations

import dataclasses
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.tree_files import RAYS, SEGMENTS, rewritten, saved

import fastlines as fl
from fastlines.structure.tree_data import MAX_DEPTH, NODE, REF


def assert_refused(path: Path, tree: fl.Tree, match: str, **changed: Any) -> None:
    """By hand, and from a file."""
    with pytest.raises(fl.InvalidTreeError, match=match):
        dataclasses.replace(tree, **changed)
    words = {name: array.view(np.uint32).reshape(len(array), -1) for name, array in changed.items()}
    rewritten(tree, path, **words)
    for verify in (True, False):
        with pytest.raises(fl.FileFormatError, match=match):
            fl.load(path, verify=verify)


def assert_answers(tree: fl.Tree, rays: Any, radius: float) -> int:
    """Those of brute force, through the layout and through the tree; tells how many hits there are."""
    right = fl.brute_force(tree.geometry, *rays, radius)
    for kernel in ("auto", "binary"):
        found = tree.all_hits(*rays, radius, kernel=kernel)
        for name in ("offsets", "t", "prim", "u", "distance"):
            assert getattr(found, name).tobytes() == getattr(right, name).tobytes(), (kernel, name)
    return len(right)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["bvh-d2", "kd-d2"])
def test_what_inner_nodes_say_of_references(tmp_path: Path, method: str) -> None:
    tree, _ = saved(tmp_path / "a.flt", method=method)
    for node in np.flatnonzero(~tree.is_leaf):
        for field in ("first_ref", "n_refs"):
            for value in {0, 1, int(tree.nodes[field][node]) + 1, tree.n_refs - 1} - {int(tree.nodes[field][node])}:
                nodes = tree.nodes.copy()
                nodes[field][node] = value
                assert_refused(tmp_path / "a.flt", tree, "axiom 2|axiom 3", nodes=nodes)


@pytest.mark.parametrize("method", ["bvh-cl", "bvh-d2", "kd-d2", "best"])
def test_one_bit_of_a_node(tmp_path: Path, method: str) -> None:
    """Of a node made by hand, each bit is refused, or does not show in answers."""
    tree = fl.build(SEGMENTS, method, limits=fl.Limits(max_leaf_refs=4) if method == "best" else None)
    rng = np.random.default_rng(5)
    n_made = 0
    for _ in range(1500):
        nodes = tree.nodes.copy()
        nodes.view(np.uint8)[rng.integers(nodes.nbytes)] ^= np.uint8(1 << rng.integers(8))
        try:
            made = dataclasses.replace(tree, nodes=nodes)
        except fl.InvalidTreeError:
            continue
        assert_answers(made, RAYS, 0.1)
        n_made += 1
    assert n_made < 400


def test_a_kd_tree_cuts_its_nodes_in_two(tmp_path: Path) -> None:
    """A BVH that says it is a KD tree would be searched by planes that it does not have."""
    tree = fl.build(SEGMENTS, "bvh-d2")
    assert tree.n_nodes > 3
    settings = dataclasses.replace(tree.settings, boxes="cut")
    with pytest.raises(fl.InvalidTreeError, match="KD axiom"):
        dataclasses.replace(tree, settings=settings)
    cut = fl.build(SEGMENTS, "kd-d2")
    node = int(np.flatnonzero(cut.is_leaf[1:] & ~cut.is_leaf[:-1])[0]) + 1
    nodes = cut.nodes.copy()
    nodes["box"][node] = nodes["box"][node - 1]
    assert_refused(tmp_path / "a.flt", cut, "KD axiom", nodes=nodes)


@pytest.mark.parametrize("cut", [1.5, 1.0000001, 1e30])
def test_pieces_lie_between_0_and_1(tmp_path: Path, cut: float) -> None:
    tree = fl.build(SEGMENTS, "bvh-ss", limits=fl.Limits(max_depth=0))
    refs = np.repeat(tree.refs, 2)
    refs["s1"][::2] = refs["s0"][1::2] = cut
    nodes = tree.nodes.copy()
    nodes["n_refs"] = len(refs)
    assert_refused(tmp_path / "a.flt", tree, "axiom 2", nodes=nodes, refs=refs)
    for good in (0.0, 0.5, 1.0):
        refs["s1"][::2] = refs["s0"][1::2] = good
        made = dataclasses.replace(tree, nodes=nodes, refs=refs)
        made.validate()
        assert assert_answers(made, RAYS, 0.1) > 50


def out_of_order(tree: fl.Tree) -> Any:
    """Nodes of the same tree below one more; an empty leaf, its other child, stands in the midst of the first."""
    nodes, right = tree.nodes, int(tree.nodes["right"][0])
    root, left, rest = nodes[:1], nodes[1:right].copy(), nodes[right:].copy()
    for part, by in ((left, 1), (rest, 2)):
        part["right"][part["right"] > 0] += by
    above, again, empty = root.copy(), root.copy(), root.copy()
    above["right"], again["right"] = right + 1, right + 2
    empty["right"], empty["n_refs"], empty["first_ref"] = 0, 0, left["n_refs"][0]
    return np.concatenate([above, again, left, empty, rest])


def test_nodes_stand_in_preorder(tmp_path: Path) -> None:
    tree = fl.build(SEGMENTS, "bvh-cl")
    assert_refused(tmp_path / "a.flt", tree, "axiom [12]", nodes=out_of_order(tree))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_boxes_are_boxes(tmp_path: Path, value: float) -> None:
    tree = fl.build(SEGMENTS, "bvh-cl")
    for node in (0, 1, tree.n_nodes - 1):
        for end in (0, 1):
            nodes = tree.nodes.copy()
            nodes["box"][node, end, 1] = value
            assert_refused(tmp_path / "a.flt", tree, "its box is not a box", nodes=nodes)


@pytest.mark.parametrize("s1", [-np.inf, np.nan, 1.0])
@pytest.mark.parametrize("geometry", [fl.Triangles(SEGMENTS[:, [0, 1, 0]]), fl.Boxes(np.sort(SEGMENTS, axis=1))])
def test_what_is_not_cut_has_no_pieces(tmp_path: Path, geometry: Any, s1: float) -> None:
    tree = fl.build(geometry)
    refs = tree.refs.copy()
    refs["s1"][3] = s1
    assert_refused(tmp_path / "a.flt", tree, "is not a piece", refs=refs)


def chain(n_levels: int, n_refs: int, side: str = "right", per_leaf: int = 0) -> dict[str, Any]:
    """A chain of nodes, each with a leaf of `per_leaf` references beside it; the deepest leaf lists the rest."""
    n_last = n_refs - n_levels * per_leaf
    nodes = np.zeros(2 * n_levels + 1, NODE)
    nodes["box"][:, 1] = 1
    level = np.arange(n_levels)
    if side == "right":
        inner, leaf, last = 2 * level, 2 * level + 1, 2 * n_levels
        nodes["right"][inner] = inner + 2
        nodes["first_ref"][inner] = nodes["first_ref"][leaf] = level * per_leaf
        nodes["first_ref"][last] = n_levels * per_leaf
    else:
        inner, leaf, last = level, 2 * n_levels - level, n_levels
        nodes["right"][inner] = leaf
        nodes["first_ref"][leaf] = n_last + (n_levels - 1 - level) * per_leaf
    nodes["n_refs"][inner] = n_last + (n_levels - level) * per_leaf
    nodes["n_refs"][leaf] = per_leaf
    nodes["n_refs"][last] = n_last
    refs = np.zeros(n_refs, REF)
    refs["prim"] = np.arange(n_refs)
    refs["s1"] = np.inf
    return {"nodes": nodes, "refs": refs}


#: Makes and queries trees as deep as they may be, where stacks are small.
DEEP = """
import pickle, sys
import fastlines as fl

for segments, given in pickle.load(sys.stdin.buffer):
    made = fl.Tree(fl.Lines.from_segments(segments), given["nodes"], given["refs"], fl.Settings())
    for kernel in ("auto", "single", "wave", "bundle", "binary"):
        for rays in (1, 200):
            hits = made.all_hits([[0.5, 0.5, -1]] * rays, [0, 0, 1], 0.1, kernel=kernel)
            assert len(hits) == rays * len(segments), (kernel, len(hits))
    made.validate()
    assert made.refit(segments).count_hits([0.5, 0.5, -1], [0, 0, 1], 0.1) == len(segments)
    assert made.stats()["depth"] == 4096
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs limits on stacks")
def test_as_deep_as_trees_may_be() -> None:
    cases = []
    for n_refs, per_leaf in ((17, 0), (40, 0), (MAX_DEPTH + 1, 1), (2 * MAX_DEPTH + 40, 2)):
        segments = np.tile(np.float32([[0, 0, 0], [1, 1, 1]]), (n_refs, 1, 1))
        cases += [(segments, chain(MAX_DEPTH, n_refs, side, per_leaf)) for side in ("left", "right")]

    def small_stacks() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_STACK, (1 << 19, 1 << 19))

    ended = subprocess.run(
        [sys.executable, "-c", DEEP],
        input=pickle.dumps(cases),
        capture_output=True,
        preexec_fn=small_stacks,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr.decode()[-3000:]


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("n_levels", [MAX_DEPTH + 1, 60_000, 1_000_000])
def test_deeper_trees_are_refused(tmp_path: Path, n_levels: int, side: str) -> None:
    tree = fl.build(np.tile(np.float32([[0, 0, 0], [1, 1, 1]]), (17, 1, 1)))
    assert_refused(tmp_path / "a.flt", tree, f"more than {MAX_DEPTH} levels", **chain(n_levels, 17, side))


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_deepest_trees_are_accepted(side: str) -> None:
    tree = fl.build(np.tile(np.float32([[0, 0, 0], [1, 1, 1]]), (17, 1, 1)))
    made = dataclasses.replace(tree, **chain(MAX_DEPTH, 17, side))
    assert made.stats()["depth"] == MAX_DEPTH
    assert assert_answers(made, ([[0.5, 0.5, -1.0]], [[0.0, 0.0, 1.0]]), 0.1) == 17


@pytest.mark.parametrize("where", [0.0, 10.0, 1e4, 1e7, -1e7])
@pytest.mark.parametrize("method", ["best", "bvh-cl", "bvh-d2"])
def test_boxes_that_are_a_little_too_small(tmp_path: Path, method: str, where: float) -> None:
    """What is accepted as rounding loses no hit, wherever a scene lies."""
    rng = np.random.default_rng(3)
    size = max(1.0, abs(where) * 2e-6)  # a few ulps, far from zero
    ends = (where + size * rng.random((200, 2, 3))).astype(np.float32)
    tree = fl.build(ends, method, limits=fl.Limits(max_leaf_refs=2) if method == "best" else None)
    target = ends.reshape(-1, 3)[rng.integers(0, 400, 1500)].astype(float)
    towards = rng.normal(size=(1500, 3))
    rays = (target - towards * size / np.linalg.norm(towards, axis=1)[:, None], towards)
    leaves = np.flatnonzero(tree.is_leaf)
    n_made = n_refused = 0
    for ulps in (0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4, 8, 16):
        nodes = tree.nodes.copy()
        by = np.float32(ulps) * np.spacing(np.float32(max(abs(where), size)))
        low, high = nodes["box"][leaves].swapaxes(0, 1)
        middle = low + (high - low) / 2
        nodes["box"][leaves] = np.stack([np.minimum(low + by, middle), np.maximum(high - by, middle)], axis=1)
        try:
            made = dataclasses.replace(tree, nodes=nodes)
        except fl.InvalidTreeError:
            n_refused += 1
            continue
        n_made += 1
        for radius in (0.0, 1e-7 * size, 1e-3 * size):
            assert_answers(made, rays, radius)
    assert n_made > 0
    assert n_refused > 0


def triangles(rng: np.random.Generator) -> fl.Triangles:
    corners = rng.random((60, 1, 3)) + rng.normal(0, 0.3, (60, 3, 3))
    corners[::3, :, 2] = corners[::3, :1, 2]  # some lie in a plane that a tree may cut
    return fl.Triangles(corners)


def boxes(rng: np.random.Generator) -> fl.Boxes:
    ends = rng.random((60, 1, 3)) + rng.normal(0, 0.2, (60, 2, 3))
    return fl.Boxes(np.stack([ends.min(axis=1), ends.max(axis=1)], axis=1))


#: Primitives without pieces, which may be in several leaves as a whole.
WHOLE: dict[str, Callable[[np.random.Generator], Any]] = {
    "triangles": triangles,
    "boxes": boxes,
    "spheres": lambda rng: fl.Geometry([fl.Spheres.from_centres(rng.random((60, 3)), rng.random(60) * 0.2)]),
    "several": lambda rng: fl.Geometry(
        [
            triangles(rng),
            fl.Lines.from_segments(rng.random((30, 2, 3)), radius=rng.random((30, 2)) * 0.1),
            fl.Curves.from_bezier(rng.random((5, 4, 3)), 0.02),
        ]
    ),
    "own": lambda rng: Balls(rng.random((60, 3)), rng.random(60) * 0.2),
}


class Balls:
    """A class of the user's own."""

    def __init__(self, centre: np.ndarray, radius: np.ndarray) -> None:
        self.centre, self.radius = centre, radius

    def bounds(self) -> np.ndarray:
        return np.stack([self.centre - self.radius[:, None], self.centre + self.radius[:, None]], axis=1)

    def hit(self, ids: np.ndarray, rays: Any, radius: np.ndarray) -> np.ndarray:
        to, along = self.centre[ids] - rays.origins, rays.directions
        t = (to * along).sum(axis=1) / (along * along).sum(axis=1)
        gap = np.linalg.norm(t[:, None] * along - to, axis=1)
        return np.where(gap <= self.radius[ids] + radius, t, np.inf)


def changed(tree: fl.Tree, rng: np.random.Generator) -> dict[str, Any]:
    """Nodes and references of which one was changed: a hand's slip, or a hair's breadth."""
    nodes, refs = tree.nodes.copy(), tree.refs.copy()
    i, j = rng.integers(len(refs), size=2)
    node = int(rng.choice(np.flatnonzero(~tree.is_leaf)))
    left, right = node + 1, int(nodes["right"][node])
    match rng.integers(6):
        case 0:  # references in each other's leaves
            refs[[i, j]] = refs[[j, i]]
        case 1:  # a reference to another primitive
            refs["prim"][i] = refs["prim"][j]
        case 2:  # the children's boxes in each other's place
            nodes["box"][[left, right]] = nodes["box"][[right, left]]
        case 3:  # a box that is too small
            leaf, axis = rng.choice(np.flatnonzero(tree.is_leaf)), rng.integers(3)
            low, high = nodes["box"][leaf, :, axis]
            nodes["box"][leaf, 0, axis] += (high - low) * rng.choice([1e-7, 1e-3, 0.5, 1])
        case 4:  # another plane: that of another axis, or one beside
            axis = rng.integers(3)
            nodes["box"][[left, right]] = nodes["box"][node]
            nodes["box"][left, 1, axis] = nodes["box"][right, 0, axis] = nodes["box"][node, :, axis].mean()
        case 5:  # a reference fewer
            leaves = (nodes["first_ref"] <= i) & (i < nodes["first_ref"] + nodes["n_refs"])
            nodes["n_refs"][leaves] -= 1
            nodes["first_ref"][nodes["first_ref"] > i] -= 1
            refs = np.delete(refs, i)
    return {"nodes": nodes, "refs": refs}


@pytest.mark.parametrize("method", ["bvh-cl", "bvh-d2", "kd-d2"])
@pytest.mark.parametrize("kind", WHOLE)
def test_whole_primitives_are_covered_by_their_leaves(kind: str, method: str) -> None:
    """What is changed by hand is refused, or does not show in answers."""
    limits = None if method == "kd-d2" else fl.Limits(max_leaf_refs=3)
    n_made = 0
    for seed in range(2):
        rng = np.random.default_rng(seed)
        tree = fl.build(WHOLE[kind](rng), method, limits=limits)
        assert dataclasses.replace(tree) is not tree  # a tree of the builder is accepted
        origins = rng.normal(0.5, 1.5, (150, 3))
        rays = origins, rng.random((150, 3)) - origins
        for _ in range(15):
            try:
                made = dataclasses.replace(tree, **changed(tree, rng))
            except fl.InvalidTreeError:
                continue
            assert_answers(made, rays, 0.01)
            n_made += 1
    assert n_made < 20


def test_references_in_the_wrong_leaves_of_a_kd_tree(tmp_path: Path) -> None:
    tree = fl.build(triangles(np.random.default_rng(0)), "kd-d2")
    refs = tree.refs.copy()
    refs["prim"] = np.roll(refs["prim"], len(refs) // 2)
    tree.save(tmp_path / "a.flt")
    assert_refused(tmp_path / "a.flt", tree, "axiom 5", refs=refs)


def test_a_gap_between_two_leaves_of_a_bvh() -> None:
    """Both leaves list a triangle, and together they reach from end to end, but not over its middle."""
    long = np.float32([[0, 0, 0], [9, 0, 0], [9, 1, 0]])
    small = np.float32([[0, 0, 0], [0.1, 0, 0], [0, 1, 0]])
    geometry = fl.Triangles([long, small, small + np.float32([8.9, 0, 0])])
    nodes, refs = np.zeros(3, NODE), np.zeros(4, REF)
    nodes["right"][0], nodes["n_refs"], nodes["first_ref"][2] = 2, [4, 2, 2], 2
    refs["prim"], refs["s1"] = [0, 1, 0, 2], np.inf
    nodes["box"] = [[[0, 0, 0], [9, 1, 0]], [[0, 0, 0], [4, 1, 0]], [[4, 0, 0], [9, 1, 0]]]
    made = fl.Tree(geometry, nodes, refs, fl.Settings())
    assert made.all_hits([[3.9, 0.1, 1], [4.1, 0.1, 1]], [0, 0, -1]).prim.tolist() == [0, 0]
    nodes["box"][1, 1, 0] = 3.5
    with pytest.raises(fl.InvalidTreeError, match="a part of primitive 0 is in none of the leaves that list it"):
        fl.Tree(geometry, nodes, refs, fl.Settings())
