"""The oracle: its trees are valid, and as cheap as the cheapest of all trees by enumeration."""

import itertools
import math

import numpy as np
import pytest
from support.slow import few_of
from support.theory_scenes import scene

from fastlines import theory as th
from fastlines_bench.studies import optimum as opt

RULES = {"tight": th.tight, "cut": th.cut}


def some_planes(prims, *numbers):
    """Return unevenly spaced planes, given their number on each axis."""
    box, rng = th.hull(prims), np.random.default_rng(len(prims))
    shares = [sorted(rng.uniform(0.1, 0.9, n).tolist()) for n in numbers]
    return [[th.f32(lo + side * x) for x in at] for lo, side, at in zip(box.lo, box.sides(), shares, strict=True)]


def trees_of_cells(prims, planes, region, rule):
    """Yield every tree whose splits are at the planes: the contents of a node are clipped from whole primitives."""
    parts = [part for prim in prims if (part := prim.clip(region)) and part.start != part.end]
    box = rule(parts, region)
    if box is None:
        return
    yield th.Node(parts, box)
    for axis in range(3):
        for plane in planes[axis]:
            if region.lo[axis] < plane < region.hi[axis]:
                halves = [list(trees_of_cells(prims, planes, half, rule)) for half in region.split(axis, plane)]
                yield from (th.Node(parts, box, left, right) for left, right in itertools.product(*halves))


def trees_of_sets(prims):
    """Yield every tree of object splits."""
    yield th.Node(prims, th.hull(prims))
    first, *rest = prims
    for n in range(len(rest)):
        for chosen in itertools.combinations(rest, n):
            others = [prim for prim in rest if prim not in chosen]
            for left, right in itertools.product(trees_of_sets([first, *chosen]), list(trees_of_sets(others))):
                yield th.Node(prims, th.hull(prims), left, right)


def trees_of_splits(prims, box, splits):
    """Yield every tree whose splits are among those of a function."""
    yield th.Node(prims, box)
    for split in splits(prims, box):
        halves = [list(trees_of_splits(*part, splits)) for part in split]
        yield from (th.Node(prims, box, left, right) for left, right in itertools.product(*halves))


@pytest.mark.parametrize("c_trav", [0.05, 0.4, 2.0])
@pytest.mark.parametrize("name", ["random", "crossing", "star"])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("numbers", [(1, 1, 1), (2, 1, 0), (0, 0, 4)])
def test_no_tree_over_the_planes_is_cheaper(numbers, rule, name, c_trav):
    ends = scene(name, 1, 4)
    prims = th.segments(ends)
    planes = some_planes(prims, *numbers)
    all_trees = list(trees_of_cells(prims, planes, th.hull(prims), RULES[rule]))
    assert len(all_trees) > 10
    least = min(th.g(tree, c_trav) for tree in all_trees)
    for found in (
        opt.optimum(prims, opt.planes_at(planes, RULES[rule]), c_trav),
        opt.grid_optimum(ends, planes, RULES[rule], c_trav),
    ):
        th.check(found, prims, RULES[rule])
        assert th.g(found, c_trav) == pytest.approx(least, rel=1e-9)


@pytest.mark.parametrize("c_trav", [0.05, 0.4, 2.0])
@pytest.mark.parametrize("name", ["random", "crossing", "equal boxes", "duplicates"])
def test_no_tree_of_sets_is_cheaper(name, c_trav):
    prims = th.segments(scene(name, 2, 5))
    all_trees = list(trees_of_sets(prims))
    assert len(all_trees) == 346  # 1 + 5·41 + 10·2·7, where 1, 2, 7 and 41 are those of 1 to 4
    found = opt.optimum(prims, opt.partitions, c_trav)
    th.check(found, prims, th.tight)
    assert th.g(found, c_trav) == pytest.approx(min(th.g(tree, c_trav) for tree in all_trees), rel=1e-9)


@pytest.mark.parametrize("c_trav", [0.05, 0.4])
def test_no_tree_of_both_kinds_is_cheaper(c_trav):
    prims = th.segments(scene("crossing", 3, 3))
    planes = some_planes(prims, 1, 1, 0)
    splits = th.union(opt.planes_at(planes, th.tight), opt.partitions)
    costs = [th.g(tree, c_trav) for tree in trees_of_splits(prims, th.hull(prims), splits)]
    found = opt.optimum(prims, splits, c_trav)
    assert th.g(found, c_trav) == pytest.approx(min(costs), rel=1e-9)
    for part in (opt.planes_at(planes, th.tight), opt.partitions):
        assert th.f(found, c_trav) <= th.f(opt.optimum(prims, part, c_trav), c_trav) * (1 + 1e-12)


@pytest.mark.parametrize("c_trav", [0.3, 2.0])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", few_of(["random", "crossing", "star", "equal boxes", "flat", "some points"], n=2))
def test_both_solvers_of_a_grid_agree(name, rule, c_trav):
    ends = scene(name, 4, 7)
    prims = th.segments(ends)
    planes = opt.even_planes(th.hull(prims), 3)
    one = opt.optimum(prims, opt.planes_at(planes, RULES[rule]), c_trav)
    other = opt.grid_optimum(ends, planes, RULES[rule], c_trav)
    assert th.f(other, c_trav) == pytest.approx(th.f(one, c_trav), rel=1e-6)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("given", [{}, {"lookahead": 2}, {"lookahead": [1, 2]}, {"bad_levels": 2}])
def test_no_built_tree_of_the_same_splits_is_cheaper(rule, given):
    for seed in range(4):
        prims = th.segments(scene("crossing", seed, 6))
        splits = opt.planes_at(opt.even_planes(th.hull(prims), 2), RULES[rule])
        least = th.f(opt.optimum(prims, splits, 0.4), 0.4)
        built = th.f(th.build(prims, splits, c_trav=0.4, leaf_refs=0, **given), 0.4)
        assert least <= built * (1 + 1e-12)
        assert math.isfinite(built)
