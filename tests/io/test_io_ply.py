"""Edges of PLY files."""

from __future__ import annotations

import struct
import warnings

import numpy as np
import pytest
from support.line_files import PLY_HEADER, POINTS, lost_by, message_of, ply
from support.mutations import mutate

import fastlines as fl

EDGES = np.array([[0, 1], [1, 2], [3, 4], [5, 6]])


@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize("others", [(), ((0, 1, 2), (3, 4, 5)), ((0, 1), (), (1, 2, 3))])
def test_edges(load, order, others):
    lines = load(ply(order, others=others), "a.ply")
    np.testing.assert_array_equal(lines.segments, POINTS.astype("f4")[EDGES])
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 2])
    np.testing.assert_array_equal(lines.radius, EDGES / 2)
    assert set(lines.attributes) == {"age", "red", "uv"}
    np.testing.assert_array_equal(lines.attributes["age"], [0, -1, -2, -3])
    np.testing.assert_array_equal(lines.end_attributes["red"], 200 + EDGES)
    np.testing.assert_array_equal(lines.end_attributes["uv"], np.stack([EDGES, EDGES / 4], axis=2))
    assert [lines.attributes[name].dtype for name in ("age", "red", "uv")] == [np.int16, np.uint8, np.float32]


@pytest.mark.parametrize("end", [b"\r\n", b"\r"])
def test_line_ends_of_the_header(load, end):
    header, body = ply("<").split(b"end_header\n")
    lines = load(header.replace(b"\n", end) + b"end_header" + end + body, "a.ply")
    assert len(lines) == 4
    assert len(load(ply("").replace(b"\n", end), "a.ply")) == 4


@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize("others", [(), ((0, 1, 2), (3, 4, 5)), ((0, 1), (), (1, 2, 3))])
@pytest.mark.parametrize("begin", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_mixed_line_ends_of_the_header(load, order, others, begin, end):
    """The data that end with the file prove where they start."""
    header, body = ply(order, others=others).split(b"end_header\n")
    for lines in (header.replace(b"\n", begin), header.replace(b"\n", begin, 3)):
        read = load(lines + b"end_header" + end + body, "a.ply")
        np.testing.assert_array_equal(read.segments, POINTS.astype("f4")[EDGES])


@pytest.mark.parametrize("begin", [b"\n", b"\r"])
def test_data_that_begin_as_a_line_ends(load, begin):
    x = np.array([0x0A, 0, 0x40, 0x40], np.uint8).view("<f4")
    header = PLY_HEADER.format(format="binary_little_endian", vertices=2, other="patch", others=0, edges=1)
    vertex = x.tobytes() + bytes(3 * 4 + 1 + 2 * 4)
    data = vertex + bytes(len(vertex)) + struct.pack("<2ih", 0, 1, 0)
    read = load(header.replace("\n", begin.decode()).encode() + data, "a.ply")
    assert read.segments[0, 0, 0] == x[0]


def test_comments_may_hold_carriage_returns(load):
    data = ply("<").replace(b"\nelement", b"\ncomment a\rb\nelement", 1)
    np.testing.assert_array_equal(load(data, "a.ply").segments, POINTS.astype("f4")[EDGES])


def test_faces_are_counted(load):
    with pytest.warns(fl.FileWarning, match="its 2 faces are not read; only its edges are lines"):
        assert len(load(ply(other="face"), "a.ply")) == 4
    with pytest.warns(fl.FileWarning, match="its 2 faces are not read"):
        assert len(load(ply(other="face", edges=()), "a.ply")) == 0


@pytest.mark.parametrize(("order", "unit"), [("<", "3 bytes"), ("", "1 numbers")])
def test_what_follows_is_told(load, order, unit):
    with pytest.warns(fl.FileWarning, match=f"{unit} after its last element are not read"):
        assert len(load(ply(order, tail=b" 7\n"), "a.ply")) == 4


def test_numbers_that_are_not_of_their_type(load):
    with pytest.warns(fl.FileWarning, match="some of its numbers 'red' of element 'vertex' are not of their type"):
        lines = load(ply("").replace(b" 203 ", b" 0.5 "), "a.ply")
    np.testing.assert_array_equal(lines.attributes["red"], [200, 201, 0.5, 205])


@pytest.mark.parametrize("order", ["", "<"])
def test_lists_of_vertices_and_edges_are_skipped(load, order):
    header = (
        "ply\nformat {} 1.0\nelement vertex 2\nproperty list uchar short tags\nproperty float x\nproperty float y\n"
        "property float z\nelement edge 1\nproperty int vertex1\nproperty list char float more\nproperty int vertex2\n"
        "end_header\n"
    )
    rows = [("Bhh3f", (2, 5, 6, 1, 2, 3)), ("B3f", (0, 4, 5, 6)), ("ibfi", (1, 1, 0.5, 0))]
    if order:
        data = header.format("binary_little_endian").encode() + b"".join(struct.pack("<" + f, *row) for f, row in rows)
    else:
        data = header.format("ascii").encode() + "\n".join(" ".join(map(str, row)) for _, row in rows).encode()
    lines = load(data, "a.ply")
    np.testing.assert_array_equal(lines.segments, [[[4, 5, 6], [1, 2, 3]]])
    assert not lines.attributes


def test_lists_that_are_cut_short_anywhere_are_refused(load):
    header = (
        b"ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty list uchar short tags\nproperty float x\n"
        b"property float y\nproperty float z\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    )
    data = struct.pack("<Bhh3f", 2, 5, 6, 1, 2, 3) + struct.pack("<B3f", 0, 4, 5, 6) + struct.pack("<2i", 1, 0)
    assert len(load(header + data, "a.ply")) == 1
    for n in range(len(data)):
        text = message_of(load, header + data[:n], "a.ply")
        row = int(n >= 17)
        if n in (0, 17):
            assert f"row {row} of element 'vertex' has no number of 'tags' that can be used" in text
        elif n < 30:
            assert f"row {row} of its 2 of element 'vertex' is not whole" in text


def test_strands_of_a_property_and_names_that_meet(load):
    header = PLY_HEADER.replace("short age", "short strand")
    np.testing.assert_array_equal(load(ply("", header=header), "a.ply").strands, [0, -1, -1, -1])
    lines = load(ply("<", header=PLY_HEADER.replace("short age", "short red")), "a.ply")
    np.testing.assert_array_equal(lines.attributes["red of edge"], [0, -1, -2, -3])
    others = ply("<", header=PLY_HEADER.replace("short age", "uint64 strand"))[: -4 * struct.calcsize("<2ih")]
    for most, strands in ((2**62 - 1, [0, 1, 2, 2**62 - 1]), (2**62, [0, 0, 1, 2]), (2**63, [0, 0, 1, 2])):
        rows = [struct.pack("<2iQ", *edge, strand) for edge, strand in zip(EDGES, [0, 1, 2, most], strict=True)]
        np.testing.assert_array_equal(load(others + b"".join(rows), "a.ply").strands, strands)
    lines = load(ply("", header=PLY_HEADER.replace("short age", "float strand")), "a.ply")
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 2])
    np.testing.assert_array_equal(lines.attributes["strand"], [0, -1, -2, -3])


