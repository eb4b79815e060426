"""The colours of lines, and their legends."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.inspection import outline_of
from fastlines.viewer.line_colors import LineLegend, check_color, color_names, line_colors
from fastlines.viewer.strokes import Strokes, strokes_of
from fastlines.viewer.tables import legend_html
from fastlines.viewer.tone_curve import light_for, shown_for
from fastlines.viewer.tree_values import tree_values

LINES = fl.Lines.from_segments(
    [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 0, 0]], [[0, 5, 0], [0, 6, 0]]],
    strands=[0, 0, 1],
    radius=[0.1] * 3,
    end_attributes={"fa": [[0.0, 0.5], [0.5, 1.0], [0.25, np.nan]], "v": np.full((3, 2, 3), [3.0, 4.0, 0.0])},
    attributes={"name": ["a", "a", "b"], "kind": [1, 1, 2]},
)


def colored(name: str, geometry: fl.Lines | fl.Geometry = LINES) -> tuple[np.ndarray, LineLegend, Strokes]:
    tree = fl.build(geometry, "kd-cl")
    strokes = strokes_of(tree.geometry)
    return *line_colors(name, strokes, tree.geometry, outline_of(tree)), strokes


def test_names_are_those_of_numbers() -> None:
    assert color_names(LINES) == (
        *("direction", "strand", "depth", "leaf size", "cost", "radius"),
        *("attribute:fa", "attribute:v", "attribute:kind"),
    )
    assert check_color("fa", LINES) == "attribute:fa"


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(fl.InputError, match="coloured by 'dept'; did you mean 'depth'"):
        check_color("dept", LINES)


def test_direction_and_strand() -> None:
    colors, legend, _ = colored("direction")
    assert colors.argmax(axis=2)[:, 0].tolist() == [0, 0, 1]
    assert legend.bar is None
    assert "x is red" in legend.title
    colors, legend, _ = colored("strand")
    assert (colors[0] == colors[1]).all()
    assert (colors[0] != colors[2]).any()
    assert "2 strands" in legend.title


def test_values_at_ends_are_interpolated_and_nan_is_grey() -> None:
    colors, legend, _ = colored("attribute:fa")
    assert legend.bar is not None
    assert (colors[0, 1] == colors[1, 0]).all()  # the same point
    assert (colors[0, 0] != colors[0, 1]).any()
    assert colors[2, 1].tolist() == pytest.approx([0.3] * 3)
    assert legend.notes[-1] == "grey: 1 segment shown without a value (NaN)"
    assert legend.title == "fa per point"


def test_an_attribute_of_nothing_but_nan_is_grey() -> None:
    lines = fl.Lines.from_segments([[[0, 0, 0], [1, 2, 3]]], attributes={"x": [np.nan]})
    colors, legend, _ = colored("attribute:x", lines)
    assert colors == pytest.approx(0.3)
    assert "grey: 1" in legend.notes[-1]


def test_vectors_are_coloured_by_their_length() -> None:
    _, legend, _ = colored("attribute:v")
    assert legend.bar is not None
    assert (legend.bar.low, legend.bar.high) == (5.0, 5.0)
    assert "its length" in legend.title


def test_a_part_without_the_attribute_is_grey() -> None:
    both = fl.Geometry([fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]), LINES])
    colors, legend, strokes = colored("attribute:kind", both)
    assert colors[strokes.prims == 0] == pytest.approx(0.3)
    assert len(np.unique(colors[strokes.prims > 0], axis=0)) > 0
    assert legend.notes[-1] == "grey: 1 primitive shown without a value (NaN)"  # drawn by three strokes


def test_corners_of_triangles_have_values_of_their_own() -> None:
    floor = fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], corner_attributes={"h": [[0.0, 0.5, 1.0]]})
    colors, _, _ = colored("attribute:h", fl.Geometry([floor]))
    assert [(colors[i, 1] == colors[(i + 1) % 3, 0]).all() for i in range(3)] == [True] * 3
    assert len(np.unique(colors.reshape(-1, 3), axis=0)) == 3


@pytest.mark.parametrize("method", ["bvh-cl", "kd-d2"])
def test_values_of_the_tree_are_those_of_its_leaves(method: str) -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 200).lines, method)
    outline = outline_of(tree)
    leaves = [i for i in range(outline.n_nodes) if outline.is_leaf[i]]
    per_prim: dict[int, list[int]] = {}
    for leaf in leaves:
        for prim in outline.prims[outline.refs_of(leaf)].tolist():
            per_prim.setdefault(prim, []).append(leaf)
    expected = {
        "depth": [np.mean([outline.level[leaf] for leaf in per_prim[i]]) for i in range(200)],
        "leaf size": [np.mean([outline.n_refs[leaf] for leaf in per_prim[i]]) for i in range(200)],
    }
    for name, values in expected.items():
        assert tree_values(outline, tree.geometry, name) == pytest.approx(values)
    cost = tree_values(outline, tree.geometry, "cost")
    assert cost.mean() == pytest.approx(1)
    shares = [sum(outline.own_cost[leaf] / outline.n_refs[leaf] for leaf in per_prim[i]) for i in range(200)]
    assert cost / cost.sum() == pytest.approx(np.array(shares) / np.sum(shares))


def test_pieces_of_curves_count_for_their_curves() -> None:
    curves = fl.Curves.from_bezier(np.random.default_rng(1).uniform(0, 1, (3, 4, 3)))
    tree = fl.build(curves)
    assert tree_values(outline_of(tree), tree.geometry, "depth").shape == (3,)


def test_the_legend_has_the_colours_and_their_ends() -> None:
    _, legend, _ = colored("radius")
    assert "<span>0.1</span>" in legend_html(legend)
    _, legend, _ = colored("attribute:fa")
    html = legend_html(legend)
    assert html.count("rgb(") == 16
    assert "NaN" in html


def test_names_from_files_are_escaped() -> None:
    lines = fl.Lines.from_segments([[[0, 0, 0], [1, 2, 3]]], attributes={"<img src=x>": [1.0]})
    _, legend, _ = colored("attribute:<img src=x>", lines)
    assert "<img" not in legend_html(legend)


def test_the_page_shows_the_colours_of_the_legend() -> None:
    colors = np.random.default_rng(0).uniform(0.1, 0.6, (100, 3))
    assert shown_for(light_for(colors)) == pytest.approx(colors, abs=0.03)


def test_primitives_without_a_value_are_counted_not_their_strokes() -> None:
    spheres = fl.Spheres.from_centres([[0, 0, 0], [1, 0, 0], [2, 0, 0]], radius=0.1, attributes={"v": [1, np.nan, 2]})
    assert colored("attribute:v", spheres)[1].notes[-1] == "grey: 1 sphere shown without a value (NaN)"
