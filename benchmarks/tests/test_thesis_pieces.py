"""Parts of the report: checks of findings, stored steps, counts of visits, and queries of Embree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from peers import needs_embree

import fastlines as fl
from fastlines.scenes import NAMES
from fastlines_bench.builders.names import THESIS_COST
from fastlines_bench.harness.rays import RayBatch, camera_rays
from fastlines_bench.peers.embree import Scenes
from fastlines_bench.peers.embree_tree import embree_tree, piece_boxes
from fastlines_bench.peers.repeat import repeat_first
from fastlines_bench.thesis.depths import THESIS_DEPTHS, build_ahead, cylinders
from fastlines_bench.thesis.findings import findings_of
from fastlines_bench.thesis.heat import MAX_COUNT, colour, visit_maps, visits_of_rays
from fastlines_bench.thesis.measure import some
from fastlines_bench.thesis.peer import ribbons
from fastlines_bench.thesis.preset import ThesisPreset
from fastlines_bench.thesis.reference import THESIS
from fastlines_bench.thesis.rows import Row, thesis_row
from fastlines_bench.thesis.store import Step, Store, run_steps

# --- What the thesis found ---


def thesis_tables():
    return {scene: {name: thesis_row(name, row) for name, row in rows.items()} for scene, rows in THESIS.items()}


def test_all_findings_hold_in_the_thesis_itself():
    findings = findings_of(thesis_tables())
    assert len(findings) == 8
    assert [finding.text for finding in findings if finding.holds is not True] == []


def test_a_finding_that_does_not_hold_is_reported():
    tables = thesis_tables()
    rows = tables["photon-beams"]
    rows["bvh-ss"] = replace(rows["bvh-ss"], cost=3.01 * rows["bvh-d2"].cost)
    rows = tables["straight-hair"]
    rows["kd-d2"] = replace(rows["kd-d2"], cost=1.06 * rows["kd-cl"].cost)
    rows = tables["spaghetti"]
    rows["kd-d2"] = replace(rows["kd-d2"], ms={**rows["kd-d2"].ms, "all N": 0.61 * rows["bvh-d2"].ms["all N"]})
    failed = {finding.text for finding in findings_of(tables) if finding.holds is False}
    assert failed == {
        "Only BVH::CL fails on photon beams.",
        "D2 changes little on hair.",
        "KD trees take about half of BVHs’ time.",
    }


def test_a_finding_that_was_not_measured_neither_holds_nor_fails():
    tables = thesis_tables()
    del tables["spaghetti-2"]["embree-ps"]
    tables["bun-hair"]["bvh-ss"] = Row("bvh-ss", {}, over_s=20.0)
    unknown = [finding.text for finding in findings_of(tables) if finding.holds is None]
    assert len(unknown) == 4
    assert "Only the D2 trees and Embree PS survive spaghetti 2." in unknown
    assert all(finding.holds is None for finding in findings_of({}))


# --- Steps ---


def test_stored_results_must_be_complete_and_of_the_same_key(tmp_path):
    made = []

    def make(results):
        made.append(dict(results))
        (tmp_path / "a.png").write_bytes(b"x")
        return {"figure": 1, "images": {"it": "a.png"}}

    steps = [Step("A: §1", 1.0, make), Step("b", 1.0, lambda results: {"twice": 2 * results["A: §1"]["figure"]})]
    found = run_steps(steps, Store(tmp_path, 1))
    assert found["b"]["twice"] == 2
    assert run_steps(steps, Store(tmp_path, 1)) == found
    assert len(made) == 1
    run_steps(steps, Store(tmp_path, 2))
    assert len(made) == 2
    (tmp_path / "a.png").unlink()
    run_steps(steps, Store(tmp_path, 2))
    assert len(made) == 3
    Store(tmp_path, 2).path("A: §1", ".json").write_text('{"key"')
    run_steps(steps, Store(tmp_path, 2), show_progress=True)
    assert len(made) == 4


def test_progress_names_the_step_and_the_time_left(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "140")
    run_steps([Step(name, 1.0, lambda results: {}) for name in "abc"], Store(tmp_path, 1), show_progress=True)
    shown = capsys.readouterr().err
    assert "of 3" in shown


# --- Embree ---


@needs_embree
def test_repeated_first_hits_are_all_hits():
    scene = fl.scenes.make("spaghetti", 80)
    rays = camera_rays(scene.camera, 48 * 48)
    scenes = Scenes(scene.lines, 0.01, scene.camera.origin, 1)
    found = repeat_first(scenes, ribbons(0.0), rays)
    expected = fl.build(scene.lines).count_hits(rays.origins, rays.directions, 0.01).sum()
    assert found.n_hits == pytest.approx(expected, rel=0.02)
    assert found.n_hits == pytest.approx(len(scenes.query(ribbons(0.0), "all", rays).unpack()[0]), rel=0.01)


@needs_embree
def test_cost_of_a_tree_that_embree_made():
    def thin(*x):
        return fl.Lines.from_segments([[[a, 0, 0], [a, 1, 1]] for a in x])

    model = THESIS_COST["bvh"]
    one = embree_tree(thin(0.0), model)
    assert (one.n_prims, one.n_nodes, one.cost) == (1, 1, 1.0)
    # Three flat boxes of area 1 at either end of one of area 1 + 2·99: c_trav = 2, then three with a chance of 1/199.
    six = embree_tree(thin(0.0, 0.0, 0.0, 99.0, 99.0, 99.0), model)
    assert (six.n_prims, six.n_nodes) == (6, 3)
    assert six.cost == pytest.approx(2 + 6 / 199)
    lines = fl.scenes.make("spaghetti", 300).lines
    whole, cut = embree_tree(lines, model), embree_tree(lines, model, 0.1)
    assert cut.n_prims == len(piece_boxes(lines, 0.1)[0]) > 300
    assert 1 < cut.cost < whole.cost <= 300
    assert whole.cost == pytest.approx(fl.build(lines, "bvh-cl").cost(), rel=0.1)


# --- Pictures and plans ---


@pytest.mark.parametrize(("radius", "nodes", "tests"), [(0.0, (3, 1, 0), (2, 0, 0)), (2.5, (3, 2, 0), (2, 1, 0))])
def test_visits_of_rays(radius, nodes, tests):
    """One ray through both leaves, one through the root alone or also a leaf, one past it."""
    ends = [[[0, 0, 0], [4, 4, 0]], [[2, 1, 0], [10, 1, 0]]]
    tree = fl.build(ends, splits=fl.ObjectSweep(), cost=fl.Cost(0.01), limits=fl.Limits(leaf_refs=0))
    assert tree.n_nodes == 3
    origins = np.array([[3, 1, -5], [8, 3, -5], [20, 20, -5]], np.float32)
    rays = RayBatch("random", origins, np.tile(np.array([0, 0, 1], np.float32), (3, 1)))
    found = visits_of_rays(tree, rays, radius)
    assert [tuple(counts) for counts in found] == [nodes, tests]


def test_a_leaf_that_is_hit_counts_once():
    scene = fl.scenes.make("photon-beams", 200)
    one = fl.build(scene.lines, splits=fl.PlaneGrid(8), lookahead=0)
    nodes, tests = visit_maps(one, scene.camera, 10, 0.001)
    assert set(np.unique(nodes)) <= {0.0, 1.0}
    assert (tests == 200 * nodes).all()


def test_colours_grow_lighter_with_the_count():
    picture = colour(np.array([[0.0, 1.0, 30.0, MAX_COUNT, 10.0 * MAX_COUNT]])).astype(int).sum(axis=2)[0]
    assert picture[0] == 0 < picture[1] < picture[2] < picture[3] == picture[4]


def test_cylinders_lie_in_the_cube():
    axes = cylinders(3)
    assert axes.shape == (100, 2, 3)
    assert ((axes >= 0) & (axes <= 4)).all()
    assert np.linalg.norm(axes[:, 1] - axes[:, 0], axis=1) == pytest.approx(np.ones(100))


def test_a_part_of_the_rays_represents_all():
    scene = fl.scenes.make("bun-hair", 2000)
    tree = fl.build(scene.lines)
    rays = camera_rays(scene.camera, 256 * 256)
    mean = tree.count_hits(rays.origins, rays.directions, 0.005).mean()
    for n_rays in (1024, 4096, 12_288, 20_000):
        part = some(rays, n_rays)
        assert n_rays / 2 < len(part) <= n_rays
        assert len(np.unique(part.directions, axis=0)) == len(part)
        assert tree.count_hits(part.origins, part.directions, 0.005).mean() == pytest.approx(mean, rel=0.1)
    assert some(rays, len(rays)) is rays


def test_presets():
    full, quick = ThesisPreset.of(), ThesisPreset.of(quick=True)
    assert set(full.scenes.values()) == {None}
    assert list(full.scenes) == list(quick.scenes) == list(NAMES)
    assert full.depths == quick.depths == (0, 1, 2, 3)
    for name in NAMES:
        assert len(fl.scenes.make(name).lines) == THESIS[name]["bvh-cl"].n_prims


def test_table_4_3_looking_further_ahead_costs_less():
    axes = cylinders(seed=0)
    costs = [build_ahead(axes, depth).cost() for depth in THESIS_DEPTHS]
    assert costs == [100.0, *(pytest.approx(cost, abs=0.05) for cost in (24.5, 24.0, 23.8))]
    assert costs == sorted(costs, reverse=True)
