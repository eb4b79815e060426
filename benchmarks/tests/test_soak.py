"""The command ``soak`` at a tiny size: what it finds, and what it writes."""

from __future__ import annotations

import json
import pickle
import runpy
import sys
import types
import warnings
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

import fastlines as fl
from fastlines.theory.hits import closest_approach, deepest_approach
from fastlines_bench.soak.answers import QUERIES
from fastlines_bench.soak.compare import difference, outcomes
from fastlines_bench.soak.decisions import check_decisions
from fastlines_bench.soak.draw import KINDS, Choice, draw_case
from fastlines_bench.soak.exact import ExactRays, clearance_of_cones, decide_boxes, decide_triangles
from fastlines_bench.soak.exact_pairs import distance_of_pairs, factor_of_tapers
from fastlines_bench.soak.exact_points import distance_from_boxes, distance_from_cones, distance_from_triangles
from fastlines_bench.soak.exact_regions import decide_in_boxes
from fastlines_bench.soak.faults import FAULTS, run_trial
from fastlines_bench.soak.parts import part_over
from fastlines_bench.soak.run import Plan, run_soak
from fastlines_bench.soak.shrink import minimised, rounded_to, shrink
from fastlines_bench.soak.values import Values
from fastlines_bench.soak.write import text_of_test

pytestmark = [
    pytest.mark.usefixtures("in_own_folder"),
    pytest.mark.filterwarnings("ignore::fastlines.PrecisionWarning"),
]


def silent(*_):
    pass


def test_run():
    text = done("soak", "--cases", 15, "--seed", 3, "--json", "soak.json")
    assert "answers by geometry" in text
    assert "wrong: 0" in text
    assert " 0 differ" in text
    found = json.loads(Path("soak.json").read_text())
    assert found["format"] == "fastlines-bench soak 1"
    assert sum(row["n"] for row in found["answers"]) > 50
    assert sum(row["n"] for row in found["decisions"]) > 100_000
    assert {row["wrong"] for row in found["decisions"]} == {0}
    assert sum(row["n"] for row in found["values"]) > 10_000
    assert {row["wrong"] for row in found["values"]} == {0}
    assert found["found"] == []


def test_only_what_is_chosen():
    plan = Plan(1, n_cases=20, choice=Choice.of(("spheres", "nearest", "within")))
    summary = run_soak(plan, silent, silent)
    assert {key[:2] for key in summary.answers} == {("spheres", "nearest"), ("spheres", "within")}
    assert not summary.tally.n
    assert Choice.of(None) == Choice(KINDS, QUERIES)


def test_a_seed_makes_the_same_cases():
    for number in (0, 7):
        once, again = draw_case(5, number), draw_case(5, number)
        assert pickle.dumps(once) == pickle.dumps(again)
    assert pickle.dumps(draw_case(5, 0)) != pickle.dumps(draw_case(6, 0))


def test_interruption_leaves_a_summary():
    def interrupt(*_):
        raise KeyboardInterrupt

    summary = run_soak(Plan(1, seed=3), interrupt, silent)
    assert summary.was_interrupted
    assert summary.n_cases == 1
    assert summary.is_clean


def test_the_case_that_runs_is_in_a_file():
    """If the process itself dies, the file has the command that repeats the case."""
    seen = []
    plan = Plan(1, seed=3, n_cases=2, folder=Path("found"))
    run_soak(plan, lambda *_: seen.append(Path("found/running.txt").read_text()), silent)
    assert seen == ["fastlines-bench soak --seed 3 --case 0\n", "fastlines-bench soak --seed 3 --case 1\n"]
    assert not Path("found/running.txt").exists()


@pytest.mark.parametrize(
    "name", ["a leaf has lost a reference", "t_max is left out", "ties are in the wrong order", "a pair is lost"]
)
def test_a_planted_fault_becomes_a_test(name):
    """It is found, is small, and the test that is written fails by itself; without the fault the test passes."""
    fault = next(fault for fault in FAULTS if fault.name == name)
    trial = run_trial(fault, Plan(5, seed=1, folder=Path("found")), silent, silent)
    assert trial.found is not None
    small = trial.found.shrunk
    assert small.n_prims <= 5
    assert len(small.questions[0]) <= 2
    written = runpy.run_path(str(trial.found.path))
    (test,) = (value for key, value in written.items() if key.startswith("test_soak_1_"))
    arguments = {"tmp_path": Path("found"), "monkeypatch": pytest.MonkeyPatch()}
    given = {key: arguments[key] for key in test.__code__.co_varnames[: test.__code__.co_argcount]}
    with fault.planted(), pytest.raises(AssertionError):
        test(**given)
    test(**given)
    arguments["monkeypatch"].undo()
    assert difference(small) is None


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_all_planted_faults_are_found(fault):
    assert run_trial(fault, Plan(5, seed=2), silent, silent).is_found


