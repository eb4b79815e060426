"""The command line with files of many formats: info, convert, options of formats, and pictures in the terminal."""

from __future__ import annotations

import io
import json
import re
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from support.command_line import done, refused, run

import fastlines as fl
from fastlines.cli.options import format_options
from fastlines.cli.terminal import has_colours, picture_text
from fastlines.io import known_formats
from fastlines.io.table import TABLE

pytestmark = [
    pytest.mark.usefixtures("in_own_folder"),
    pytest.mark.filterwarnings("always::fastlines.FileWarning"),  # which the command line prints
]

ROADS = (
    'id,name,way,geometry\n1,oak,"LINESTRING (0 0, 9 9)","LINESTRING (0 0, 3 0, 3 4)"\n2,,,"LINESTRING (0 1, 1 1)"\n'
)


@pytest.fixture
def table():
    Path("roads.csv").write_text(ROADS)
    return "roads.csv"


@pytest.fixture
def tracts():
    data = (resources.files("nibabel") / "tests" / "data" / "complex.trk").read_bytes()
    Path("a.trk").write_bytes(data)
    return "a.trk"


# --- Curves ---


def test_a_tree_over_curves_is_built_from_their_file():
    curves = fl.Curves.from_strands(np.arange(24.0).reshape(8, 3) ** 1.5, [8], basis="bspline", radius=0.5)
    fl.write("a.npz", curves)
    assert "over 5 curves" in done("build", "a.npz", "-o", "a.flt")
    np.testing.assert_array_equal(fl.load("a.flt").geometry.control, curves.control)
    assert "holds Curves; expected lines here" in refused("report", "a.npz")[1]


# --- info ---


def test_info_describes_lines(table):
    result = run("info", table, "--json")
    assert result.exit_code == 0
    assert result.stderr == (
        "warning: roads.csv: other columns of lines are not read (column= names the one to read): 'way'\n"
    )
    told = json.loads(result.stdout)
    assert told["format"] == "well-known text, alone or in a column of a table"
    lines = told["lines"]
    assert lines["strand_lengths"] == [1, 4, 7]
    texts = {"feature": "int64 per strand", "id": "int64 per strand", "name": "text per strand"}
    assert lines["attributes"] == texts
    assert (lines["unit"], lines["up"], lines["n_strands"], lines["n_segments"]) == (None, "z", 2, 3)
    assert 0 < lines["radius_for_pictures"] < 3
    text = run("info", table).stdout
    assert text.startswith("roads.csv: well-known text")
    assert re.search(r"lines  attributes +feature \(int64 per strand\), id \(int64 per strand\), name \(text", text)
    assert re.search(r"lines  radius for pictures +0\.\d", text)


def test_info_of_points_units_and_radii(tracts):
    lines = json.loads(done("info", tracts, "--json"))["lines"]
    assert "float32 × 3 per point" in lines["attributes"].values()
    assert lines["unit"] == "mm"
    np.savez("a.npz", segments=4 * np.eye(6).reshape(6, 2, 3), radius=np.linspace(1, 2, 6))
    lines = json.loads(done("info", "a.npz", "--json"))["lines"]
    assert lines["radius"] == [1, 2]
    assert lines["radius_for_pictures"] is None
    assert "radius for pictures" not in done("info", "a.npz")


def test_info_of_curves_and_of_several_kinds():
    points, straight = np.arange(12.0).reshape(4, 3), np.sqrt(27) * 3
    curves = fl.Curves.from_strands(np.tile(points, (2, 1)), [4, 4], basis="bezier", attributes={"heat": np.arange(8)})
    curves = replace(curves, attributes={"id": np.array([5, 6])})
    fl.write("a.npz", curves)
    shapes = json.loads(done("info", "a.npz", "--json"))["shapes"]
    assert shapes["attributes"] == {"heat": "int64 per end of a curve", "id": "int64 per curve"}
    assert shapes["total_length"] == pytest.approx(2 * straight)
    assert re.search(
        r"shapes  attributes +heat \(int64 per end of a curve\), id \(int64 per curve\)\n", done("info", "a.npz")
    )
    lines = fl.Lines.from_points(points, [4])
    lines = replace(lines, attributes={"id": np.full(3, 0.5), "row": np.array([0, 1, np.nan])})
    mesh = fl.Triangles(
        np.eye(3)[None], attributes={"area": np.ones((1, 2))}, corner_attributes={"id": np.ones((1, 3))}
    )
    boxes = fl.Boxes([[[0, 0, 0], [1, 1, 1]]], attributes={"area": np.ones(1)})
    fl.build(fl.Geometry([lines, curves, mesh, boxes])).save("a.flt")
    shapes = json.loads(done("info", "a.flt", "--json"))["shapes"]
    assert shapes["attributes"] == {
        "area": "float64 × 2 per triangle or float64 per box",
        "heat": "int64 per end of a curve",
        "id": "float64 per strand or int64 per curve or float64 per corner",
        "row": "float64 per segment",
    }
    assert shapes["total_length"] == pytest.approx(3 * straight)


