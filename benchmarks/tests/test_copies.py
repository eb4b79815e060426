"""The commands ``compare`` and ``answers``: copies of fastlines in worker processes."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import done, refused, run

import fastlines as fl
from fastlines_bench.engine import copies
from fastlines_bench.engine.copies import CopiesPreset, alternate, compare_copies, contest_of, differences
from fastlines_bench.peers.copy_process import Copy

pytestmark = pytest.mark.usefixtures("in_own_folder")
TINY = CopiesPreset(scenes=("spaghetti",), radii=(0.01,), n_rays=256, rounds=2, seconds=0.0)


@pytest.fixture
def tiny(monkeypatch):
    monkeypatch.setattr(CopiesPreset, "of", lambda *given, **more: TINY)
    monkeypatch.setattr(copies, "SMALL", 50)


@pytest.mark.usefixtures("tiny")
def test_a_copy_compared_with_itself():
    text = done("compare", "--old", sys.executable, "--json", "c.json")
    assert "All answers and trees are the same" in " ".join(text.split())
    found = json.loads(Path("c.json").read_text())
    assert found["format"] == "fastlines-bench compare 2"
    assert found["old"] == found["new"]
    assert Path(found["old"]["folder"]) == Path(fl.__file__).parent
    assert len(found["means"]) == 3 * 2 + 3 * 8
    assert all(each["same"] and each["ratio"] > 0 for each in found["contests"])


@pytest.mark.usefixtures("tiny")
def test_hashes_are_written_and_checked():
    assert "hashes of fastlines" in done("answers", "--write", "a.json")
    assert "bit for bit" in done("answers", "--check", "a.json")
    written = json.loads(Path("a.json").read_text())
    assert len(written["hashes"]) == len(set(written["hashes"])) == 8 + 2 + 3 * 9
    name = "spaghetti, radius 0.01: random rays, all, surface"
    written["hashes"][name] = "0"
    del written["hashes"]["spaghetti: tree of kd-d2"]
    Path("a.json").write_text(json.dumps(written))
    result = run("answers", "--check", "a.json")
    assert result.exit_code == 1
    assert f"differs: {name}\n" in result.stdout
    assert "differs: spaghetti: tree of kd-d2\n" in result.stdout
    assert "2 of 37 hashes differ" in result.stderr


def test_what_differs_is_named_in_order():
    assert differences({"a": "1", "b": "2", "c": "3"}, {"a": "1", "c": "4", "d": "5"}) == ["b", "c", "d"]


def test_each_copy_goes_first_every_other_round():
    called = []

    class FakeCopy:
        def __init__(self, name):
            self.name = name

        def request(self, method):
            called.append(self.name)
            return self.name

    old, new = FakeCopy("old"), FakeCopy("new")
    assert list(alternate((old, new), 3, lambda copy: copy.request("method"))) == [("old", "new")] * 3
    assert called == ["new", "old", "old", "new", "new", "old"]


def test_a_ratio_is_the_median_of_the_rounds():
    """The ratios of the rounds are 1, 1/4 and 3; the ratio of the medians would be 2/3."""
    contest = contest_of("spaghetti", None, "build", "best", [(1, 1), (2, 8), (9, 3)], True)
    assert (contest.ratio, contest.best) == (1, 1)
    assert contest_of("spaghetti", None, "layout", "best", [(0.0, 0.0)] * 2, True).ratio == 1


def test_both_processes_are_started_again_for_each_scene_and_radius(monkeypatch):
    started = []

    class FakeCopy:
        about = {"version": "0"}  # noqa: RUF012

        def __init__(self, where, n_threads):
            self.where, self.scene, self.radii = where, None, set()
            started.append(self)

        def __enter__(self):
            return self

        def __exit__(self, *error):
            pass

        def request(self, method, /, scene=None, radius=None, **arguments):
            if method == "open":
                assert self.scene is None
                self.scene = scene
            if method == "make_rays":
                self.radii.add(radius)
            if method in ("open", "make_rays", "hash_answer"):
                return "the same hash"
            seconds = 1.0 if self.where == "new" else 2.0
            return {"build": seconds, "layout": seconds, "hash": ""} if method == "build" else seconds

    monkeypatch.setattr(copies, "Copy", FakeCopy)
    preset = replace(TINY, scenes=("spaghetti", "bun-hair"), radii=(0.01, 0.001), rounds=3)
    result = compare_copies("old", "new", preset, {})
    assert [(copy.where, copy.scene, copy.radii) for copy in started] == [
        (where, scene, radii)
        for scene in preset.scenes
        for radii in (set(), {0.01}, {0.001})
        for where in ("old", "new")
    ]
    assert {each.ratio for each in result.contests} == {2.0}


def test_an_error_of_a_worker_is_reported():
    with (
        Copy(sys.executable) as copy,
        pytest.raises(fl.FastlinesError, match=r"'open' .*failed: .*no scene 'spagetti'"),
    ):
        copy.request("open", scene="spagetti")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["compare", "--old", "nowhere"], "is neither a Python nor a folder"),
        (["compare", "--old", "."], "holds no fastlines"),
        (["compare", "--old", sys.executable, "--query", "frist"], "did you mean 'first'"),
        (["compare", "--old", sys.executable, "--radius", "x"], "is not one or more numbers"),
        (["answers"], "--write FILE and --check FILE"),
        (["answers", "--write", "a.txt"], "expected .json"),
        (["answers", "--check", "none.json"], "none.json"),
        (["answers", "--check", "bad.json"], "is not a file that 'fastlines-bench answers --write' wrote"),
    ],
)
def test_refused(arguments, said):
    Path("bad.json").write_text("{}")
    assert said in refused(*arguments)[1]