def test_written_tests_of_all_queries_pass(monkeypatch):
    """What is written asks the same question: of cases that do not fail, every test passes."""
    seen = set()
    for number in range(60):
        case = draw_case(11, number)
        for question, outcome in zip(case.questions, outcomes(case), strict=False):
            key = question.query, case.kind in ("own class", "several parts"), case.offset is not None
            key += case.frame is not None, bool(case.spoiled)
            if key in seen or outcome.is_refused or len(question) > 100 or case.n_prims > 100:
                continue
            seen.add(key)
            module = types.ModuleType("written")  # where pickle looks for classes
            monkeypatch.setitem(sys.modules, "written", module)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                exec(text_of_test(case.alone(question), "test_it", "soak", "nothing"), vars(module))
                folder = Path(f"{number}-{question.query}")
                folder.mkdir(exist_ok=True)
                with monkeypatch.context() as patch:
                    arguments = {"tmp_path": folder.absolute(), "monkeypatch": patch}
                    code = module.test_it.__code__
                    module.test_it(**{key: arguments[key] for key in code.co_varnames[: code.co_argcount]})
    assert {key[0] for key in seen} == set(QUERIES)
    assert {key[3:] for key in seen} >= {(False, False), (True, False), (False, True)}


def test_a_fault_of_both_sides_is_found_beside_float64():
    fault = next(fault for fault in FAULTS if fault.is_of_both)
    trial = run_trial(fault, Plan(5, seed=1, choice=Choice.of(("lines", "all_hits"))), silent, silent)
    assert trial.is_found
    assert trial.found is None
    assert "lines, distance of pairs on" in trial.shown_by


def test_shrinking_leaves_what_is_needed():
    assert minimised(100, lambda rows: {17, 63} <= set(rows.tolist())).tolist() == [17, 63]
    assert minimised(5, lambda rows: True).tolist() == []
    assert rounded_to(np.array([1234.5, 0.0456]), 2).tolist() == [1200, 0.046]
    case = draw_case(5, 1)
    question = replace(case.questions[0], kernel="wave", n_threads=3)
    small = shrink(case.alone(question), lambda smaller: smaller.n_prims >= min(2, case.n_prims))
    assert (small.n_prims, small.build, small.steps) == (min(2, case.n_prims), {}, ())
    assert (small.questions[0].kernel, small.questions[0].n_threads) == ("auto", 1)


def test_what_is_ignored_has_the_new_numbers():
    case = next(case for case in map(partial(draw_case, 5), range(9)) if case.n_prims > 9 and case.questions)
    rows = {**case.questions[0].rows, "ignore": np.array([[2, -1], [7, 5]])}
    few = case.alone(replace(case.questions[0], rows=rows)).some(np.array([5, 7, 8]))
    assert few.n_prims == 3
    assert few.questions[0].rows["ignore"].tolist() == [[-1, -1], [1, 0]]


def rays(rng, n=60):
    origins, directions = rng.normal(0, 2, (n, 3)), rng.normal(0, 1, (n, 3))
    t_max = np.where(rng.random(n) < 0.5, np.inf, rng.uniform(0, 3, n))
    rows = {"origins": origins, "directions": directions, "radius": 0.1 * rng.random(n), "t_max": t_max}
    return {name: values.astype(np.float32) for name, values in rows.items()}


def test_clearance_is_that_of_a_search():
    rng = np.random.default_rng(1)
    rows, ends, radii = rays(rng), rng.normal(0, 1, (40, 2, 3)), rng.random((40, 2))
    radii[::4] = 0
    ends[::5, 1] = ends[::5, 0]
    rows["spread"] = np.where(rng.random(60) < 0.5, 0, 0.1 * rng.random(60)).astype(np.float32)
    centre = np.array([0.25, 0.5, 0.75])
    found = clearance_of_cones(ExactRays.of(rows, centre), ends - centre, radii)
    given = rows["origins"], rows["directions"], rows["radius"], 0.0, rows["t_max"]
    expected = deepest_approach(ends, radii, *given, spread=rows["spread"])[0]
    assert np.abs(found - expected).max() < 1e-9
    plain = {**rows, "spread": 0 * rows["spread"], "radius": 0 * rows["radius"]}
    thin = clearance_of_cones(ExactRays.of(plain, centre), ends - centre, 0 * radii)
    expected = closest_approach(ends, rows["origins"], rows["directions"], 0.0, rows["t_max"])[0]
    assert np.abs(thin - expected).max() < 1e-9


@pytest.mark.parametrize("kind", ["triangles", "boxes"])
def test_certain_decisions_are_those_of_brute_force(kind):
    rng = np.random.default_rng(2)
    rows, corners = rays(rng), rng.normal(0, 1, (40, 3, 3)).astype(np.float32)
    if kind == "boxes":
        corners = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)
    hits = fl.brute_force((fl.Triangles if kind == "triangles" else fl.Boxes)(corners), **{**rows, "radius": 0})
    decide = decide_triangles if kind == "triangles" else decide_boxes
    is_hit, certain = decide(ExactRays.of(rows, np.zeros(3)), corners.astype(np.float64), np.full((60, 1), 1e-6))
    found = np.zeros(is_hit.shape, bool)
    found[hits.ray, hits.prim] = True
    assert found.any()
    assert certain.mean() > 0.999
    assert (found == is_hit)[certain].all()


