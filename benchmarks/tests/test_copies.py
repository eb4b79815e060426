"""The commands ``compare`` and ``answers``: two copies of fastlines in processes of their own."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from command_line import done, refused, run

import fastlines as fl
from fastlines_bench import copies
from fastlines_bench.copies import CopiesPreset, Copy, differences, in_turn

pytestmark = pytest.mark.usefixtures("in_own_folder")
TINY = CopiesPreset(scenes=("spaghetti",), radii=(0.01,), n_rays=256, rounds=2, seconds=0.0)


@pytest.fixture
def tiny(monkeypatch):
    monkeypatch.setattr(CopiesPreset, "of", lambda *given, **more: TINY)
    monkeypatch.setattr(copies, "SMALL", 50)


@pytest.mark.usefixtures("tiny")
def test_a_copy_beside_itself():
    text = done("compare", "--old", sys.executable, "--json", "c.json")
    assert "All answers and trees are the same" in " ".join(text.split())
    found = json.loads(Path("c.json").read_text())
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


def test_each_begins_every_other_round():
    begun = []

    class Pretended:
        def __init__(self, name):
            self.name = name

        def do(self, order):
            begun.append(self.name)
            return self.name

    old, new = Pretended("old"), Pretended("new")
    assert list(in_turn((old, new), 3, lambda copy: copy.do("it"))) == [("old", "new")] * 3
    assert begun == ["new", "old", "old", "new", "new", "old"]


def test_an_error_of_a_copy_is_told():
    with Copy(sys.executable) as copy, pytest.raises(fl.FastlinesError, match=r"asked to open: .*no scene 'spagetti'"):
        copy.do("open", scene="spagetti")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["compare", "--old", "nowhere"], "is no Python and no folder"),
        (["compare", "--old", "."], "holds no fastlines"),
        (["compare", "--old", sys.executable, "--query", "frist"], "did you mean 'first'"),
        (["compare", "--old", sys.executable, "--radius", "x"], "is not one or more numbers"),
        (["answers"], "--write FILE and --check FILE"),
        (["answers", "--write", "a.txt"], "expected .json"),
        (["answers", "--check", "none.json"], "none.json"),
        (["answers", "--check", "bad.json"], "is not what 'fastlines-bench answers --write' writes"),
    ],
)
def test_refused(arguments, said):
    Path("bad.json").write_text("{}")
    assert said in refused(*arguments)[1]
