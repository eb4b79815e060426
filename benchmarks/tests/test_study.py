"""The commands of ``study`` at tiny sizes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import done, refused
from PIL import Image

import fastlines as fl
from fastlines_bench.studies import lookahead, options
from fastlines_bench.studies.retraced import SCENES

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_budgets():
    text = done("study", "budgets", "spaghetti:300", "max_refs=500", "max_refs=400,c_trav=2")
    first, second = map(json.loads, text.splitlines())
    assert first["n_refs"] <= 500
    assert second["n_refs"] <= 400
    assert (first["scene"], second["c_trav"]) == ("spaghetti:300", 2.0)


def test_memory():
    text = done("study", "memory", "streamlines:20000", "spaghetti:300", "--threads", 1)
    first, second = map(json.loads, text.splitlines())
    assert first["input_bytes"] == 20_000 * 32
    assert first["peak_bytes"] >= first["tree_bytes"] > 0
    assert second["n_refs"] >= 300


def test_bounds():
    text = done("study", "bounds", "--segments", 60, "--json", "b.json")
    rows = json.loads(Path("b.json").read_text())
    assert len(rows) == 5 * 3
    assert all(row["cost"] >= row["bound"] > 0 for row in rows)
    assert "cost/bound" in text


def test_beams():
    text = done("study", "beams", "--segments", 300, "--radius", "0.01", "--tree", "best,bvh-cl", "--json", "b.json")
    best, whole = json.loads(Path("b.json").read_text())
    assert (best["tree"], whole["tree"]) == ("best", "bvh-cl")
    assert best["refs"] > whole["refs"] == 1
    assert best["queries"][0]["hits"] == whole["queries"][0]["hits"] > 0
    assert text.splitlines()[0].startswith("| beams | tree | references a beam |")


def test_opening():
    rows = done("study", "opening", "--segments", 300).splitlines()
    assert rows[0] == "| 300 segments | ms | with a radius |"
    assert len(rows) == 2 + 2 * 6


def test_frames():
    rows = done("study", "frames", "--segments", 300, "--rays", 400).splitlines()
    assert rows[0] == "| ns a hit | lines, camera | lines, random | curves, camera | curves, random |"
    assert len(rows) == 2 + 7


def test_brightness():
    rows = done("study", "brightness", "scene:bun-hair:2000", "--side", 16, "--samples", 16).splitlines()
    name, normal, high, _ = rows[2].strip("| ").split(" | ")
    assert name == "`scene:bun-hair:2000`, brown"
    assert 0.5 < float(normal) / float(high) < 2


def test_retraced():
    text = done("study", "retraced", "--scene", "spaghetti", "--effort", "0", "--radius", "0.001")
    assert "capped" in text
    assert "random all" in text
    assert "cost" in done("study", "retraced", "--scene", "spaghetti", "--effort", "0", "--aim", "bvh")


@pytest.mark.parametrize("scene", ["one-line-10k", "circling"])
def test_scenes_of_retraced_lines(scene):
    ends = SCENES[scene]()
    assert ends.shape == ({"one-line-10k": 10_000, "circling": 500_000}[scene], 2, 3)


def test_options_are_a_table(monkeypatch):
    monkeypatch.setitem(options.TABLES, "lanes", lambda: iter([["scene", "lanes"], ["hair", "16"]]))
    assert done("study", "options", "--table", "lanes") == "| scene | lanes |\n|---|---|\n| hair | 16 |\n\n"


def test_a_row_of_options():
    tree, seconds = options.timed("spaghetti", method="bvh-cl")
    assert tree.n_prims == 2000
    assert seconds > 0


def test_lookahead(monkeypatch):
    monkeypatch.setattr(lookahead, "THESIS_DEPTHS", {0: (100.0, 0.1), 1: (13.0, 2.0)})
    text = done("study", "lookahead", "--c-trav", 0.6, "--json", "l.json")
    assert "| 1 | 15.7 |" in text
    assert len(json.loads(Path("l.json").read_text())["rows"]) == 2


def test_banner():
    Path("demo/images").mkdir(parents=True)
    names = [*(f"{name}-M" for name in fl.scenes.NAMES), "spaghetti-bvh-d2", "straight-hair-kd-d2"]
    for name in names:
        Image.new("L", (64, 64)).save(f"demo/images/{name}.png")
    done("study", "banner", "demo", "-o", "banner.png")
    with Image.open("banner.png") as picture:
        assert picture.width == 1280


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["budgets", "spaghetti:10", "max_refs"], "is not a budget"),
        (["options", "--table", "lane"], "did you mean 'lanes'"),
        (["retraced", "--scene", "one"], "--scene 'one' is not a scene"),
        (["retraced", "--effort", "x"], "--effort 'x' is not one or more numbers"),
        (["lookahead", "--json", "l.txt"], "expected .json"),
    ],
)
def test_refused(arguments, said):
    assert said in refused("study", *arguments)[1]
