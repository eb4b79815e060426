"""The theorems of docs/theory.md that are not from the thesis, as properties."""

import itertools
import math
from functools import partial

import numpy as np
import pytest
from support.slow import few_of
from support.theory_scenes import SCENE_NAMES, Ball, scene

import fastlines as fl
from fastlines import theory as th
from fastlines_bench.studies import optimum as opt
from fastlines_bench.studies.optimum.bound import grown, most_cells, touched

RULES = {"tight": th.tight, "cut": th.cut}
DIAGONALS = [[[0, 0, 0], [8, 8, 8]], [[0, 8, 0], [8, 0, 8]], [[0, 0, 8], [8, 8, 0]], [[8, 0, 0], [0, 8, 8]]]


# ---- 5: pruning ----


def prunings(node):
    """Yield every tree that results if some inner nodes become leaves."""
    yield th.Node(node.prims, node.box)
    if node.left:
        for left, right in itertools.product(list(prunings(node.left)), list(prunings(node.right))):
            yield th.Node(node.prims, node.box, left, right)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", SCENE_NAMES)
def test_the_exact_prune_is_the_cheapest_of_all_prunings(name, rule):
    prims = th.segments(scene(name, 1, 9))
    splits = partial(th.plane_grid, n_planes=2, rule=RULES[rule])
    for c_trav in (0.1, 0.7, 2.0):
        deep = th.build(prims, splits, c_trav=c_trav, bad_levels=9, max_depth=3, leaf_refs=0, pruned=False)
        costs = [th.g(tree, c_trav) for tree in prunings(deep)]
        assert th.g(th.prune(deep, c_trav), c_trav) == pytest.approx(min(costs), rel=1e-12)


# ---- 6: the lower bound ----


@pytest.mark.parametrize("name", few_of(SCENE_NAMES, n=3))
def test_no_tree_is_cheaper_than_the_lower_bound(name):
    ends = scene(name, 5, 40)
    for c_trav in (0.1, 2.0):
        bound = opt.lower_bound(ends, c_trav, n_cells=1 << 12)
        assert min(c_trav, len(ends)) <= bound * (1 + 1e-12)
        for method in fl.METHODS:
            tree = fl.build(ends, method, cost=fl.Cost(c_trav), limits=fl.Limits(max_refs=1000))
            assert bound <= tree.cost() * (1 + 1e-6), method
        whole = opt.lower_bound(ends, c_trav, whole=True, n_cells=1 << 12)
        assert bound <= whole <= fl.build(ends, "bvh-cl", cost=fl.Cost(c_trav)).cost() * (1 + 1e-6)


@pytest.mark.parametrize("seed", few_of(range(3), n=0))
def test_no_optimal_tree_is_cheaper_than_the_lower_bound(seed):
    ends = scene("crossing", seed, 7)
    prims = th.segments(ends)
    planes = opt.even_planes(th.hull(prims), 5)
    for c_trav in (0.02, 0.2, 1.0):
        bound = opt.lower_bound(ends, c_trav, n_cells=1 << 15)
        for rule in RULES.values():
            assert bound <= th.f(opt.grid_optimum(ends, planes, rule, c_trav), c_trav)
        whole = opt.lower_bound(ends, c_trav, whole=True, n_cells=1 << 12)
        assert whole <= th.f(opt.optimum(prims, opt.partitions, c_trav), c_trav) * (1 + 1e-12)


def test_the_lower_bound_grows_as_the_cost_does():
    few, many = (opt.lower_bound(fl.scenes.make("spaghetti", n).lines, n_cells=1 << 21) for n in (500, 8000))
    assert 8 < few < many
    assert 0.3 < math.log(many / few, 16) < 0.7  # the square root
    assert opt.lower_bound(np.zeros((0, 2, 3))) == 0


