"""The command ``calibrate`` at tiny sizes, and its parts: counts, overlap, fits and ranks."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

import fastlines as fl
from fastlines.settings.settings import Cost, Settings
from fastlines.structure.tree_data import NODE, REF
from fastlines.tree import Tree
from fastlines_bench.builders import calibrate
from fastlines_bench.builders.fit import fit_steps
from fastlines_bench.builders.overlap import overlap, points_along
from fastlines_bench.builders.predict import PREDICTORS, best_mix, mixed, predictors
from fastlines_bench.builders.ranks import kendall, ranks, spearman
from fastlines_bench.harness.rays import RayBatch
from fastlines_bench.harness.visits import Visits, count_visits, expect_visits, expect_wide

TINY = ("--quick", "--n-rays", 1024, "--seconds", 0, "--rounds", 1)
QUESTIONS = ("camera first", "camera all", "random first", "random all")
BOTH = ("bvh-cl", "kd-d2")

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run():
    options = ("--scene", "spaghetti:100", "--scene", "straight-hair:200", "--builder", "best,bvh-cl,kd-d2,median")
    text = done("calibrate", *options, *TINY, "--radius", 0.01, "--json", "c.json")
    for said in ("what a step takes", "c_trav/c_prim", "Spearman", "Kendall", "regret"):
        assert said in text
    result = json.loads(Path("c.json").read_text())
    assert result["format"] == "fastlines-bench calibrate 2"
    assert result["machine"]["simd"] == fl.simd()
    assert [(sample["scene"], sample["builder"]) for sample in result["samples"]] == [
        (scene, name)
        for scene in ("spaghetti:100", "straight-hair:200")
        for name in ("best", "bvh-cl", "kd-d2", "median")
    ]
    for sample in result["samples"]:
        assert tuple(sample["ns"]) == (*QUESTIONS, "binary")
        assert min(sample["ns"].values()) > 0
        steps = sample["steps"]
        # Both traversals find the same hits.
        assert steps["binary"]["hits"] == steps["random all"]["hits"]
        assert steps["binary"]["tests"] >= steps["binary"]["hits"]
        for question in QUESTIONS:
            assert steps[question]["nodes"] > 0
    searches = list(calibrate.SEARCHES.values())
    assert [fit["what"] for fit in result["fits"]] == [*searches, calibrate.LAYOUT, *QUESTIONS]
    assert [fit["n"] for fit in result["fits"]] == [6, 2] + 5 * [8]
    for fit in result["fits"]:
        assert 0 <= fit["error"] <= fit["worst"]
        assert min(fit["ns"].values()) >= 0
    assert result["c_trav"].keys() == {*searches, calibrate.LAYOUT}
    # Where times are noise, tests may explain nothing; then no model is calibrated.
    known = [
        name for name in PREDICTORS if name != "cost, calibrated" or result["c_trav"][calibrate.LAYOUT] is not None
    ]
    assert [predictor["name"] for predictor in result["predictors"]] == known
    for predictor in result["predictors"]:
        assert predictor["name"] in text
        assert predictor["regret"] >= 0
        assert predictor["scenes"].keys() == {"spaghetti:100", "straight-hair:200"}
        assert predictor["questions"].keys() == set(QUESTIONS)
        for found in (predictor["overall"], *predictor["scenes"].values(), *predictor["questions"].values()):
            assert all(value is None or -1 - 1e-9 <= value <= 1 + 1e-9 for value in found.values())
    assert 0 <= result["mix"]["alpha"] <= 1


def test_a_build_over_the_limit_is_reported():
    options = ("--scene", "spaghetti:2000", "--builder", "kd-d2", "--limit", 0, "--json", "c.json")
    assert "kd-d2 did not end within 0 s" in done("calibrate", *options, *TINY)
    result = json.loads(Path("c.json").read_text())
    assert result["over"] == [{"scene": "spaghetti:2000", "builder": "kd-d2", "seconds": 0.0}]
    assert result["samples"] == result["fits"] == result["predictors"] == []


def two_leaves(segments, boxes):
    """A tree of a root and two leaves, with a segment each."""
    nodes = np.zeros(3, NODE)
    nodes["box"][1:] = boxes
    nodes["box"][0] = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
    nodes["right"] = (2, 0, 0)
    nodes["first_ref"], nodes["n_refs"] = (0, 0, 1), (2, 1, 1)
    refs = np.array([(0, 0, np.inf), (1, 0, np.inf)], REF)
    return Tree(fl.Lines.from_segments(segments), nodes, refs, Settings())


#: A diagonal, and a line through the corner of its box: of the line's 8, a part of 2 lies there.
CROSSING = ([[[0, 0, 0], [4, 4, 0]], [[2, 1, 0], [10, 1, 0]]], [[[0, 0, 0], [4, 4, 0]], [[2, 1, 0], [10, 1, 0]]])


def test_overlap_by_hand():
    tree = two_leaves(*CROSSING)
    tree.validate()
    found = overlap(tree, n_points=20_000)
    assert found.inner == 0  # all lies below the root
    assert found.tests == pytest.approx(2 / (np.sqrt(32) + 8), abs=1e-3)
    assert found.cost(Cost(5.0, 3.0)) == 3 * found.tests

    # Grown by 1, the line's box [1, 11] × [0, 2] holds of the diagonal the part from 1 to 2, and the diagonal's box
    # [−1, 5] holds 3 of the line.
    grown = overlap(tree, 1.0, n_points=20_000)
    assert grown.tests == pytest.approx((3 + np.sqrt(2)) / (np.sqrt(32) + 8), abs=1e-3)


def test_overlap_of_cut_and_whole_segments():
    """Leaves of a KD tree overlap only in their faces, so few visits are in vain; whole lines overlap."""
    lines = fl.scenes.make("spaghetti", 300).lines
    cut, whole = (overlap(fl.build(lines, method)) for method in ("kd-d2", "bvh-cl"))
    assert cut.tests < 0.05
    assert cut.tests < 0.01 * whole.tests
    # One leaf holds all pieces, so no visit is in vain.
    assert overlap(fl.build(lines, "bvh-ss")) == Visits(0.0, 0.0)


def test_overlap_of_points_and_empty_trees():
    point = fl.build([[[1, 1, 1], [1, 1, 1]], [[2, 2, 2], [2, 2, 2]]])
    assert overlap(point, 0.1) == Visits(0.0, 0.0)
    assert overlap(fl.build(np.zeros((0, 2, 3)))) == Visits(0.0, 0.0)
    with pytest.raises(fl.InputError, match="for lines"):
        overlap(fl.build(fl.Boxes([[[0, 0, 0], [1, 1, 1]]])))


def test_points_are_spread_by_length():
    lines = fl.Lines.from_segments([[[0, 0, 0], [1, 0, 0]], [[5, 5, 5], [5, 5, 5]], [[0, 0, 0], [0, 3, 0]]])
    prim, s = points_along(lines, 8)
    assert prim.tolist() == [0, 0, 2, 2, 2, 2, 2, 2]
    assert s.tolist() == pytest.approx([0.25, 0.75, *((np.arange(6) + 0.5) / 6)])


def test_visits_by_hand():
    """One ray through both leaves, one through the root alone, one past it."""
    tree = two_leaves(*CROSSING)
    origins = np.array([[3, 1, -5], [8, 3, -5], [20, 20, -5]], np.float32)
    rays = RayBatch("random", origins, np.tile(np.array([0, 0, 1], np.float32), (3, 1)))
    assert count_visits(tree, rays, 0.0) == Visits(2 / 3, 2 / 3)
    assert count_visits(tree, rays.take(slice(1, 2)), 2.5) == Visits(1, 1)
    assert count_visits(tree, rays.take(slice(1, 2)), 4.5) == Visits(1, 2)


@pytest.mark.parametrize("method", BOTH)
def test_expected_steps_give_the_cost(method):
    tree = fl.build(fl.scenes.make("bun-hair", 300).lines, method)
    for model in (Cost(2.0), Cost(0.6, 3.0)):
        assert expect_visits(tree, 0.0).cost(model) == pytest.approx(tree.cost(by="g", model=model))
    bare, grown = expect_visits(tree, 0.0), expect_visits(tree, 0.01)
    assert grown.inner > bare.inner
    assert grown.tests > bare.tests


def test_expected_steps_are_near_the_counted_ones():
    """Lines of every direction through every point of a disc that covers the scene; a share of them hits the root."""
    lines, radius, n_rays = fl.scenes.make("spaghetti", 300).lines, 0.001, 20_000
    low, high = lines.bounds.astype(np.float64)
    reach = np.linalg.norm(high - low) / 2 + 2 * radius
    rng = np.random.default_rng(5)
    d, across = rng.standard_normal((2, n_rays, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    across -= (across * d).sum(axis=1, keepdims=True) * d
    across *= reach * np.sqrt(rng.random((n_rays, 1))) / np.linalg.norm(across, axis=1, keepdims=True)
    origins = (low + high) / 2 + across - 5 * reach * d
    rays = RayBatch("random", origins.astype(np.float32), d.astype(np.float32))
    x, y, z = high - low + 2 * radius
    share = (x * y + x * z + y * z) / 2 / (np.pi * reach**2)
    for method in BOTH:
        tree = fl.build(lines, method)
        counted, expected = count_visits(tree, rays, radius), expect_visits(tree, radius)
        assert counted.inner / share == pytest.approx(expected.inner, rel=0.05)
        assert counted.tests / share == pytest.approx(expected.tests, rel=0.05)


@pytest.mark.parametrize("scale", [1e-8, 0.7, 1.0, 1e8])
def test_expected_steps_of_the_layout(scale):
    """The root is one node, and the unit of the scene does not matter."""
    lines = fl.scenes.make("spaghetti", 300).lines.segments
    tree = fl.build(lines * np.float32(scale), "bvh-d2")
    nodes, leaves = expect_wide(tree.layout, 0.001 * scale)
    layout = tree.layout
    assert 1 < nodes < len(layout.nodes)
    assert 0 < leaves < len(layout.leaves)
    unit = expect_wide(fl.build(lines, "bvh-d2").layout, 0.001)
    assert (nodes, leaves) == pytest.approx(unit, rel=0.05)
    one = fl.build([[[0, 0, 0], [1, 1, 1]]]).layout
    assert expect_wide(one, 0.0) == pytest.approx((1, 1))


def test_a_fit_finds_what_was_put_in():
    rng = np.random.default_rng(0)
    steps = [dict(zip("abc", row, strict=True)) for row in rng.uniform(1, 10, (20, 3))]
    exact = fit_steps("x", [2 * row["a"] + 7 * row["c"] for row in steps], steps)
    assert exact.ns == pytest.approx({"a": 2, "b": 0, "c": 7}, abs=1e-9)
    assert exact.worst == pytest.approx(0, abs=1e-9)
    # A step whose best time would be negative has time 0.
    signed = fit_steps("x", [9 * row["a"] - 0.3 * row["b"] for row in steps], steps)
    assert signed.ns["b"] == 0
    assert signed.ns["a"] > 0
    assert 0 < signed.error < signed.worst
    # A step that never occurs has time 0.
    assert fit_steps("x", [4.0], [{"a": 2.0, "b": 0.0}]).ns == {"a": 2.0, "b": 0.0}


def test_ranks_by_hand():
    assert ranks([5, 1, 5, 2]).tolist() == [3.5, 1, 3.5, 2]
    assert spearman([1, 2, 3], [2, 4, 9]) == pytest.approx(1)
    assert spearman([1, 2, 3], [9, 4, 2]) == pytest.approx(-1)
    # 1 − 6·Σd²/(n(n² − 1)), with d = 0, 1, 1, 1, 1.
    assert spearman([1, 2, 3, 4, 5], [1, 3, 2, 5, 4]) == pytest.approx(1 - 6 * 4 / 120)
    assert kendall([1, 2, 3, 4, 5], [1, 3, 2, 5, 4]) == pytest.approx((8 - 2) / 10)
    # τ_b: five pairs alike, none otherwise, and one pair equal on the one side.
    assert kendall([1, 2, 2, 3], [1, 2, 3, 4]) == pytest.approx(5 / np.sqrt(5 * 6))
    assert spearman([1, 1], [1, 2]) is None
    assert kendall([3], [1]) is None


def sample(scene, builder, ns, **figures):
    names = ("references", *(f"{which}{step}" for which in ("", "grown ", "vain ") for step in ("inner", "tests")))
    figures = {**dict.fromkeys((*names, "wide nodes", "wide leaves"), 1.0), **figures}
    return calibrate.Sample(scene, builder, "bvh", dict.fromkeys(QUESTIONS, ns), {}, figures)


def test_predictors_of_made_up_trees():
    """The cost swaps two of three trees in one scene, and prefers a tree that is twice as slow there."""
    samples = [
        sample("a", "x", 10.0, inner=1),
        sample("a", "y", 20.0, inner=2),
        sample("a", "z", 30.0, inner=3),
        sample("b", "x", 20.0, inner=1),
        sample("b", "y", 10.0, inner=2),
        sample("b", "z", 30.0, inner=3),
    ]
    found = {predictor.name: predictor for predictor in predictors(samples, None, best_mix(samples))}
    assert "cost, calibrated" not in found
    cost = found["cost"]
    assert (cost.scenes["a"].spearman, cost.scenes["b"].spearman) == pytest.approx((1, 0.5))
    assert (cost.scenes["a"].kendall, cost.scenes["b"].kendall) == pytest.approx((1, 1 / 3))
    assert cost.regret == pytest.approx((0 + 1) / 2)
    assert cost.questions["random all"] == cost.overall
    assert found["references"].overall.spearman is None
    assert predictors(samples, Cost(3.0), best_mix(samples))[2].name == "cost, calibrated"


def test_the_mix_finds_the_share_of_overlap():
    """Times are in the order of overlap, and in the reverse order of area."""
    samples = [sample("a", str(i), 10.0 + i, **{"grown tests": 9.0 - i, "vain tests": float(i)}) for i in range(4)]
    mix = best_mix(samples)
    assert mix.spearman == pytest.approx(1)
    assert mix.alpha == pytest.approx(0.55)  # the first at which the sum rises
    assert mixed(samples[0], 1.0) == pytest.approx(2.0)
    assert mixed(samples[0], 0.0) == pytest.approx(2.0 + 9.0)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--builder", "bvh-dl"], "--builder 'bvh-dl' is not a builder"),
        (["--radius", "nan"], "--radius"),
        (["--json", "c.txt"], "expected .json"),
        (["--file", "nothing.npy"], "nothing.npy"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("calibrate", *TINY, *arguments)[1]
