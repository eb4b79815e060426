"""The executable specification: the thesis's theorems as properties."""

import doctest
import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.theory_scenes import SCENE_NAMES, Ball, a_box, scene

import fastlines as fl
from fastlines import theory as th

RULES = {"tight": th.tight, "cut": th.cut}
few = settings(max_examples=30, deadline=None, database=None, derandomize=True)


def test_examples():
    tried = doctest.testmod(th)
    assert tried.attempted > 0
    assert tried.failed == 0


def test_a_tree_prints_as_one_line():
    apart = [[[x, 0, 0], [x + 0.5, 1, 1]] for x in range(30)]
    tree = th.build(th.segments(apart), th.object_sweep)
    assert len(tree.nodes()) > 2
    assert repr(tree) == f"<Node: 30 primitives, {len(tree.nodes())} nodes at and below it>"


# ---- Random trees ----

SPLITS: dict[str, Callable[[th.BoxRule], th.Splits]] = {
    "grid": lambda rule: partial(th.plane_grid, n_planes=2, rule=rule),
    "events": lambda rule: partial(th.plane_events, rule=rule),
    "median": lambda rule: partial(th.median, rule=rule),
    "middle": lambda rule: partial(th.middle, rule=rule),
    "sweep": lambda rule: th.object_sweep if rule is th.tight else partial(th.median, rule=rule),
    "two": lambda rule: th.union(partial(th.middle, rule=rule), partial(th.plane_grid, n_planes=1, rule=rule)),
}


class Setting(NamedTuple):
    prims: list[Any]
    rule: th.BoxRule
    splits: th.Splits
    lookahead: Any
    c_trav: float
    c_prim: float
    limits: dict[str, Any]

    def build(self, scale=1.0, **limits):
        costs = self.c_trav * scale, self.c_prim * scale
        return th.build(self.prims, self.splits, self.lookahead, *costs, **{**self.limits, **limits})

    @property
    def costs(self):
        return self.c_trav, self.c_prim


@st.composite
def a_setting(draw) -> Setting:
    seed, name = draw(st.integers(0, 999)), draw(st.sampled_from(SCENE_NAMES))
    rng = np.random.default_rng(seed)
    n = draw(st.integers(1, 7))
    kind = draw(st.sampled_from(["segments", "balls", "blocks", "cones"]))
    if kind == "balls":
        prims = [Ball(i, tuple(rng.uniform(-1, 1, 3).tolist()), rng.uniform(0, 0.7)) for i in range(n)]
    elif kind == "blocks":
        prims = [th.Block(i, a_box(ends)) for i, ends in enumerate(scene(name, seed, n).tolist())]
    elif kind == "cones":
        n = min(n, 4)  # slow to clip
        ends = scene(name, seed, n)
        prims = th.cones(ends, rng.choice([0, 0.1, 1], (n, 2)) * rng.random((n, 2)) * np.ptp(ends))
    else:
        prims = th.segments(scene(name, seed, n))
    rule = draw(st.sampled_from([th.tight, th.cut]))
    splits = SPLITS[draw(st.sampled_from(sorted(SPLITS)))](rule)
    lookahead = draw(st.sampled_from([0, 1, 1, 2, [1, 2]]))
    c_prim = draw(st.sampled_from([1.0, 0.3, 7.0]))
    c_trav = c_prim * draw(st.sampled_from([0.1, 0.5, 2.0]))
    limits = {"max_depth": draw(st.integers(1, 4)), "leaf_refs": draw(st.integers(0, 2))}
    return Setting(prims, rule, splits, lookahead, c_trav, c_prim, limits)


# ---- Theorems ----


@few
@given(a_setting())
def test_what_is_built_is_a_tree(setting):
    th.check(setting.build(), setting.prims, setting.rule)


@few
@given(a_setting())
def test_theorem_1_recursion_and_sum_agree(setting):
    tree = setting.build()
    assert th.f(tree, *setting.costs) == pytest.approx(th.g(tree, *setting.costs), rel=1e-12)


@few
@given(a_setting(), st.integers(-8, 8), st.floats(0.01, 100))
def test_theorem_2_only_the_ratio_of_costs_matters(setting, exponent, factor):
    tree = setting.build()
    scaled = [cost * factor for cost in setting.costs]
    assert th.f(tree, *scaled) == pytest.approx(factor * th.f(tree, *setting.costs), rel=1e-12)
    # A power of two changes no rounding, so the whole build is the same.
    same = setting.build(scale=2.0**exponent)
    assert [node.box for node in same.nodes()] == [node.box for node in tree.nodes()]


@few
@given(a_setting())
def test_theorem_3_inner_nodes_need_no_lists(setting):
    tree = setting.build()
    costs = th.f(tree, *setting.costs), th.g(tree, *setting.costs)
    for node in tree.nodes():
        if node.left:
            node.prims = []
    assert (th.f(tree, *setting.costs), th.g(tree, *setting.costs)) == costs


@few
@given(a_setting())
def test_theorem_4_a_primitive_outside_a_leaf_only_costs(setting):
    tree = setting.build()
    cost = th.f(tree, *setting.costs)
    for number, node in enumerate(tree.nodes()):
        outside = [p for p in setting.prims if p.clip(node.box) is None]
        if node.left or not outside or node.box.area() == 0:
            continue
        node.prims = [*node.prims, outside[0]]
        more = th.chance(node.box, tree.box) * setting.c_prim
        assert th.f(tree, *setting.costs) == pytest.approx(cost + more, rel=1e-9)
        with pytest.raises(fl.InvalidTreeError) as error:
            th.check(tree, setting.prims, setting.rule)
        assert (error.value.node, error.value.axiom) == (number, "Theorem 4")
        node.prims = node.prims[:-1]


