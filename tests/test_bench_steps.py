"""The command ``bench steps`` at a tiny size: what is counted adds up."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import done, refused

import fastlines as fl
from fastlines.engines import counting

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run():
    text = done("bench", "steps", "--scene", "spaghetti:200", "--n-rays", 4096, "--rounds", 1, "--json", "s.json")
    for said in ("a step alone", "a node culled", "steps a ray", "share"):
        assert said in text
    result = json.loads(Path("s.json").read_text())
    assert result["format"] == "fastlines bench steps 1"
    assert result["machine"]["simd"] == fl.simd()
    assert all(nanoseconds > 0 for nanoseconds in result["pace"]["spaghetti:200"].values())
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
        assert steps["segments"] <= steps["pieces"] <= 16 * steps["leaves"]
        assert (steps["bundles"] > 0) == (steps["lines"] > 0) == (cell["kind"] == "camera")


def test_counts():
    """One segment, one ray: a node, a leaf and an exact test, however it is asked."""
    tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    with counting() as module:
        module.taken()
        assert tree.first_hit([0, 0, -5], [0, 0, 1], 0.1, kernel="single").hit
        taken = module.taken()
        assert {name: n for name, n in taken.items() if n} == {
            "rays": 1,
            "nodes": 1,
            "leaves": 1,
            "tests": 1,
        }
        assert not any(module.taken().values())
    assert fl.simd() != "tally"


def test_refused():
    assert "--rays 'tiled' is not a choice" in refused("bench", "steps", "--rays", "tiled")[1]
    assert "expected one or more" in refused("bench", "steps", "--radius", "-1")[1]
    assert ".json" in refused("bench", "steps", "--json", "s.txt")[1]
