"""How trees of the theory show themselves: one line, a graph, a picture of their levels."""

from __future__ import annotations

import math
import re
from functools import partial
from xml.etree import ElementTree

import numpy as np
import pytest
from support.theory_scenes import SCENE_NAMES, Ball, a_box, scene

import fastlines as fl
from fastlines import theory as th
from fastlines.support.graphviz import DotNode, dot_text
from fastlines.theory.drawing import MAX_BOXES, MAX_LEVELS, MAX_PRIMS

ENDS = np.random.default_rng(7).normal(size=(30, 2, 3))
SEGMENTS = th.segments(ENDS)
SWEEP = th.build(SEGMENTS, th.object_sweep, c_trav=0.2)
CUT = th.build(SEGMENTS, partial(th.middle, rule=th.cut), c_trav=0.2, bad_levels=2, max_depth=7)
CONES = th.cones(ENDS, np.full((30, 2), 0.1))
BLOCKS = [th.Block(i, a_box(ends)) for i, ends in enumerate(ENDS.tolist())]
SCALES = 1.0, -1.23456789e-38, 1e30


# --- One line ---


def reachable(thing, seen: dict[int, object]) -> dict[int, object]:
    """Collect what a thing holds, and what that holds."""
    if id(thing) not in seen and not isinstance(thing, int | float | str | type(None)):
        seen[id(thing)] = thing
        for part in thing if isinstance(thing, list | tuple) else getattr(thing, "__dict__", {}).values():
            reachable(part, seen)
    return seen


@pytest.mark.parametrize("scale", SCALES)
def test_everything_prints_as_a_short_line(scale):
    ends = np.float32(scale) * ENDS
    prims = th.segments(ends)
    tree = th.build(prims, partial(th.plane_grid, n_planes=3), 1, c_trav=0.2)
    best = th.best_split(prims, tree.box, partial(th.plane_grid, n_planes=3), 1, 0.2, 1.0)
    cones = th.cones(ends, abs(np.float32(scale)) * np.ones((30, 2)))
    parts = [cone.clip(half) for cone in cones for half in tree.box.split(0, tree.box.centre(0))]
    blocks = [th.Block(10**9 + i, a_box(pair)) for i, pair in enumerate(ends.tolist())]
    splits = [*th.object_sweep(prims, tree.box), *th.plane_events(prims, tree.box), th.Best(1.0, None)]
    found = reachable([tree, best, cones, parts, blocks, splits], {}).values()
    public = {kind for name in th.__all__ if isinstance(kind := getattr(th, name), type)} - {th.Primitive}
    assert public <= {type(thing) for thing in found} == public | {list, tuple}
    for thing in found:
        if type(thing) in public:
            assert len(repr(thing)) <= 200
            assert "\n" not in repr(thing)


def test_what_the_lines_say():
    (segment,) = th.segments([[[0, 0, 0], [1, 2, 4]]])
    assert repr(segment) == "<Segment 0: (0, 0, 0) to (1, 2, 4)>"
    assert repr(segment.cut(0, 0.25)[0]) == "<Segment 0: (0, 0, 0) to (0.25, 0.5, 1), s from 0 to 0.25>"
    (cone,) = th.cones([[[0, 0, 0], [4, 0, 0]]], [[1, 2]])
    assert repr(cone) == "<Cone 0: radius 1 to 2, its part in the box (-1, -2, -2) to (6, 2, 2)>"
    split = th.at_object(SEGMENTS, 10)
    assert repr(split).startswith("<Split: 10 and 20 primitives, in boxes of area ")
    assert split == ((SEGMENTS[:10], th.hull(SEGMENTS[:10])), (SEGMENTS[10:], th.hull(SEGMENTS[10:])))
    assert repr(th.Best(2.0, None)) == "<Best: cost 2, a leaf>"
    assert repr(th.Node(SEGMENTS[:1], th.hull(SEGMENTS[:1]))) == "<Node: 1 primitive, 1 node at and below it>"