def test_known_by_its_first_bytes(tmp_path):
    (tmp_path / "a.unknown").write_bytes(ply())
    assert len(fl.read(tmp_path / "a.unknown")) == 4


def test_lines_come_back_as_they_were_written(tmp_path):
    rng = np.random.default_rng(2)
    made = fl.Lines.from_points(
        rng.random((9, 3)),
        [4, 3, 2],
        radius=rng.random(9),
        attributes={"color": rng.random((9, 3)), "kind": np.arange(9), "half": np.arange(9, dtype="f2")},
    )
    lines = fl.Lines(
        made.segments, np.array([7, 7, 7, 2, 2, -1]), made.radius, {"age": np.arange(6), "is": np.arange(6) > 2},
        end_attributes=made.end_attributes,
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fl.write(tmp_path / "a.ply", lines)
    back = fl.read(tmp_path / "a.ply")
    for name in ("segments", "radius", "strands"):
        np.testing.assert_array_equal(getattr(back, name), getattr(lines, name))
    assert set(back.attributes) == set(lines.attributes)
    for name, values in lines.attributes.items():
        np.testing.assert_array_equal(back.attributes[name], values)
    assert back.end_attributes["color"].dtype == np.float64
    fl.write(tmp_path / "a.ply", made)
    assert b"strand" not in (tmp_path / "a.ply").read_bytes()
    np.testing.assert_array_equal(fl.read(tmp_path / "a.ply").strands, made.strands)


def test_what_ply_cannot_hold_is_told(tmp_path):
    attributes = {
        "name": np.array(["a", "b"]),
        "large": np.array([1, 2**40]),
        "a b": np.ones(2),
        "vertex1": np.ones(2),
        "box": np.ones((2, 2, 2)),
    }
    lines = fl.Lines.from_segments(np.eye(6).reshape(6, 2, 3)[:2], strands=[1, 2**40], attributes=attributes)
    with pytest.warns(fl.FileWarning) as told:
        fl.write(tmp_path / "a.ply", lines)
    text = str(told[0].message)
    for name in (
        "the numbers of strands",
        "'name'",
        "'large'",
        "'a b'",
        "'vertex1', whose name stands for another property",
        "'box'",
    ):
        assert name in text
    assert not fl.read(tmp_path / "a.ply").attributes


@pytest.mark.parametrize("name", ["strand", "vertex1", "vertex2"])
def test_names_of_edges_that_ply_reads_otherwise(tmp_path, name):
    made = fl.Lines.from_points(POINTS, [3, 1, 2, 1])
    lines = fl.Lines(made.segments, made.strands, attributes={name: np.full(len(made), 5)})
    assert lost_by(tmp_path / "a.ply", lines) == [f"{name!r}, whose name stands for another property"]
    back = fl.read(tmp_path / "a.ply")
    np.testing.assert_array_equal(back.strands, made.strands)
    assert not back.attributes


@pytest.mark.parametrize("name", ["radius", "x", "y", "z"])
def test_names_of_vertices_that_ply_reads_otherwise(tmp_path, name):
    lines = fl.Lines.from_points(POINTS, [3, 1, 2, 1], attributes={name: np.arange(7)})
    assert lost_by(tmp_path / "a.ply", lines) == [f"{name!r}, whose name stands for another property"]
    back = fl.read(tmp_path / "a.ply")
    np.testing.assert_array_equal(back.segments, lines.segments)
    assert (back.radius, dict(back.attributes)) == (None, {})


def test_shapes_and_names_that_do_not_come_back_are_told_once(tmp_path):
    values = {"v": np.ones((7, 1)), "none": np.ones((7, 0)), "c_0": np.zeros(7), "c_1": np.ones(7), "w_1": np.ones(7)}
    lines = fl.Lines.from_points(POINTS, [7], attributes={**values, "word": np.array([*"abcdefg"])})
    assert lost_by(tmp_path / "a.ply", lines) == [
        "the shape (7, 1) of 'v', which is written as one column",
        "'none' (float64 of shape (7, 0))",
        "'word' (<U1 of shape (7,))",
        "that 'c_0' is an attribute, as names with _0, _1, … are of columns of one",
        "that 'c_1' is an attribute, as names with _0, _1, … are of columns of one",
    ]
    back = fl.read(tmp_path / "a.ply")
    assert {name: v.shape for name, v in back.attributes.items()} == {"v": (6,), "c": (6, 2), "w_1": (6,)}
    np.testing.assert_array_equal(back.attributes["c"], [[0, 1]] * 6)


def test_an_attribute_that_is_not_written_is_told_once(tmp_path):
    segments = np.float32([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 0, 0]]])
    lines = fl.Lines(segments, np.zeros(2, int), end_attributes={"word": np.array([["a", "b"], ["c", "d"]])})
    assert lost_by(tmp_path / "a.ply", lines) == ["'word' (<U1 of shape (3,))"]