def test_distances_of_points_are_those_of_a_search():
    rng = np.random.default_rng(3)
    points, ends, radii = rng.normal(0, 1, (50, 3)), rng.normal(0, 1, (40, 2, 3)), rng.random((40, 2))
    ends[::5, 1] = ends[::5, 0]
    s = np.linspace(0, 1, 2001)[:, None, None]
    axis = ends[:, 0] + s[..., None] * (ends[:, 1] - ends[:, 0])
    sampled = np.linalg.norm(points[:, None] - axis, axis=-1) - (radii[:, 0] + s * (radii[:, 1] - radii[:, 0]))
    found = distance_from_cones(points, ends, radii)
    assert (found <= sampled.min(axis=0) + 1e-12).all()
    assert (found >= sampled.min(axis=0) - 1e-3).all()
    corners = rng.normal(0, 1, (40, 3, 3)).astype(np.float32)
    boxes = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)
    for distance, made, numbers in (
        (distance_from_triangles, fl.Triangles(corners), corners),
        (distance_from_boxes, fl.Boxes(boxes), boxes),
    ):
        nearest = fl.brute_force_points(made, points, k=40)
        exact = np.sort(distance(points, numbers.astype(np.float64)), axis=1)
        assert np.abs(nearest.distance - exact).max() < 1e-6


def test_wrong_decisions_are_noticed(monkeypatch):
    """A radius that is larger by 4 parts in a million changes some decisions outside the band."""
    real, grow = fl.Tree.all_hits, np.float32(1 + 4e-6)
    monkeypatch.setattr(fl.Tree, "all_hits", lambda tree, radius, **rows: real(tree, radius=radius * grow, **rows))
    wrong = [check_decisions(1, number, ("cones",), 256) for number in range(8)]
    assert sum(sum(tally.wrong.values()) for tally in wrong) > 0
    assert any(tally.examples for tally in wrong)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--only", "lynes"], "did you mean 'lines'"),
        (["--case", 3, "--cases", 2], "--case runs one case"),
        (["--json", "soak.txt"], ".json"),
        (["--only", "boxes,pairs"], "boxes have no pairs"),
        (["--planted", "--write", "found"], "--planted prints a table of the faults; leave out --write"),
        (["--minutes", "1e400"], "--minutes is inf; expected a number"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("soak", *arguments)[1]


def test_pairs_are_those_of_a_grid():
    rng = np.random.default_rng(4)
    ends, radii = rng.normal(0, 1, (2, 30, 2, 3)), 0.3 * rng.random((2, 30, 2))
    found = distance_of_pairs(ends[0], radii[0], ends[1], radii[1])
    at = np.linspace(0, 1, 300)
    places = [
        (np.stack([1 - at, at], axis=1) @ of, np.stack([1 - at, at], axis=1) @ r[..., None])
        for of, r in zip(ends, radii, strict=True)
    ]
    (a, r), (b, q) = places
    away = np.linalg.norm(a[:, :, None] - b[:, None], axis=3) - r - q.swapaxes(1, 2)
    least = away.min(axis=(1, 2))
    assert (found <= least + 1e-12).all()
    assert (least - found < 1e-3).all()
    assert (factor_of_tapers(ends[0], 0 * radii[0], ends[1], 0 * radii[1]) == 1).all()
    beside = ends[0] + 1e-4 * ends[1]
    assert (factor_of_tapers(ends[0], 1e-5 * radii[0], beside, 1e-5 * radii[1]) > 10).any()


@pytest.mark.parametrize("kind", ["lines", "cones", "triangles", "boxes"])
def test_certain_decisions_about_boxes_of_space(kind):
    rng = np.random.default_rng(5)
    ends = rng.integers(-4, 5, (60, 2, 3)).astype(np.float32)
    low = rng.integers(-4, 4, (40, 3)).astype(np.float64)
    high = low + rng.integers(0, 3, (40, 3))
    high[0], low[1, 0] = np.inf, -np.inf
    part = part_over(rng, kind, ends)
    geometry = part.made()
    corners = geometry.corners if kind in ("triangles", "boxes") else geometry.segments
    radii = geometry.end_radii if kind == "cones" else None
    is_in, certain = decide_in_boxes(kind, corners, radii, low, high)
    listed = fl.brute_force_in_box(geometry, low, high)
    found = np.zeros(is_in.shape, bool)
    found[listed.box, listed.prim] = True
    assert found.any()
    assert certain.mean() > 0.5
    assert (found == is_in)[certain].all()


def test_values_that_are_off_are_told():
    values = Values()
    values.check("cones, t", "avx2", np.array([0.5, -1, np.nan]), np.array([1.0, 1, 1]))
    values.check("cones, t", "avx2", np.zeros((0, 1)), np.zeros((0, 1)))
    assert (values.n, values.wrong) == ({("cones, t", "avx2"): 3}, {("cones, t", "avx2"): 1})
    assert values.examples == ["cones, t on avx2: off by nan, expected at most 1"]
    more = Values()
    more.check("cones, t", "avx2", np.array([3.0]), np.array([2.0]))
    values.add(more)
    assert values.wrong["cones, t", "avx2"] == 2
