"""The executable specification: the thesis's theorems as properties, and the core equal to it node for node."""

import dataclasses
import doctest
import importlib.util
import math
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nasty import SCENES

import fastlines as fl
from fastlines import theory as th

RULES = {"tight": th.tight, "cut": th.cut}
few = settings(max_examples=40, deadline=None, database=None)


def test_examples():
    tried = doctest.testmod(th)
    assert tried.attempted > 0
    assert tried.failed == 0


# ---- Primitives of our own ----


class Ball(NamedTuple):
    """What of a ball lies within a box."""

    id: int
    centre: th.Point
    radius: float
    within: th.Box = th.Box((-math.inf,) * 3, (math.inf,) * 3)

    def gaps(self):
        """Squared distance from the centre to the box, by axis."""
        return [max(lo - x, 0, x - hi) ** 2 for x, lo, hi in zip(self.centre, *self.within, strict=True)]

    def bounds(self):
        gaps = self.gaps()
        reach = [math.sqrt(max(0, self.radius**2 - (sum(gaps) - gap))) for gap in gaps]
        lo = tuple(max(x - r, edge) for x, r, edge in zip(self.centre, reach, self.within.lo, strict=True))
        hi = tuple(min(x + r, edge) for x, r, edge in zip(self.centre, reach, self.within.hi, strict=True))
        return th.Box(lo, hi)

    def clip(self, box):
        block = th.Block(0, self.within).clip(box)
        part = self._replace(within=block.box) if block else None
        return part if part and sum(part.gaps()) <= self.radius**2 else None


class Triangle(NamedTuple):
    """What of a triangle lies within a box, with the arithmetic of primitives/triangles.hpp."""

    id: int
    corners: list[th.Point]
    box: th.Box

    def bounds(self):
        return self.box

    def clip(self, box):
        block = th.Block(0, self.box).clip(box)
        if block is None:
            return None
        polygon = self.corners
        for axis in range(3):
            for sign, plane in ((1.0, block.box.hi[axis]), (-1.0, block.box.lo[axis])):
                kept = []
                for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
                    beyond_a, beyond_b = sign * (a[axis] - plane), sign * (b[axis] - plane)
                    if beyond_a <= 0:
                        kept.append(a)
                    if beyond_a * beyond_b < 0:
                        s = beyond_a / (beyond_a - beyond_b)
                        kept.append(tuple(plane if k == axis else a[k] + s * (b[k] - a[k]) for k in range(3)))
                polygon = kept
        # Round outwards, but to where it was cut.
        lo, hi = list(block.box.lo), list(block.box.hi)
        for k in range(3 if polygon else 0):
            if lo[k] == self.box.lo[k]:
                lo[k] = max(lo[k], outwards(min(point[k] for point in polygon), -1))
            if hi[k] == self.box.hi[k]:
                hi[k] = min(hi[k], outwards(max(point[k] for point in polygon), 1))
        return self._replace(box=th.Box(tuple(lo), tuple(hi)))


def outwards(x: float, sign: int) -> float:
    at = np.float32(x)
    return float(np.nextafter(at, np.float32(sign * np.inf)) if sign * (x - float(at)) > 0 else at)


def a_box(points: list[th.Point]) -> th.Box:
    return th.Box(tuple(map(min, *points)), tuple(map(max, *points)))


# ---- Random trees ----


def scene(name: str, seed: int, n: int) -> Any:
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    return SCENES[name](rng, max(8, n))[:n].astype(np.float32)


SCENE_NAMES = (
    *("random", "crossing", "star", "equal boxes", "axis parallel", "collinear", "flat", "duplicates", "points"),
    *("some points", "nearly points", "single", "outlier", "moved 1e4", "scale 1e-8", "scale 1e8"),
)

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
    kind = draw(st.sampled_from(["segments", "balls", "blocks"]))
    if kind == "balls":
        prims = [Ball(i, tuple(rng.uniform(-1, 1, 3).tolist()), rng.uniform(0, 0.7)) for i in range(n)]
    elif kind == "blocks":
        prims = [th.Block(i, a_box(ends)) for i, ends in enumerate(scene(name, seed, n).tolist())]
    else:
        prims = th.segments(scene(name, seed, n))
    rule = draw(st.sampled_from([th.tight, th.cut]))
    splits = SPLITS[draw(st.sampled_from(sorted(SPLITS)))](rule)
    lookahead = draw(st.sampled_from([0, 1, 1, 2, [1, 2]]))
    c_prim = draw(st.sampled_from([1.0, 0.3, 7.0]))
    c_trav = c_prim * draw(st.sampled_from([0.1, 0.5, 2.0]))
    limits = {"max_depth": draw(st.integers(1, 6)), "leaf_refs": draw(st.integers(0, 2))}
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


