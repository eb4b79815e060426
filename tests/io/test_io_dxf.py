"""DXF: each kind of entity, blocks, layers, units, and bad files."""

from __future__ import annotations

import contextlib
import io
import re

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutations

import fastlines as fl
from fastlines.errors import FastlinesError, FileWarning, MissingExtraError

ezdxf = pytest.importorskip("ezdxf")


def drawing(draw, units=4, version="R2010"):
    document = ezdxf.new(version)
    document.header["$INSUNITS"] = units
    draw(document, document.modelspace())
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode()


def points_of(lines, strand):
    ends = lines.segments[lines.strands == strand]
    assert (ends[1:, 0] == ends[:-1, 1]).all()
    return np.concatenate([ends[:1, 0], ends[:, 1]])


def test_straight_entities_layers_and_units(load):
    def draw(document, space):
        document.layers.add("walls")
        space.add_line((0, 0, 0), (1, 2, 3), dxfattribs={"layer": "WALLS"})
        space.add_lwpolyline([(0, 0), (1, 0), (1, 1)], close=True)
        space.add_polyline3d([(0, 0, 5), (1, 1, 6)], dxfattribs={"layer": "new"})
        space.add_polyline2d([(0, 0), (2, 2)], dxfattribs={"extrusion": (0, 0, -1)})
        space.add_text("oak")
        space.add_point((1, 1))
        document.layout("Layout1").add_line((0, 0), (1, 1))

    with pytest.warns(FileWarning, match="not read: 1 TEXT, 1 POINT, 1 lines of layouts"):
        lines = load(drawing(draw), "a.dxf")
    assert points_of(lines, 0).tolist() == [[0, 0, 0], [1, 2, 3]]
    assert points_of(lines, 1).tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0]]
    assert points_of(lines, 2).tolist() == [[0, 0, 5], [1, 1, 6]]
    assert points_of(lines, 3).tolist() == [[0, 0, 0], [-2, 2, 0]]
    layer = lines.attributes["layer"]
    assert (layer[0], layer[1], layer[-1]) == (2, 0, 0)  # after 0 and Defpoints
    assert layer[lines.strands == 2].tolist() == [3]
    assert lines.attributes["feature"].tolist() == [0, 1, 1, 1, 2, 3]
    assert lines.attributes["layer_name"].tolist() == ["WALLS", "0", "0", "0", "new", "0"]
    assert (lines.unit, lines.up) == ("mm", "z")
    assert load(drawing(lambda _, space: space.add_line((0, 0), (1, 1)), units=0), "a.dxf").unit is None


@pytest.mark.parametrize("tolerance", [None, 0.1, 1e-4])
def test_curves_are_within_the_tolerance(load, tolerance):
    def draw(_, space):
        space.add_circle((1, 2, 3), 5)
        space.add_arc((0, 0), 5, 90, 180)
        space.add_ellipse((0, 0), (5, 0), 0.5)
        space.add_lwpolyline([(-5, 0, 0, 0, 1), (5, 0)])  # half a circle
        space.add_spline([(0, 0), (10, 0)])

    lines = load(drawing(draw), "a.dxf", **({} if tolerance is None else {"tolerance": tolerance}))
    allowed = tolerance or 1e-4  # 1e-5 of the size
    centres = {0: (1, 2, 3), 1: (0, 0, 0), 3: (0, 0, 0)}
    for strand, centre in centres.items():
        points = points_of(lines, strand)
        middles = (points[1:] + points[:-1]) / 2
        for some in (points, middles):
            assert (np.abs(np.linalg.norm(some - np.float32(centre), axis=1) - 5) < allowed + 2e-6).all()
    points = points_of(lines, 2)
    assert np.abs((points[:, 0] / 5) ** 2 + (points[:, 1] / 2.5) ** 2 - 1).max() < 1e-4
    assert points_of(lines, 0)[0] == pytest.approx(points_of(lines, 0)[-1], abs=1e-5)
    assert points_of(lines, 1)[[0, -1]] == pytest.approx(np.float32([[0, 5, 0], [-5, 0, 0]]), abs=1e-5)
    assert (points_of(lines, 4)[:, 1] == 0).all()


