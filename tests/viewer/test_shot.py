"""Rays that are typed or clicked, and the tables of their ways."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.inspection import outline_of, trace_ray
from fastlines.viewer.shot import (
    Ray,
    hit_table,
    hits_text,
    ray_ends,
    read_radius,
    read_vector,
    step_text,
    vector_text,
    work_table,
)

TREE = fl.build(fl.scenes.make("spaghetti", 300).lines, "bvh-d2")
RAY = ([0.5, 0.5, -1.0], [0.0, 0.0, 1.0])
BOX = np.array([[0.0, 0, 0], [1, 1, 1]])


@pytest.mark.parametrize("text", ["", "1, 2", "1 2 3 4", "a, b, c", "1,,2"])
def test_a_text_that_is_not_three_numbers(text: str) -> None:
    with pytest.raises(fl.InputError, match=r"origin .* is not three numbers, such as"):
        read_vector(text, "origin")


@pytest.mark.parametrize("text", ["nan, 0, 0", "0 inf 0"])
def test_a_text_that_is_not_finite(text: str) -> None:
    with pytest.raises(fl.InputError, match="not finite"):
        read_vector(text, "origin")


def test_a_text_is_read_as_it_is_written() -> None:
    for vector in ((1 / 3, -2.0, 1e-9), (4500000.123456, 1e30, -0.1)):
        assert read_vector(vector_text(vector), "x") == vector


def test_a_radius_is_read_to_the_last_digit() -> None:
    assert [read_radius(text) for text in ("0.0005", "2.8184e-3", "0")] == [0.0005, 0.0028184, 0.0]
    for text in ("", "-1", "nan", "inf", "a"):
        with pytest.raises(fl.InputError, match="is not a number from 0"):
            read_radius(text)


def test_attributes_with_the_names_of_columns_stand_beside_them() -> None:
    names = ["t", "prim", "distance", "strand", "hit", "part"]
    lines = [[[0, 0, 0], [1, 1, 1]], [[0, 0, 8], [1, 1, 9]]]
    for name in names:
        tree = fl.build(fl.Lines.from_segments(lines, attributes={name: [111.0, 222.0]}))
        table = hit_table(tree.all_hits([[0.5, 0.5, -5]], [[0, 0, 1]], 0.1))
        assert list(table.header) == ["hit", "prim", "t", "distance", f"attribute:{name}"]
        assert table.rows == [["1", "0", "5.5", "0", "111"], ["2", "1", "13.5", "0", "222"]]


def test_the_table_lists_the_hits_of_the_api() -> None:
    hits = TREE.all_hits([RAY[0]], [RAY[1]], 0.05)
    table = hit_table(hits, 5)
    assert list(table.header) == ["hit", "prim", "strand", "t", "distance"]
    expected = zip(hits.prim[:5], hits.strand[:5], hits.t[:5], hits.distance[:5], strict=True)
    assert [row[1:] for row in table.rows] == [[f"{p}", f"{s}", f"{t:.6g}", f"{d:.4g}"] for p, s, t, d in expected]
    assert hits_text(hits, 5) == f"{len(hits)} hits; the first 5 are listed"


def test_the_table_has_attributes_and_parts() -> None:
    lines = fl.Lines.from_segments(
        [[[0, 0, 0], [1, 0, 0]]], end_attributes={"fa": [[0.0, 1.0]]}, attributes={"a": [np.nan], "text": ["x"]}
    )
    tree = fl.build(fl.Geometry([fl.Spheres.from_centres([[9, 9, 9]], radius=1), lines]))
    table = hit_table(tree.all_hits([[0.25, 0, -1]], [[0, 0, 1]], 0.1))
    found = dict(zip(table.header, table.rows[0], strict=True))
    assert (found["part"], found["prim"], found["fa"], found["a"]) == ("1", "0", "0.25", "NaN")
    assert "text" not in found


def test_work_of_two_trees_stands_beside_each_other() -> None:
    other = fl.build(TREE.geometry, "bvh-cl")
    ways = [trace_ray(tree, *RAY, 0.02) for tree in (TREE, other)]
    outlines = [outline_of(TREE), outline_of(other)]
    rows = work_table(["a", "b"], ways, outlines).rows
    assert [row[0] for row in rows] == ["a", "b"]
    assert [row[1] for row in rows] == [f"{way.n_steps:,}" for way in ways]
    assert rows[0][4] == rows[1][4]  # the same hits


def test_steps_are_told_one_by_one() -> None:
    outline = outline_of(TREE)
    way = trace_ray(TREE, *RAY, 0.02)
    assert step_text(way, outline, 1).startswith(f"step 1 of {len(way.nodes)}: inner node 0, level 0")
    first = int(np.flatnonzero(way.is_leaf)[0])
    assert f"leaf {way.nodes[first]}, " in step_text(way, outline, first + 1)
    assert step_text(way, outline, 10**6).startswith(f"step {len(way.nodes)} of")
    assert step_text(way, outline, 0) == "before the first node"
    assert "misses the box" in step_text(trace_ray(TREE, [9, 9, 9], [0, 0, 1], 0.0), outline, 1)


def test_the_ray_is_drawn_through_the_box() -> None:
    both = ray_ends(Ray((0.5, 0.5, -9.0), (0.0, 0.0, 2.0)), BOX)
    assert both is not None
    assert both[:, 2].tolist() == pytest.approx([-0.1, 1.1])
    inside = ray_ends(Ray((0.5, 0.5, 0.5), (0.0, 0.0, 2.0)), BOX, stop=0.125)
    assert inside is not None
    assert inside[:, 2].tolist() == pytest.approx([0.5, 0.75])
    assert ray_ends(Ray((5.0, 0.5, -9.0), (0.0, 0.0, 2.0)), BOX) is None
