"""The command ``builders`` at tiny sizes: its output, its checks and its errors."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path

import pytest
from command_line import done, refused
from peers import needs_embree

import fastlines as fl
from fastlines_bench.builders import trees
from fastlines_bench.builders.checks import checks
from fastlines_bench.builders.names import BUILDERS, THESIS_COST, kind_of
from fastlines_bench.builders.rows import BuilderRow, Peer
from fastlines_bench.builders.run import front
from fastlines_bench.builders.show import sweeps
from fastlines_bench.harness import turns
from fastlines_bench.harness.findings import Check
from fastlines_bench.harness.plot import label_log, name_points
from fastlines_bench.harness.subjects import Subject

TINY = ("--quick", "--n-rays", 1024, "--seconds", 0, "--rounds", 2)
QUESTIONS = ("camera first", "camera all", "random first", "random all")

pytestmark = pytest.mark.usefixtures("in_own_folder", "own_cache")


def test_run():
    pytest.importorskip("matplotlib")
    options = ("--scene", "spaghetti:60", "--scene", "bun-hair:200", "--radius", 0.01, "--peer", "none")
    text = done("builders", *options, *TINY, "--json", "p.json", "--plot", "p.png")
    for said in ("references", "alike", "layout", "what ought to hold", "spaghetti:60: 60 segments", *BUILDERS):
        assert said in text
    assert "Embree" not in text
    assert Path("p.png").read_bytes().startswith(b"\x89PNG")

    result = json.loads(Path("p.json").read_text())
    assert result["format"] == "fastlines-bench builders 1"
    assert {"processor", "load", "threads"} <= result["machine"].keys()
    assert result["over"] == result["peers"] == []
    assert [(row["scene"], row["builder"]) for row in result["rows"]] == [
        (scene, name) for scene in ("spaghetti:60", "bun-hair:200") for name in BUILDERS
    ]
    lines = fl.scenes.make("bun-hair", 200).lines
    for row in result["rows"]:
        if row["scene"] == "bun-hair:200":
            tree = fl.build(lines, **BUILDERS[row["builder"]])
            assert (row["n_refs"], row["n_nodes"], row["cost"]) == (tree.n_refs, tree.n_nodes, tree.cost())
            assert row["thesis_cost"] == tree.cost(model=THESIS_COST[kind_of(tree.settings)])
            assert row["bytes"] == tree.layout.n_bytes
        assert len(row["builds"]) == 2
        assert min(row["builds"]) <= row["build_s"] <= max(row["builds"])
        assert tuple(row["ns"]) == QUESTIONS
        assert min(row["ns"].values()) <= row["query_ns"] <= max(row["ns"].values())
    assert [asked["question"] for asked in result["asked"]] == [*QUESTIONS] * 2
    assert {asked["radius"] for asked in result["asked"]} == {0.01}
    assert {check["scene"] for check in result["checks"]} == {"spaghetti:60", "bun-hair:200"}
    for check in result["checks"]:
        assert check["holds"] == (check["figure"] <= check["most"] * (1 + 1e-9))


@needs_embree
def test_with_embree():
    options = ("--scene", "straight-hair:100", "--builder", "best,bvh-cl", "--builder", "best")
    text = done("builders", *options, *TINY, "--json", "p.json")
    for said in ("Embree 4.", "no more than Embree"):
        assert said in " ".join(text.split())
    result = json.loads(Path("p.json").read_text())
    assert [row["builder"] for row in result["rows"]] == ["best", "bvh-cl"]
    (peer,) = result["peers"]
    assert peer["scene"] == "straight-hair:100"
    assert "ribbon" not in peer["config"]
    assert len(peer["builds"]) == 2
    assert peer["bytes"] > 0


def test_a_build_over_the_limit_is_reported():
    """No build of 2,000 segments with lookahead 2 ends before its first report of progress."""
    options = ("--scene", "spaghetti:2000", "--builder", "kd-d2", "--limit", 0, "--peer", "none")
    text = done("builders", *options, *TINY, "--json", "p.json")
    assert "over 0 s" in text
    result = json.loads(Path("p.json").read_text())
    assert result["over"] == [{"scene": "spaghetti:2000", "builder": "kd-d2", "seconds": 0.0}]
    assert result["rows"] == result["checks"] == []


def test_builds_are_alternated(monkeypatch):
    """A tree has as many rounds as its limit allows; the peer is called in each round."""
    lines = fl.scenes.make("spaghetti", 40).lines
    took = {"best": 1.0, "median": 4.0, "sbvh": None}
    called = []

    def fake_build(lines, name, limit):
        called.append(name)
        return None if took[name] is None else trees.TimedTree(fl.build(lines, **BUILDERS[name]), [took[name]])

    monkeypatch.setattr(trees, "_build", fake_build)
    found = trees.alternate_builds(lines, list(took), 3, 8.0, peer=lambda: called.append("peer"))
    assert called == ["best", "median", "sbvh", "peer", "best", "median", "peer", "best", "peer"]
    assert found["sbvh"] is None
    assert (found["best"].seconds, found["median"].seconds) == ([1.0] * 3, [4.0] * 2)


def test_different_answers_raise(monkeypatch):
    scene = fl.scenes.make("spaghetti", 30)
    subject = Subject("s", scene.lines, scene.camera, (0.01,))
    both = {name: fl.build(scene.lines, name) for name in ("best", "kd-d2")}
    monkeypatch.setattr(turns, "same", lambda a, b: False)
    with pytest.raises(RuntimeError, match="first hits differ between best and kd-d2"):
        trees.alternate_queries(subject, both, 256, 0.0, 1)


def test_pareto_front():
    assert front([]) == []
    assert front([(1, 1)]) == [0]
    # Points that are worse in one coordinate and no better in the other are not on the front.
    assert front([(1, 5), (2, 6), (1, 7), (3, 5), (4, 2), (4, 2)]) == [0, 4]


def row(builder, kind="bvh", cost=100.0, build_s=1.0, ns=100.0, scene="spaghetti", n_segments=2000):
    queries = dict.fromkeys(QUESTIONS, ns)
    return BuilderRow(scene, n_segments, builder, kind, 1, 1, 2.0, 0.0, cost, (build_s,) * 3, 0.1, 1, queries, {})


def held(rows, peers=(), n_threads=1):
    return {check.what: check.holds for check in checks(rows, peers, n_threads)}


def test_checks():
    rows = [
        row("best", cost=999.0, build_s=0.1, ns=101.9),
        row("best-bvh", cost=260.0, build_s=0.3),
        row("best-kd", "kd", cost=137.7, build_s=0.5),
        row("bvh-cl", cost=1300.0),
        row("bvh-d2", cost=260.0, build_s=1.0),
        row("kd-d2", "kd", cost=137.7, build_s=4.0),
        row("kd-d2-exhaustive", "kd", cost=137.7, build_s=6.0),
    ]
    peer = Peer("spaghetti", "user, whole", (0.2, 0.1, 0.3), 1)
    assert held(rows, [peer]) == {
        "best-bvh costs no more than any of bvh-cl, bvh-d2 (bvh-d2)": True,
        "best-kd costs no more than any of kd-d2 (kd-d2)": True,
        "ns a ray of best: within 2 % of the fastest other (best-bvh)": True,
        "best-bvh costs at most 269": True,
        "best-kd costs at most 137.6": False,
        "s to build best-bvh: 0.33 of bvh-d2": True,
        "s to build best-kd: 0.1 of kd-d2": False,
        "s to build best-kd: 0.1 of kd-d2-exhaustive": True,
        "s to build best: no more than Embree (user, whole)": True,
    }
    slower = [replace(rows[0], ns=dict.fromkeys(QUESTIONS, 102.1)), *rows[1:]]
    assert held(slower)["ns a ray of best: within 2 % of the fastest other (best-bvh)"] is False
    costlier = [rows[0], replace(rows[1], thesis_cost=260.001), *rows[2:]]
    assert held(costlier)["best-bvh costs no more than any of bvh-cl, bvh-d2 (bvh-d2)"] is False


def test_checks_about_what_was_not_measured():
    """They are left out, or are not measured."""
    assert held([row("best-bvh")]) == {
        "ns a ray of best: within 2 % of the fastest other (best-bvh)": None,
        "best-bvh costs at most 269": True,
        "s to build best-bvh: 0.33 of bvh-d2": None,
    }
    assert held([row("kd-cl", "kd")])["best-kd costs no more than any of kd-cl (kd-cl)"] is None
    assert "best-bvh costs at most 269" not in held([row("best-bvh", n_segments=1000)])
    assert Check("what", None, 1.0, scene="s").to_json()["holds"] is None


def test_half_of_embree_is_for_two_threads_and_a_million():
    says = "s to build best: half of Embree (c)"
    peer = Peer("hair", "c", (2.0,), 1)
    large = row("best", build_s=1.1, scene="hair", n_segments=1_000_000)
    assert held([large], [peer], 2)[says] is False
    assert held([replace(large, builds=(1.0,))], [peer], 2)[says] is True
    assert says not in held([large], [peer], 1)
    assert says not in held([replace(large, n_segments=999_999)], [peer], 2)


def test_sweeps():
    assert sweeps([row(name) for name in ("best@0", "bvh-cl", "best@1", "best", "x@3")]) == {"best": [0, 2], "x": [4]}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--builder", "best,bvh-dl"], "--builder 'bvh-dl' is not a builder; did you mean"),
        (["--builder", ""], "--builder '' is not a builder"),
        (["--peer", "optix"], "--peer 'optix' is not a choice"),
        (["--radius", "0"], "is not a number above 0"),
        (["--limit", "-1"], "--limit"),
        (["--scene", "spaghetty"], "did you mean 'spaghetti'"),
        (["--json", "p.txt"], "expected .json"),
        (["--plot", "nowhere/p.png"], "there is no folder"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("builders", *TINY, "--peer", "none", *arguments)[1]


# --- The plot ---


@pytest.mark.parametrize(("low", "high"), [(42, 85), (710, 755), (0.0009, 3), (3, 4), (0.14, 1.9), (1e3, 1e6)])
def test_a_logarithmic_axis_has_some_plain_labels_apart(low, high):
    figure = pytest.importorskip("matplotlib.figure").Figure(figsize=(5, 4))
    panel = figure.subplots()
    panel.loglog([low, high], [low, high])
    for axis in (panel.xaxis, panel.yaxis):
        label_log(axis)
    figure.draw_without_rendering()
    first, last = panel.get_xlim()
    ticks = zip(panel.get_xticks(), panel.get_xticklabels(), strict=True)
    places, labels = zip(*((at, label) for at, label in ticks if first <= at <= last), strict=True)
    assert 3 <= len(labels) <= 9
    assert [float(label.get_text().replace(",", "")) for label in labels] == pytest.approx(sorted(places))
    boxes = [label.get_window_extent() for label in labels]
    assert not any(a.overlaps(b) for a, b in pairwise(boxes))
    assert not any(label.get_text() for label in panel.get_xticklabels(minor=True))


def test_names_beside_points_do_not_cover_each_other():
    figure = pytest.importorskip("matplotlib.figure").Figure(figsize=(5, 4))
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    FigureCanvasAgg(figure)
    panel = figure.subplots()
    points = [(1.0, 1.0), (1.0, 1.0), (1.01, 1.0), (1.02, 1.01), (2.0, 2.0), (2.0, 1.99)]
    panel.loglog(*zip(*points, strict=True), "o")
    figure.draw_without_rendering()
    name_points(panel, points, [f"builder-{i}" for i in range(6)])
    names = [Text.get_window_extent(text) for text in panel.texts]
    assert len(names) == 6
    assert not any(a.overlaps(b) for a, b in combinations(names, 2))
    assert all(panel.bbox.x0 <= name.x0 < name.x1 <= panel.bbox.x1 for name in names)
