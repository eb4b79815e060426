"""Neurons: trees of nodes in any order, and what is odd in them."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutate

import fastlines as fl

#: A soma of three points, a dendrite that forks, and a comment.
NEURON = b"""# by hand
1 1 0 0 0 5 -1
2 1 0 -5 0 5 1
3 1 0 5 0 5 1

4 3 5 0 0 1 1 # first
5 3 6 0 0 1.5 4
6 3 7 1 0 0.5 5
7 3 7 -1 0 0.5 5
8 3 8 -1 0 0.25 7
"""


def ids(lines: fl.Lines) -> list[list[int]]:
    found: list[list[int]] = lines.end_attributes["id"].tolist()
    return found


def test_sections_of_a_neuron(load):
    lines = load(NEURON, "a.swc")
    assert ids(lines) == [[1, 2], [1, 3], [1, 4], [4, 5], [5, 6], [5, 7], [7, 8]]
    np.testing.assert_array_equal(lines.strands, [0, 1, 2, 2, 3, 4, 4])
    np.testing.assert_array_equal(lines.segments[3], [[5, 0, 0], [6, 0, 0]])
    np.testing.assert_array_equal(lines.radius[2:4], [[5, 1], [1, 1.5]])
    np.testing.assert_array_equal(lines.end_attributes["type"][2], [1, 3])
    assert lines.unit == "µm"


def test_order_and_line_ends_do_not_matter(load):
    rows = [line for line in NEURON.split(b"\n") if line and not line.startswith(b"#")]
    lines = load(b"\xef\xbb\xbf" + b"\r\n".join(reversed(rows)), "a.swc")
    assert sorted(ids(lines)) == sorted(ids(load(NEURON, "a.swc")))
    # Each section still goes from its root outwards.
    for strand in np.unique(lines.strands):
        chain = np.array(ids(lines))[lines.strands == strand]
        np.testing.assert_array_equal(chain[1:, 0], chain[:-1, 1])


@pytest.mark.parametrize(
    ("comment", "first"),
    [
        ("# OFFSET 72000.0 15000.5 31000.25", [72001, 15002.5, 31003.25]),
        ("#offset: -1, 2e0, +.5", [0, 4, 3.5]),
        ("# OFFSET\t0 0 100\n# SCALE 1 1 1", [1, 2, 103]),
        ("## OFFSET = [10, 20; 30]", [11, 22, 33]),
        ("# Offset X=10 Y=20 Z=30", [11, 22, 33]),
        ("# OFFSET of the soma", [1, 2, 3]),
        ('# Meta: {"units": "1 micrometer"}', [1, 2, 3]),
    ],
)
def test_offset_is_added(load, comment, first):
    rows = "\n1 0 1 2 3 1 -1\n2 0 2 2 3 1 1 # OFFSET 9 9 9\n"
    lines = load((comment + rows).encode(), "a.swc")
    np.testing.assert_array_equal(lines.segments, np.float32([[first, [first[0] + 1, *first[1:]]]]))


def test_offset_that_float32_rounds(load):
    with pytest.warns(fl.PrecisionWarning):
        lines = load(b"# OFFSET 1e7 0 0\n1 0 0.25 0 0 1 -1\n2 0 3.5 0 0 1 1\n", "a.swc")
    np.testing.assert_array_equal(lines.segments[0, :, 0], np.float32([1e7 + 0.25, 1e7 + 3.5]))


def test_lone_root_is_a_segment_of_zero_length(load):
    lines = load(b"7 1 1 2 3 4 -1", "a.swc")
    np.testing.assert_array_equal(lines.segments, [[[1, 2, 3]] * 2])
    np.testing.assert_array_equal(lines.radius, [[4, 4]])
    assert ids(load(b"1 1 0 0 0 1 -1\n2 1 0 0 0 1 1\n9 1 0 0 0 1 -1", "a.swc")) == [[1, 2], [9, 9]]


@pytest.mark.parametrize(
    ("text", "said", "expected"),
    [
        (b"1 1 0 0 0 1 1", "1 of its nodes are their own parents", [[1, 1]]),
        (b"1 1 0 0 0 1 0", "the parents of 1 of its nodes are not there", [[1, 1]]),
        (
            b"1 0 1 0 0 1 3\n2 0 2 0 0 1 1\n3 0 3 0 0 1 2",
            "3 of its nodes descend from no root",
            [[3, 1], [1, 2], [2, 3]],
        ),
        (
            b"1 0 1 0 0 1 3\n2 0 2 0 0 1 1\n3 0 3 0 0 1 2\n4 0 3 0 0 1 2",
            "4 of its nodes descend from no root",
            [[2, 3], [3, 1], [1, 2], [2, 4]],
        ),
        (
            b"1 1 0 0 0 1 -1\n1 1 0 0 0 1 -1\n2 1 1 0 0 1 1",
            "1 of its nodes have the id of an earlier",
            [[1, 1], [1, 2]],
        ),
        (b"1 1 0 0 0 1 -1\n2 1 1 0 0 1 1\n2 1 2 0 0 1 1", "1 of its nodes have the id", [[1, 2], [1, 2]]),
        (b"# scale 1.0 1 0.5\n1 1 0 0 0 1 -1", "SCALE is 1 1 0.5; coordinates are not scaled", [[1, 1]]),
        (b"#SHRINKAGE_CORRECTION 1.2 1 1\n1 1 0 0 0 1 -1", "SHRINKAGE_CORRECTION is 1.2 1 1; coord", [[1, 1]]),
        (b"# SCALE 2\n1 1 0 0 0 1 -1", "SCALE is 2 2 2; coordinates are not scaled", [[1, 1]]),
        (b"# OFFSET 5 6\n1 1 0 0 0 1 -1", "'OFFSET 5 6' does not have three numbers alone", [[1, 1]]),
        (b"# OFFSET 1 2 nan\n1 1 0 0 0 1 -1", "'OFFSET 1 2 nan' does not have three numbers", [[1, 1]]),
        (b"# OFFSET 5 6 7 mm\n1 1 0 0 0 1 -1", "'OFFSET 5 6 7 mm' does not have three numbers", [[1, 1]]),
        (b"# units: nm\n1 1 0 0 0 1 -1", "say that the unit is 'nm'", [[1, 1]]),
        (b"# OFFSET 0 0 0\n# OFFSET 1 0 0\n1 1 0 0 0 1 -1", "several comments OFFSET; only the first", [[1, 1]]),
        (b'# Meta: {"units": "8 nanometer"}\n1 1 0 0 0 1 -1', "the unit is '8 nanometer'; by the format, µm", [[1, 1]]),
        (b"1 1 0 0 0 1 -1 99", "1 of its lines have more than 7 numbers", [[1, 1]]),
    ],
)
def test_what_is_odd_is_told(load, text, said, expected):
    with pytest.warns(fl.FileWarning, match=said) as told:
        lines = load(text, "a.swc")
    assert len(told) == 1
    assert sorted(ids(lines)) == sorted(expected)


def test_usual_scale_is_not_told(load):
    assert len(load(b"# SCALE 1.0 1.000 1\n1 1 0 0 0 1 -1", "a.swc")) == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"1 1 0 0 0 1 -1\n2 1 0 0 0 1", "line 2 has 6 numbers; expected 7, id type x y z radius parent"),
        (b"# head\n\n1 1 0 0 zero 1 -1", "line 3: '1 1 0 0 zero 1 -1' is not numbers"),
        (b"1 1 0 0 0 -1 -1", "radii must be finite and not negative .see row 0"),
        (b"1.5 1 0 0 0 1 -1", "line 1: the id is 1.5; expected a whole number"),
        (b"1 1 0 0 0 1 nan", "line 1: the parent is nan"),
        (b"1 1e300 0 0 0 1 -1", "line 1: the type is 1e.300"),
        (
            b"1 1 0 0 0 1 -1\n1 1 0 0 1 1 -1\n2 1 1 0 0 1 1",
            "the id 1 stands on lines 1 and 2 for different nodes, and is a parent",
        ),
        (b"1,1,0,0,0,1,-1", "line 1: '1,1,0,0,0,1,-1' is not numbers"),
    ],
)
def test_what_is_wrong_is_refused(load, text, said):
    assert re.search(said, message_of(load, text, "a.swc"))


def test_nan_is_refused_or_skipped(load):
    text = NEURON.replace(b"6 3 7 1 0", b"6 3 nan 1 0")
    with pytest.raises(fl.InputError, match="NaN"):
        load(text, "a.swc")
    assert len(load(text, "a.swc", invalid="skip")) == 6


def test_sections_of_random_trees_against_a_walk(load):
    for seed in range(40):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(1, 40))
        parent = [-1 if i == 0 or rng.random() < 0.1 else int(rng.integers(max(0, i - 3), i)) + 1 for i in range(n)]
        order = rng.permutation(n)
        text = "\n".join(f"{i + 1} 0 {i} 0 0 1 {parent[i]}" for i in order)
        lines = load(text.encode(), "a.swc")
        children = {i + 1: [j + 1 for j in range(n) if parent[j] == i + 1] for i in range(n)}
        sections = set()
        for node in range(1, n + 1):
            is_root = parent[node - 1] == -1
            if is_root and not children[node]:
                sections.add(((node, node),))
            if not is_root and len(children[node]) == 1:
                continue
            for child in children[node]:
                chain = [(node, child)]
                while len(children[chain[-1][1]]) == 1:
                    chain.append((chain[-1][1], children[chain[-1][1]][0]))
                sections.add(tuple(chain))
        found = np.array(ids(lines))
        assert {tuple(map(tuple, found[lines.strands == s].tolist())) for s in np.unique(lines.strands)} == sections


def test_neuron_comes_back_as_it_was_written(load, tmp_path):
    lines = load(NEURON, "a.swc")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fl.write(tmp_path / "b.swc", lines)
    back = fl.read(tmp_path / "b.swc")
    for name in ("segments", "radius", "strands"):
        np.testing.assert_array_equal(getattr(back, name), getattr(lines, name))
    assert ids(back) == ids(lines)
    np.testing.assert_array_equal(back.end_attributes["type"], lines.end_attributes["type"])


@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_other_lines_are_written_as_trees_of_their_own(tmp_path):
    rng = np.random.default_rng(3)
    lines = replace(fl.Lines.from_points(rng.random((9, 3)), [4, 3, 2], radius=rng.random(9)), unit="µm")
    fl.write(tmp_path / "a.swc", lines)
    back = fl.read(tmp_path / "a.swc")
    for name in ("segments", "radius", "strands"):
        np.testing.assert_array_equal(getattr(back, name), getattr(lines, name))
    with pytest.warns(fl.FileWarning, match="no radius, which is written as 0; 'age'"):
        fl.write(tmp_path / "a.swc", fl.Lines.from_points(rng.random((2, 3)), [2], attributes={"age": [1, 2]}))
    fl.write(tmp_path / "a.swc", fl.Lines.from_segments(np.empty((0, 2, 3)), radius=1))
    assert len(fl.read(tmp_path / "a.swc")) == 0


def test_other_order_of_segments_is_told(load, tmp_path):
    lines = load(NEURON, "a.swc")
    ends = {name: values[::-1].copy() for name, values in lines.end_attributes.items()}
    turned = fl.Lines.from_segments(
        lines.segments[::-1], strands=lines.strands[::-1], radius=lines.radius[::-1], end_attributes=ends
    )
    turned = replace(turned, unit="µm")
    with pytest.warns(fl.FileWarning, match="no place for it: the order of segments$"):
        fl.write(tmp_path / "b.swc", turned)
    np.testing.assert_array_equal(fl.read(tmp_path / "b.swc").segments, lines.segments)
    for strands, said in (
        (lines.strands + 1, "the numbers of strands, which are those of sections$"),
        (np.where(lines.strands == 1, -1, lines.strands), "no place for it: that segments have no strand$"),
    ):
        given = replace(lines, strands=strands)
        with pytest.warns(fl.FileWarning, match=said):
            fl.write(tmp_path / "b.swc", given)


def test_types_are_kept_only_at_ends_and_as_whole_numbers(load, tmp_path):
    lines = load(NEURON, "a.swc")
    for types in (lines.end_attributes["type"] + 0.5, np.ones((7, 2, 2), int)):
        more = {"id": lines.end_attributes["id"], "type": types}
        given = fl.Lines(lines.segments, lines.strands, lines.radius, end_attributes=more, unit="µm")
        with pytest.warns(fl.FileWarning, match="no place for it: 'type'$"):
            fl.write(tmp_path / "b.swc", given)
        back = fl.read(tmp_path / "b.swc")
        assert ids(back) == ids(lines)
        assert not back.attributes["type"].any()
    given = fl.Lines(lines.segments, lines.strands, lines.radius, {"type": np.ones(7, int)}, unit="µm")
    with pytest.warns(fl.FileWarning, match="no place for it: 'type'$"):
        fl.write(tmp_path / "b.swc", given)


@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_ids_that_make_no_trees_are_not_kept(tmp_path):
    lines = fl.Lines.from_points(
        np.random.default_rng(3).random((4, 3)), [2, 2], radius=1, attributes={"id": [1, 2, 1, 2]}
    )
    with pytest.warns(fl.FileWarning, match="'id'"):
        fl.write(tmp_path / "a.swc", lines)
    np.testing.assert_array_equal(fl.read(tmp_path / "a.swc").segments, lines.segments)


def test_lone_node_that_repeats_is_written_each_time(tmp_path):
    lines = fl.Lines.from_segments(
        np.ones((2, 2, 3)), strands=[0, 1], radius=1, end_attributes={"id": np.full((2, 2), 5)}
    )
    with pytest.warns(fl.FileWarning, match="no place for it: 'id'$"):
        fl.write(tmp_path / "a.swc", replace(lines, unit="µm"))
    assert len(fl.read(tmp_path / "a.swc")) == 2


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damage_raises_nothing_else(load):
    assert 20 < mutate(load, NEURON, "a.swc") < 290
