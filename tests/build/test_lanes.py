"""References that are tested in lanes: the search counts half of them as full lanes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.nasty import named_scene, same

import fastlines as fl
from fastlines.settings.splits import BoxRule, SplitSet

#: A tree of one split, whatever it costs.
ONE_SPLIT: dict[str, Any] = {"bad_levels": 1, "prune": False, "limits": fl.Limits(max_depth=1)}


def area(low: np.ndarray, high: np.ndarray) -> float:
    x, y, z = high.astype(np.float64) - low
    return 2 * (x * y + x * z + y * z)


def best_sweep(ends: np.ndarray, lanes: int) -> int:
    """How many segments the best split into whole ones puts to the left."""
    low, high = ends.min(axis=1), ends.max(axis=1)
    n = len(ends)
    found = []
    for axis in range(3):
        order = np.argsort(0.5 * low[:, axis] + 0.5 * high[:, axis], kind="stable")
        for n_left in range(1, n):
            sides = (order[:n_left], order[n_left:])
            tests = [(len(side) + -(-len(side) // lanes) * lanes) / 2 for side in sides]
            areas = [area(low[side].min(axis=0), high[side].max(axis=0)) for side in sides]
            found.append((areas[0] * tests[0] + areas[1] * tests[1], n_left))
    return min(found)[1]


@pytest.mark.parametrize("lanes", [1, 4, 16, 32])
@pytest.mark.parametrize("seed", range(6))
def test_the_search_counts_half_of_them_as_full_lanes(seed: int, lanes: int) -> None:
    ends = np.random.default_rng(seed).random((45, 2, 3), dtype=np.float32)
    tree = fl.build(ends, splits=fl.ObjectSweep(), lanes=lanes, **ONE_SPLIT)
    assert tree.n_nodes == 3
    assert tree.nodes["n_refs"][1] == best_sweep(ends, lanes)


@pytest.mark.parametrize("seed", range(6))
def test_a_beam_takes_what_looks_cheapest_with_lanes(seed: int) -> None:
    ends = np.random.default_rng(seed).random((45, 2, 3), dtype=np.float32)
    search: dict[str, Any] = {"splits": fl.ObjectSweep(), "lookahead": 2, "beam": 1, "lanes": 16}
    tree = fl.build(ends, **search, bad_levels=1, prune=False, limits=fl.Limits(max_depth=2))
    assert tree.nodes["n_refs"][1] == best_sweep(ends, lanes=16)


@pytest.mark.parametrize("boxes", ["tight", "cut"])
def test_octets_count_as_the_grid_does(boxes: BoxRule) -> None:
    def split(name: str, splits: SplitSet, lanes: int) -> list[int]:
        tree = fl.build(named_scene(name, 70), splits=splits, boxes=boxes, lanes=lanes, **ONE_SPLIT)
        return tree.nodes["n_refs"].tolist()

    n_differ = 0
    for name in ("random", "crossing", "hair"):
        plain, full = (split(name, fl.PlaneGrid(16), lanes) for lanes in (1, 16))
        assert [split(name, fl.BinnedPlanes(16), lanes) for lanes in (1, 16)] == [plain, full]
        n_differ += plain != full
    assert n_differ > 0


@pytest.mark.parametrize("boxes", ["tight", "cut"])
@pytest.mark.parametrize("lookahead", [2, 3])
def test_what_a_search_skips_can_not_pay_with_lanes_either(lookahead: int, boxes: BoxRule) -> None:
    given: dict[str, Any] = {"splits": fl.PlaneGrid(4), "boxes": boxes, "lookahead": lookahead, "lanes": 16}
    for seed in range(3):
        ends = np.random.default_rng(seed).random((60, 2, 3), dtype=np.float32)
        skipping, exhaustive = (fl.build(ends, **given, exhaustive=all_of_them) for all_of_them in (False, True))
        assert same(skipping, exhaustive)
        assert skipping.n_nodes > 3


@pytest.mark.parametrize("effort", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("scene", ["spaghetti", "bun-hair"])
def test_leaves_are_fuller_and_fewer(scene: str, effort: float) -> None:
    lines = fl.scenes.make(scene, 2000).lines
    full, plain = (fl.build(lines, "best", effort=effort, lanes=lanes) for lanes in (16, 1))
    full.validate()
    assert full.settings == fl.build(lines, effort=effort).settings
    fill = [tree.nodes["n_refs"][tree.is_leaf].mean() for tree in (full, plain)]
    assert fill[0] > 1.15 * fill[1]
    assert full.layout.n_bytes < plain.layout.n_bytes


@pytest.mark.parametrize("lanes", [0, 3, 24, 128, 1.5, "16", None, True])
def test_wrong_lanes(lanes: Any) -> None:
    with pytest.raises(fl.InputError, match="lanes"):
        fl.Settings(lanes=lanes)


def test_lanes_fit_into_leaves() -> None:
    lines = fl.scenes.make("spaghetti", 70).lines
    assert fl.build(lines).settings.lanes == 16
    for most, lanes in {1: 1, 3: 2, 8: 8, 15: 8, 16: 16, 40: 16}.items():
        tree = fl.build(lines, limits=fl.Limits(max_leaf_refs=most))
        assert tree.settings.lanes == lanes
        tree.validate()
    with pytest.raises(fl.InputError, match=r"lanes=32 .* max_leaf_refs=16"):
        fl.build(lines, lanes=32)
    assert fl.build(lines, lanes=32, limits=fl.Limits(max_leaf_refs=32)).settings.lanes == 32
