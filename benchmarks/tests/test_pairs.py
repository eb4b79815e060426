"""The command ``pairs`` at a tiny size."""

from __future__ import annotations

import importlib.util
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

import fastlines as fl
from fastlines_bench.peers.pairs import AllPairs
from fastlines_bench.proximity import contacts, pairs
from fastlines_bench.proximity.pairs import PairsCell, PairsPreset, PairsResult, PairsRival

HAS_SCIPY = importlib.util.find_spec("scipy") is not None

HAS_COMPILER = bool(shutil.which("g++") or shutil.which("c++"))

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run():
    text = done("pairs", "--quick", "--rounds", 1, "--sizes", "300,100", "--json", "p.json")
    for said in ("pairs of segments that touch", "What is wanted", "exponent of our time", "medians of 1 round"):
        assert said in text
    assert ("NOT MEASURED: scipy is not installed" in text) != HAS_SCIPY
    peers = [*(["scipy"] if HAS_SCIPY else []), "all pairs", *(["textbook"] if HAS_COMPILER else [])]
    result = json.loads(Path("p.json").read_text())
    assert result["format"] == "fastlines-bench pairs 1"
    sizes = [("yarn", 100), ("yarn", 300), ("rods", 100), ("rods", 300), ("crossing", 500)]
    assert [(cell["scene"], cell["n_segments"]) for cell in result["cells"]] == sizes
    for cell in result["cells"]:
        assert cell["n_pairs"] > 0
        assert [rival["peer"] for rival in cell["rivals"]] == peers
        for rival in cell["rivals"]:
            assert rival["ratio"] == pytest.approx(rival["seconds"] / cell["seconds"])  # one round
            assert (rival["note"] != "") == (rival["peer"] == "scipy")


def test_two_threads_leave_the_textbook_out():
    text = done("pairs", "--quick", "--rounds", 1, "--scene", "rods", "--sizes", 50, "--threads", 2)
    assert "2 threads" in text
    assert "all pairs" in text.split("What is wanted")[0]
    assert "│ textbook" not in text
    assert "NOT MEASURED: textbook has one thread" in text


def test_all_pairs_are_those_of_the_tree():
    scene = contacts.yarn(500)
    tree = fl.build(scene.lines)
    found = tree.pairs(scene.radius, skip_neighbours=3, to="axis")
    assert len(found) > 100
    assert np.array_equal(AllPairs(tree, scene.radius, 3).find(), np.stack([found.i, found.j], axis=1))


def test_what_is_wanted():
    def cell(scene, n, seconds, **ratios):
        rivals = (PairsRival(peer.replace("_", " "), "", 0.0, 1.0, ratio, 0) for peer, ratio in ratios.items())
        return PairsCell(scene, n, 0.1, 9, 0.1, seconds, tuple(rivals))

    cells = [
        cell("rods", 10_000, 0.001, scipy=2, all_pairs=26, textbook=3),
        cell("rods", 1_000_000, 1.0),
        cell("rods", 100_000, 0.02, scipy=19),
        cell("crossing", 2000, 1.0, scipy=2, all_pairs=0.7),
    ]
    result = PairsResult({}, PairsPreset.of(), {}, cells, 1.0)
    assert result.exponent("rods") == pytest.approx(1.5)
    assert [(check.scene, check.what.partition(" ")[0], check.holds) for check in result.checks()] == [
        ("rods", "10,000", True),
        ("rods", "100,000", False),
        ("crossing", "2,000", True),
        ("rods", "exponent", False),
    ]
    assert PairsResult({}, PairsPreset.of(), {}, cells[:1], 1.0).exponent("rods") is None


def test_a_wrong_pair_is_an_error():
    scene = contacts.rods(100)
    both = np.array([[0, 1]]), np.empty((0, 2), np.int64)
    with pytest.raises(RuntimeError, match="the pair of 0 and 1 is found by one of ours and scipy alone"):
        pairs._differences(scene, "scipy", *both)
    with pytest.raises(RuntimeError, match="1 pairs are found by a tree or by brute force alone"):
        pairs._differences(scene, "all pairs", *both)
    assert pairs._differences(scene, "scipy", both[0], both[0]) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--scene", "yrn"], "did you mean 'yarn'"),
        (["--sizes", "0"], "--sizes '0' is not a whole number from 1"),
        (["--json", "p.txt"], ".json"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("pairs", "--quick", *arguments)[1]
