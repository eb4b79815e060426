"""The figures of the thesis, rays, sheets and files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import fastlines as fl
from fastlines import theory as th
from fastlines.drawing.files import write_drawing
from fastlines.drawing.graph import positions
from fastlines.drawing.letters import lettered
from fastlines.inspection import outline_of

FEW = fl.read(Path(__file__).parents[2] / "docs" / "images" / "drawing" / "few.wkt")
BVH = fl.build(FEW, "bvh-cl", cost=fl.Cost(0.25))
KD = fl.build(FEW, "kd-cl", cost=fl.Cost(0.25))
MANY = fl.build(fl.scenes.make("spaghetti", 200).lines, "bvh-d2")


def letters(ax: Any) -> list[str]:
    return sorted(text.get_text() for text in ax.texts if re.fullmatch("[A-Z]+", text.get_text()))


@pytest.mark.parametrize("tree", [BVH, KD], ids=["bvh", "kd"])
def test_partition_and_graph_have_the_same_letters(tree: fl.Tree) -> None:
    expected = [chr(ord("A") + i) for i in range(tree.n_nodes)]
    assert letters(fl.drawing.draw_partition(tree)) == expected
    assert letters(fl.drawing.draw_graph(tree)) == expected


def test_titles_say_which_kind_of_tree_it_is() -> None:
    titles = [fl.drawing.draw_graph(tree).get_title() for tree in (BVH, KD, fl.build(FEW, "kd-cl", cost=fl.Cost(9)))]
    assert titles == ["BVH: 13 nodes", "KD tree: 15 nodes", "One leaf: 1 node"]


def test_leaves_list_their_primitives() -> None:
    below = [text.get_text() for text in fl.drawing.draw_graph(KD).texts if text.get_text().isdigit()]
    assert sorted(below) == ["0", "1", "2", "3", "3", "4", "5", "6"]
    empty = th.build(th.segments([[[0, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 2, 9]]]), th.plane_events, c_trav=0.01)
    assert any(not node.prims for node in empty.nodes())
    assert "∅" in [text.get_text() for text in fl.drawing.draw_graph(empty).texts]


def test_parents_are_above_the_middle_of_their_children() -> None:
    outline = outline_of(MANY)
    named = lettered(outline)
    place = positions(outline, named)
    assert set(place) == set(named.nodes.tolist())
    for nodes in outline.levels[: named.last + 1]:
        across = [place[node][0] for node in nodes.tolist()]
        assert np.diff(across).min(initial=1) >= 1
    for node in np.concatenate(outline.levels[: named.last]).tolist():
        if not outline.is_leaf[node]:
            left, right = place[node + 1], place[int(outline.right[node])]
            assert place[node] == pytest.approx(((left[0] + right[0]) / 2, left[1] + 1))


def test_large_trees_are_cut_at_a_level_and_say_so() -> None:
    outline = outline_of(MANY)
    named = lettered(outline)
    assert len(named.nodes) <= 63 < len(named.nodes) + len(outline.levels[named.last + 1])
    for draw in (fl.drawing.draw_partition, fl.drawing.draw_graph):
        ax = draw(MANY)
        assert f"levels 0 to {named.last}; {MANY.n_nodes - len(named.nodes):,} nodes below" in ax.get_xlabel().replace(
            "\n", " "
        )
        assert letters(draw(MANY, max_level=1)) == ["A", "B", "C"]
        with pytest.raises(fl.InputError, match=r"max_level=9 has [\d,]+ nodes; a figure with letters has at most 63"):
            draw(MANY, max_level=9)


def test_a_ray_has_a_number_for_each_box_that_it_enters() -> None:
    ray = [-1, 3.4, 0], [1, 0.2, 0], 0.1
    for query in ("all", "first"):
        way = fl.inspection.trace_ray(BVH, *ray, query=query)  # type: ignore[arg-type]
        ax = fl.drawing.draw_ray(BVH, *ray, query=query)  # type: ignore[arg-type]
        numbers = [text.get_text() for text in ax.texts if text.get_fontweight() == "bold"]
        assert numbers == [str(i + 1) for i in range(len(way.nodes))]
        assert len(way.hits) > 0
        assert ax.get_title().endswith(f"{len(way.hits)} hit" + "s" * (len(way.hits) != 1))
        points = next(line for line in ax.lines if line.get_marker() == "o")
        assert np.array_equal(points.get_xydata(), way.hits.points()[:, :2])


def test_rays_that_cannot_be_drawn() -> None:
    lesson = th.build(th.segments(FEW.segments), th.object_sweep)
    with pytest.raises(fl.InputError, match=r"a tree of fl\.theory has no rays"):
        fl.drawing.draw_ray(lesson, [0, 0, 0], [1, 0, 0], 0.1)  # type: ignore[arg-type]
    along_the_view = fl.drawing.draw_ray(BVH, [1, 5, -1], [0, 0, 1], 0.5)
    assert any(line.get_marker() == "x" for line in along_the_view.lines)


def test_a_sheet_shows_a_tree_or_several() -> None:
    one = fl.drawing.draw_sheet(MANY, title="lines")
    assert one.get_suptitle().startswith("lines\nbvh-d2: 200 primitives")
    titles = [ax.get_title() for ax in one.axes if ax.get_title()]
    assert len(titles) == 4 + 2 + 3
    several = fl.drawing.draw_sheet({"first": KD, "second": fl.build(FEW, "kd-cl")})
    assert several.get_suptitle().endswith("\ncost with a step of 0.25, a test of 1")
    assert f"second: 7 primitives, 8 references, 15 nodes, cost {KD.cost():.4g}\n" in several.get_suptitle()
    work = [ax.images[0].get_clim() for ax in several.axes if ax.images]
    assert work[0] == work[1]
    done: list[float] = []
    fl.drawing.draw_sheet([BVH, KD], progress=done.append)
    assert done == sorted(done)
    assert done[-1] == 1


def test_a_sheet_of_levels_leaves_out_those_that_are_not_there() -> None:
    assert len(fl.drawing.draw_level_sheet(BVH, 99).axes) == len(BVH.levels())
    assert [ax.get_title() for ax in fl.drawing.draw_level_sheet(BVH, [2, 77]).axes] == ["custom, level 2: 4 boxes"]


@pytest.mark.parametrize(
    ("extension", "start"), [(".svg", b"<?xml"), (".png", b"\x89PNG"), (".pdf", b"%PDF"), (".webp", b"RIFF")]
)
def test_a_figure_gives_the_same_file_each_time(tmp_path: Path, extension: str, start: bytes) -> None:
    contents = []
    for name in ("one", "two"):
        path = tmp_path / (name + extension)
        write_drawing(path, fl.drawing.draw_graph(BVH).figure)  # type: ignore[arg-type]
        contents.append(path.read_bytes())
    assert contents[0].startswith(start)
    assert contents[0] == contents[1]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(name + extension for name in ("one", "two"))


def test_other_extensions_are_refused(tmp_path: Path) -> None:
    with pytest.raises(fl.InputError, match=r"unknown extension '.jpg' for a drawing; expected one of .svg"):
        write_drawing(tmp_path / "tree.jpg", Figure())


def test_figures_are_light_whatever_the_style_is() -> None:
    from matplotlib import rc_context

    with rc_context({"text.color": "white", "axes.labelcolor": "white", "figure.facecolor": "black"}):
        ax = fl.drawing.draw_levels(BVH, 1)
        own = Figure().subplots()
        fl.drawing.draw_levels(BVH, 1, ax=own)
    assert ax.figure.get_facecolor() == (1, 1, 1, 1)
    assert ax.title.get_color() == "#222222"
    assert own.title.get_color() == "white"
    assert own.get_facecolor() == (1, 1, 1, 1)