def test_info_reads_whatever_can_be_read():
    np.save("a.npy", np.where(np.arange(18).reshape(3, 2, 3) == 7, np.nan, 1.0))
    result = run("info", "a.npy", "--json")
    assert json.loads(result.stdout)["lines"]["n_skipped"] == 1
    assert result.stderr == "note: a.npy: 1 segment with NaN or Inf was left out\n"
    np.save("b.npy", np.full((3, 2, 3), np.nan))
    lines = json.loads(run("info", "b.npy", "--json").stdout)["lines"]
    assert (lines["n_skipped"], lines["n_segments"], lines["radius_for_pictures"]) == (3, 0, None)
    assert "no such option" in refused("info", "a.npy", "--skip-invalid")[1].lower()


@pytest.mark.parametrize("what", ["lines", "tree", "scene", "thick", "empty", "curves"])
def test_a_picture_in_the_terminal(what, tree_file):
    np.savez("thick.npz", segments=np.eye(6).reshape(6, 2, 3), radius=np.full(6, 0.05))
    np.save("empty.npy", np.empty((0, 2, 3)))
    np.save("lines.npy", np.random.default_rng(0).random((50, 2, 3)))
    fl.build(fl.Curves.from_bezier(np.random.default_rng(0).random((9, 4, 3)))).save("curves.flt")
    source = {"tree": tree_file, "scene": "scene:bun-hair:500", "thick": "thick.npz", "empty": "empty.npy",
              "curves": "curves.flt"}.get(what, "lines.npy")  # fmt: skip
    plain, drawn = done("info", source), done("info", source, "--picture")
    assert drawn.startswith(plain)
    rows = drawn[len(plain) :].splitlines()
    assert (len(rows) > 5) == (what != "empty")
    assert max(map(len, rows), default=1) <= 80
    assert set("".join(rows)) <= set(" .:-=+*#%@")
    assert "--picture does not apply to --json" in refused("info", source, "--picture", "--json")[1]


class Stream(io.StringIO):
    def __init__(self, terminal, encoding):
        super().__init__()
        self.terminal, self.name = terminal, encoding

    @property
    def encoding(self):
        return self.name

    def isatty(self):
        return self.terminal


def test_colours_are_for_terminals_that_have_them(monkeypatch):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    assert has_colours(Stream(True, "utf-8"))
    assert not has_colours(Stream(False, "utf-8"))
    assert not has_colours(Stream(True, "ascii"))
    monkeypatch.setenv("TERM", "dumb")
    assert not has_colours(Stream(True, "utf-8"))
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("NO_COLOR", "1")
    assert not has_colours(Stream(True, "utf-8"))


def test_two_pixels_a_character():
    picture = np.array([[0, 0, 255], [0, 0, 0]], np.uint8)
    dark, light = ("\x1b[38;2;0;0;0m\x1b[48;2;0;0;0m▀▀", "\x1b[38;2;255;255;255m\x1b[48;2;0;0;0m▀")
    assert picture_text(picture, colours=True) == f"{dark}{light}\x1b[0m"
    assert picture_text(picture, colours=False) == "  ="


# --- convert ---


def test_convert(table):
    result = run("convert", table, "roads.geojson")
    assert result.exit_code == 0
    assert result.stdout == "roads.geojson: maps, GeoJSON, also one feature a line: 3 segments, 2 strands\n"
    assert result.stderr.startswith("warning: roads.csv: other columns of lines are not read")
    lines = fl.read("roads.geojson")
    assert lines.attributes["name"].tolist() == ["oak", "oak", ""]
    assert lines.attributes["id"].tolist() == [1, 1, 2]
    assert done("convert", "roads.geojson", "roads.npz.gz").endswith(": 3 segments, 2 strands\n")
    assert (fl.read("roads.npz.gz").segments == lines.segments).all()
    assert fl.read("roads.npz.gz").attributes["name"].tolist() == ["oak", "oak", ""]
    result = run("convert", "roads.geojson", "roads.npy")
    assert result.exit_code == 0
    assert "800 segments" in done("convert", "scene:bun-hair:800", "hair.npz")
    fl.build(lines).save("roads.flt")
    done("convert", "roads.flt", "again.npz")