def test_a_rational_spline_is_within_the_tolerance(load):
    """A quarter of a circle of radius 1000, which Bezier curves alone are not."""

    def draw(_, space):
        quarter = space.add_spline(degree=2)
        quarter.control_points = [(1000, 0, 0), (1000, 1000, 0), (0, 1000, 0)]
        quarter.knots, quarter.weights = [0, 0, 0, 1, 1, 1], [1, 0.5**0.5, 1]

    lines = load(drawing(draw), "a.dxf")
    radii = np.linalg.norm(np.concatenate([lines.segments.mean(axis=1), lines.segments[:, 0]]), axis=1)
    assert np.abs(radii - 1000).max() < 0.01 + 1e-4


def test_hits_lead_back_to_entities(load):
    def draw(document, space):
        document.blocks.new("block").add_line((0, 0), (0, 1))
        space.add_text("oak")
        for x in (5, 6):
            space.add_blockref("block", (x, 0))
        space.add_line((7, 0), (7, 1))

    data = drawing(draw)
    with pytest.warns(FileWarning, match="1 TEXT"):
        lines = load(data, "a.dxf")
    assert lines.attributes["feature"].tolist() == [1, 2, 3]
    entities = list(ezdxf.read(io.StringIO(data.decode())).modelspace())
    hits = fl.build(lines).first_hit([7, 0.5, -1], [0, 0, 1], 0.1)
    entity = entities[lines.attributes["feature"][hits.prim]]
    assert (entity.dxftype(), entity.dxf.handle) == ("LINE", lines.attributes["handle"][hits.prim])


def test_blocks_are_placed(load):
    def draw(document, space):
        inner = document.blocks.new("inner")
        inner.add_line((0, 0, 0), (1, 0, 0))
        outer = document.blocks.new("outer")
        outer.add_blockref("inner", (1, 0, 0), dxfattribs={"rotation": 90})
        space.add_blockref("outer", (10, 0, 0), dxfattribs={"xscale": 2, "yscale": 3, "zscale": 2})
        space.add_blockref(
            "inner", (0, 0), dxfattribs={"row_count": 2, "column_count": 3, "row_spacing": 5, "column_spacing": 2}
        )

    lines = load(drawing(draw), "a.dxf")
    assert lines.segments[0] == pytest.approx(np.float32([[12, 0, 0], [12, 3, 0]]), abs=1e-5)
    assert lines.n_strands == 7


def test_blocks_in_themselves_and_blocks_without_number(load, monkeypatch):
    def circular(document, space):
        block = document.blocks.new("a")
        block.add_blockref("a", (0, 0))
        space.add_blockref("a", (0, 0))

    assert "nested more than 64 deep, perhaps in themselves" in message_of(load, drawing(circular), "a.dxf")

    def bomb(document, space):
        document.blocks.new("b0").add_line((0, 0), (1, 1))
        for i in range(9):
            for _ in range(10):
                document.blocks.get(f"b{i + 1}") or document.blocks.new(f"b{i + 1}")
                document.blocks.get(f"b{i + 1}").add_blockref(f"b{i}", (0, 0))
        space.add_blockref("b9", (0, 0))

    monkeypatch.setattr("fastlines.io.formats.dxf._MAX_ENTITIES", -30_000)
    assert "far more entities than a drawing has" in message_of(load, drawing(bomb), "a.dxf")


