"""The commands about points write what the library answers, bit for bit."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from support.command_line import done, refused, run
from support.table_files import same, table

import fastlines as fl

pytestmark = pytest.mark.usefixtures("in_own_folder")

LINES = fl.scenes.make("bun-hair", 300).lines
THICK = fl.Lines.from_points(
    LINES.points,
    np.diff(LINES.offsets),
    radius=np.linspace(0.001, 0.002, len(LINES.points)),
    attributes={"fa": np.linspace(0, 1, len(LINES.points)), "colour": LINES.points[:, ::-1]},
)
TREE, THICK_TREE = fl.build(LINES), fl.build(THICK)
RNG = np.random.default_rng(5)
LOW, HIGH = LINES.bounds.astype(np.float64)
POINTS = LOW + RNG.random((40, 3)) * (HIGH - LOW)


@pytest.fixture(autouse=True)
def files(in_own_folder):
    """Write lines, lines with a radius, and points."""
    fl.write("lines.npz", LINES)
    fl.write("thick.npz", THICK)
    np.save("points.npy", POINTS)


# --- What is nearest ---


@pytest.mark.parametrize("name", ["out.csv", "out.parquet", "out.npz"])
def test_nearest_answers_as_the_library_does(name):
    for k in (1, 3):
        told = done("nearest", "thick.npz", "points.npy", "-k", k, "-o", name)
        assert told.startswith(f"{name}: 40 points, {40 * k} primitives found, in ")
        found, expected = table(name), THICK_TREE.nearest(POINTS, k)
        assert list(found) == ["point", "x", "y", "z", "prim", "u", "distance", "strand"]
        assert same(found["point"], np.repeat(np.arange(40), k), np.int64)
        for column, values in zip("xyz", expected.points().reshape(-1, 3).T, strict=True):
            assert same(found[column], values, np.float64)
        for column in ("prim", "strand"):
            assert same(found[column], getattr(expected, column), np.int64)
        for column in ("u", "distance"):
            assert same(found[column], getattr(expected, column), np.float32)


def test_options_are_those_of_python():
    np.save("each.npy", np.arange(80).reshape(40, 2))
    for given, of_python in (
        (("--to", "axis"), {"to": "axis"}),
        (("--nearest", 2, "--max-distance", 0.05), {"k": 2, "max_distance": 0.05}),
        (("--no-own-radius",), {"to": "axis"}),
        (("--ignore", "3,17,-1"), {"ignore": [3, 17, -1]}),
        (("--ignore", "each.npy"), {"ignore": np.arange(80).reshape(40, 2)}),
        (("--ignore-strands", "0,1"), {"ignore_strands": [0, 1]}),
    ):
        done("nearest", "thick.npz", "points.npy", *given, "-o", "out.npz")
        found, expected = table("out.npz"), THICK_TREE.nearest(POINTS, **of_python)
        assert same(found["prim"], expected.prim, np.int64), given
        assert same(found["distance"], expected.distance, np.float32), given


def test_what_a_miss_lacks_is_missing():
    expected = TREE.nearest(POINTS, max_distance=0.02)
    assert 0 < expected.hit.sum() < 40
    for name in ("out.csv", "out.parquet"):
        told = done("nearest", "lines.npz", "points.npy", "--max-distance", 0.02, "-o", name)
        assert f"{expected.hit.sum()} primitives found" in told
        found = table(name)
        assert (found.pop("point") == np.arange(40)).all()
        for column, values in found.items():
            assert (np.isnan(values) == ~expected.hit).all(), column
    assert ",,,,,,,\n" in Path("out.csv").read_text()
    done("nearest", "lines.npz", "points.npy", "--max-distance", 0.02, "-o", "out.npz")
    found = table("out.npz")
    assert same(found["prim"], expected.prim, np.int64)
    assert same(found["distance"], expected.distance, np.float32)


def test_attributes_are_sampled():
    done(
        "nearest",
        "thick.npz",
        "points.npy",
        "--sample",
        "fa",
        "--sample",
        "colour",
        "--sample",
        "radius",
        "-o",
        "a.csv",
    )
    found, expected = table("a.csv"), THICK_TREE.nearest(POINTS)
    assert same(found["fa"], expected.sample("fa"), np.float64)
    assert same(found["radius"], expected.sample("radius"), np.float64)
    for i in range(3):
        assert same(found[f"colour_{i}"], expected.sample("colour")[:, i], np.float64)


def test_parts_rows_and_lines_without_a_strand():
    segments = np.float32([[[0, 0, 0], [1, 0, 0]], [[np.nan, 0, 0], [0, 0, 1]], [[0, 5, 0], [1, 5, 0]]])
    np.save("odd.npy", segments)
    result = run("nearest", "odd.npy", "0.5,4,0", "--skip-invalid", "-o", "a.csv")
    assert (result.exit_code, "1 segment with NaN or Inf was left out" in result.stderr) == (0, True)
    assert Path("a.csv").read_text() == "point,x,y,z,prim,u,distance,row\n0,0.5,5.0,0.0,1,0.5,1,2\n"
    floor = fl.Triangles([[[-9, -1, -9], [9, -1, -9], [0, -1, 9]]])
    fl.build(fl.Geometry([floor, LINES])).save("parts.flt")
    done("nearest", "parts.flt", "points.npy", "--parts", "1", "-o", "a.npz")
    found, expected = table("a.npz"), TREE.nearest(POINTS)
    assert (found["part"] == 1).all()
    assert same(found["prim"], expected.prim, np.int64)


def test_a_point_on_the_command_line_shows_its_answer():
    np.save("cross.npy", np.float32([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 2], [0, 1, 2]]]))
    told = done("nearest", "cross.npy", "-0.5,-3,0", "-k", 2).splitlines()
    assert told[0].startswith("cross.npy: 1 point, 2 primitives found, in ")
    assert told[1:] == ["point,x,y,z,prim,u,distance", "0,0.0,-1.0,2.0,1,0,2.8722813", "0,-0.5,0.0,0.0,0,0.25,3"]
    facts = json.loads(done("nearest", "cross.npy", "0.5,3,0", "--max-distance", 1, "--json"))
    assert (facts["n_points"], facts["n_found"], facts["max_distance"]) == (1, 0, 1)
    assert facts["answer"]["prim"] == [None]
    assert "\n" not in done("nearest", "cross.npy", "0.5,3,0", "-o", "a.csv").strip()


# --- What is within a distance ---


@pytest.mark.parametrize("name", ["out.csv", "out.parquet", "out.npz"])
def test_within_answers_as_the_library_does(name):
    told = done("within", "thick.npz", "points.npy", "-r", 0.1, "--sample", "fa", "-o", name)
    found, expected = table(name), THICK_TREE.within(POINTS, 0.1)
    assert len(expected) > 100
    assert f"40 points, {len(expected):,} primitives found" in told
    for column in ("point", "prim", "strand"):
        assert same(found[column], getattr(expected, column), np.int64)
    for column in ("u", "distance"):
        assert same(found[column], getattr(expected, column), np.float32)
    assert same(found["fa"], expected.sample("fa"), np.float64)


def test_nothing_within_is_a_table_of_no_rows():
    for name in ("out.csv", "out.parquet", "out.npz"):
        assert "0 primitives found" in done("within", "lines.npz", "9,9,9", "-r", 0.1, "-o", name)
        assert {name: len(values) for name, values in table(name).items()} == dict.fromkeys(
            ["point", "x", "y", "z", "prim", "u", "distance", "strand"], 0
        )


# --- Files of points ---


def write_points(name):
    """Write the points to a file, in one of the ways in which they are read."""
    if name == "points.npz":
        np.savez(name, points=POINTS)
    elif name == "strand.npz":
        fl.write(name, fl.Lines.from_strands([POINTS]))
    elif name == "bare.csv":
        np.savetxt(name, POINTS, fmt="%.17g", delimiter=",")
    elif name == "named.csv":
        rows = [f'"a, b",{z!r},{x!r},1e9,{y!r}' for x, y, z in POINTS.tolist()]
        Path(name).write_text("\ufeffname, Z,x,mass,y\r\n" + "\r\n".join(rows), encoding="utf-8")
    elif name == "tabs.tsv":
        np.savetxt(name, POINTS, fmt="%.17g", delimiter="\t", header="x\ty\tz", comments="")
    elif name == "points.parquet":
        pa = pytest.importorskip("pyarrow")
        columns = {"id": ["a"] * 40} | dict(zip("xyz", POINTS.T, strict=True))
        pytest.importorskip("pyarrow.parquet").write_table(pa.table(columns), name)
    elif name == "points.flt":
        fl.build(fl.Spheres.from_centres(POINTS, radius=0.1)).save(name)


@pytest.mark.parametrize(
    "name",
    ["points.npz", "strand.npz", "bare.csv", "named.csv", "tabs.tsv", "points.parquet", "points.flt"],
)
def test_points_are_read_from_many_files(name):
    write_points(name)
    rounded = name in ("strand.npz", "points.flt")
    points = np.float64(np.float32(POINTS)) if rounded else POINTS
    done("nearest", "lines.npz", name, "-o", "out.npz")
    found, expected = table("out.npz"), TREE.nearest(points)
    assert same(found["prim"], expected.prim, np.int64)
    assert same(found["distance"], expected.distance, np.float32)


def test_lines_of_their_own_offset_are_points_where_they_are():
    far = fl.Lines.from_strands([POINTS + np.array([5_000_000, 0, 0])], offset="auto")
    fl.write("far.npz", far)
    done("nearest", "far.npz", "far.npz", "-o", "out.npz")
    found = table("out.npz")
    assert len(found["prim"]) == 40
    assert (found["distance"] == 0).all()
    assert np.allclose(found["x"], far.points[:, 0], rtol=0, atol=1e-6)


def test_tables_are_points():
    for name in ("out.csv", "out.parquet"):
        done("nearest", "lines.npz", "points.npy", "-o", name)
        facts = json.loads(done("within", "lines.npz", name, "-r", 0.0001, "--json"))
        assert facts["n_points"] == 40
        assert facts["n_found"] >= 40


def test_no_points_are_no_rows():
    for name, text in (("none.csv", "x,y,z\n"), ("none.tsv", "z\ty\tx")):
        Path(name).write_text(text)
        assert done("nearest", "lines.npz", name, "-o", "a.csv").startswith("a.csv: 0 points, 0 primitives found")
        assert Path("a.csv").read_text() == "point,x,y,z,prim,u,distance,strand\n"
    np.save("none.npy", np.empty((0, 3)))
    assert "0 points" in done("nearest", "lines.npz", "none.npy", "-k", 2)
    assert "0 points" in done("within", "lines.npz", "none.npy", "-r", 1)


BAD_POINTS = {
    "shape.npy": (lambda path: np.save(path, np.zeros((3, 4))), "has the shape (3, 4); expected (n, 3)"),
    "words.npy": (lambda path: np.save(path, np.array([["a", "b", "c"]])), "number"),
    "nan.npy": (lambda path: np.save(path, np.full((2, 3), np.nan)), "points"),
    "cut.npy": (lambda path: path.write_bytes(b"\x93NUMPY"), "cannot be read as an array of points"),
    "cut.npz": (lambda path: path.write_bytes(b"PK\3\4"), "cannot be read as an array of points"),
    "empty.csv": (lambda path: path.write_text(""), "begins with nothing; expected a header with x, y and z"),
    "twice.csv": (lambda path: path.write_text("x,y,z,X\n1,2,3,4\n"), "has several columns x; expected one each"),
    "lines.csv": (lambda path: path.write_text("id,way\n1,2\n"), "begins with id, way; expected a header"),
    "four.csv": (lambda path: path.write_text("1,2,3,4\n"), "three numbers in each row"),
    "words.csv": (
        lambda path: path.write_text("x,y,z\n1,2,3\n1,a,3\n"),
        "cannot be read as numbers: could not convert",
    ),
    "short.csv": (lambda path: path.write_text("x,y,z\n1,2,3\n1,2\n"), "cannot be read as numbers"),
    "binary.csv": (lambda path: path.write_bytes(bytes(range(256))), "expected a header"),
    "cut.parquet": (lambda path: path.write_bytes(b"PAR1 and no more"), "cannot be read as numbers"),
}


@pytest.mark.parametrize("name", BAD_POINTS)
def test_bad_files_of_points(name):
    write, words = BAD_POINTS[name]
    write(Path(name))
    for command in (("nearest",), ("within", "-r", 1)):
        sentence = refused(*command, "lines.npz", name)[1]
        assert words in sentence
        assert name in sentence or name in ("nan.npy", "words.npy")


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        (("nearest", "lines.npz"), 2, "POINTS"),
        (("nearest", "lines.npz", "1,2"), 1, "1,2: no such file, and not three numbers separated by commas"),
        (("nearest", "lines.npz", "1,nan,2"), 1, "points"),
        (("nearest", "lines.npz", "no.npy"), 1, "no.npy"),
        (("nearest", "lines.npz", "no.csv"), 1, "no.csv"),
        (("nearest", "lines.npz", "no.parquet"), 1, "no.parquet"),
        (("nearest", "lines.npz", "no.xyz"), 1, "no.xyz: no such file"),
        (("nearest", "no.swc", "1,2,3"), 1, "no.swc: no such file"),
        (("nearest", "lines.npz", "1,2,3", "-k", -2), 1, "k=-2"),
        (("nearest", "lines.npz", "1,2,3", "-k", "x"), 2, "--nearest"),
        (("nearest", "lines.npz", "1,2,3", "--max-distance", -1), 2, "is not a finite number that is 0 or more"),
        (("nearest", "lines.npz", "1,2,3", "--to", "end"), 1, "to='end'"),
        (("nearest", "lines.npz", "1,2,3", "--ignore", "1,x"), 1, "--ignore '1,x' is not whole numbers"),
        (("nearest", "lines.npz", "1,2,3", "--ignore", "300"), 1, "ignore names 300; there are 300 primitives"),
        (("nearest", "lines.npz", "1,2,3", "--frob"), 2, "--frob"),
        (("nearest", "lines.npz", "1,2,3", "-o", "a.txt"), 1, "expected .csv or .parquet or .npz"),
        (("nearest", "lines.npz", "points.npy", "-o", "no/a.csv"), 1, "there is no folder no"),
        (("nearest", "lines.npz", "points.npz", "-o", "points.npz"), 1, "points.npz: is read from"),
        (("nearest", "lines.npz", "1,2,3", "--sample", "fa"), 1, "--sample 'fa' is not an attribute of the input"),
        (("nearest", "lines.npz", "1,2,3", "--sample", "prim"), 1, "is the name of another column"),
        (("nearest", "thick.npz", "1,2,3", *["--sample", "fa"] * 2), 1, "is given twice"),
        (("within", "lines.npz", "1,2,3"), 2, "--radius"),
        (("within", "lines.npz", "1,2,3", "-r", "nan"), 2, "is not a finite number"),
    ],
)
def test_bad_arguments(args, code, words):
    got, sentence = refused(*args)
    assert got == code
    assert words in sentence


def test_points_of_triangles_are_refused():
    fl.build(fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])).save("mesh.flt")
    assert "mesh.flt: holds Triangles; expected lines here" in refused("nearest", "lines.npz", "mesh.flt")[1]
    done("nearest", "mesh.flt", "points.npy", "-o", "a.csv")


def test_parquet_needs_an_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    assert "needs the extra 'arrow'" in refused("nearest", "lines.npz", "points.npy", "-o", "a.parquet")[1]
    Path("points.parquet").write_bytes(b"PAR1")
    assert "needs the extra 'arrow'" in refused("nearest", "lines.npz", "points.parquet")[1]
