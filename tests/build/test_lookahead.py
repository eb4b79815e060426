"""Searches deeper than one level: branch and bound, and a beam."""

from __future__ import annotations

import numpy as np
import pytest
from support.nasty import named_scene, same

import fastlines as fl

LOOKAHEADS = {
    "tight, 2": {"splits": fl.PlaneGrid(5), "lookahead": (1, 2)},
    "tight with objects, 2": {"splits": (fl.PlaneGrid(3), fl.ObjectSweep(max_refs=20)), "lookahead": 2},
    "tight, 3": {"splits": fl.PlaneGrid(2), "lookahead": 3},
    "cut, 2": {"splits": fl.PlaneGrid(7), "boxes": "cut", "lookahead": 2},
    "cut, 3": {"splits": fl.PlaneGrid(3), "boxes": "cut", "lookahead": 3},
    "cut events, 2": {"splits": fl.PlaneEvents(), "boxes": "cut", "lookahead": 2, "limits": fl.Limits(max_depth=4)},
    "cut octets, 2": {"splits": fl.BinnedPlanes(8), "boxes": "cut", "lookahead": 2},
    "octets, 2, grown": {"splits": fl.BinnedPlanes(8, 16), "lookahead": 2, "radius_hint": 0.05},
}


@pytest.mark.parametrize("settings", LOOKAHEADS)
@pytest.mark.parametrize("name", ["random", "crossing", "axis parallel", "duplicates", "points", "flat", "outlier"])
def test_branch_and_bound_makes_the_tree_of_exhaustive_search(name: str, settings: str) -> None:
    ends = named_scene(name, 30 if "3" in settings or "events" in settings else 60)
    given = {"cost": fl.Cost(0.4), "limits": fl.Limits(max_depth=7), **LOOKAHEADS[settings]}
    bound, exhaustive = (fl.build(ends, exhaustive=exhaustive, **given) for exhaustive in (False, True))
    assert same(bound, exhaustive)
    assert bound.cost() == exhaustive.cost()
    if exhaustive.searched:
        assert exhaustive.searched["carried_out"] == exhaustive.searched["candidates"]
        assert bound.searched["carried_out"] <= exhaustive.searched["carried_out"]


@pytest.mark.slow
@pytest.mark.parametrize("lookahead", [2, 3])
def test_branch_and_bound_where_planes_meet_the_ends_of_lines(lookahead: int) -> None:
    """What only touches a plane is on one side of it, until it is cut and lies in it."""
    for seed in range(6):
        ends = np.random.default_rng(seed).integers(0, 9, (20, 2, 3))
        given = {"splits": fl.PlaneGrid(7), "boxes": "cut", "lookahead": lookahead, "cost": fl.Cost(0.3)}
        bound, exhaustive = (
            fl.build(ends, exhaustive=exhaustive, limits=fl.Limits(max_depth=6), **given)  # type: ignore[arg-type]
            for exhaustive in (False, True)
        )
        assert same(bound, exhaustive)


@pytest.mark.parametrize("seed", range(60))
def test_branch_and_bound_by_pairs_of_planes(seed: int) -> None:
    """On lattices, lines along axes, flat and thin scenes, with all that a search can be told."""
    rng = np.random.default_rng(seed)
    ends = rng.integers(0, 9, (40, 2, 3)).astype(float) if seed % 2 else rng.random((40, 2, 3))
    ends *= [1.0, *rng.choice([1.0, 1e-3, 1e-6, 1e-41, 1e-44], 2)]
    if seed % 3 == 0:
        ends[:, 1, seed % 2] = ends[:, 0, seed % 2]
    lookahead = 2 + (seed % 5 == 0)
    planes = int(rng.choice([1, 3, 7, 8] if lookahead == 3 else [2, 8, 9, 16, 17, 30]))
    given = {
        "splits": fl.BinnedPlanes(planes, sample=int(rng.choice([0, 10]))) if seed % 4 else fl.PlaneGrid(planes),
        "lookahead": lookahead,
        "radius_hint": rng.choice([0.0, 0.01, 0.5]),
        "bad_levels": int(rng.choice([0, 2])),
        "beam": [None, 5][seed % 7 == 0],
        "limits": fl.Limits(max_depth=5, max_refs=int(rng.choice([60, 10_000]))),
        "cost": fl.Cost(rng.choice([0.05, 0.3, 1.0])),
    }
    bound, exhaustive = (
        fl.build(ends[: 20 if lookahead == 3 else 40], boxes="cut", exhaustive=exhaustive, **given)
        for exhaustive in (False, True)
    )
    assert same(bound, exhaustive)


def test_bounds_save_most_of_the_search() -> None:
    lines = named_scene("random", 100)
    given = {"splits": fl.PlaneGrid(16), "boxes": "cut", "lookahead": 2, "cost": fl.Cost(1.2)}
    bound, exhaustive = (fl.build(lines, exhaustive=exhaustive, **given) for exhaustive in (False, True))
    assert bound.searched["carried_out"] < 0.1 * exhaustive.searched["carried_out"]


def test_a_beam_is_a_bound_on_the_search() -> None:
    ends = named_scene("crossing", 60)
    given = {"splits": fl.PlaneGrid(8), "lookahead": 2, "cost": fl.Cost(0.4)}
    costs = []
    for beam in (1, 4, 24, 1000):
        tree = fl.build(ends, beam=beam, **given)
        tree.validate()
        costs.append(tree.cost())
    assert same(tree, fl.build(ends, **given))
    # The widest beam searches most; the narrowest takes what SAH takes, where that is worth it.
    assert costs[-1] <= costs[0]
    for beam in (0, -1, 1.5):
        with pytest.raises(fl.InputError, match="beam="):
            fl.build(ends, beam=beam, **given)  # type: ignore[arg-type]