def test_a_split_may_be_a_plain_tuple():
    def plain(prims, box):
        yield from ((left, right) for left, right in th.object_sweep(prims, box))

    assert th.best_split(SEGMENTS, SWEEP.box, plain, 1, 0.2, 1.0) == th.best_split(
        SEGMENTS, SWEEP.box, th.object_sweep, 1, 0.2, 1.0
    )
    assert len(th.build(SEGMENTS, plain, c_trav=0.2).nodes()) == len(SWEEP.nodes())


# --- Graphs ---

NODE = re.compile(r'  n(\d+) \[label="((?:[^"\\]|\\.)*)"((?:, \w+=\w+)*)\]')
EDGE = re.compile(r"  n(\d+) -> n(\d+)")


def parse(dot: str) -> tuple[str, dict[int, tuple[str, str]], list[tuple[int, int]]]:
    """Read a graph: its caption, its nodes and its edges."""
    first, caption, shape, *lines, last, end = dot.split("\n")
    assert (first, last, end) == ("digraph tree {", "}", "")
    assert shape == "  node [shape=box]"
    (text,) = re.fullmatch(r'  graph \[label="((?:[^"\\]|\\.)*)"\]', caption).groups()
    nodes, edges = {}, []
    for line in lines:
        if found := EDGE.fullmatch(line):
            edges.append(tuple(map(int, found.groups())))
        else:
            number, label, more = NODE.fullmatch(line).groups()
            nodes[int(number)] = label, more
    assert {end for edge in edges for end in edge} <= nodes.keys()
    assert [child for _, child in edges] == [number for number in nodes if number != 0]
    return text, nodes, edges


@pytest.mark.parametrize("tree", [SWEEP, CUT, fl.build(ENDS, "kd-d2"), fl.build(ENDS, "bvh-cl", cost=fl.Cost(0.2))])
def test_a_graph_has_all_nodes(tree):
    text, nodes, edges = parse(tree.to_dot(max_level=None))
    n_nodes = len(tree.nodes()) if isinstance(tree, th.Node) else tree.n_nodes
    assert text.endswith(f"a tree of 30 primitives: {n_nodes} nodes")
    assert [*nodes] == [*range(n_nodes)]
    assert len(edges) == n_nodes - 1
    leaves = [number for number, (_, more) in nodes.items() if "ellipse" in more]
    assert len(leaves) == (n_nodes + 1) // 2
    if isinstance(tree, th.Node):
        assert leaves == [number for number, node in enumerate(tree.nodes()) if not node.left]
    else:
        assert leaves == np.flatnonzero(tree.is_leaf).tolist()
        assert sorted(edges) == sorted(
            (parent, int(child))
            for parent in np.flatnonzero(~tree.is_leaf).tolist()
            for child in (tree.left[parent], tree.right[parent])
        )


@pytest.mark.parametrize("tree", [CUT, fl.build(ENDS, "kd-d2")])
def test_the_levels_of_a_graph_are_limited(tree):
    whole, by_level = parse(tree.to_dot(max_level=None))[1], [len(level) for level in tree.levels()]
    for level in range(len(by_level)):
        text, nodes, edges = parse(tree.to_dot(max_level=level))
        assert len(nodes) == sum(by_level[: level + 1]) == len(edges) + 1
        n_left_out = len(whole) - len(nodes)
        assert ("left out" in text) == (n_left_out > 0)
        assert f"{n_left_out:,} are left out" in text or n_left_out == 0
        below = [int(found[1]) for label, _ in nodes.values() if (found := re.search(r"n(\d+) nodes? below", label))]
        assert sum(below) == n_left_out
        assert {number: whole[number][0] for number in nodes} == {
            number: re.sub(r"\\n\d+ nodes? below", "", label) for number, (label, _) in nodes.items()
        }
    with pytest.raises(fl.InputError, match="max_level=-1"):
        tree.to_dot(max_level=-1)


