"""The command ``sweep`` at a tiny size."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import done, refused
from peers import needs_embree

from fastlines_bench.engine.sweep import Side

pytestmark = pytest.mark.usefixtures("in_own_folder")

SMALL = ("sweep", "--quick", "--scene", "photon-beams:300", "--radii", 4, "--n-rays", 1024)


def test_one_side():
    text = done(*SMALL, "--peer", "none", "--json", "s.json")
    assert "4 radii, 0.0005 to 0.05" in text
    result = json.loads(Path("s.json").read_text())
    assert result["format"] == "fastlines-bench sweep 1"
    assert result["n_prims"] == 300
    assert len(result["radii"]) == 4
    (ours,) = result["sides"]
    assert ours["name"] == "fastlines"
    assert (len(ours["build_s"]), len(ours["query_s"])) == (1, 4)
    assert result["hit"] == sorted(result["hit"])
    assert result["differ"] is None
    assert result["ratios"] == {}


@needs_embree
def test_both_sides_agree():
    text = done(*SMALL, "--json", "s.json")
    assert "Embree's fastest takes" in text
    result = json.loads(Path("s.json").read_text())
    names = [side["name"] for side in result["sides"]]
    assert [name.split(", ")[1] for name in names[1:]] == ["user", "flat", "round"]
    assert all(len(side["build_s"]) == 4 for side in result["sides"][1:])
    assert set(result["ratios"]) == set(names[1:])
    assert result["differ"] <= 1e-3


def test_a_total_has_all_builds_and_queries():
    assert Side("Embree", [1.0, 2.0], [0.5, 0.25]).total_s == 3.75


def test_refused():
    assert "unknown method" in refused("sweep", "--method", "nope")[1]
    assert "--peer" in refused("sweep", "--peer", "nope")[1]
    assert ".json" in refused("sweep", "--json", "s.txt")[1]
