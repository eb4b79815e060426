"""The command ``nearest`` at a tiny size."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import done, refused

import fastlines as fl
from fastlines_bench.peers import closest_points
from fastlines_bench.proximity import nearest, scenes
from fastlines_bench.proximity.nearest import NearestPreset, NearestResult, Rival, WithinCell

TINY = ("--quick", "--n-points", 256, "--rounds", 1)

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run():
    installed = [name for name in closest_points.PEERS if closest_points.is_installed(name)]
    text = done("nearest", *TINY, "--scene", "neuron:300", "--scene", "spaghetti:100", "--json", "n.json")
    for said in ("neuron (generated)", "millions of points per second", "dense", "sparse", "medians of 1 round"):
        assert said in text
    for name in closest_points.PEERS:
        assert (f"NOT MEASURED: {name} is not installed" in text) == (name not in installed)
    result = json.loads(Path("n.json").read_text())
    assert result["format"] == "fastlines-bench nearest 1"
    assert [(cell["scene"], cell["n_prims"], cell["k"]) for cell in result["nearest"]] == [
        (scene, n, k) for scene, n in (("neuron", 300), ("spaghetti", 100)) for k in (1, 8)
    ]
    for cell in result["nearest"]:
        assert (cell["n_points"], cell["source"]) == (256, "generated")
        assert cell["mpoints"] > 0
        sides = [name for name in installed if cell["k"] == 1 or not closest_points.PEERS[name].exact]
        assert [rival["peer"] for rival in cell["rivals"]] == sides
        for rival in cell["rivals"]:
            assert rival["ratio"] == pytest.approx(cell["mpoints"] / rival["mpoints"])  # one round
            assert -1e-5 < rival["least"] <= rival["most"] < 1.1e-3
            assert rival["floor"] is None
    assert [(cell["scene"], cell["name"]) for cell in result["within"]] == [
        (scene, name) for scene in ("neuron", "spaghetti") for name in ("dense", "sparse")
    ]
    for cell in result["within"]:
        assert cell["ratio"] == pytest.approx(cell["ray_ns"] / cell["within_ns"])
        assert (cell["per_point"] > 10) == (cell["name"] == "dense")
    assert result["checks"] == []


def test_files_without_peers():
    lines = fl.Lines.from_segments(fl.scenes.make("bun-hair", 200).lines.segments, radius=0.1)
    fl.build(lines).save("hair.flt")
    text = done("nearest", *TINY, "--file", "hair.flt", "--peer", "none", "--json", "n.json")
    assert "NOT MEASURED" not in text
    result = json.loads(Path("n.json").read_text())
    assert [(cell["scene"], cell["k"], cell["rivals"]) for cell in result["nearest"]] == [
        ("hair.flt", 1, []),
        ("hair.flt", 8, []),
    ]


def test_what_is_wanted():
    rival = Rival("fcpw", 9, 0.1, 1.0, 1.05, 0.0, 0.0, nearest.FLOORS["neuron"]["fcpw"])
    cell = nearest.NearestCell("neuron", "generated", 9, 10, 1, 0.1, 1.05, (rival,))
    within = WithinCell("neuron", "sparse", 0.1, 10, 0.3, 100.0, 90.0, 101.0, 1.01, 0.0)
    result = NearestResult({}, NearestPreset.of(), (), [cell], [within], 1.0)
    assert [(check.scene, check.holds) for check in result.checks()] == [("neuron", False), ("neuron", True)]
    assert NearestResult({}, NearestPreset.of(quick=True), (), [cell], [within], 1.0).checks() == []


def test_a_wrong_distance_is_an_error(monkeypatch):
    class Wrong(closest_points.Libigl):
        def __init__(self, lines, n_threads):
            self.n_items, self.build_s = 1, 0.0

        def search(self, points, k):
            return closest_points.Search(lambda: 0, lambda answer: (0 * points[:1, 0].astype(int), points[:1, 0] + 9))

    monkeypatch.setitem(closest_points.PEERS, "libigl", Wrong)
    preset = NearestPreset.of(quick=True, n_points=64, peers=("libigl",))
    with pytest.raises(RuntimeError, match="neuron: distances of libigl less ours are"):
        nearest.run_nearest([scenes.make("neuron:50")], preset)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--scene", "neurn"], "did you mean 'neuron'"),
        (["--scene", "bun-hair:0"], "a whole number from 1"),
        (["--peer", "embree"], "--peer 'embree' is not a peer"),
        (["--data", "nowhere"], "--data 'nowhere' is not a folder"),
        (["--json", "n.txt"], ".json"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("nearest", *TINY, *arguments)[1]


def test_a_missing_peer_is_refused(monkeypatch):
    monkeypatch.setattr(closest_points, "is_installed", lambda name: False)
    assert "pip install './benchmarks[nearest]'" in refused("nearest", *TINY, "--peer", "fcpw")[1]
