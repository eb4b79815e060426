"""The command ``engine`` at a tiny size: its output and its errors."""

from __future__ import annotations

import importlib.util
import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused
from peers import needs_embree

import fastlines as fl
from fastlines_bench.engine import run as engine
from fastlines_bench.harness import compare as comparing
from fastlines_bench.peers import embree, repeat, tuning

TINY = ("--n-rays", 1024, "--seconds", 0, "--rounds", 1, "--quick")

pytestmark = pytest.mark.usefixtures("in_own_folder", "own_cache")


@needs_embree
def test_run(own_cache):
    pytest.importorskip("matplotlib")
    scenes = ("--scene", "spaghetti:60", "--scene", "straight-hair:100:5", "--radius", "0.01,0.02")
    text = done("engine", *scenes, *TINY, "--json", "b.json", "--plot", "b.png")
    for said in ("camera rays", "random rays", "ao rays", "geometric mean", "ratio", "differ", "building", "Embree 4."):
        assert said in text
    assert (own_cache.parent.parent / "b.png").read_bytes().startswith(b"\x89PNG")
    result = json.loads((own_cache.parent.parent / "b.json").read_text())
    assert result["format"] == "fastlines-bench engine 1"
    assert {"processor", "embree", "threads", "load"} <= result["machine"].keys()
    assert len(result["cells"]) == 2 * 2 * 5
    assert [mean["query"] for mean in result["geometric_means"]] == ["first", "all", "first", "all", "any"]
    for cell in result["cells"]:
        assert cell["mrays"] > 0
        assert cell["ratio"] > 0
        assert cell["n_rays"] >= 1024 or cell["kind"] == "ao"
        geometries = {peer["geometry"] for peer in cell["peers"]}
        assert {"user", "flat", "round"} <= geometries
        assert ("ribbon" in geometries) == (cell["kind"] == "camera")
        for peer in cell["peers"]:
            assert peer["mrays"] > 0
            assert peer["bytes"] > 0
            assert peer["difference"]["n_rays"] == peer["n_rays"]
            if peer["geometry"] == "user":
                assert peer["difference"]["share"] < 0.01
        best = max((peer for peer in cell["peers"] if peer["n_rounds"]), key=lambda peer: peer["mrays"])
        assert best["name"] == cell["best"]
        assert cell["ratio"] == pytest.approx(cell["mrays"] / best["mrays"])
    for built in result["built"]:
        assert built["bytes"] > 0

    # Tuned lengths are cached.
    before = own_cache.read_text()
    assert len(json.loads(before)) == 2
    done("engine", *scenes, *TINY, "--rays", "camera")
    assert own_cache.read_text() == before
    own_cache.write_text("no JSON")
    done("engine", *scenes, *TINY, "--rays", "camera", "--retune")
    assert len(json.loads(own_cache.read_text())) == 2


@needs_embree
@pytest.mark.parametrize("alone", [(), ("--one-by-one",)])
def test_builds_are_not_timed_with_queries(monkeypatch, alone):
    long, get, ticks, built = 1.0, embree.Scenes.get, itertools.count(), []

    def slow(self, build):
        built.extend([build] * (build not in self._scenes))
        return get(self, build)

    def clock(_):
        return lambda: 1e-6 * next(ticks) + long * len(built)

    monkeypatch.setattr(embree.Scenes, "get", slow)
    for module in (engine, repeat):
        monkeypatch.setattr(module, "clock", clock)
    done("engine", "--scene", "spaghetti:60", "--rays", "random", *TINY, *alone, "--json", "b.json")
    peers = [peer for cell in json.loads(Path("b.json").read_text())["cells"] for peer in cell["peers"]]
    assert len(peers) >= 6
    assert built
    assert all(peer["n_rays"] / peer["mrays"] / 1e6 < long for peer in peers)


def test_without_a_peer(own_cache):
    np.savez("hair.npz", segments=fl.scenes.make("bun-hair", 80).lines.segments)
    text = done("engine", "--file", "hair.npz", *TINY, "--peer", "none", "--method", "kd-d2", "--json", "b.json")
    assert "Embree" not in text
    result = json.loads((own_cache.parent.parent / "b.json").read_text())
    assert result["built"][0]["method"] == "kd-d2"
    assert all(cell["peers"] == [] and cell["ratio"] is None for cell in result["cells"])
    low, high = fl.read("hair.npz").bounds
    assert result["cells"][0]["radius"] == pytest.approx(0.001 * (high - low).max())


