"""The command ``steps`` at a tiny size: its counts are consistent."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import done, refused

import fastlines as fl
from fastlines.threads import num_threads
from fastlines_bench.engine.steps import compiled
from fastlines_bench.harness.internals import use_engine

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run():
    text = done("steps", "--scene", "spaghetti:200", "--n-rays", 4096, "--rounds", 1, "--json", "s.json")
    for said in ("a step alone", "a node culled", "steps a ray", "share", "again"):
        assert said in text
    result = json.loads(Path("s.json").read_text())
    assert result["format"] == "fastlines-bench steps 2"
    assert result["machine"]["simd"] == fl.simd()
    assert all(nanoseconds > 0 for nanoseconds in result["alone"]["spaghetti:200"].values())
    assert [(cell["kind"], cell["query"]) for cell in result["cells"]] == [
        ("camera", "first"),
        ("camera", "all"),
        ("random", "first"),
        ("random", "all"),
        ("ao", "any"),
    ]
    for cell in result["cells"]:
        steps = cell["per_ray"]
        assert steps["rays"] == 1
        assert steps["nodes"] > 0
        assert cell["bound_ns"] > 0
        assert cell["again_ns"] is None if cell["kind"] == "camera" else cell["again_ns"] > 0
        assert steps["segments"] <= steps["pieces"] <= 16 * steps["leaves"]
        assert (steps["bundles"] > 0) == (steps["lines"] > 0) == (cell["kind"] == "camera")


def test_counts():
    """One ray and one segment take one node, one leaf and one exact test."""
    tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    assert tree.layout  # built by the usual engine
    module = compiled("_counting")
    with use_engine(module):
        module.take_steps()
        assert tree.first_hit([0, 0, -5], [0, 0, 1], 0.1, kernel="single").hit
        taken = module.take_steps()
        assert {name: n for name, n in taken.items() if n} == {
            "rays": 1,
            "nodes": 1,
            "leaves": 1,
            "tests": 1,
        }
        assert not any(module.take_steps().values())


@pytest.mark.parametrize("query", ["first_hit", "all_hits"])
@pytest.mark.parametrize("pixels", [128, 512])
def test_bundles_are_used_only_where_they_are_faster(pixels, query):
    """The leaves of straight hair are long and close to each other, so small pictures are slower with bundles.

    The choice needs some bundles on each thread.
    """
    scene = fl.scenes.make("straight-hair")
    tree = fl.build(scene.lines)
    assert tree.layout
    origins, directions = scene.camera.rays(pixels, pixels)
    cycles = {"nodes": 65, "leaves": 55, "segments": 40, "lines": 18, "packets": 70, "tests": 50}
    cost = {}
    module = compiled("_counting")
    with num_threads(1), use_engine(module):
        for kernel in ("wave", "bundle", "auto"):
            module.take_steps()
            getattr(tree, query)(origins, directions, 0.001, kernel=kernel)
            taken = module.take_steps()
            cost[kernel] = sum(n * taken[name] for name, n in cycles.items())
            if kernel != "auto":  # the given kernel is used
                assert taken["bundles"] == (pixels * pixels // 64 if kernel == "bundle" else 0)
    assert cost["auto"] < 1.7 * min(cost["wave"], cost["bundle"]), cost
    assert (cost["wave"] < cost["bundle"]) == (pixels == 128), cost


def test_refused():
    assert "--rays 'tiled' is not a choice" in refused("steps", "--rays", "tiled")[1]
    assert "expected one or more" in refused("steps", "--radius", "-1")[1]
    assert ".json" in refused("steps", "--json", "s.txt")[1]