@few
@given(a_setting())
def test_a_deeper_search_never_finds_less(setting):
    box = th.hull(setting.prims)
    found = [th.best_split(setting.prims, box, setting.splits, k, *setting.costs)[0] for k in range(3)]
    assert found == sorted(found, reverse=True)
    # The tree keeps what the search promised: each of its nodes is searched again, as deep as the root was.
    for k, cost in enumerate(found):
        tree = setting._replace(lookahead=k).build(max_depth=20, leaf_refs=0)
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


# ---- The core is equal, node for node ----


def theory_splits(given: fl.Settings) -> th.Splits:
    """Translate SPLITS."""
    rule = RULES[given.boxes]

    def translate(split) -> th.Splits:
        options = {"rule": rule, "n_planes": getattr(split, "n_planes", None)}
        names = {"object_sweep": (), "plane_grid": ("n_planes", "rule")}.get(split.name, ("rule",))
        splits = partial(getattr(th, split.name), **{name: options[name] for name in names})
        most = split.max_refs or math.inf
        return lambda prims, box: splits(prims, box) if len(prims) <= most else ()

    return th.union(*map(translate, given.splits))


def theory_build(prims, given: fl.Settings) -> th.Node:
    limits = {name: getattr(given.limits, name) for name in ("max_depth", "leaf_refs", "leaf_size")}
    splits = theory_splits(given)
    return th.build(prims, splits, given.lookahead, given.cost.c_trav, given.cost.c_prim, **limits)


def core_build(geometry, given: fl.Settings) -> fl.Tree:
    """Build without the core's budget of references, which the theory does not know."""
    options = {field.name: getattr(given, field.name) for field in dataclasses.fields(given)}
    return fl.build(geometry, **{**options, "limits": dataclasses.replace(given.limits, max_refs=10**6)})


def assert_equal(tree: fl.Tree, expected: th.Node) -> None:
    """Boxes bit for bit, the same graph, the same pieces in each leaf, the same cost."""
    assert "max_refs" not in tree.limits_hit
    nodes = expected.nodes()
    place = {id(node): number for number, node in enumerate(nodes)}
    assert tree.nodes["right"].tolist() == [place[id(node.right)] if node.right else 0 for node in nodes]
    np.testing.assert_array_equal(tree.nodes["box"], np.array([node.box for node in nodes]))
    for number in np.flatnonzero(tree.is_leaf):
        _, _, first, n = tree.nodes[number]
        pieces = [(prim.id, getattr(prim, "s0", 0.0), getattr(prim, "s1", math.inf)) for prim in nodes[number].prims]
        assert sorted(tree.refs[first : first + n].tolist()) == sorted(pieces)
    assert tree.cost() == th.f(expected, tree.settings.cost.c_trav, tree.settings.cost.c_prim)


Given = fl.Settings
cheap, dear = fl.Cost(c_trav=0.3), fl.Cost(c_trav=3.0, c_prim=4.0)
deep, shallow = fl.Limits(max_depth=6), fl.Limits(max_depth=4)