def test_convert_prints_what_was_written():
    curves = fl.Curves.from_strands(np.arange(12.0).reshape(4, 3) ** 2, [4], basis="bezier")
    fl.write("a.npz", curves)
    assert done("convert", "a.npz", "b.npz").endswith(": 1 curve, 1 strand\n")
    n = len(curves.pieces)
    assert run("convert", "a.npz", "a.vtp").stdout == f"a.vtp: polylines, VTK polydata: {n} segments, 1 strand\n"
    assert run("convert", "a.npz", "a.npy").stdout.endswith(f": {n} segments\n")  # which holds no strands
    # A strand with a gap is two polylines, and a segment without a strand is another.
    gaps = [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 0, 0]], [[5, 0, 0], [6, 0, 0]], [[7, 7, 7], [8, 8, 8]]]
    fl.write("gaps.npz", fl.Lines.from_segments(gaps, strands=[0, 0, 0, -1]))
    for extension, row in known_formats().items():
        if row.writes:
            said = run("convert", "gaps.npz", f"b{extension}").stdout
            if not said:  # a library is missing
                continue
            n = fl.read(f"b{extension}").n_strands
            assert said.endswith(f": 4 segments, {n} strand{'s' * (n > 1)}\n" if n else ": 4 segments\n"), extension
            assert n == {"kept": 1, "polylines": 3, "none": 0}[row.strands]
    pytest.importorskip("pxr")
    mesh = fl.Triangles(np.eye(3)[None])
    fl.build(fl.Geometry([mesh, curves])).save("a.flt")
    result = run("convert", "a.flt", "a.usda")
    assert result.stdout == "a.usda: scenes, USD BasisCurves and HermiteCurves: 1 curve, 1 strand\n"
    assert "part 0, Triangles" in result.stderr


def test_convert_says_of_which_file_its_options_are():
    text = " ".join(done("convert", "--help").replace("│", " ").split())
    assert "The format of INPUT, where its extension does not say it; not of OUTPUT." in text
    assert "An option of INPUT's format" in text


def test_convert_notes_what_is_lost(tracts):
    result = run("convert", tracts, "a.geojson")
    assert result.exit_code == 0
    assert re.search("warning: a.geojson: not kept, as the format has no place for it: .*'mm'", result.stderr)


def test_convert_takes_options_of_the_output():
    lines = replace(fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0]]]), unit="mm")
    grid = {"dimensions": [3, 4, 5], "voxel_to_rasmm": np.diag([-2.0, 2, 2, 1])}
    fl.write("own.trk", replace(lines, metadata={"grid": grid}))
    fl.write("a.npz", lines)
    done("convert", "a.npz", "a.trx", "--output-option", "reference=own.trk")
    assert fl.read("a.trx").metadata["grid"]["dimensions"] == (3, 4, 5)
    for option, said in (
        ("reference", "--output-option 'reference' is not a name and a value"),
        ("size=3", "has no option 'size' of its writer; known: reference"),
        ("reference=none.trk", "none.trk: no such file"),
    ):
        assert said in refused("convert", "a.npz", "b.trk", "--output-option", option)[1]
    assert not Path("b.trk").exists()


def test_convert_refuses(table):
    before = Path(table).read_bytes()
    np.save("nan.npy", np.full((1, 2, 3), np.nan))
    Path("roads").write_text("what")
    for args, said in (
        ((table, "./roads.csv"), "files of extension '.csv' are not written"),
        ((table, "a.flt"), "a.flt: is the name of a tree, not of a file of lines; fl.build(lines).save(path) builds"),
        ((table, "a.npzz"), "files of extension '.npzz' are not written; did you mean '.npz'?"),
        ((table, "."), ".: is a directory; expected the name of a file to write"),
        (("none.flt", "a.npz"), "none.flt: no such file; check the path (the working directory is"),
        (("roads", "a.npz"), "name the format by format= (--format on the command line)"),
        ((table, "no/a.npz"), "there is no folder no"),
        (("nan.npy", "./nan.npy"), "is read from; write to another file"),
        (("nan.npy", "a.npz"), "hold NaN"),
        (("none.csv", "a.npz"), "none.csv: no such file"),
    ):
        assert said in refused("convert", *args)[1]
    assert Path(table).read_bytes() == before
    assert not Path("a.npz").exists()
    assert "0 segments" in run("convert", "nan.npy", "a.npz", "--skip-invalid").stdout


