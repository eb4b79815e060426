"""Insertion-based optimisation: valid trees that cost no more and answer the same, whatever the number of threads."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from support.builds import TO_REINSERT
from support.slow import few_of
from support.theory_scenes import SCENE_NAMES, scene

import fastlines as fl
from fastlines.threads import num_threads


#: Trees to work on: whole lines, pieces, and pieces that object splits have put in any order.
def cost_of_grown_boxes(tree: fl.Tree) -> float:
    """The cost as the search measures it."""
    box = tree.nodes["box"].astype(float)
    x, y, z = (box[:, 1] - box[:, 0] + 2 * tree.settings.radius_hint * (box[0, 1] - box[0, 0]).max()).T
    area = x * y + x * z + y * z
    model = tree.settings.cost
    at = np.where(tree.is_leaf, tree.nodes["n_refs"] * model.c_prim, model.c_trav)
    return float((area / area[0] * at).sum()) if area[0] > 0 else float(at.sum())


def leaves(tree: fl.Tree) -> set[tuple[bytes, bytes]]:
    """The box and the references of each leaf."""
    found = tree.nodes[tree.is_leaf]
    return {(node["box"].tobytes(), tree.refs[node["first_ref"] :][: node["n_refs"]].tobytes()) for node in found}


@pytest.mark.parametrize("name", few_of(SCENE_NAMES, n=4))
@pytest.mark.parametrize("kind", TO_REINSERT)
def test_leaves_move_whole_and_costs_never_grow(kind: str, name: str) -> None:
    ends = scene(name, 11, 150)
    before = fl.build(ends, **TO_REINSERT[kind])
    costs = [cost_of_grown_boxes(before)]
    for rounds in (1, 2, 3, 20):
        tree = fl.build(ends, **TO_REINSERT[kind], reinsertion=rounds)
        tree.validate()
        assert leaves(tree) == leaves(before)
        assert tree.n_nodes == before.n_nodes
        assert tree.stats()["depth"] <= tree.settings.limits.max_depth
        assert tree.cost(by="f") == pytest.approx(tree.cost(by="g"), rel=1e-9)
        costs.append(cost_of_grown_boxes(tree))
    assert all(after <= earlier * (1 + 1e-12) for earlier, after in pairwise(costs))


def test_a_bad_tree_gets_much_better() -> None:
    """Medians of hair leave much to gain; pairs of near lines are found wherever they are."""
    lines = fl.scenes.make("straight-hair", 2000).lines
    bad = fl.build(lines, splits=fl.Median(), cost=fl.Cost(0.1))
    good = fl.build(lines, splits=fl.Median(), cost=fl.Cost(0.1), reinsertion=50)
    assert good.cost() < 0.9 * bad.cost()


def lone_points(rng: np.random.Generator, n: int) -> Any:
    at = rng.uniform(0, 1, (n, 1, 3))
    return np.concatenate([at, at + 1e-3], axis=1).astype(np.float32)


def sum_of_areas(tree: fl.Tree) -> float:
    return float(tree.areas[~tree.is_leaf].sum())


def put(tree: fl.Tree, v: int, x: int) -> float | None:
    """The sum of the areas of the inner nodes once v is beside x, the slow way: by bounding all nodes anew."""
    parent = {int(c): int(i) for i in np.flatnonzero(~tree.is_leaf) for c in (tree.left[i], tree.right[i])}
    children = {int(i): [int(tree.left[i]), int(tree.right[i])] for i in np.flatnonzero(~tree.is_leaf)}
    above = [x]
    while above[-1] in parent:
        above.append(parent[above[-1]])
    if v in above or x == parent[v]:
        return None
    out, root = parent[v], 0
    sibling = next(c for c in children[out] if c != v)
    if out == root:
        root = sibling
    else:
        children[parent[out]] = [sibling if c == out else c for c in children[parent[out]]]
        parent[sibling] = parent[out]
    if x == root:
        root = out
    else:
        children[parent[x]] = [out if c == x else c for c in children[parent[x]]]
    children[out] = [x, v]
    total = 0.0

    def bound(node: int) -> Any:
        nonlocal total
        if node not in children:
            return tree.nodes["box"][node].astype(float)
        a, b = (bound(child) for child in children[node])
        box = np.array([np.minimum(a[0], b[0]), np.maximum(a[1], b[1])])
        d = box[1] - box[0]
        total += 2 * (d[0] * d[1] + d[0] * d[2] + d[1] * d[2])
        return box

    bound(root)
    return total


@pytest.mark.parametrize("seed", few_of(range(8), n=2))
def test_in_the_end_no_single_move_gains(seed: int) -> None:
    """The search finds the best of all places: where it finds none, trying every pair of nodes finds none."""
    rng = np.random.default_rng(seed)
    ends = lone_points(rng, 14) if seed % 2 else rng.uniform(0, 1, (12, 2, 3)).astype(np.float32)
    given = {"splits": fl.Median(), "cost": fl.Cost(1e-3), "limits": fl.Limits(max_leaf_refs=1)}
    before = fl.build(ends, **given)
    after = fl.build(ends, **given, reinsertion=1000)

    def most_gained(tree: fl.Tree) -> float:
        now = sum_of_areas(tree)
        sums = (put(tree, v, x) for v in range(1, tree.n_nodes) for x in range(tree.n_nodes) if v != x)
        return max(now - then for then in sums if then is not None)

    negligible = 2e-9 * before.areas[0]
    assert most_gained(after) <= negligible
    assert (sum_of_areas(after) < sum_of_areas(before)) == (most_gained(before) > negligible)
    assert seed % 2 or most_gained(before) > negligible


@pytest.mark.parametrize("kind", TO_REINSERT)
def test_number_of_threads_does_not_show(kind: str) -> None:
    lines = fl.scenes.make("bun-hair", 3000).lines
    given = {**TO_REINSERT[kind], "limits": fl.Limits(max_refs=20_000)}
    trees = []
    for n_threads in (1, 2, 3, 8):
        with num_threads(n_threads):
            trees.append(fl.build(lines, **given, reinsertion=5))
    for tree in trees[1:]:
        assert tree.nodes.tobytes() == trees[0].nodes.tobytes()
        assert tree.refs.tobytes() == trees[0].refs.tobytes()


@pytest.mark.parametrize("max_depth", [8, 9, 10, 12])
def test_no_node_gets_deeper_than_allowed(max_depth: int) -> None:
    lines = fl.scenes.make("straight-hair", 250).lines
    limits = fl.Limits(max_leaf_refs=1, max_depth=max_depth)
    given = {"splits": fl.Median(), "limits": limits, "cost": fl.Cost(0.01)}
    before = fl.build(lines, **given)
    tree = fl.build(lines, **given, reinsertion=30)
    assert tree.stats()["depth"] <= max_depth
    assert tree.cost() <= before.cost()
    assert tree.limits_hit["max_depth"] > before.limits_hit.get("max_depth", 0)


def test_moves_need_lines_and_tight_boxes() -> None:
    with pytest.raises(fl.InputError, match="those of a KD tree"):
        fl.build([[[0, 0, 0], [1, 1, 1]]], "kd-d2", reinsertion=3)
    with pytest.raises(fl.InputError, match="these are Boxes"):
        fl.build(fl.Boxes([[[0, 0, 0], [1, 1, 1]]]), "bvh-cl", reinsertion=3)
    with pytest.raises(fl.InputError, match="reinsertion=-1; expected a whole number, 0 to 1000"):
        fl.build([[[0, 0, 0], [1, 1, 1]]], reinsertion=-1)


def test_progress_and_files(tmp_path: Any) -> None:
    seen: list[float] = []
    lines = fl.scenes.make("spaghetti", 1500).lines
    tree = fl.build(lines, "bvh-d2", reinsertion=10, progress=seen.append)
    assert seen == sorted(seen)
    assert not seen or seen[-1] <= 1
    tree.save(tmp_path / "a.flt")
    back = fl.load(tmp_path / "a.flt")
    assert back.settings == tree.settings
    back.validate()