def test_binary_old_and_packed_drawings(load, tmp_path):
    document = ezdxf.new("R12")
    document.modelspace().add_line((0, 0, 0), (1, 2, 3))
    document.saveas(tmp_path / "b.dxf", fmt="bin")
    document.saveas(tmp_path / "c.dxf")
    for name in ("b.dxf", "c.dxf"):
        data = (tmp_path / name).read_bytes()
        assert load(data, "a.dxf").segments.tolist() == [[[0, 0, 0], [1, 2, 3]]]
    assert load((tmp_path / "b.dxf").read_bytes(), "a.unknown").segments.tolist() == [[[0, 0, 0], [1, 2, 3]]]
    assert len(load(drawing(lambda *_: None), "a.dxf")) == 0


def test_bad_files(load):
    for text in ("oak", "0\nSECTION\n0\nEOF"):
        assert "has no section ENTITIES; check the extension" in message_of(load, text.encode(), "a.dxf")
    for text in ("ENTITIES\nEOF", "AutoCAD Binary DXF\r\n\x1a\0ENTITIES\0EOF"):
        assert re.search("is not a DXF drawing: .*; check the extension", message_of(load, text.encode(), "a.dxf"))


def with_all_kinds(document, space):
    space.add_line((0, 0), (1, 0))
    space.add_spline([(0, 0), (1, 1), (2, 0), (3, 1)])
    space.add_circle((0, 0), 2)
    space.add_ellipse((0, 0), (5, 0), 0.5)
    space.add_polyline2d([(0, 0), (2, 2), (3, 3)])
    document.blocks.new("b").add_circle((0, 0), 1)
    space.add_blockref("b", (3, 3))


def changed(text: str, kind: str, code: int, old: str, new: str | None, *, section: str = "ENTITIES") -> bytes:
    """Replace the first value of a code in the first entity of a kind, or remove it."""
    start = text.index(f"\n{kind}\n", text.index(f"\n{section}\n"))
    at = text.index(f"\n{code:3}\n{old}", start)
    return (text[:at] + ("" if new is None else f"\n{code:3}\n{new}") + text[at + 5 + len(old) :]).encode()


@pytest.mark.parametrize(
    ("kind", "code", "old", "new", "said"),
    [
        ("SPLINE", 100, "AcDbSpline", None, "break the rules of the format are left out: 1 SPLINE .missing 'AcDbSpl"),
        ("SPLINE", 71, "3", "oak", "break the rules of the format are left out: 1 SPLINE .Invalid tag"),
        ("CIRCLE", 40, "2.0", "oak", "break the rules of the format are left out: 1 CIRCLE .Invalid tag"),
        ("CIRCLE", 40, "2.0", "nan", "cannot be read are left out: 1 CIRCLE .it has no size."),
        ("CIRCLE", 40, "2.0", "0.0", "cannot be read are left out: 1 CIRCLE .it has no size."),
        ("CIRCLE", 40, "2.0", "1" + "0" * 400, "cannot be read are left out: 1 CIRCLE"),
        ("ELLIPSE", 11, "5.0", "0.0", "cannot be read are left out: 1 ELLIPSE .Invalid major axis"),
        ("ELLIPSE", 40, "0.5", "0.0", "cannot be read are left out: 1 ELLIPSE"),
        ("POLYLINE", 70, "0", "x", "break the rules of the format are left out: 1 POLYLINE .Invalid tag"),
        ("INSERT", 10, "3.0", "x", "break the rules of the format are left out: 1 INSERT .Invalid"),
        ("LINE", 11, "1.0", "x", "break the rules of the format are left out: 1 LINE .Invalid"),
    ],
)
def test_one_bad_entity_is_left_out(load, kind, code, old, new, said):
    good = drawing(with_all_kinds).decode()
    with pytest.warns(FileWarning) as told:
        lines = load(changed(good, kind, code, old, new), "a.dxf")
    assert len(told) == 1
    assert re.search(said, str(told[0].message)), told[0].message
    whole = load(good.encode(), "a.dxf")
    kinds = ["LINE", "SPLINE", "CIRCLE", "ELLIPSE", "POLYLINE", "INSERT"]
    kept = np.concatenate([whole.segments[whole.strands == i] for i in range(6) if kinds[i] != kind])
    np.testing.assert_array_equal(lines.segments, kept)