def test_counts_of_the_lower_bound():
    rng = np.random.default_rng(7)
    ends = rng.random((6, 2, 3))
    marked = touched(ends, 0.1, np.ones(3))
    on = ends[:, :1] + np.linspace(0, 1, 4001)[:, None] * (ends[:, 1:] - ends[:, :1])
    expected = np.zeros_like(marked)
    expected[tuple((on.reshape(-1, 3) / 0.1).astype(int).T)] = True
    assert not (expected & ~marked).any()
    assert marked.sum() <= 1.02 * expected.sum()

    wide = grown(marked, 2)
    assert wide.shape == tuple(n + 4 for n in marked.shape)
    places = np.argwhere(marked) + 2
    near = [(np.abs(places - place).max(1) <= 2).any() for place in np.argwhere(np.ones_like(wide))]
    np.testing.assert_array_equal(wide.ravel(), near)

    for _ in range(300):
        sides = rng.uniform(0.1, 30, 3)
        a, b, c = sides * rng.random(3) ** rng.integers(0, 9)
        area, margin = a * b + a * c + b * c, int(rng.integers(2, 9))
        assert (a + margin) * (b + margin) * (c + margin) <= most_cells(np.array([area]), margin, sides) * (1 + 1e-12)


# ---- 7 and 8: where SAH makes a leaf, and when spatial splits help ----


@pytest.mark.parametrize("name", ["random", "crossing", "flat", "equal boxes", "some points", "balls"])
def test_gain_of_a_plane(name):
    rng = np.random.default_rng(3)
    if name == "balls":
        prims = [Ball(i, tuple(rng.uniform(-1, 1, 3).tolist()), rng.uniform(0, 0.7)) for i in range(9)]
    else:
        prims = th.segments(scene(name, 6, 20))
    box = th.hull(prims)
    splits = {rule: partial(th.plane_grid, n_planes=3, rule=RULES[rule]) for rule in RULES}
    for axis in range(3):
        for plane in opt.even_planes(box, 5)[axis]:
            for split in th.at_plane(prims, box, axis, plane, th.cut):
                cost = 2.0 + sum(th.chance(b, box) * len(p) for p, b in split)
                assert opt.gain(prims, box, axis, plane) == pytest.approx(len(prims) - cost, abs=1e-5)
    gains = [
        opt.gain(prims, box, axis, x) for axis in range(3) for x in opt.even_planes(box, 3)[axis] if box.sides()[axis]
    ]
    assert (len(th.build(prims, splits["cut"]).nodes()) == 1) == (max(gains) <= 0)


@pytest.mark.parametrize("n_each", [1, 7])
def test_sah_makes_one_leaf_of_diagonals(n_each):
    prims = th.segments(DIAGONALS * n_each)
    for c_trav in (1e-3, 2.0):
        for splits in (
            th.object_sweep,
            *(partial(th.plane_grid, n_planes=7, rule=rule) for rule in RULES.values()),
        ):
            assert len(th.build(prims, splits, c_trav=c_trav).nodes()) == 1
        # Two levels pay off from 8·c_trav on, and then halve the cost.
        tree = opt.optimum(prims, opt.planes_at([[4.0]] * 3, th.cut), c_trav)
        n = 4 * n_each
        assert th.f(tree, c_trav) == pytest.approx(min(n, 4 * c_trav + n / 2))


@pytest.mark.parametrize("seed", range(5))
def test_one_leaf_is_the_best_classic_bvh_of_large_boxes(seed):
    ends = scene("crossing", seed, 6)
    prims, box = th.segments(ends), th.hull(th.segments(ends))
    shares = sum(th.chance(prim.bounds(), box) for prim in prims)
    enough = len(prims) - shares
    assert len(opt.optimum(prims, opt.partitions, enough * 1.001).nodes()) == 1
    assert th.f(opt.optimum(prims, opt.partitions, 0.01), 0.01) >= 0.01 + shares


def halved(prims, box, axes):
    """Return the tree of cuts in the middle across the given axes, one level for each."""
    if not axes:
        return th.Node(prims, box)
    split = next(th.at_plane(prims, box, axes[0], box.centre(axes[0]), th.cut))
    return th.Node(prims, box, *(halved(*part, axes[1:]) for part in split))


