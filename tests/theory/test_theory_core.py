"""The C++ core equals the executable specification, node for node; and the table of thesis §4.3."""

import dataclasses
import math
import zlib
from functools import partial

import numpy as np
import pytest
from support.slow import few_of
from support.theory_scenes import SCENE_NAMES, Triangle, a_box, scene

import fastlines as fl
from fastlines import theory as th
from fastlines.settings.methods import THESIS_METHODS

RULES = {"tight": th.tight, "cut": th.cut}


def theory_splits(given: fl.Settings) -> th.Splits:
    """Translate SPLITS."""
    rule = RULES[given.boxes]

    def translate(split) -> th.Splits:
        options = {"rule": rule, "n_planes": getattr(split, "n_planes", None)}
        names = {"object_sweep": (), "plane_grid": ("n_planes", "rule")}.get(split.name, ("rule",))
        splits = partial(
            getattr(th, {"midpoint": "middle"}.get(split.name, split.name)), **{name: options[name] for name in names}
        )
        most = split.max_refs or math.inf
        return lambda prims, box: splits(prims, box) if len(prims) <= most else ()

    return th.union(*map(translate, given.splits))


def theory_build(prims, given: fl.Settings) -> th.Node:
    limits = {name: getattr(given.limits, name) for name in ("max_depth", "leaf_refs", "leaf_size")}
    splits = theory_splits(given)
    levels = {"bad_levels": given.bad_levels, "pruned": given.prune}
    return th.build(prims, splits, given.lookahead, given.cost.c_trav, given.cost.c_prim, **limits, **levels)


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
        # max_leaf_refs and the radius hint are the core's own; tests/build/test_deep_build.py
        if name not in ("best", "beams")
    },
    "never split": (Given(lookahead=0), 10),
    "sweep and grid": (Given((fl.ObjectSweep(), fl.PlaneGrid(3)), cost=cheap, limits=deep), 15),
    "grid and sweep, [1, 2]": (
        Given((fl.PlaneGrid(2), fl.ObjectSweep()), lookahead=(1, 2), cost=cheap, limits=deep),
        7,
    ),
    "all sets, 2": (
        Given((fl.PlaneEvents(), fl.Midpoint(), fl.ObjectSweep(), fl.Median()), lookahead=2, cost=dear, limits=shallow),
        5,
    ),
    "tight events": (Given(fl.PlaneEvents(), cost=cheap, limits=deep), 10),
    "cut events, 2": (Given(fl.PlaneEvents(), "cut", 2, cost=cheap, limits=shallow), 5),
    "tight grid, 3": (Given(fl.PlaneGrid(1), lookahead=3, cost=cheap, limits=shallow), 5),
    "cut grid and middle, [1, 2, 3]": (Given((fl.PlaneGrid(1), fl.Midpoint()), "cut", (1, 2, 3), cheap, shallow), 6),
    "tight median": (Given(fl.Median(), cost=cheap), 40),
    "cut median": (Given(fl.Median(), "cut", cost=cheap, limits=deep), 30),
    "tight middle": (Given(fl.Midpoint(), cost=cheap, limits=deep), 30),
    "cut middle, 2": (Given(fl.Midpoint(), "cut", 2, cost=cheap, limits=deep), 20),
    "max_depth": (Given((fl.PlaneGrid(4), fl.ObjectSweep()), cost=cheap, limits=fl.Limits(max_depth=3)), 20),
    "leaf_refs": (Given(fl.PlaneGrid(4), "cut", cost=cheap, limits=fl.Limits(max_depth=6, leaf_refs=4)), 20),
    "leaf_size": (Given(fl.PlaneGrid(3), cost=cheap, limits=fl.Limits(max_depth=6, leaf_refs=0, leaf_size=0.4)), 12),
    "sets by size": (Given((fl.PlaneGrid(2), fl.ObjectSweep(max_refs=5)), cost=cheap, limits=deep), 15),
    "bad levels": (Given(fl.PlaneGrid(3), bad_levels=2, limits=deep), 12),
    "bad levels, kept": (Given((fl.PlaneGrid(2), fl.ObjectSweep()), bad_levels=3, prune=False, limits=shallow), 10),
    "bad levels, cut": (Given(fl.PlaneGrid(2), "cut", bad_levels=3, cost=cheap, limits=shallow), 10),
    "bad levels, [1, 2]": (Given(fl.PlaneGrid(1), "cut", (1, 2), bad_levels=1, limits=shallow), 8),
    "bad levels of one split": (Given(fl.Midpoint(), "cut", bad_levels=16, cost=cheap, limits=deep), 12),
    "fine grid": (Given(fl.PlaneGrid(40), cost=fl.Cost(c_trav=1.0), limits=shallow), 5),
}


@pytest.mark.parametrize("name", few_of(SCENE_NAMES, n=3))
@pytest.mark.parametrize("given", SETTINGS)
def test_core_equals_theory_on_segments(given, name):
    chosen, n = SETTINGS[given]
    ends = scene(name, zlib.crc32(given.encode()), n)
    assert_equal(core_build(ends, chosen), theory_build(th.segments(ends), chosen))


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("method", THESIS_METHODS)
def test_core_equals_theory_at_other_scales(method, scale):
    ends = scene("crossing", 1, 5) * np.float32(scale)
    assert_equal(core_build(ends, fl.METHODS[method]), theory_build(th.segments(ends), fl.METHODS[method]))


@pytest.mark.parametrize("name", few_of(["random", "crossing", "axis parallel", "equal boxes"], n=1))
@pytest.mark.parametrize("given", SETTINGS)
def test_core_equals_theory_on_other_primitives(given, name):
    chosen, n = SETTINGS[given]
    n = min(n, 8)
    seed = zlib.crc32(given.encode())
    ends = scene(name, seed, n)
    third = ends[:, :1] + np.float32(0.3) * np.random.default_rng(seed).normal(size=(n, 1, 3)).astype(np.float32)
    corners = np.concatenate([ends, third], axis=1)

    # The core's grid bounds parts of parts: for segments that comes to the same, for triangles nearly.
    if chosen.boxes == "cut" or not any(isinstance(split, fl.PlaneGrid) for split in chosen.splits):
        triangles = [Triangle(i, list(map(tuple, rows)), a_box(rows)) for i, rows in enumerate(corners.tolist())]
        assert_equal(core_build(fl.Triangles(corners), chosen), theory_build(triangles, chosen))

    boxes = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)
    blocks = [th.Block(i, a_box(rows)) for i, rows in enumerate(boxes.tolist())]
    assert_equal(core_build(fl.Boxes(boxes), chosen), theory_build(blocks, chosen))


# ---- §4.3 ----