def test_effort_changes_our_tree():
    n_bytes = []
    for effort in (0, 1):
        done(
            *("engine", "--scene", "spaghetti:300", *TINY, "--rays", "random"),
            *("--peer", "none", "--effort", effort, "--json", "b.json"),
        )
        result = json.loads(Path("b.json").read_text())
        assert result["preset"]["effort"] == effort
        n_bytes.append(result["built"][0]["bytes"])
        tree = fl.build(fl.scenes.make("spaghetti", 300).lines, effort=effort)
        assert n_bytes[-1] == tree.layout.n_bytes
    assert n_bytes[0] < n_bytes[1]


def test_the_number_of_threads_is_restored():
    before = fl.get_num_threads()
    done("engine", "--scene", "spaghetti:40", *TINY, "--peer", "none", "--threads", 2, "--rays", "tiled")
    assert fl.get_num_threads() == before


def test_missing_embree_is_reported(monkeypatch):
    monkeypatch.setattr(embree, "load", embree.load.__wrapped__)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    code, sentence = refused("engine", "--quick")
    assert code == 1
    assert "pip install embreex" in sentence


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--peer", "optix"], "--peer 'optix' is not a choice"),
        (["--rays", "camera,mirror"], "--rays 'mirror' is not a choice"),
        (["--radius", "0.1,x"], "--radius 'x' is not a number"),
        (["--radius", "0"], "above 0"),
        (["--scene", "spagetti"], "did you mean 'spaghetti'"),
        (["--method", "bvh"], "unknown method"),
        (["--scene", "spaghetti:40", "--method", "bvh-d2", "--effort", "1"], "a knob of method='best'"),
        (["--scene", "spaghetti:40", "--effort", "2"], "from 0 (fastest) to 1 (best tree)"),
        (["--json", "b.txt"], "expected .json"),
        (["--plot", "nowhere/b.png"], "there is no folder"),
        (["--file", "none.tfx"], "none.tfx"),
    ],
)
def test_refused(arguments, said):
    arguments = arguments if "--peer" in arguments else [*arguments, "--peer", "none"]
    assert said in refused("engine", "--quick", *arguments)[1]


def test_differences_are_counted():
    lines = fl.scenes.make("spaghetti", 50)
    origins, directions = lines.camera.rays(16, 16)
    ours = fl.build(lines.lines).all_hits(origins, directions, 0.05)

    class Theirs:
        def __init__(self, rows):
            self.rows = rows

        def unpack(self):
            return ours.ray[self.rows], ours.prim[self.rows], ours.t[self.rows]

    every = np.random.default_rng(0).permutation(len(ours))
    assert comparing.compare("all", ours, Theirs(every)) == comparing.Difference(256, 0, 0, 0.0)
    assert comparing.compare("all", ours, Theirs(every[1:])).n_differ == 1
    assert comparing.compare("all", ours, Theirs(np.append(every, every[0]))).n_differ == 1
    both = comparing.Difference(10, 2, 1, 0.5) + comparing.Difference(30, 3, 1, 0.1)
    assert both == comparing.Difference(40, 5, 2, 0.5)
    assert both.share == 3 / 40

    # Another segment at the same t is a tie; at another t it is a difference.
    first = fl.build(lines.lines).first_hit(origins, directions, 0.05)
    hit = int(np.flatnonzero(first.hit)[0])
    t, prim = first.t.copy(), first.prim.copy()
    prim[hit] += 1
    assert comparing.compare("first", first, (t, prim)) == comparing.Difference(256, 1, 1, 0.0)
    t[hit] += 0.01
    assert comparing.compare("first", first, (t, prim)) == comparing.Difference(256, 1, 0, 0.0)


def test_cache_is_in_the_users_cache_folder(monkeypatch, tmp_path):
    monkeypatch.undo()
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert tuning.cache_file() == tmp_path / "fastlines" / "embree-tuning.json"