@pytest.mark.parametrize("sides", [(1, 1, 1), (1, 3, 20), (5, 5, 0.01)])
@pytest.mark.parametrize("name", ["random", "crossing", "spaghetti"])
def test_any_segments_have_a_tree_of_the_root_of_their_number(name, sides):
    ends = fl.scenes.make("spaghetti", 90).lines.segments if name == "spaghetti" else scene(name, 8, 90)
    prims = th.segments(ends * np.float32(sides))
    box = th.hull(prims)
    longest_first = sorted(range(3), key=lambda axis: -box.sides()[axis])
    for j, c_trav in itertools.product((1, 2, 3), (0.1, 1.0)):
        k = 2**j
        tree = halved(prims, box, longest_first * j)
        bound = 4 * (k - 1) * c_trav + len(prims) * (3 * k - 2) / k**2
        assert th.g(tree, c_trav) <= bound * (1 + 1e-6)
        if j == 2 and len(prims) > 32 * c_trav:
            assert th.g(tree, c_trav) < len(prims)


# ---- 9: bounds of a search ----


@pytest.mark.parametrize("name", SCENE_NAMES)
def test_no_search_beats_its_bounds(name):
    prims = th.segments(scene(name, 9, 12))
    box = th.hull(prims)
    planes = opt.even_planes(box, 3)
    for rule, lookahead, c_trav in itertools.product(RULES.values(), (1, 2), (0.1, 2.0)):
        few = prims if lookahead == 1 else prims[:6]
        found, _ = th.best_split(few, box, opt.planes_at(planes, rule), lookahead, c_trav, 1.0)
        for n_witnesses in (0, 1, 3, len(few)):
            least = opt.at_least(few, box, planes, few[:n_witnesses], lookahead, c_trav, rule=rule)
            assert least <= found * (1 + 1e-12)
        if lookahead == 1 and box.area() > 0:
            assert least == pytest.approx(found, rel=1e-12)
        if rule is th.cut:
            assert opt.at_least_cut(few, box, lookahead, c_trav) <= found * (1 + 1e-12)


def test_the_bounds_of_a_search_are_far_above_one_step():
    prims = th.segments(fl.scenes.make("spaghetti", 200).lines.segments)
    box = th.hull(prims)
    planes = opt.even_planes(box, 8)
    assert th.best_split(prims, box, opt.planes_at(planes, th.tight), 1, 2.0, 1.0)[0] == 200
    assert opt.at_least_cut(prims, box, 1) > 100
    assert opt.at_least(prims, box, planes, prims[:8], 1) > 100


@pytest.mark.parametrize("n_planes", [1, 3, 4])
@pytest.mark.parametrize("name", few_of(SCENE_NAMES, n=2))
def test_no_search_below_a_split_beats_the_bounds_of_pairs(name, n_planes):
    prims = th.segments(scene(name, 11, 10))
    box = th.hull(prims)
    grid = partial(th.plane_grid, n_planes=n_planes, rule=th.cut)
    for axis, (side, lo) in enumerate(zip(box.sides(), box.lo, strict=True)):
        for i in range(1, n_planes + 1):
            plane = th.f32(lo + side * i / (n_planes + 1))
            for children in th.at_plane(prims, box, axis, plane, th.cut):
                for lookahead, c_trav in itertools.product((1, 2) if n_planes < 4 else (1,), (0.1, 1.0)):
                    least = opt.at_least_of_pairs(prims, box, axis, plane, n_planes, lookahead, c_trav)
                    for (part, half), bound in zip(children, least, strict=True):
                        assert bound <= th.best_split(part, half, grid, lookahead, c_trav, 1.0)[0] * (1 + 1e-6)


def test_the_bounds_of_pairs_are_near_the_search():
    prims = th.segments(fl.scenes.make("spaghetti", 150).lines.segments)
    box = th.hull(prims)
    grid = partial(th.plane_grid, n_planes=5, rule=th.cut)
    shares = []
    for axis, i in itertools.product(range(3), range(1, 6)):
        plane = th.f32(box.lo[axis] + box.sides()[axis] * i / 6)
        ((left, low), _) = next(th.at_plane(prims, box, axis, plane, th.cut))
        least, _ = opt.at_least_of_pairs(prims, box, axis, plane, 5, 1, 0.1)
        shares.append(least / th.best_split(left, low, grid, 1, 0.1, 1.0)[0])
    assert min(shares) > 0.7
    assert max(shares) <= 1 + 1e-6
