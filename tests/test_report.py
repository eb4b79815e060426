"""The pages of ``demo`` and ``report`` at a tiny size: what they write, and that they refuse answers that differ."""

from __future__ import annotations

import contextlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image
from support.command_line import done, refused

import fastlines as fl
from fastlines.rendering import default_camera
from fastlines.report import FULL, QUICK, Preset, demo_page, measure, report_page
from fastlines.report.tables import answer_points
from fastlines.scenes import NAMES, RADII

TINY = Preset(
    scenes={"bun-hair": 400, "straight-hair": 400, "spaghetti": 120, "spaghetti-2": 160, "photon-beams": 200},
    size=24,
    budget=0.001,
    picture=24,
    samples=1,
    panel=32,
    levels=3,
)
METHODS = ("best", "bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-d2", "beams")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo") / "new" / "folder"
    assert demo_page(folder, TINY) == folder / "index.html"
    return folder


class Page(HTMLParser):
    """Collects what a page refers to, and checks that tags are closed."""

    VOID = ("meta", "img", "br", "link")

    def __init__(self, text):
        super().__init__()
        self.links, self.ids, self.open, self.text = [], set(), [], ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.links += [attrs[name] for name in ("href", "src") if name in attrs]
        self.ids.add(attrs.get("id"))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def test_page_is_whole_and_needs_nothing_else(folder):
    text = (folder / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    for link in page.links:
        assert link == "data:," or not re.match(r"\w+:|//", link), "no external resources"
        assert link == "data:," or (link[1:] in page.ids if link.startswith("#") else (folder / link).is_file())
    assert len([link for link in page.links if link.endswith(".png")]) == 5 * (3 + 3)
    assert "Answers agree: yes" in page.text
    assert "35 of 35" in page.text
    assert "width=device-width" in text
    assert "prefers-color-scheme: dark" in text


def test_json_has_everything(folder):
    table = json.loads((folder / "table.json").read_text())
    assert table["n_trees_valid"] == 35
    assert table["n_answers_compared"] >= 35 * 2 * 2 * 16
    assert {"processor", "threads", "python", "fastlines"} <= table["machine"].keys()
    assert [subject["name"] for subject in table["subjects"]] == list(NAMES)
    for subject in table["subjects"]:
        assert subject["radii"] == RADII
        assert [tree["method"] for tree in subject["trees"]] == list(METHODS)
        lines = fl.scenes.make(subject["name"], TINY.scenes[subject["name"]]).lines
        for row in subject["trees"]:
            tree = fl.build(lines, row["method"])
            assert (row["n_refs"], row["n_nodes"], row["bytes"]) == (tree.n_refs, tree.n_nodes, tree.layout.n_bytes)
            assert row["cost"] == tree.cost(model=fl.Cost(0.6 if row["method"].startswith("kd") else 2.0))
            assert list(row["mrays"]) == [f"{query} {letter}" for query in ("first", "all") for letter in RADII]
            assert min([*row["mrays"].values(), *row["as_built"].values()]) > 0


def test_page_explains_its_figures(folder):
    text = Page((folder / "index.html").read_text(encoding="utf-8")).text
    assert "best is built for that" in text
    noise = re.findall(r"The median round took ([\d.e+]+) % longer: smaller differences are noise", text)
    assert len(noise) == 5
    for subject in json.loads((folder / "table.json").read_text())["subjects"]:
        for row in subject["trees"]:
            assert len(row["noise"]) == len(row["mrays"]) + len(row["as_built"])
            assert min(row["noise"]) >= 0


def test_pictures_are_shaded(folder):
    for name in NAMES:
        picture = np.asarray(Image.open(folder / "images" / f"{name}-M.png"))
        assert picture.ndim == 3
        assert (picture[..., 0] != picture[..., 2]).any()


def test_the_bar_moves_within_steps(tmp_path, monkeypatch):
    told = []

    @contextlib.contextmanager
    def listening(progress, what):
        yield told.append

    monkeypatch.setattr("fastlines.report.run.reporting", listening)
    scene = fl.scenes.make("spaghetti", 2000)
    preset = replace(TINY, methods=("best", "bvh-d2"))
    report_page(tmp_path, preset, "it", scene.lines, scene.camera)
    assert told == sorted(told)
    assert told[-1] == 1
    n_steps = 2 + 6 + 1
    assert len({round(share * n_steps, 6) for share in told}) > 3 * n_steps


def test_presets():
    assert list(FULL.scenes) == list(QUICK.scenes) == list(NAMES)
    assert FULL.scenes["bun-hair"] is None
    assert FULL.methods == METHODS


# --- Answers ---


def test_a_wrong_answer_is_found():
    scene = fl.scenes.make("spaghetti", 100)
    moved = scene.lines.segments.copy()
    moved[0] += 0.05
    right, wrong = fl.build(scene.lines, "kd-d2"), fl.build(moved, "bvh-cl")
    for kernel in ("auto", "binary"):
        assert measure.compare(right, fl.build(scene.lines), scene.camera, 0.01, kernel, 32) == 2 * 32 * 32
        with pytest.raises(fl.FastlinesError, match="bvh-cl and kd-d2 answer first hits differently"):
            measure.compare(wrong, right, scene.camera, 0.01, kernel, 32)


# --- Lines of one's own ---


def test_report_of_lines(tmp_path):
    scene = fl.scenes.make("photon-beams", 150)
    lines = fl.Lines.from_segments(1e3 * scene.lines.segments)
    page = report_page(tmp_path, TINY, "some/beams.npz", lines, fl.Camera.framing(lines, (0, 0, -1)))
    text = page.read_text(encoding="utf-8")
    assert "<h1>beams.npz</h1>" in text
    assert "Which tree suits these lines" in text
    assert "is fastest" in text
    side = float((lines.bounds[1] - lines.bounds[0]).max())
    assert f"W = {RADII['W'] * side:.3g}" in text


NASTY = {
    "one": [[[0, 0, 0], [1, 2, 3]]],
    "all in a point": np.ones((5, 2, 3)),
    "on an axis": [[[i, 0, 0], [i + 1, 0, 0]] for i in range(20)],
    "tiny": 1e-8 * fl.scenes.make("spaghetti", 40).lines.segments,
    "huge": 1e8 * fl.scenes.make("spaghetti", 40).lines.segments,
    "far away": 1e6 + fl.scenes.make("spaghetti", 40).lines.segments,
}


@pytest.mark.parametrize("name", NASTY)
def test_report_of_nasty_lines(tmp_path, name):
    lines = fl.Lines.from_segments(NASTY[name])
    page = report_page(tmp_path, replace(TINY, methods=("best", "kd-d2")), name, lines, default_camera(lines))
    assert page.read_text(encoding="utf-8").count("<img") == 3 + 2


def test_a_build_over_the_limit_is_named(tmp_path, capsys):
    scene = fl.scenes.make("bun-hair", 4000)
    page = report_page(tmp_path, replace(TINY, build_limit=0.0, methods=("kd-d2",)), "it", scene.lines, scene.camera)
    assert "the build of kd-d2 did not end within 0 s" in page.read_text(encoding="utf-8")
    assert "did not end within 0 s" in capsys.readouterr().out


def test_the_answer_names_what_is_fastest_and_what_is_near():
    rates = {"best": 100.0, "kd-d2": 92.0, "bvh-cl": 50.0}
    rows = [
        measure.TreeFigures(name, build_s, mrays={"first M": rate, "all M": 200.0 - rate})
        for (name, rate), build_s in zip(rates.items(), (2.0, 3.0, 1.0), strict=True)
    ]
    said = dict(answer_points(rows))
    assert said["First hits"] == "best is fastest, 100 million rays a second; within a tenth of it: kd-d2."
    assert said["All hits"] == "bvh-cl is fastest, 150 million rays a second; best takes 1.5 times as long."
    assert said["Builds"].startswith("bvh-cl is built first, in 1.00 s; best, ")


# --- Commands ---


@pytest.mark.usefixtures("in_own_folder")
def test_commands(monkeypatch, tmp_path):
    monkeypatch.setattr("fastlines.report.QUICK", TINY)
    shown = done("demo", "scene:spaghetti:50", "--quick", "-o", "out")
    assert "spaghetti:50: 50 segments" in shown
    assert "index.html" in shown
    assert "index.html" in done("report", "scene:spaghetti:50", "--quick", "-o", "report")
    assert "Which tree suits" in (tmp_path / "report" / "index.html").read_text(encoding="utf-8")
    code, said = refused("report", "nothing.npz", "-o", "out")
    assert code == 1
    assert "nothing.npz" in said


@pytest.mark.usefixtures("in_own_folder")
def test_the_thesis_is_made_by_another_command():
    assert "fastlines-bench thesis" in refused("report", "thesis")[1]