# --- Options of formats ---


def test_options_are_parsed_by_their_types():
    types = {"a": int, "b": float, "c": bool, "d": bool, "e": str, "f": str, "g": str}
    texts = ["a=1", "b=-1e3", "c=true", "d=False", "e=oak=1", "f=", "g=42", "h=42"]
    options = {"a": 1, "b": -1000.0, "c": True, "d": False, "e": "oak=1", "f": "", "g": "42", "h": "42"}
    assert format_options(texts, types) == options
    for texts, said in (
        (["a"], "'a' is not a name and a value"),
        (["=1"], "is not a name"),
        (["a=1", "a=2"], "twice"),
        (["a=1.5"], "--option a is '1.5'; expected a whole number"),
        (["b=wide"], "--option b is 'wide'; expected a number"),
        (["c=1"], "--option c is '1'; expected true or false"),
    ):
        with pytest.raises(fl.InputError, match=said):
            format_options(texts, types)


def test_every_option_has_a_type_that_is_read():
    types = {(row.name, name): kind for row in TABLE for name, kind in row.options().items()}
    assert set(types.values()) == {str, bool, int, float}
    assert types["trx", "bundle"] is str
    assert types["usd", "time"] is float
    assert types["molecules", "model"] is int
    assert types["gpx", "elevation"] is bool


def test_a_column_may_be_called_by_a_number():
    Path("a.csv").write_text('42,geometry\n"LINESTRING (0 0, 1 1, 2 2)","LINESTRING (0 0, 9 9)"\n')
    for column, n_segments in (("42", 2), ("geometry", 1)):
        told = run("info", "a.csv", "--option", f"column={column}", "--json")
        assert json.loads(told.stdout)["lines"]["n_segments"] == n_segments


@pytest.mark.parametrize("command", ["info", "convert", "build", "render"])
def test_options_and_formats(table, command):
    Path("roads.txt").write_text(ROADS)
    more = {"convert": ("a.npz",), "render": ("-o", "a.png", "--width", 8, "--height", 8, "-r", 1)}.get(command, ())
    for args in (("roads.txt", "--format", "wkt"), (table, "--format", ".csv", "--option", "column=way")):
        result = run(command, args[0], *more, *args[1:])
        assert result.exit_code == 0, result.output
    assert "1 segment" in result.stdout or "segments            1\n" in result.stdout
    for args, said in (
        ((table, "--option", "oak=1"), "the format 'wkt' has no option 'oak'; known: column, radius"),
        ((table, "--option", "colum=way"), "no option 'colum'; did you mean 'column'?"),
        ((table, "--option", "oak"), "is not a name and a value"),
        ((table, "--format", "oak"), "format 'oak' is unknown; known: arrow, bcc, dxf,"),
        ((table, "--format", ".safetensor"), "format '.safetensor' is unknown; did you mean 'safetensors'?"),
        (("scene:spaghetti", "--format", "wkt"), "--format does not apply: scene:spaghetti is a scene"),
    ):
        assert said in refused(command, args[0], *more, *args[1:])[1]


def test_trees_take_no_options(tree_file):
    assert "--option does not apply: s.flt is a tree" in refused("info", tree_file, "--option", "a=1")[1]
    assert "does not apply: the five scenes are not files" in refused("demo", "--format", "trk")[1]


# --- Files and their trees ---


def test_a_file_and_its_tree_look_the_same(tracts):
    done("build", tracts, "-o", "a.flt")
    tree, lines = fl.load("a.flt"), fl.read(tracts)
    assert (tree.geometry.up, tree.geometry.unit) == (lines.up, lines.unit) == ("z", "mm")
    for source, picture in ((tracts, "lines.png"), ("a.flt", "tree.png")):
        done("render", source, "-r", 0.2, "-o", picture, "--width", 60, "--height", 60)
    assert Path("lines.png").read_bytes() == Path("tree.png").read_bytes()
    told = [json.loads(done("info", source, "--json"))["lines"] for source in (tracts, "a.flt")]
    assert told[0] == told[1]
    assert told[0]["radius_for_pictures"] > 0
