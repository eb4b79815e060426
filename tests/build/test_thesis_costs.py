"""The costs of the thesis's tables on its hardest scenes: what each named tree must reach."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

import fastlines as fl

#: Scene, method, least and largest cost, number of nodes if the thesis gives it. Random scenes are not its very scenes.
COSTS = [
    ("spaghetti", "bvh-cl", 0.95 * 1331, 1.05 * 1331, None),
    ("spaghetti", "bvh-ss", 2000, 2000, 1),
    ("spaghetti", "bvh-d2", 0, 287, None),
    ("spaghetti", "kd-cl", 2000, 2000, 1),
    ("spaghetti", "kd-d2", 0, 142, None),
    ("spaghetti-2", "bvh-cl", 0.95 * 4925, 1.05 * 4925, None),
    ("spaghetti-2", "bvh-ss", 8000, 8000, 1),
    ("spaghetti-2", "kd-cl", 8000, 8000, 1),
]


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "method", "least", "largest", "n_nodes"), COSTS)
def test_cost(scene: str, method: str, least: float, largest: float, n_nodes: int | None) -> None:
    tree = fl.build(fl.scenes.make(scene, seed=0).lines, method)
    assert tree.settings.cost.c_prim == 1
    assert least <= tree.cost() <= largest
    assert math.isclose(tree.cost(by="f"), tree.cost(by="g"), rel_tol=1e-9)
    assert n_nodes is None or tree.n_nodes == n_nodes


@pytest.mark.parametrize(("deep", "flat"), [("bvh-d2", "bvh-ss"), ("kd-d2", "kd-cl")])
def test_depth_two_is_the_second_level_alone(deep: str, flat: str) -> None:
    """§5: the same SPLITS, so on hair, where one level suffices, the same tree but for little."""
    assert fl.METHODS[deep] == replace(fl.METHODS[flat], lookahead=(1, 2))
    lines = fl.scenes.make("straight-hair", 4000).lines
    assert 0.97 < fl.build(lines, deep).cost() / fl.build(lines, flat).cost() <= 1


def test_bad_levels_are_cheaper_than_looking_ahead() -> None:
    """The figure of docs/builder.md."""
    splits = (fl.PlaneGrid(16), fl.ObjectSweep(max_refs=8))
    tree = fl.build(fl.scenes.make("spaghetti").lines, splits=splits, bad_levels=3)
    assert tree.settings.cost == fl.Cost(c_trav=2.0)
    assert tree.cost() == pytest.approx(265.24, abs=0.01)
