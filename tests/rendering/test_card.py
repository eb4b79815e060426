"""What notebooks show of geometry and trees: a picture and a table of facts."""

from __future__ import annotations

import base64
import dataclasses
import io
import pickle
import re
import subprocess
import sys
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

import fastlines as fl
from fastlines.rendering.card.sketch import MAX_DRAWN, sketch, spaced_rows
from fastlines.rendering.card.thumbnail import BACKGROUND, HEIGHT, WIDTH, draw_sketch

POINTS = np.random.default_rng(4).random((60, 3))
ENDS = POINTS.reshape(30, 2, 3)


class Balls:
    """Primitives of a class of one's own."""

    def __init__(self, n=60):
        self.boxes = np.stack([POINTS[:n] - 0.1, POINTS[:n] + 0.1], axis=1)

    def bounds(self):
        return self.boxes

    def hit(self, ids, rays, radius):
        return np.full(len(ids), np.nan)


class Halves(Balls):
    def clipped_bounds(self, ids, boxes):
        return boxes


LINES = fl.Lines.from_segments(ENDS, radius=0.02, strands=np.repeat([0, 1, 2], 10))
CURVES = fl.Curves.from_strands(POINTS, [60], basis="catmull-rom", radius=0.01)
MESH = fl.Triangles(POINTS.reshape(20, 3, 3))
BOXES = fl.Boxes(np.sort(ENDS, axis=1))
SHOWN = {
    "lines": LINES,
    "spheres": fl.Spheres.from_centres(POINTS, 0.1),
    "curves": CURVES,
    "triangles": MESH,
    "boxes": BOXES,
    "geometry": fl.Geometry([LINES, CURVES, MESH, BOXES]),
    "one of yours": fl.build(Balls()).geometry,
    "a point": fl.Lines.from_segments([[[1, 2, 3], [1, 2, 3]]]),
    "flat": fl.Lines.from_segments(ENDS * [1, 1, 0]),
    "far away": fl.Lines.from_segments([[[-1e30, 0, 0], [1e30, 1e30, 1]]]),
    "tiny": fl.Lines.from_segments([[[0, 0, 0], [1e-40, 1e-41, 0]]]),
    "degenerate triangles": fl.Triangles(np.ones((2, 3, 3))),
    "tree": fl.build(LINES),
    "kd tree": fl.build(ENDS, "kd-d2"),
    "refitted": fl.build(ENDS).refit(ENDS[::-1].copy()),
    "tree of curves": fl.build(CURVES),
    "tree of geometry": fl.build(fl.Geometry([MESH, CURVES])),
    "tree of yours": fl.build(Halves()),
    "leaf": fl.build([[[0, 0, 0], [1, 1, 1]]]),
}
EMPTY = {
    "lines": fl.Lines.from_segments([]),
    "boxes": fl.Boxes([]),
    "geometry": fl.Geometry([]),
    "empty parts": fl.Geometry([fl.Triangles([]), fl.Lines.from_segments([])]),
    "curves": fl.Curves.from_bezier(np.empty((0, 4, 3))),
    "tree": fl.build(np.empty((0, 2, 3))),
    "tree of yours": fl.build(Balls(0)),
}


