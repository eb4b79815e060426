"""The command ``engine --shapes`` at a tiny size: its output, its data and its errors."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused, run
from peers import needs_embree

import fastlines as fl
from fastlines_bench.engine.shapes import cubics, solids, subjects
from fastlines_bench.harness.compare import Difference, compare_surfaces

QUESTIONS = (("camera", "first"), ("camera", "all"), ("random", "first"), ("random", "all"))
TINY = ("--n-rays", 1024, "--seconds", 0, "--rounds", 1, "--quick")

pytestmark = pytest.mark.usefixtures("in_own_folder", "own_cache")


def test_lines_of_the_same_radius_take_turns_with_cones():
    options = ("--shape", "cones", "--scene", "spaghetti:60", "--radius", "0.01,0.02", "--peer", "none")
    text = done("engine", *options, *TINY, "--json", "b.json")
    assert "Embree" not in text.partition("What is wanted")[0]
    cells = json.loads(Path("b.json").read_text())["cells"]
    assert [cell["radius"] for cell in cells] == [0.01] * 4 + [0.02] * 4
    for cell in cells:
        assert set(cell["others"]) == {"lines", "capsules"}
        assert cell["cones_to_lines"] == pytest.approx(cell["others"]["lines"] / cell["mrays"])
        assert cell["ratio"] is None


@needs_embree
def test_run():
    shapes = ("--shape", "cones,spheres", "--scene", "straight-hair:100", "--scene", "beads:500", "--radius", "0.01")
    text = " ".join(done("engine", *shapes, *TINY, "--json", "b.json").split())
    for said in ("cones: round cones beside", "spheres: spheres beside", "geometric mean", "floor", "at least 1.8"):
        assert said in text
    assert "NOT MEASURED" not in text
    result = json.loads(Path("b.json").read_text())
    assert result["format"] == "fastlines-bench shapes 1"
    assert result["missing"] == []
    assert [(cell["shape"], cell["kind"], cell["query"]) for cell in result["cells"]] == [
        (shape, *question) for shape in ("cones", "spheres") for question in QUESTIONS
    ]
    for cell in result["cells"]:
        assert {peer["geometry"] for peer in cell["peers"]} == {"round" if cell["shape"] == "cones" else "sphere"}
        best = max((peer for peer in cell["peers"] if peer["n_rounds"]), key=lambda peer: peer["mrays"])
        assert cell["ratio"] == pytest.approx(cell["mrays"] / best["mrays"])
        assert best["difference"]["share"] < 0.02
    assert {check["what"].partition(",")[0] for check in result["checks"]} == {"cones", "spheres"}
    for check in result["checks"]:
        assert check["holds"] in (True, False)


@needs_embree
@pytest.mark.parametrize("shape", ["hair", "triangles"])
def test_run_of_hair_and_triangles(shape):
    scene = {"hair": "bun-hair:200", "triangles": "icosphere:320"}[shape]
    found = run("engine", "--shape", shape, "--scene", scene, "--radius", "0.005", *TINY, "--json", "b.json")
    result = json.loads(Path("b.json").read_text())
    assert found.exit_code == 0
    assert len(result["cells"]) == 4
    assert all(cell["ratio"] > 0 for cell in result["cells"])
    for cell in result["cells"]:
        best = max((peer for peer in cell["peers"] if peer["n_rounds"]), key=lambda peer: peer["mrays"])
        assert best["difference"]["share"] < 0.05


def test_what_cannot_be_measured_is_named(monkeypatch):
    def fail(self, preset):
        raise fl.InputError("no such thing")

    monkeypatch.setattr(subjects._Spheres, "build", fail)
    options = ("--shape", "spheres", "--scene", "balls:50", "--peer", "none")
    found = run("engine", *options, *TINY, "--json", "b.json")
    assert found.exit_code == 1
    assert "NOT MEASURED: spheres, balls:50: no such thing" in found.stdout
    result = json.loads(Path("b.json").read_text())
    assert result["missing"][0]["why"] == "no such thing"
    assert all(check["holds"] is None for check in result["checks"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--shape", "cubes"], "--shape 'cubes' is not a shape"),
        (["--shape", "spheres", "--scene", "bal"], "did you mean 'balls'"),
        (["--shape", "spheres", "--scene", "balls:0"], "a size from 1"),
        (["--shape", "triangles", "--scene", "knot:1:2:3"], "NAME:SIZE:SEED"),
        (["--shape", "triangles", "--file", "a.tfx"], "--file is for the shapes cones and hair"),
        (["--shapes", "--rays", "ao"], "--rays 'ao' is not a choice"),
        (["--shapes", "--built-for", "0.01"], "do not go together"),
        (["--shapes", "--plot", "p.png"], "--plot draws no shapes"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("engine", "--quick", "--peer", "none", *arguments)[1]


# --- Cubic curves ---


def test_curves_go_through_points_of_strands():
    lines = fl.scenes.make("bun-hair", 120).lines  # two strands of 50 segments, and 20 of a third
    control, radius = cubics.hair_curves(lines, 4, 0.01)
    counts = [12, 12, 5]
    assert control.shape == (29, 4, 3)
    points = lines.segments[:, 0]
    assert np.array_equal(control[0, 0], points[0])
    assert np.array_equal(control[11, 3], lines.segments[49, 1])
    assert np.array_equal(control[28, 3], lines.segments[119, 1])
    ends = np.cumsum(counts)
    for i in range(1, 29):
        if i not in ends:
            assert np.array_equal(control[i, 0], control[i - 1, 3])
            # Tangents are the same on both sides.
            np.testing.assert_allclose(control[i, 1] - control[i, 0], control[i - 1, 3] - control[i - 1, 2], atol=1e-6)
    np.testing.assert_allclose(radius[[0, 12, 24], 0], 0.01, rtol=1e-6)
    np.testing.assert_allclose(radius[[11, 23, 28], 3], 0.002, rtol=1e-6)
    inner = np.setdiff1d(np.arange(1, 29), ends)
    np.testing.assert_allclose(radius[inner, 0], radius[inner - 1, 3], rtol=1e-5)


def test_a_straight_strand_is_a_straight_curve():
    control, radius = cubics.hair_curves(fl.Lines.from_segments([[[0, 0, 0], [3, 0, 0]]]), 4, 1.0)
    np.testing.assert_allclose(control[0, :, 0], [0, 1, 2, 3])
    np.testing.assert_allclose(radius, [[1, 1 - 0.8 / 3, 1 - 1.6 / 3, 0.2]], rtol=1e-6)
    empty = cubics.hair_curves(fl.Lines.from_segments(np.empty((0, 2, 3))), 4, 1.0)
    assert [len(part) for part in empty] == [0, 0]


# --- Solids ---


@pytest.mark.parametrize("name", solids.SPHERES)
def test_spheres_are_as_many_as_asked_for(name):
    made = solids.SPHERES[name][0](1234, 0)
    assert made.vertices.shape == (1234, 4)
    assert len(made) == 1234
    assert made.vertices[:, 3].min() > 0
    assert made.vertices[:, 3].max() > 3 * made.vertices[:, 3].min()


@pytest.mark.parametrize("name", solids.MESHES)
def test_meshes_have_no_holes(name):
    made = solids.MESHES[name][0](2000, 0)
    assert 1000 <= len(made) <= 8000
    assert made.vertices.dtype == np.float32
    assert (np.abs(made.vertices - 0.5) <= 0.7).all()
    edges = np.sort(made.index[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    # Every edge is that of two triangles, but on the boundary of the height field.
    boundary = 4 * round((len(made) / 2) ** 0.5) if name == "terrain" else 0
    assert (counts == 1).sum() == boundary
    assert counts.max() == 2
    if name != "terrain":
        n_edges, n_vertices = len(counts), len(made.vertices)
        assert n_vertices - n_edges + len(made) == (2 if name == "icosphere" else 0)  # Euler


# --- Differences ---


def test_surfaces_agree_where_t_does():
    spheres = fl.Spheres.from_centres([[0, 0, 0], [0, 0, 0], [0, 0, 5]], radius=[1, 1, 1])
    tree = fl.build(spheres)
    rays = np.array([[0, 0, -9], [0.5, 0, -9], [9, 0, -9]]), np.array([0, 0, 1])
    first = tree.first_hit(*rays, at="surface")
    t, prim = first.t.copy(), first.prim.copy()
    assert compare_surfaces("first", first, (t, prim), 1e-5) == Difference(3)
    prim[0] = 1 - prim[0]  # the same sphere by another name
    assert compare_surfaces("first", first, (t, prim), 1e-5) == Difference(3, 1, 1, 0.0)
    assert compare_surfaces("first", first, (t, prim), 1e-5, np.zeros(3, np.int64)).n_differ == 1
    t[1] += 0.01
    found = compare_surfaces("first", first, (t, prim), 1e-5)
    assert (found.n_differ, found.n_ties, found.share) == (2, 1, 1 / 3)
    assert found.max_dt == pytest.approx(0.01, rel=1e-3)
    prim[2], t[2] = 2, 3.0
    assert compare_surfaces("first", first, (t, prim), 1e-5).n_differ == 3

    hits = tree.all_hits(*rays, at="surface")

    class Theirs:
        def __init__(self, *columns):
            self.unpack = lambda: columns

    twice = np.append(np.arange(len(hits)), 0)
    same = Theirs(hits.ray[twice], hits.prim[twice], hits.t[twice])  # the nearest counts
    assert compare_surfaces("all", hits, same, 1e-5) == Difference(3, 0, 0, 0.0, 6, 0)
    fewer = Theirs(hits.ray[1:], hits.prim[1:], hits.t[1:] + np.float32(0.01) * (hits.ray[1:] == 1))
    found = compare_surfaces("all", hits, fewer, 1e-5)
    assert (found.n_differ, found.n_hits, found.n_hits_differ) == (2, 6, 1 + 3)
    owner = np.array([0, 0, 1])
    kept = hits.prim != 1
    merged = Theirs(hits.ray[kept], owner[hits.prim[kept]], hits.t[kept])
    assert compare_surfaces("all", hits, merged, 1e-5, owner).n_differ == 0
