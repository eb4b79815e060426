"""The demonstration at a tiny size: all that it writes, and that it refuses answers that differ."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import fastlines as fl
from fastlines.demo import FULL, QUICK, Plan, run_demo
from fastlines.demo.measure import Answers, CameraRays, digest, measure
from fastlines.demo.reference import THESIS
from fastlines.demo.run import compare
from fastlines.methods import THESIS_METHODS
from fastlines.scenes import NAMES, RADII

TINY = Plan(
    "tiny",
    scenes={"bun-hair": 400, "straight-hair": 400, "spaghetti": 120, "spaghetti-2": 160, "photon-beams": 200},
    rays=24,
    budget=0.02,
    picture=24,
    samples=1,
    panel=32,
    levels=3,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo") / "new" / "folder"
    page = run_demo(folder, TINY, show=False)
    assert page == folder / "index.html"
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
        assert not re.match(r"\w+:|//", link), "no external resources"
        assert link[1:] in page.ids if link.startswith("#") else (folder / link).is_file()
    assert len([link for link in page.links if link.endswith(".png")]) == 2 * 5 * (3 + 2)  # shown, and linked to
    assert "Answers agree: yes" in page.text
    assert "25 of 25" in page.text
    assert "width=device-width" in text
    assert "prefers-color-scheme: dark" in text
    for scene in THESIS.values():
        assert f"{scene['kd-d2'].cost:,.2f}" in page.text


def test_table_json_has_everything(folder):
    table = json.loads((folder / "table.json").read_text())
    assert table["answers_agree"]
    assert table["n_trees_valid"] == 25
    assert table["n_answers_compared"] >= 5 * 4 * 6 * 9
    assert {"processor", "threads", "python", "fastlines"} <= table["machine"].keys()
    assert [scene["name"] for scene in table["scenes"]] == list(NAMES)
    for scene in table["scenes"]:
        assert [tree["method"] for tree in scene["trees"]] == list(THESIS_METHODS)
        for tree in scene["trees"]:
            assert tree["n_prims"] == TINY.scenes[scene["name"]]
            assert tree["cost"] == pytest.approx(tree["cost_g"], rel=1e-9)
            assert tree["thesis"]["cost"] > 0
            for kind in ("first", "all"):
                assert list(tree["queries"][kind]) == list(RADII)
                for timing in tree["queries"][kind].values():
                    assert timing["n_rays"] == 24 * 24 >= timing["n_measured"] > 0
                    assert timing["ms"] > 0


def test_table_md_has_a_row_for_each_tree(folder):
    text = (folder / "table.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith(("| bvh", "| kd"))]
    assert len(rows) == 25
    assert (
        len({row.count("|") for row in text.splitlines() if row.startswith("|")} - {text.count("|---") // 5 + 1}) <= 1
    )


def test_terminal_table(tmp_path, capsys):
    plan = replace(TINY, scenes={"spaghetti": 50}, methods=("bvh-cl", "kd-cl"))
    run_demo(tmp_path, plan, show_progress=True)
    shown = capsys.readouterr()
    assert "Spaghetti: 50 segments" in shown.out
    assert "bvh-cl" in shown.out


def test_plans_are_what_the_page_says():
    assert list(FULL.scenes) == list(QUICK.scenes) == list(NAMES)
    assert FULL.scenes["bun-hair"] is None
    for name in NAMES:
        assert len(fl.scenes.make(name).lines) == THESIS[name]["bvh-cl"].n_prims


# --- Answers ---


@pytest.fixture(scope="module")
def rays():
    scene = fl.scenes.make("spaghetti", 100)
    return scene.lines, CameraRays.of(scene.camera, 32)


def test_a_wrong_answer_is_found(rays):
    lines, grid = rays
    tree = fl.build(lines, "kd-d2")
    moved = lines.segments.copy()
    moved[0] += 0.05
    for kind in ("first", "all"):
        _, right = measure(tree, grid, kind, 0.01, 10.0)
        _, same = measure(fl.build(lines, "bvh-cl"), grid, kind, 0.01, 10.0)
        _, wrong = measure(fl.build(moved, "bvh-cl"), grid, kind, 0.01, 10.0)
        assert compare("it", {"a": right, "b": same}) == 32 * 32
        with pytest.raises(fl.FastlinesError, match=r"it: a and b answer \d+ of 1024 rays differently"):
            compare("it", {"a": right, "b": wrong})


def test_a_part_of_the_rays_is_compared_with_all(rays):
    lines, grid = rays
    tree = fl.build(lines)
    whole, all_answers = measure(tree, grid, "all", 0.01, 10.0)
    part, some_answers = measure(tree, grid, "all", 0.01, 0.0)
    assert (whole.n_measured, part.n_measured, part.n_rays) == (1024, 64, 1024)
    assert part.ms == pytest.approx(1e3 * part.seconds * 16)
    assert compare("it", {"a": all_answers, "b": some_answers}) == 64
    other = Answers(some_answers.stride, some_answers.values + np.uint64(1))
    assert all_answers.count_differences(other) == (64, 64)


def test_digest_sees_ids_depths_and_their_order(rays):
    lines, grid = rays
    hits = fl.build(lines).all_hits(grid.origin, grid.directions, 0.05)
    before = digest(hits)
    ray = int(hits.counts.argmax())
    first = hits.offsets[ray]
    assert (before[:, 0] == hits.counts.astype(np.uint64)).all()
    for change in ("prim", "t"):
        values = getattr(hits, change).copy()
        values[[first, first + 1]] = values[[first + 1, first]]
        assert np.flatnonzero((digest(replace(hits, **{change: values})) != before).any(axis=1)).tolist() == [ray]