class Checker(HTMLParser):
    """Collects tags and text, and fails on a tag that is not closed."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.text: list[str] = []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag != "img":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def facts(shown) -> dict[str, str]:
    """Return the table of a card."""
    text = Checker(shown._repr_html_()).text
    rows = text[text.index(next(iter(name for name in text if name in ("method", "segments", "parts")))) :]
    return dict(zip(rows[::2], rows[1::2], strict=True))


@pytest.mark.parametrize("name", SHOWN)
def test_everything_has_a_picture_and_a_card(name):
    shown = SHOWN[name]
    picture = Image.open(io.BytesIO(shown._repr_png_())).convert("RGB")
    assert picture.size == (WIDTH, HEIGHT)
    pixels = np.asarray(picture).reshape(-1, 3)
    assert (pixels != BACKGROUND).any()
    html = shown._repr_html_()
    checker = Checker(html)
    assert set(checker.tags) == {"div", "img", "table", "tr", "th", "td"}
    assert "http" not in html
    (data,) = re.findall(r'src="data:image/png;base64,([^"]*)"', html)
    assert base64.b64decode(data) == shown._repr_png_()
    assert len(html) < 100_000


@pytest.mark.parametrize("name", EMPTY)
def test_nothing_has_a_card_without_a_picture(name):
    assert EMPTY[name]._repr_png_() is None
    assert "nothing to draw" in Checker(EMPTY[name]._repr_html_()).text


def test_facts_of_lines():
    lines = dataclasses.replace(LINES, unit="mm", up="z", attributes={"fa": np.ones((30, 3), np.float32)})
    found = facts(lines)
    assert found["segments"] == "30"
    assert found["strands"] == "3"
    assert found["radius"] == "0.02"
    assert found["attributes"] == "fa (float32 × 3)"
    assert found["up"] == "z"
    assert found["size"].endswith(" mm")
    assert facts(fl.Lines.from_points(POINTS, [60], radius=np.linspace(1, 2, 60)))["radius"] == "1 to 2"
    skipped = fl.Lines.from_segments([[[0, 0, np.nan], [1, 1, 1]], *ENDS.tolist()], invalid="skip")
    assert facts(skipped)["left out"].startswith("1 ")
    per_point = fl.Lines.from_points(POINTS, [60], attributes={"t": np.zeros((60, 2))})
    assert facts(per_point)["attributes"] == "t (float64 × 2)"
    with_uv = fl.Triangles.from_mesh(POINTS, [[0, 1, 2]], attributes={"uv": np.zeros((60, 2))})
    assert facts(fl.Geometry([with_uv, CURVES]))["attributes"] == "uv (float64 × 2)"


def test_facts_of_trees():
    tree = fl.build(ENDS, "kd-d2")
    found, stats = facts(tree), tree.stats()
    assert found["method"] == "kd-d2, a KD tree"
    assert found["over"] == "30 segments"
    assert found["nodes"] == f"{stats['n_nodes']:,}, {stats['n_leaves']:,} of them leaves"
    assert found["depth"] == str(stats["depth"])
    assert found["cost"].startswith(f"{stats['cost']:,.6g},")
    assert "on the first query" in found["memory"]
    tree.any_hit([0, 0, -5], [0, 0, 1], 0.1)
    assert "as laid out" in facts(tree)["memory"]
    assert "growth" in facts(SHOWN["refitted"])
    assert facts(fl.build(Balls()))["over"] == "60 of your own"


def rows(answer) -> dict[str, str]:
    """Return the table of the card of an answer, which has no picture."""
    assert answer._repr_png_() is None
    text = Checker(answer._repr_html_()).text
    assert text[0] == type(answer).__name__
    return dict(zip(text[1::2], text[2::2], strict=True))


STRANDS = fl.Lines.from_strands([[[-1, 0, 0], [1, 0, 0], [3, 0, 0]], [[0, -1, 1], [0, 1, 1]]])


def test_facts_of_hits():
    tree = fl.build(STRANDS)
    origins = np.float32([[[0, 0, -5], [2, 0.25, -5], [9, 9, 9]], [[0, 0, -5], [0, 0.5, -5], [2, 0, -5]]])
    first = tree.first_hit(origins, [0, 0, 1], 0.5)
    expected = {
        "rays": "6, 2 × 3",
        "that hit": "5, 83.3 %",
        "t": "5",
        "distance": "0 to 0.5",
        "different prims": "2",
        "different strands": "1",
        "of": "3 segments",
    }
    assert rows(first) == expected
    known = {name: text for name, text in expected.items() if name not in ("different strands", "of")}
    assert rows(pickle.loads(pickle.dumps(first))) == known
    every = rows(tree.all_hits(origins, [0, 0, 1], 0.5, at="surface"))
    assert (every["rays"], every["hits"]) == ("6", "8, 1.33 a ray, 2 at most")
    assert every["t"].endswith(", at surfaces")
    assert rows(tree.first_hit([np.nan, 0, 0], [0, 0, 1], 1, invalid="skip"))["invalid rays"] == "1, which miss"
    assert rows(tree.first_hit(np.zeros((0, 3)), [0, 0, 1], 1)) == {"rays": "0", "of": "3 segments"}
    parts = fl.build(fl.Geometry([MESH, LINES])).all_hits(POINTS - 1, [1, 1, 1], 0.1)
    near = {"distance": "0.5", "different prims": "1", "different strands": "1", "of": "3 segments"}
    points = [[0, 0.5, 0], [9, 9, 9]]
    assert rows(tree.nearest(points, max_distance=1)) == {"points": "2", "with an answer": "1, 50 %"} | near
    twice = rows(tree.nearest([points] * 3, 2, max_distance=1))
    assert (twice["points"], twice["answers"]) == ("6, 3 × 2", "6, 1 a point, 2 at most")
    counts = {"points": "2", "with an answer": "1, 50 %", "answers": "1, 0.5 a point, 1 at most"}
    assert rows(tree.within(points, 0.5)) == counts | near
    assert rows(tree.along([[0, 0.5, 0], [0, 9, 0]], 0.5)) == near
    in_box = {"boxes": "1", "with an answer": "1, 100 %", "answers": "2, 2 a box, 2 at most"}
    assert rows(tree.in_box([-1, -1, -1], [2, 1, 0])) == in_box | {
        "different prims": "2",
        "different strands": "1",
        "of": "3 segments",
    }
    pairs = tree.pairs(1)
    assert rows(pairs) == {"pairs": "1", "distance": "1", "of": "3 segments"}
    assert rows(pickle.loads(pickle.dumps(pairs))) == {"pairs": "1", "distance": "1"}
    thick = fl.build(LINES)
    assert rows(thick.pairs(1, tree))["of"] == "30 segments and 3 segments"
    assert rows(thick.pairs(1, tree))["distance"].endswith(", of surfaces")
    assert rows(tree.pairs(0)) == {"pairs": "0", "of": "3 segments"}
    assert rows(parts)["hits of parts"] == f"0: {(parts.part == 0).sum():,}, 1: {(parts.part == 1).sum():,}"


def test_what_files_say_is_escaped():
    evil = '<script>alert("1")</script>&'
    lines = dataclasses.replace(LINES, unit=evil, attributes={evil: np.arange(30), "x" * 1000: np.zeros(30)})
    html = lines._repr_html_()
    assert set(Checker(html).tags) == {"div", "img", "table", "tr", "th", "td"}
    assert facts(lines)["size"].endswith(evil)
    assert evil in facts(lines)["attributes"]
    assert "x" * 50 not in html
    tree = dataclasses.replace(fl.build(ENDS), method="<b>")
    assert facts(tree)["method"] == "<b>, a BVH"


def test_long_lists_are_cut():
    many = fl.Lines.from_segments(ENDS, attributes={f"a{i}": np.zeros(30) for i in range(99)})
    assert facts(many)["attributes"].endswith("a7 (float64) and 91 more")
    assert facts(fl.Geometry([LINES] * 99))["parts"].endswith(" and 91 more")


# --- Samples ---


def test_large_geometry_is_drawn_by_a_sample():
    points = np.random.default_rng(1).random((200_001, 3))
    lines = fl.Lines.from_points(points, [200_001])
    drawn = sketch(lines)
    assert drawn.n_drawn <= MAX_DRAWN
    assert f"a sample of {drawn.n_drawn:,} of 200,000" in Checker(lines._repr_html_()).text
    both = sketch(fl.Geometry([lines, MESH]))
    assert len(both.parts[1]) == 20
    assert both.n_drawn <= MAX_DRAWN + len(MESH)
    assert "sample" not in LINES._repr_html_()
    curves = fl.Curves.from_strands(points[:30_001], [30_001], basis="bezier")
    assert len(sketch(curves).parts[0]) <= MAX_DRAWN


@pytest.mark.parametrize(
    ("n", "most", "run"), [(0, 5, 2), (5, 5, 2), (6, 5, 2), (64, 63, 32), (999, 100, 7), (9, 1, 4)]
)
def test_rows_of_a_sample_differ_and_reach_both_ends(n, most, run):
    rows = spaced_rows(n, most, run)
    assert len(np.unique(rows)) == len(rows) <= most
    assert len(rows) > 0 or n == 0
    if len(rows) > run:
        assert (rows[0], rows[-1]) == (0, n - 1)


# --- Pictures ---


@pytest.mark.parametrize(("axis", "colour"), [((1, 0, 0), 0), ((0, 1, 0), 1), ((0, 0, -1), 2)])
def test_the_colour_is_the_direction(axis, colour):
    lines = fl.Lines.from_segments([[[0, 0, 0], axis], [[0.5, 0.5, 0.5], np.add(axis, 0.5)]])
    total = (np.asarray(draw_sketch(sketch(lines))).astype(int) - BACKGROUND).clip(0).sum(axis=(0, 1))
    assert total.argmax() == colour
    assert total[colour] > 2 * np.delete(total, colour).max()


def test_the_nearer_is_in_front():
    triangle = fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    both = fl.Geometry([triangle, fl.Lines.from_segments([[[0.1, 0.1, 1e-4], [0.4, 0.4, 1e-4]]], radius=0.02)])
    picture = np.asarray(draw_sketch(sketch(both))).astype(int)
    # The line is yellow, on a blue triangle.
    assert (picture[..., 0] - picture[..., 2]).max() > 60


def test_thick_lines_are_wide():
    lit = [
        (np.asarray(draw_sketch(sketch(fl.Lines.from_segments(ENDS[:1], radius=r)))).max(axis=2) > 60).sum()
        for r in (0.001, 0.1)
    ]
    assert lit[1] > 8 * lit[0]


def test_a_tree_shows_boxes():
    lines, tree = fl.Lines.from_segments(ENDS), fl.build(ENDS)
    plain, boxed = (np.asarray(draw_sketch(sketch(lines), over)) for over in (None, tree))
    assert (plain != boxed).any()


# --- Import ---


def test_pictures_are_imported_when_they_are_needed():
    code = (
        "import sys, fastlines as fl; lines = fl.Lines.from_segments([[[0, 0, 0], [1, 1, 1]]]); repr(lines); "
        "assert not {'PIL', 'fastlines.rendering', 'html', 'base64'} & sys.modules.keys(); lines._repr_png_(); "
        "assert 'PIL' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