def test_a_graph_has_the_costs():
    _, nodes, _ = parse(CUT.to_dot(c_trav=0.2, max_level=None))
    for (label, _), node in zip(nodes.values(), CUT.nodes(), strict=True):
        assert f"cost {th.f(node, 0.2):.4g}, area {node.box.area():.4g}" in label
    tree = fl.build(ENDS, "kd-d2")
    label, _ = parse(tree.to_dot())[1][0]
    assert f"{tree.n_refs} references\\ncost {tree.cost():.4g}" in label


def test_graphs_of_nothing_and_of_a_deep_tree():
    assert len(parse(fl.build(np.empty((0, 2, 3))).to_dot())[1]) == 1
    deep = fl.build(2.0 ** -np.arange(60)[:, None, None] * np.array([[0, 0, 0], [1, 1, 1]]), "kd-cl")
    assert len(parse(deep.to_dot(max_level=None))[1]) == deep.n_nodes


def test_labels_are_quoted():
    evil = 'a "quoted" \\ name\nand [more]'
    text, nodes, _ = parse(dot_text(evil, [DotNode(0, None, [evil], True, 0)]))
    assert text == r"a \"quoted\" \\ name\nand [more]: 1 node"
    assert nodes[0][0] == r"0: a \"quoted\" \\ name\nand [more]"


# --- Pictures of levels ---

SVG = "{http://www.w3.org/2000/svg}"


def picture(tree) -> ElementTree.Element:
    return ElementTree.fromstring(tree._repr_svg_())


@pytest.mark.parametrize("tree", [SWEEP, CUT, th.Node(CONES, th.hull(CONES)), th.Node(BLOCKS, th.hull(BLOCKS))])
def test_a_picture_has_a_panel_for_each_level(tree):
    levels = tree.levels()
    assert [node for level in levels for node in level if not node.left]
    root = picture(tree)
    assert root.find(f"{SVG}title").text == repr(tree)
    titles = [text.text for text in root.iter(f"{SVG}text")]
    for i, level in enumerate(levels[:MAX_LEVELS]):
        assert titles[i].startswith(f"level {i} · {len(level)} node")
    assert len(root.findall(f"{SVG}g")) == min(MAX_LEVELS, len(levels))
    assert {element.tag.removeprefix(SVG) for element in root.iter()} == {"svg", "title", "rect", "g", "text", "path"}
    assert not [element for element in root.iter() if "id" in element.attrib]


def test_a_picture_of_a_large_tree_is_small():
    prims = th.segments(np.random.default_rng(1).random((400, 2, 3)))
    tree = th.build(prims, partial(th.middle, rule=th.cut), c_trav=0.2, bad_levels=9, max_depth=8)
    assert len(tree.nodes()) > 400
    svg = tree._repr_svg_()
    assert len(svg) < 60_000
    assert f"{MAX_PRIMS} of 400 primitives" in svg
    for panel in picture(tree).findall(f"{SVG}g"):
        assert len([*panel.iter(f"{SVG}rect")]) <= 2 * MAX_BOXES


@pytest.mark.parametrize("name", SCENE_NAMES)
def test_odd_scenes_have_pictures(name):
    prims = th.segments(scene(name, 1, 6))
    for some in (prims, prims[:1], [Ball(0, (0.0, 0.0, 0.0), 1.0)]):
        root = picture(th.build(some, th.object_sweep, c_trav=0.2))
        assert "nan" not in ElementTree.tostring(root, encoding="unicode")


def test_a_broken_tree_has_a_picture_or_none():
    box = th.hull(SEGMENTS)
    strange = th.Box((math.nan, 0.0, 0.0), (1.0, math.inf, 1.0))
    assert th.Node(SEGMENTS, strange)._repr_svg_() is None
    inner = th.Node(SEGMENTS, box, th.Node(SEGMENTS, strange), th.Node([], box))
    assert len([*picture(inner).iter(f"{SVG}rect")]) == 3
