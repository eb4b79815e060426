"""All builders, with the cost models of the thesis."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import fastlines as fl
from fastlines_bench.builders.names import BUILDERS
from fastlines_bench.harness.compare import same

CROSSING = np.random.default_rng(4).random((60, 2, 3), np.float32)
CASES = {
    "crossing": CROSSING,
    "hair": fl.scenes.make("straight-hair", 80).lines.segments,
    "duplicates": np.repeat(CROSSING[:6], 8, axis=0),
    "points": np.repeat(CROSSING[:, :1], 2, axis=1),
    "empty": CROSSING[:0],
    "scale 1e8": 1e8 * CROSSING,
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("builder", BUILDERS)
def test_every_builder_makes_a_tree_that_answers(builder: str, name: str) -> None:
    segments = np.asarray(CASES[name], np.float32)
    scale = float(np.abs(segments).max(initial=1.0))
    rng = np.random.default_rng(5)
    origins = scale * rng.uniform(-0.5, 1.5, (64, 3))
    rays = {"origins": origins, "directions": scale * rng.random((64, 3)) - origins, "radius": 0.05 * scale}
    given = dict(BUILDERS[builder])
    limits = dataclasses.replace(given.pop("limits", fl.Limits()), max_refs=3000)
    tree = fl.build(segments, **given, limits=limits)
    tree.validate()
    for query in ("first_hit", "all_hits"):
        assert same(getattr(tree, query)(**rays), fl.brute_force(segments, **rays, query=query))


def test_builders_of_one_kind_share_their_cost_model() -> None:
    for builder, given in BUILDERS.items():
        settings = fl.build(CROSSING, **given).settings
        if given.get("method") != "best":
            assert settings.cost == fl.Cost(0.6 if settings.boxes == "cut" else 2.0), builder


def test_optimised_builders_cost_no_more() -> None:
    lines = fl.scenes.make("spaghetti", 400).lines
    cost = {name: fl.build(lines, **given).cost(model=fl.Cost(2.0)) for name, given in BUILDERS.items()}
    for name in ("bvh-cl", "bvh-d2", "presplit"):
        assert cost[f"{name}-reinsertion"] < cost[name]
    assert cost["presplit"] < cost["bvh-cl"]
