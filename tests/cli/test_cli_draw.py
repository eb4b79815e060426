"""``fastlines draw`` writes pictures of trees, and refuses what it cannot draw before any work."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support.command_line import done, refused

import fastlines as fl
from fastlines.cli.drawings import Order, figure_of

pytestmark = pytest.mark.usefixtures("in_own_folder")

FEW = str(Path(__file__).parents[2] / "docs" / "images" / "drawing" / "few.wkt")


@pytest.mark.parametrize(
    "options",
    [
        ("--kind", "levels", "--axis", "z"),
        ("--kind", "levels", "--level", "0", "--against", "bvh-cl"),
        ("--kind", "planes", "--method", "kd-d2", "--level", "3"),
        ("--kind", "icicle", "--by", "refs"),
        ("--kind", "leaves", "--by", "share", "--method", "bvh-cl", "--against", "bvh-d2"),
        ("--kind", "depths"),
        ("--kind", "work", "--by", "cost", "--against", "bvh-cl"),
        ("--kind", "thesis", "--method", "kd-cl"),
    ],
    ids=" ".join,
)
def test_each_kind_is_written(options: tuple[str, ...]) -> None:
    said = done("draw", FEW, *options, "-o", "tree.png")
    assert said.startswith(f"tree.png: {options[1]} of ")
    assert said.endswith("over 7 segments\n")
    assert Path("tree.png").read_bytes().startswith(b"\x89PNG")


def test_a_tree_is_drawn_as_it_is_with_others_beside_it() -> None:
    fl.build(fl.read(FEW), "bvh-cl", cost=fl.Cost(0.25)).save("few.flt")
    said = done("draw", "few.flt", "--kind", "graph", "--against", "kd-d2", "-o", "tree.svg")
    assert said == "tree.svg: graph of custom, kd-d2 over 7 segments\n"
    _, sentence = refused("draw", "few.flt", "-m", "kd-d2", "-o", "tree.svg")
    assert "--method does not apply: few.flt is a tree already" in sentence


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("-o", "tree.jpg"), "tree.jpg: unknown extension '.jpg' for a drawing; expected one of .svg"),
        (("-o", "no/tree.svg"), "there is no folder no"),
        (("-o", "x.svg", "--kind", "lvels"), "there is no kind of drawing 'lvels'; did you mean 'levels'?"),
        (("-o", "x.svg", "--level", "2"), "--level does not apply: --kind is sheet"),
        (("-o", "x.svg", "--kind", "graph", "--axis", "x"), "--axis does not apply: --kind is graph"),
        (("-o", "x.svg", "--axis", "w"), "--axis='w' is not a choice"),
        (("-o", "x.svg", "--kind", "leaves", "--by", "cost"), "--by='cost' is not a choice"),
        (("-o", "x.svg", "--method", "bhv"), "unknown method 'bhv'"),
        (("-o", "x.svg", "-m", "best", "--against", "best"), "best is drawn already"),
        (("-o", "x.svg", "--kind", "levels", "--level", "40"), "--level 40: best has levels 0 to 0 here"),
        (("-o", "x.svg", "--kind", "levels", "-m", "kd-cl", "--against", "best"), "add --level to draw one level"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_what_cannot_be_drawn_is_refused_in_a_sentence(options: tuple[str, ...], sentence: str) -> None:
    assert sentence in refused("draw", FEW, *options)[1]
    assert not list(Path().iterdir())


def test_a_level_with_too_many_letters_is_refused_by_its_option() -> None:
    error = refused("draw", "scene:spaghetti:300", "-m", "bvh-d2", "--kind", "thesis", "--level", "9", "-o", "x.svg")[1]
    assert re.match(r"error: --level 9: bvh-d2 has [\d,]+ nodes up to there, and --kind thesis draws at most 63", error)


def test_icicles_beside_each_other_have_one_scale_and_titles_are_on_the_page() -> None:
    trees = {method: fl.build(fl.scenes.make("spaghetti", 100).lines, method) for method in ("bvh-cl", "bvh-d2")}
    common = {"axis": None, "by": None, "skip_invalid": False, "format": None, "option": None}
    for kind, level in (("icicle", None), ("levels", 3)):
        order = Order(source="x", output="x.svg", kind=kind, methods=[None, "bvh-d2"], level=level, **common)
        figure = figure_of(order, "x", trees)
        figure.draw_without_rendering()
        assert all(figure.bbox.containsy(panel.title.get_window_extent().y1) for panel in figure.axes)
        assert len({panel.get_xlim() for panel in figure.axes}) == 1


def test_a_file_without_lines_is_refused() -> None:
    Path("empty.wkt").write_text("LINESTRING EMPTY\n")
    assert "holds no segments" in refused("draw", "empty.wkt", "-o", "x.svg")[1]
