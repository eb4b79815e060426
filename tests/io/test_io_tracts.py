"""Readers of tracts: .trk and .tck files from hand-written bytes, and those that nibabel ships."""

from __future__ import annotations

import io
import itertools
import warnings
from importlib import resources

import numpy as np
import pytest
from support.line_files import FIRST, LAST, POINTS, STRANDS, message_of, tck, trk

import fastlines as fl

nibabel = pytest.importorskip("nibabel")
nibabel_data = resources.files(nibabel) / "tests" / "data"


def test_trk(load):
    lines = load(trk(n_scalars=1, n_properties=1), "a.trk")
    np.testing.assert_allclose(lines.segments, POINTS[np.stack([FIRST, LAST], axis=1)], rtol=1e-6)
    np.testing.assert_array_equal(lines.strands, STRANDS)
    np.testing.assert_array_equal(lines.attributes["fa"], np.zeros(5))
    np.testing.assert_array_equal(lines.attributes["fa of streamline"], STRANDS)
    assert len(load(trk(promised=0), "unknown count.trk")) == 5


def test_tck(load):
    lines = load(tck(), "a.tck")
    np.testing.assert_array_equal(lines.segments, POINTS[np.stack([FIRST, LAST], axis=1)])
    np.testing.assert_array_equal(lines.strands, STRANDS)
    heads = ["count: 0000000000\n", "count: 0004\n", "# made by hand\nno key\nCount: 4\ncount: 4\n", "\r\n"]
    for same in (tck(gap=b"\0\0\0"), *[tck(head=f"{head}datatype: Float32LE\n") for head in heads]):
        assert len(load(same, "a.tck")) == 5


@pytest.mark.parametrize("name", ["Float32LE", "Float32BE", "Float64LE", "Float64BE", "float64le"])
def test_tck_of_every_type(load, name):
    dtype = (">" if name.endswith("BE") else "<") + ("f8" if "64" in name else "f4")
    lines = load(tck(head=f"datatype: {name}\n", dtype=dtype), "a.tck")
    np.testing.assert_array_equal(lines.segments, POINTS[np.stack([FIRST, LAST], axis=1)])


def test_streamlines_without_points_keep_the_numbers_of_the_others(load):
    counts = [3, 0, 1, 0, 2, 1]
    for name, data in {"a.trk": trk(counts=counts), "a.tck": tck(counts=counts)}.items():
        np.testing.assert_array_equal(load(data, name).strands, [0, 0, 2, 4, 5])
    assert len(load(tck(counts=counts, head="count: 4\ndatatype: Float32LE\n"), "a.tck")) == 5
    lines = load(trk(counts=counts, n_properties=1), "a.trk")
    np.testing.assert_array_equal(lines.attributes["fa"], lines.strands)


# --- Files that nibabel ships ---


@pytest.mark.parametrize(
    ("name", "n_strands", "n_segments"),
    [
        ("simple.trk", 3, 6),
        ("complex.trk", 3, 6),
        ("complex_big_endian.trk", 3, 6),
        ("standard.trk", 120, 240),
        ("standard.LPS.trk", 120, 240),
        ("empty.trk", 0, 0),
        ("simple.tck", 3, 6),
        ("simple_big_endian.tck", 3, 6),
        ("standard.tck", 120, 240),
        ("multiline_header_field.tck", 1, 252),
        ("empty.tck", 0, 0),
    ],
)
def test_files_of_nibabel(load, name, n_strands, n_segments):
    data = (nibabel_data / name).read_bytes()
    lines = load(data, name)
    assert (lines.n_strands, len(lines)) == (n_strands, n_segments)
    if n_strands:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            streamlines = nibabel.streamlines.load(io.BytesIO(data)).streamlines
        expected = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in streamlines if len(line) > 1])
        at_length = lines.segments[[np.any(a != b) for a, b in lines.segments]]
        np.testing.assert_array_equal(at_length, expected[[np.any(a != b) for a, b in expected]])


def test_values_that_trk_files_hold_beside_points(load):
    lines = load((nibabel_data / "complex.trk").read_bytes(), "complex.trk")
    shapes = {name: values.shape for name, values in lines.attributes.items()}
    assert shapes == {
        "colors": (6, 3),
        "fa": (6,),
        "mean_colors": (6, 3),
        "mean_curvature": (6,),
        "mean_torsion": (6,),
    }