def test_bad_entities_in_blocks_and_several(load):
    text = changed(drawing(with_all_kinds).decode(), "CIRCLE", 40, "1.0", "oak", section="BLOCKS").decode()
    text = changed(text, "SPLINE", 100, "AcDbSpline", None).decode()
    with pytest.warns(FileWarning, match="left out: 1 CIRCLE, 1 SPLINE, 1 ELLIPSE"):
        lines = load(changed(text, "ELLIPSE", 40, "0.5", "oak").replace(b"oak", b"x y"), "a.dxf")
    assert lines.n_strands == 3  # the line, the circle and the polyline; the block is empty
    lost = text.replace("\n  2\nBLOCKS\n", "\n  2\nBLOCKS\nzz\n")
    assert "cannot be read as a DXF drawing: " in message_of(load, lost.encode(), "a.dxf")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("\n  2\nTABLES\n", "\n  2\nTABLES\nzz\n", "1 section TABLES"),
        ("\n  2\nOBJECTS\n", "\n  2\nOBJECTS\nzz\n", "1 section OBJECTS"),
        ("$LUNITS\n 70\n", "$LUNITS\n 70\nx\n 70\n", r"1 \$LUNITS"),
    ],
)
def test_bad_sections_and_variables_are_left_out(load, old, new, said):
    text = drawing(with_all_kinds).decode()
    assert old in text
    with pytest.warns(FileWarning, match=f"rules of the format are left out: {said} "):
        lines = load(text.replace(old, new).encode(), "a.dxf")
    np.testing.assert_array_equal(lines.segments, load(text.encode(), "a.dxf").segments)


def test_one_bad_entity_of_a_binary_drawing_is_left_out(load, tmp_path):
    document = ezdxf.new("R2010")
    with_all_kinds(document, document.modelspace())
    document.saveas(tmp_path / "binary.dxf", fmt="bin")
    data = (tmp_path / "binary.dxf").read_bytes()
    with pytest.warns(FileWarning, match="rules of the format are left out: 1 SPLINE .missing 'AcDbSpline'"):
        lines = load(data.replace(b"d\0AcDbSpline\0", b""), "a.dxf")
    assert len(lines) < len(load(data, "a.dxf"))


def test_drawings_that_are_cut_short(load):
    data = drawing(lambda _, space: [space.add_line((0, 0), (i, 1)) for i in range(5)], version="R12")
    start = data.rindex(b"ENTITIES") + 10
    for end in range(start, len(data) - 1):
        assert "does not end with EOF; the file is cut short" in message_of(load, data[:end], "a.dxf")


def test_bad_tolerance(load):
    with pytest.raises(fl.InputError, match="tolerance"):
        load(drawing(lambda *_: None), "a.dxf", tolerance=0)


def test_without_the_library(load, monkeypatch):
    data = drawing(lambda *_: None)
    monkeypatch.setitem(__import__("sys").modules, "ezdxf", None)
    with pytest.raises(MissingExtraError, match=r"reading .dxf needs .*the extra 'cad'"):
        load(data, "a.dxf")


@pytest.mark.filterwarnings("ignore")
def test_damaged_text(load):
    def draw(document, space):
        document.blocks.new("b").add_lwpolyline([(0, 0, 0, 0, 1), (1, 0), (1, 1)], close=True)
        space.add_blockref("b", (1, 1), dxfattribs={"rotation": 30})
        space.add_line((0, 0), (1, 1))
        space.add_ellipse((0, 0), (5, 0), 0.5)
        space.add_spline([(0, 0), (1, 1), (2, 0)])

    document = drawing(draw)
    start, end = document.rindex(b"ENTITIES"), document.rindex(b"OBJECTS")
    for damaged in mutations(document[start:end], 40):
        with contextlib.suppress(FastlinesError):
            load(document[:start] + damaged + document[end:], "a.dxf", invalid="skip")
