"""``fastlines pairs`` writes what the library answers, bit for bit."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.command_line import done, refused, run
from support.table_files import same, table

import fastlines as fl

pytestmark = pytest.mark.usefixtures("in_own_folder")

LINES = fl.scenes.make("bun-hair", 300).lines
THICK = LINES.with_radius(0.002)
TREE, THICK_TREE = fl.build(LINES), fl.build(THICK)


@pytest.fixture(autouse=True)
def files(in_own_folder):
    """Write lines, and lines with a radius."""
    fl.write("lines.npz", LINES)
    fl.write("thick.npz", THICK)


def pair_columns(pairs):
    columns = {name: getattr(pairs, name) for name in ("i", "j", "strand_i", "strand_j", "s", "t", "distance")}
    return columns | dict(zip(["x_i", "y_i", "z_i", "x_j", "y_j", "z_j"], pairs.points().reshape(-1, 6).T, strict=True))


@pytest.mark.parametrize("name", ["out.csv", "out.parquet", "out.npz"])
@pytest.mark.parametrize("size", [1 << 28, 1 << 12])
def test_pairs_are_those_of_the_library(name, size, monkeypatch):
    monkeypatch.setattr("fastlines.cli.pairs.MAX_BYTES", size)
    for given, of_python in (
        ((), {}),
        (("--skip-neighbours", 3), {"skip_neighbours": 3}),
        (("--skip-strand", "--to", "axis"), {"skip_strand": True, "to": "axis"}),
        (("--other", "lines.npz"), {"other": TREE}),
    ):
        told = done("pairs", "thick.npz", "-r", 0.01, *given, "--points", "-o", name)
        found, expected = table(name), THICK_TREE.pairs(0.01, **of_python)
        assert len(expected) > 10
        assert told.startswith(f"{name}: {len(expected):,} pairs within 0.01, in ")
        assert list(found) == list(pair_columns(expected))
        for column, values in pair_columns(expected).items():
            assert same(found[column], values, values.dtype), (given, column)


def test_pairs_without_a_file_are_counted():
    n = len(TREE.pairs(0.01))
    assert done("pairs", "lines.npz", "-r", 0.01).startswith(f"lines.npz: {n:,} pairs within 0.01, in ")
    facts = json.loads(done("pairs", "lines.npz", "-r", 0.01, "--json"))
    assert (facts["n_pairs"], facts["radius"], facts["output"]) == (n, 0.01, None)


def test_no_pairs_are_a_table_of_no_rows():
    np.save("two.npy", np.float32([[[0, 0, 0], [1, 0, 0]], [[0, 5, 0], [1, 5, 0]]]))
    for name in ("out.csv", "out.parquet", "out.npz"):
        done("pairs", "two.npy", "-r", 1, "-o", name)
        assert {name: len(values) for name, values in table(name).items()} == dict.fromkeys(
            ["i", "j", "s", "t", "distance"], 0
        )


@pytest.mark.parametrize(
    ("args", "code", "words"),
    [
        ((), 2, "--radius"),
        (("-r", "-1"), 2, "is not a finite number"),
        (("-r", "1", "--skip-neighbours", "-1"), 1, "skip_neighbours=-1"),
        (("-r", "1", "--other", "no.npz"), 1, "no.npz"),
        (("-r", "1", "--other", "thick.npz", "--skip-strand"), 1, "--skip-strand does not apply"),
        (("-r", "1", "--other", "thick.npz", "-o", "thick.npz"), 1, "thick.npz: is read from"),
    ],
)
def test_bad_arguments(args, code, words):
    got, sentence = refused("pairs", "lines.npz", *args)
    assert got == code
    assert words in sentence


def test_the_other_input_is_read_with_the_offset_of_the_first():
    far = [np.float64([[x, y, 0], [x + 1, y, 1]]) + np.array([5_000_000, 0, 0]) for x in range(3) for y in range(3)]
    fl.write("far.npz", fl.Lines.from_strands(far, offset="auto"))
    fl.write("there.npz", fl.Lines.from_strands([strand + 0.5 for strand in far], offset=(5_000_000, 7, 0)))
    lines = [fl.read(name, offset=fl.read("far.npz").offset) for name in ("far.npz", "there.npz")]
    expected = fl.build(lines[0]).pairs(0.5, fl.build(lines[1]))
    assert len(expected) > 3
    done("pairs", "far.npz", "-r", 0.5, "--other", "there.npz", "--points", "-o", "out.npz")
    for column, values in pair_columns(expected).items():
        assert same(table("out.npz")[column], values, values.dtype), column


def test_skipped_rows_are_counted():
    segments = np.float32([[[0, 0, 0], [1, 0, 0]], [[np.nan, 0, 0], [0, 0, 1]], [[0, 0.25, 0], [1, 0.25, 0]]])
    np.save("odd.npy", segments)
    result = run("pairs", "odd.npy", "-r", 1, "--skip-invalid", "-o", "a.csv")
    assert (result.exit_code, result.stderr.count("\n")) == (0, 1)
    assert Path("a.csv").read_text() == "i,j,row_i,row_j,s,t,distance\n0,1,0,2,0,0,0.25\n"
    assert "has no radius of its own" in refused("pairs", "lines.npz", "-r", 1, "--no-own-radius")[1]


def test_pairs_of_several_parts_name_them():
    tree = fl.build(fl.Geometry([LINES, fl.Spheres.from_centres(LINES.segments[:50, 0], radius=0.001)]))
    tree.save("both.flt")
    done("pairs", "both.flt", "-r", 0.001, "-o", "pairs.npz")
    found, expected = table("pairs.npz"), tree.pairs(0.001)
    assert set(found["part_j"]) == {0, 1}
    assert np.array_equal(found["part_i"], expected.part_i)
    assert np.array_equal(found["part_j"], expected.part_j)