@few
@given(a_setting())
def test_lookahead_1_is_sah(setting):
    prims, box = setting.prims, th.hull(setting.prims)
    c_trav, c_prim = setting.costs
    cost, split = th.best_split(prims, box, setting.splits, 1, c_trav, c_prim)
    splits = setting.splits(prims, box) if box.area() > 0 else []
    sah = [c_trav + sum(b.area() / box.area() * len(p) * c_prim for p, b in split) for split in splits]
    assert cost == pytest.approx(min([len(prims) * c_prim, *sah]), rel=1e-12)
    assert (split is None) == (cost == len(prims) * c_prim)


def depth(node):
    return 1 + max(depth(node.left), depth(node.right)) if node.left else 0


@few
@given(a_setting())
def test_a_deeper_search_never_finds_less(setting):
    box = th.hull(setting.prims)
    found = [th.best_split(setting.prims, box, setting.splits, k, *setting.costs)[0] for k in range(3)]
    assert found == sorted(found, reverse=True)
    # The tree keeps what the search promised: each of its nodes is searched again, as deep as the root was.
    for k, cost in enumerate(found):
        tree = setting._replace(lookahead=k).build(max_depth=9, leaf_refs=0)
        if depth(tree) < 9:  # else a node at the limit could not keep it
            assert th.f(tree, *setting.costs) <= cost * (1 + 1e-12)


# ---- Trees that are broken on purpose ----

CROSSING = th.segments([[[0, 0, 0], [8, 8, 8]], [[0, 8, 0], [8, 0, 8]], [[0, 0, 8], [8, 8, 0]], [[8, 0, 0], [0, 8, 8]]])


def broken(tree: th.Node, rule: th.BoxRule, how: str) -> int:
    """Break a tree and return the place of the node that should be blamed."""
    nodes = tree.nodes()
    number = next(i for i, node in enumerate(nodes) if node.left and not node.left.left)
    node, leaf = nodes[number], nodes[number].left
    lo, hi = leaf.box
    if how == "one child":
        node.right = None
    elif how == "two parents":
        node.right = leaf
        return number + 2  # where it is met again
    elif how == "no primitive":
        leaf.prims = [*leaf.prims, leaf.prims[0]._replace(id=99)]
        return number + 1
    elif how == "twice":
        leaf.prims = [*leaf.prims, leaf.prims[0]]
        return number + 1
    elif how == "NaN":
        leaf.box = th.Box(lo, (math.nan, *hi[1:]))
        return number + 1
    elif how == "inverted":
        leaf.box = th.Box(hi, lo)
        return number + 1
    elif how == "root too large":
        tree.box = th.Box((-1.0, *tree.box.lo[1:]), tree.box.hi)
        return 0
    elif how == "root too short a list":
        tree.prims = tree.prims[1:]
        return 0
    elif how == "sticks out":
        node.box, _ = node.box.split(0, node.left.box.hi[0] - 0.1)
        node.prims = [part for prim in node.prims if (part := prim.clip(node.box))]
    elif how == "lost":
        leaf.prims = leaf.prims[1:]
    elif how == "lost a piece":
        leaf.prims = [leaf.prims[0].cut(0, (lo[0] + hi[0]) / 2)[0], *leaf.prims[1:]]
    elif how == "more than the parent":
        node.prims = node.prims[1:]
    elif how == "loose":
        leaf.box = th.Box(lo, (*hi[:2], hi[2] + 0.5))
        return number + 1
    elif how == "gap":
        axis = next(k for k in range(3) if leaf.box.hi[k] < node.box.hi[k])
        leaf.box, _ = leaf.box.split(axis, leaf.box.hi[axis] - 0.01)
    return number


@pytest.mark.parametrize(
    ("how", "rule", "axiom"),
    [
        ("one child", "any", "axiom 1"),
        ("two parents", "any", "axiom 1"),
        ("no primitive", "any", "axiom 2"),
        ("twice", "any", "axiom 2"),
        ("NaN", "any", "axiom 2"),
        ("inverted", "any", "axiom 2"),
        ("root too large", "any", "axiom 3"),
        ("root too short a list", "any", "axiom 3"),
        ("sticks out", "any", "axiom 4"),
        ("lost", "any", "axiom 5"),
        ("lost a piece", "any", "axiom 5"),
        ("more than the parent", "any", "axiom 5"),
        ("loose", "tight", "BVH axiom"),
        ("gap", "cut", "KD axiom"),
        ("gap", "any", "axiom 5"),
    ],
)
def test_check_names_the_node_and_the_axiom(how, rule, axiom):
    built_by = th.tight if rule == "tight" else th.cut
    tree = th.build(CROSSING, partial(th.plane_grid, n_planes=1, rule=built_by), 2, c_trav=0.2)
    assert len(tree.nodes()) >= 7
    th.check(tree, CROSSING, RULES.get(rule))
    number = broken(tree, built_by, how)
    with pytest.raises(fl.InvalidTreeError) as error:
        th.check(tree, CROSSING, RULES.get(rule))
    assert (error.value.node, error.value.axiom) == (number, axiom), error.value


def test_a_leaf_is_a_bvh_and_a_kd_tree():
    tree = th.Node(CROSSING, th.hull(CROSSING))
    th.check(tree, CROSSING, th.tight)
    th.check(tree, CROSSING, th.cut)
