"""Readers of tracts: .trk and .tck files from hand-written bytes, and those that nibabel ships."""

from __future__ import annotations

import io
import sys
import warnings
from importlib import resources

import numpy as np
import pytest
from line_files import FIRST, LAST, POINTS, SAMPLES, STRANDS, message_of, tck, trk

from fastlines.errors import FileFormatError, MissingExtraError

nibabel_data = resources.files(pytest.importorskip("nibabel")) / "tests" / "data"


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
    for same in (tck(count="0000000000"), tck(count="0004"), tck(gap=b"\0\0\0")):
        assert len(load(same, "a.tck")) == 5


def test_streamlines_without_points_keep_the_numbers_of_the_others(load):
    counts = [3, 0, 1, 0, 2, 1]
    for name, data in {"a.trk": trk(counts=counts), "a.tck": tck(counts=counts)}.items():
        np.testing.assert_array_equal(load(data, name).strands, [0, 0, 2, 4, 5])
    assert len(load(tck(counts=counts, count="4"), "a.tck")) == 5
    with pytest.raises(FileFormatError, match="nibabel can not read"):
        load(trk(counts=counts, n_properties=1), "a.trk")


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
        import nibabel.streamlines

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
    [
        ("no_header_end.tck", "END"),
        ("no_header_end_eof.tck", "END"),
        ("no_magic_number.tck", "magic number"),
        ("matlab_nan.tck", "counts '615000' streamlines, but the file holds 1"),
    ],
)
def test_malformed_files_of_nibabel(load, name, said):
    assert said in message_of(load, (nibabel_data / name).read_bytes(), name)


def test_missing_nibabel_names_the_extra(load, monkeypatch):
    monkeypatch.setitem(sys.modules, "nibabel.streamlines", None)
    for name in ("some.trk", "some.tck"):
        with pytest.raises(MissingExtraError, match=r"reading \.t.k needs .*fastlines\[tracts\]"):
            load(SAMPLES[name], name)