#: Settings, and how many primitives of a scene Python can afford.
SETTINGS: dict[str, tuple[fl.Settings, int]] = {
    **{
        name: (dataclasses.replace(method, limits=deep), 5 if name.endswith("d2") else 15)
        for name, method in fl.METHODS.items()
    },
    "never split": (Given(lookahead=0), 10),
    "sweep and grid": (Given((fl.ObjectSweep(), fl.PlaneGrid(3)), cost=cheap, limits=deep), 15),
    "grid and sweep, [1, 2]": (
        Given((fl.PlaneGrid(2), fl.ObjectSweep()), lookahead=(1, 2), cost=cheap, limits=deep),
        7,
    ),
    "all sets, 2": (
        Given((fl.PlaneEvents(), fl.Middle(), fl.ObjectSweep(), fl.Median()), lookahead=2, cost=dear, limits=shallow),
        5,
    ),
    "tight events": (Given(fl.PlaneEvents(), cost=cheap, limits=deep), 10),
    "cut events, 2": (Given(fl.PlaneEvents(), "cut", 2, cost=cheap, limits=shallow), 5),
    "tight grid, 3": (Given(fl.PlaneGrid(1), lookahead=3, cost=cheap, limits=shallow), 5),
    "cut grid and middle, [1, 2, 3]": (Given((fl.PlaneGrid(1), fl.Middle()), "cut", (1, 2, 3), cheap, shallow), 6),
    "tight median": (Given(fl.Median(), cost=cheap), 40),
    "cut median": (Given(fl.Median(), "cut", cost=cheap, limits=deep), 30),
    "tight middle": (Given(fl.Middle(), cost=cheap, limits=deep), 30),
    "cut middle, 2": (Given(fl.Middle(), "cut", 2, cost=cheap, limits=deep), 20),
    "max_depth": (Given((fl.PlaneGrid(4), fl.ObjectSweep()), cost=cheap, limits=fl.Limits(max_depth=3)), 20),
    "leaf_refs": (Given(fl.PlaneGrid(4), "cut", cost=cheap, limits=fl.Limits(max_depth=6, leaf_refs=4)), 20),
    "leaf_size": (Given(fl.PlaneGrid(3), cost=cheap, limits=fl.Limits(max_depth=6, leaf_refs=0, leaf_size=0.4)), 12),
    "sets by size": (Given((fl.PlaneGrid(2), fl.ObjectSweep(max_refs=5)), cost=cheap, limits=deep), 15),
    "fine grid": (Given(fl.PlaneGrid(40), cost=fl.Cost(c_trav=1.0), limits=shallow), 5),
}


@pytest.mark.parametrize("name", SCENE_NAMES)
@pytest.mark.parametrize("given", SETTINGS)
def test_core_equals_theory_on_segments(given, name):
    chosen, n = SETTINGS[given]
    ends = scene(name, zlib.crc32(given.encode()), n)
    assert_equal(core_build(ends, chosen), theory_build(th.segments(ends), chosen))


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("method", fl.METHODS)
def test_core_equals_theory_at_other_scales(method, scale):
    ends = scene("crossing", 1, 5) * np.float32(scale)
    assert_equal(core_build(ends, fl.METHODS[method]), theory_build(th.segments(ends), fl.METHODS[method]))


@pytest.mark.parametrize("name", ["random", "crossing", "axis parallel", "equal boxes"])
@pytest.mark.parametrize("given", SETTINGS)
def test_core_equals_theory_on_other_primitives(given, name):
    chosen, n = SETTINGS[given]
    n = min(n, 8)
    seed = zlib.crc32(given.encode())
    ends = scene(name, seed, n)
    third = ends[:, :1] + np.float32(0.3) * np.random.default_rng(seed).normal(size=(n, 1, 3)).astype(np.float32)
    corners = np.concatenate([ends, third], axis=1)

    triangles = [Triangle(i, list(map(tuple, rows)), a_box(rows)) for i, rows in enumerate(corners.tolist())]
    assert_equal(core_build(fl.Triangles(corners), chosen), theory_build(triangles, chosen))

    boxes = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)
    blocks = [th.Block(i, a_box(rows)) for i, rows in enumerate(boxes.tolist())]
    assert_equal(core_build(fl.Boxes(boxes), chosen), theory_build(blocks, chosen))


# ---- §4.3 ----


def test_table_4_3_looking_further_ahead_costs_less():
    path = Path(__file__).parents[1] / "benchmarks" / "table_4_3.py"
    spec = importlib.util.spec_from_file_location("table_4_3", path)
    assert spec is not None
    table = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(table)
    axes = table.cylinders(seed=0)
    assert axes.shape == (100, 2, 3)
    np.testing.assert_allclose(np.linalg.norm(axes[:, 1] - axes[:, 0], axis=1), 1)
    costs = [table.build(axes, depth, c_trav=1.2).cost() for depth in table.DEPTHS]
    assert costs == [100.0, *(pytest.approx(cost, abs=0.05) for cost in (24.5, 24.0, 23.8))]
    assert costs == sorted(costs, reverse=True)