def test_names_that_only_look_like_those_of_joined_columns(load):
    names = ["a_1", "a_1_0", "b_1", "b_0", "b_01", "b_\u00b2", "c_0", "c_1", "c_3"]
    head = "ply\nformat ascii 1.0\nelement vertex 2\n" + "".join(
        f"property float {name}\n" for name in [*"xyz", *names]
    )
    head += "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    rows = "\n".join(" ".join(map(str, range(first, first + 12))) for first in (0, 100)) + "\n0 1\n"
    found = load((head + rows).encode("latin-1"), "a.ply").end_attributes
    expected = {"a_1": 3, "a_1_0": 4, "b": [6, 5], "b_01": 7, "b_\u00b2": 8, "c": [9, 10], "c_3": 11}
    assert {name: values[0, 0].tolist() for name, values in found.items()} == expected


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damage_raises_nothing_else(load):
    assert 20 < mutate(load, ply(""), "a.ply") < 290


@pytest.mark.parametrize("end", [b"\n\n", b"\r\r\n", b"\r\n\r\n", b"\n\n\n"])
def test_blank_lines_behind_a_binary_header(load, end):
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    head += b"property float z\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header"
    data = np.float32([[0, 0, 0], [1, 2, 3]]).tobytes() + np.int32([0, 1]).tobytes()
    np.testing.assert_array_equal(load(head + end + data, "a.ply").segments, [[[0, 0, 0], [1, 2, 3]]])


def test_elements_without_edges_are_named(load):
    text = b"ply\nformat ascii 1.0\nelement point 2\nproperty float x\nend_header\n0\n1\n"
    with pytest.warns(fl.FileWarning, match="its elements are not read, as none is an edge: 2 point"):
        assert len(load(text, "a.ply")) == 0