@pytest.mark.parametrize(
    ("name", "said"),
    [("no_header_end.tck", "END"), ("no_header_end_eof.tck", "END"), ("no_magic_number.tck", "check the extension")],
)
def test_malformed_files_of_nibabel(load, name, said):
    assert said in message_of(load, (nibabel_data / name).read_bytes(), name)


def test_file_of_nibabel_that_counts_what_was_taken_out_of_it(load):
    with pytest.warns(fl.FileWarning, match=r"matlab_nan\.tck: its header counts 615000 streamlines; the 1 that"):
        assert load((nibabel_data / "matlab_nan.tck").read_bytes(), "matlab_nan.tck").n_strands == 1


# --- The place of a .trk in the world ---

#: A rotation by a small angle about each axis, and a shift.
OBLIQUE = np.array([[0.96, -0.17, 0.22, 20], [0.19, 0.98, -0.1, -30], [-0.2, 0.14, 0.97, 40], [0, 0, 0, 1]])


@pytest.mark.parametrize("byte_order", ["<", ">"])
@pytest.mark.parametrize("order", [b"RAS", b"LPS", b"las", b"RPI"])
@pytest.mark.parametrize("mirror", [(1, 1, 1), (-1, 1, 1), (-1, -1, 1)])
def test_transform_as_nibabel_applies_it(load, byte_order, order, mirror):
    to_ras = OBLIQUE @ np.diag([*(np.array([2, 3, 4]) * mirror), 1])
    data = trk(voxel_size=(2, 3, 4), to_ras=to_ras, order=order, byte_order=byte_order)
    points = nibabel.streamlines.load(io.BytesIO(data)).streamlines.get_data()
    segments = load(data, "a.trk").segments
    np.testing.assert_allclose(segments, points[np.stack([FIRST, LAST], axis=1)], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("order", ["".join(letters) for letters in itertools.permutations("RAS")])
def test_axes_of_points_in_another_order_than_those_of_the_transform(load, order):
    # Voxels of 1 mm: a point's world coordinate is that along the axis of the same letter, from the voxel's centre.
    segments = load(trk(order=order.encode()), "a.trk").segments
    expected = POINTS[:, [order.index(letter) for letter in "RAS"]]
    np.testing.assert_allclose(segments, expected[np.stack([FIRST, LAST], axis=1)], rtol=1e-6)


@pytest.mark.parametrize(
    "options",
    [
        {"to_ras": np.zeros((4, 4))},
        {"to_ras": np.diag([3, 3, 3, 0])},
        {"version": 1},
        {"version": 1, "voxel_size": (0, 0, 0)},
        {"version": 0, "to_ras": np.zeros((4, 4)), "order": b""},
    ],
)
def test_trk_without_a_transform_stays_in_millimetres(load, options):
    data = trk(**{"voxel_size": (2, 2, 4), "order": b"LPS", **options})
    axes = r"axes \(LPS\);" if options.get("order") is None else "axes;"
    with pytest.warns(
        fl.FileWarning, match=rf"a\.trk: its header has no transform .*first voxel, along .* {axes}"
    ) as told:
        lines = load(data, "a.trk")
    assert len(told) == 1
    assert told[0].filename == load.__globals__["__file__"], "it points to who reads"
    np.testing.assert_array_equal(lines.segments, POINTS[np.stack([FIRST, LAST], axis=1)] + np.float32(0.5))


@pytest.mark.parametrize("order", [b"", b"XYZ", b"RRS", b"RA"])
def test_trk_without_a_voxel_order_is_taken_for_lps(load, order):
    with pytest.warns(fl.FileWarning, match=r"a\.trk: its voxel order is .*; LPS is assumed") as told:
        lines = load(trk(order=order), "a.trk")
    assert len(told) == 1
    expected = POINTS * [-1, -1, 1] + [8, 7, 0]
    np.testing.assert_allclose(lines.segments, expected[np.stack([FIRST, LAST], axis=1)], rtol=1e-6)


# --- Values beside points ---


def test_names_of_values_in_trk(load):
    names = (b"a\0" + b"2", b"b", b"a", b"junk\0\xff\xfe")
    lines = load(trk(n_scalars=6, names=names), "a.trk")
    shapes = {name: values.shape[1:] for name, values in lines.attributes.items()}
    assert shapes == {"a": (2,), "b": (), "a 3": (), "junk": (), "scalars": ()}
    np.testing.assert_array_equal(lines.attributes["a"], np.tile([0, 1], (5, 1)))
    np.testing.assert_array_equal(lines.attributes["scalars"], np.full(5, 5))
