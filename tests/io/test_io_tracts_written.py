"""Written .trk and .tck files: points bit for bit, also by nibabel; and what is lost."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from support.line_files import AROUND, POINTS, lost_by, trk

import fastlines as fl
from fastlines.io.formats import trk as trk_format

nibabel = pytest.importorskip("nibabel")

#: Coordinates of which many bits would be lost by adding half a voxel and subtracting it.
NASTY = np.array([[1e-30, -0.0, 0.1], [1e7 / 3, -1e-12, 5.5], [0.0, 1 / 3, -2e5], [1, 2, 3]], np.float32)
#: The same within the grid that a .trk gets where none is known.
FROM_0 = np.array([[1e-30, -0.0, 0.1], [512, 1e-12, 5.5], [0.0, 1 / 3, 511.99], [1, 2, 3]], np.float32)


@pytest.mark.parametrize(
    ("name", "points"), [("a.trk", FROM_0), ("a.tck", NASTY), ("a.trk.gz", FROM_0), ("A.TCK", NASTY), ("a.trx", NASTY)]
)
@pytest.mark.filterwarnings("ignore::fastlines.PrecisionWarning", "ignore:.*no voxel grid:fastlines.FileWarning")
def test_points_keep_their_bits(tmp_path, name, points):
    lines = replace(fl.Lines.from_points(points[[0, 1, 2, 3, 3, 0, 1]], [4, 1, 2]), unit="mm")
    fl.write(tmp_path / name, lines)
    again = fl.read(tmp_path / name)
    np.testing.assert_array_equal(again.segments.view(np.int32), lines.segments.view(np.int32))
    np.testing.assert_array_equal(again.strands, lines.strands)
    assert (again.unit, again.up) == ("mm", "z")
    if not name.endswith((".gz", ".trx")):
        streamlines = nibabel.streamlines.load(str(tmp_path / name)).streamlines
        for streamline, expected in zip(streamlines, [points, points[[3, 3]], points[:2]], strict=True):
            np.testing.assert_array_equal(streamline, expected)


@pytest.mark.parametrize("extension", [".trk", ".tck"])
def test_nothing(tmp_path, extension):
    fl.write(tmp_path / f"a{extension}", np.empty((0, 2, 3)))
    assert len(fl.read(tmp_path / f"a{extension}")) == 0
    assert len(nibabel.streamlines.load(str(tmp_path / f"a{extension}")).streamlines) == 0


def test_values_of_trk_come_back(tmp_path, load):
    names = (b"a\0" + b"2", b"b")
    lines = replace(load(trk(n_scalars=3, n_properties=3, names=names), "a.trk"), metadata=AROUND)
    fl.write(tmp_path / "b.trk", lines)
    again = fl.read(tmp_path / "b.trk")
    assert list(again.attributes) == ["a", "b", "a of streamline", "b of streamline"]
    for name, values in lines.attributes.items():
        np.testing.assert_array_equal(again.attributes[name], values)
    assert set(again.end_attributes) == {"a", "b"}
    tractogram = nibabel.streamlines.load(str(tmp_path / "b.trk")).tractogram
    assert {name: values.get_data().shape[1] for name, values in tractogram.data_per_point.items()} == {"a": 2, "b": 1}
    np.testing.assert_array_equal(tractogram.data_per_streamline["b"][:, 0], range(4))


@pytest.mark.parametrize(("most", "written"), [(3, 0), (4, 4)])
def test_more_streamlines_than_the_header_can_count_are_written_as_unknown(tmp_path, load, monkeypatch, most, written):
    lines = load(trk(), "a.trk")
    monkeypatch.setattr(trk_format, "MOST_COUNTED", most)
    with pytest.warns(fl.FileWarning, match="outside of it"):
        fl.write(tmp_path / "b.trk", lines)
    data = (tmp_path / "b.trk").read_bytes()
    assert int.from_bytes(data[988:992], "little") == written
    assert fl.read(tmp_path / "b.trk").n_strands == lines.n_strands == 4


def test_what_is_lost_is_told(tmp_path):
    values = {f"value {i}": np.zeros(7) for i in range(11)}
    lines = fl.Lines.from_points(POINTS, [3, 1, 2, 1], attributes={"words": ["a"] * 7, **values})
    with pytest.warns(fl.FileWarning, match=r"a.trk: not kept.*'words', <U1.*'value 10', as there is room for 10 scal"):
        fl.write(tmp_path / "a.trk", lines)
    assert list(fl.read(tmp_path / "a.trk").attributes) == [f"value {i}" for i in range(10)]
    long = "a name of more than 20 bytes"
    strange = {long: np.full(7, 1 / 3), "x" * 18: np.ones((7, 12)), "cube": np.ones((7, 2, 2))}
    lines = replace(fl.Lines.from_points(POINTS, [7], radius=2, attributes=strange), unit="m", up="y")
    with pytest.warns(fl.FileWarning) as told:
        fl.write(tmp_path / "a.trk", lines)
    for said in (
        f"whole name '{long}' ('a name of more than' is written)",
        f"digits of '{long}' (float64) beyond those of float32",
        f"whole name '{'x' * 18}' ('{'x' * 17}' is written)",
        "'cube', float64 of shape (7, 2, 2)",
        "that 'radius' is the radius",
        "the unit 'm'",
        "the upward axis 'y'",
    ):
        assert said in str(told[0].message)
    again = fl.read(tmp_path / "a.trk")
    assert again.attributes["x" * 17].shape == (6, 12)
    np.testing.assert_array_equal(again.attributes["radius"], 2)
    with pytest.warns(fl.FileWarning, match="radius; 'a name of more than 20 bytes'; .*'cube'; the unit 'm'"):
        fl.write(tmp_path / "a.tck", lines)


def test_strands_that_fork_or_are_none(tmp_path):
    segments = POINTS[:6].reshape(3, 2, 3)
    with pytest.warns(fl.FileWarning, match="no place for it: that segments have no strand$"):
        fl.write(tmp_path / "a.tck", replace(fl.lines(segments), unit="mm"))
    np.testing.assert_array_equal(fl.read(tmp_path / "a.tck").strands, [0, 1, 2])
    with pytest.warns(fl.FileWarning, match="numbers of strands"):
        fl.write(tmp_path / "a.tck", fl.Lines.from_segments(segments, strands=[4, 4, 4]))
    np.testing.assert_array_equal(fl.read(tmp_path / "a.tck").segments, segments)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (np.full(7, 2**53 + 1), "digits of 'v' (int64) beyond those of float32"),
        (np.full(7, 2**63 - 1), "digits of 'v' (int64) beyond those of float32"),
        (np.full(7, 2**64 - 1, np.uint64), "digits of 'v' (uint64) beyond those of float32"),
        (np.full(7, -(2**63)), None),
        (np.full(7, 2**63, np.uint64), None),
        (np.ones(7, np.bool_), "that 'v' is boolean (0 and 1 are written)"),
    ],
)
def test_values_that_float32_does_not_keep_are_told(tmp_path, values, said):
    lines = replace(fl.Lines.from_points(POINTS, [7], attributes={"v": values}), unit="mm", metadata=AROUND)
    assert lost_by(tmp_path / "a.trk", lines) == ([said] if said else [])
    np.testing.assert_array_equal(fl.read(tmp_path / "a.trk").attributes["v"], values[:6].astype("f4"))


@pytest.mark.parametrize("name", ["a.trk", "a.tck", "a.trx", "a.vtp", "a.hair", "a.swc", "a.txt", "a.obj", "a.geojson"])
def test_segments_of_no_strand_are_told_once(tmp_path, name):
    segments = POINTS[:6].reshape(3, 2, 3).astype("f4")
    for strands, said in (
        ([0, -1, 2], ["that segments have no strand"]),
        ([-1, 7, -1], ["that segments have no strand", "the numbers of strands, which are counted from 0"]),
        ([0, 1, 1], ["the numbers of strands, which are counted from 0"]),
    ):
        radius = None if name.endswith(("tck", "obj")) else 0
        lines = fl.Lines.from_segments(segments, strands=strands, radius=radius)
        assert [text for text in lost_by(tmp_path / name, lines) if "strand" in text] == said
        back = fl.read(tmp_path / name)
        np.testing.assert_array_equal(back.segments, segments)
        np.testing.assert_array_equal(back.strands, [0, 1, 2])


@pytest.mark.filterwarnings("ignore:.*no voxel grid:fastlines.FileWarning")
@pytest.mark.parametrize(("extension", "n_bytes"), [(".trk", 40), (".tck", 40), (".trx", 50)])
def test_memory_of_reading(tmp_path, extension, n_bytes):
    """Each point takes 12 bytes in the file and 32 in lines; pieces of a file are freed before the next one is read."""
    points = np.random.default_rng(0).random((1_000_000, 3), np.float32)
    path = tmp_path / f"a{extension}"
    fl.write(path, replace(fl.Lines.from_points(points, [100] * 10_000), unit="mm"))
    fl.read(path)
    tracemalloc.start()
    try:
        fl.read(path)
        assert tracemalloc.get_traced_memory()[1] < n_bytes * len(points)
    finally:
        tracemalloc.stop()


def test_the_unit_of_curves_is_not_lost_in_silence(tmp_path):
    curves = replace(fl.Curves.from_strands(POINTS[:4], [4], basis="bezier"), unit="cm")
    assert curves.pieces.lines.unit == "cm"
    with pytest.warns(fl.FileWarning, match="curves, which are written as their pieces.*the unit 'cm'"):
        fl.write(tmp_path / "a.trk", curves)
    with pytest.warns(fl.FileWarning, match="written as their pieces"):
        fl.write(tmp_path / "a.vtp", curves)
    assert fl.read(tmp_path / "a.vtp").unit == "cm"
