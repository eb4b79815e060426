"""Deep builds: levels that look bad are gone through with, and taken back where they did not pay."""

from __future__ import annotations

import numpy as np
import pytest
from support.slow import few_of
from support.theory_scenes import SCENE_NAMES, scene

import fastlines as fl

GRID = (fl.PlaneGrid(16), fl.ObjectSweep(max_refs=8))


def least_cost_of_prunings(tree: fl.Tree) -> float:
    """Choose leaf or children at every node, from the bottom up."""
    cost = tree.settings.cost
    nodes = tree.nodes
    low, high = nodes["box"][:, 0].astype(float), nodes["box"][:, 1].astype(float)
    x, y, z = (high - low).T
    area = 2 * (x * y + x * z + y * z)
    n_whole = [len(np.unique(tree.refs["prim"][first : first + n])) for _, _, first, n in nodes.tolist()]
    best = cost.c_prim * np.array(n_whole, float)
    for v in range(len(nodes) - 1, -1, -1):
        if nodes["right"][v]:
            children = [v + 1, int(nodes["right"][v])]
            chance = [area[child] / area[v] if area[v] > 0 else 1.0 for child in children]
            best[v] = min(best[v], cost.c_trav + sum(p * best[c] for p, c in zip(chance, children, strict=True)))
    return float(best[0])


@pytest.mark.parametrize("c_trav", [0.5, 2.0])
@pytest.mark.parametrize("name", few_of(SCENE_NAMES, n=3))
def test_prune_leaves_the_cheapest_of_all_prunings(name: str, c_trav: float) -> None:
    ends = scene(name, 3, 60)
    given = {"splits": GRID, "bad_levels": 3, "cost": fl.Cost(c_trav), "method": "bvh-ss"}
    pruned = fl.build(ends, **given)
    pruned.validate()
    whole = fl.build(ends, prune=False, **given)
    whole.validate()
    assert pruned.cost() <= whole.cost() * (1 + 1e-12)
    least = least_cost_of_prunings(whole)
    if whole.limits_hit:  # references that pruning gives back go to others
        assert pruned.cost() <= least * (1 + 1e-9)
    else:
        assert pruned.cost() == pytest.approx(least, rel=1e-9)


def test_bad_levels_get_past_what_stops_sah() -> None:
    lines = fl.scenes.make("spaghetti", 500).lines
    stopped = fl.build(lines, "bvh-ss")
    deep = fl.build(lines, "bvh-ss", bad_levels=3)
    ahead = fl.build(lines, "bvh-d2")
    assert stopped.n_nodes == 1
    deep.validate()
    assert deep.cost() < 1.02 * ahead.cost() < 0.6 * stopped.cost()


def test_without_bad_levels_the_other_settings_say_nothing() -> None:
    ends = scene("random", 5, 80)
    plain, with_prune = (fl.build(ends, "bvh-d2", prune=prune) for prune in (True, False))
    np.testing.assert_array_equal(plain.nodes, with_prune.nodes)
    np.testing.assert_array_equal(plain.refs, with_prune.refs)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_the_radius_hint_is_in_parts_of_the_scene(scale: float) -> None:
    lines = fl.scenes.make("spaghetti", 300).lines.segments * np.float32(scale)
    trees = [fl.build(lines, "best", splits=fl.BinnedPlanes(8), lanes=1, radius_hint=hint) for hint in (0.0, 0.1)]
    assert trees[1].n_refs < 0.6 * trees[0].n_refs
    for tree in trees:
        tree.validate()
        assert tree.nodes["n_refs"][tree.is_leaf].max() <= 16


@pytest.mark.parametrize("name", SCENE_NAMES)
def test_best_is_a_valid_tree_of_small_leaves(name: str) -> None:
    for ends in (scene(name, 7, 100), np.repeat(scene(name, 7, 3), 100, axis=0)):
        tree = fl.build(ends)
        assert tree.method == "best"
        tree.validate()
        assert tree.nodes["n_refs"][tree.is_leaf].max() <= 16


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"bad_levels": -1}, "bad_levels=-1; expected a whole number"),
        ({"bad_levels": 1.5}, "bad_levels=1.5"),
        ({"prune": 1}, "prune=1; expected True or False"),
        ({"radius_hint": -0.1}, "fraction of the scene's longest side"),
        ({"radius_hint": 2}, "fraction of the scene's longest side"),
        ({"radius_hint": np.nan}, "fraction of the scene's longest side"),
    ],
)
def test_wrong_settings(given: dict[str, object], message: str) -> None:
    with pytest.raises(fl.InputError, match=message):
        fl.build(scene("random", 1, 5), **given)
