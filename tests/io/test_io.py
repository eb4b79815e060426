"""Readers: arrays, what every format has in common, and which paths are read at all."""

from __future__ import annotations

import doctest
import errno
import gzip
import os
import re
from pathlib import Path

import numpy as np
import pytest
from support.line_files import (
    COUNTS,
    FIRST,
    LAST,
    POINTS,
    SAMPLES,
    STRANDS,
    bcc,
    hair,
    message_of,
    npy,
    npz,
    tck,
    tfx,
    trk,
    trx,
    usc,
)

import fastlines.io
from fastlines.errors import InputError
from fastlines.io import known_formats, read

# --- Arrays ---


@pytest.mark.parametrize("dtype", ["<f4", ">f4", "<f8", ">i2", "u1", "<f2", "?"])
@pytest.mark.parametrize("shape", [(3, 6), (3, 2, 3)])
@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("version", [(1, 0), (2, 0)])
def test_npy(load, dtype, shape, order, version):
    array = np.array(POINTS[:6].reshape(shape), dtype, order=order)
    lines = load(npy(array, version=version), "a.npy")
    np.testing.assert_array_equal(lines.segments, array.reshape(3, 2, 3).astype("f4"))
    assert lines.n_strands == 0


@pytest.mark.parametrize("compressed", [False, True])
def test_npz_of_segments(load, compressed):
    segments = POINTS[:6].reshape(3, 2, 3)
    more = {"strands": np.array([4, 4, 7], "u1"), "radius": np.ones((3, 2)), "age": np.arange(3)}
    lines = load(npz(compressed=compressed, segments=segments, **more), "a.npz")
    np.testing.assert_array_equal(lines.segments, segments)
    np.testing.assert_array_equal(lines.strands, [4, 4, 7])
    np.testing.assert_array_equal(lines.radius, np.ones((3, 2)))
    np.testing.assert_array_equal(lines.attributes["age"], [0, 1, 2])
    assert load(npz(segments=segments.reshape(3, 6), radius=np.ones(3)), "a.npz").radius.shape == (3,)
    assert load(npz(segments=segments), "a.npz").radius is None


def test_npz_of_points(load):
    lines = load(npz(points=POINTS, counts=COUNTS, radius=np.arange(7.0), age=np.arange(7)), "a.npz")
    ends = np.stack([FIRST, LAST], axis=1)
    np.testing.assert_array_equal(lines.segments, POINTS[ends])
    np.testing.assert_array_equal(lines.strands, STRANDS)
    np.testing.assert_array_equal(lines.radius, ends)
    np.testing.assert_array_equal(lines.attributes["age"], FIRST)


# --- Every format ---

EMPTY = {
    "a.hair": hair(strands=0, n_points=0, body=b""),
    "v3.tfx": tfx(3, strands=0, vertices=3, points=POINTS[:0]),
    "a.trk": trk(counts=[]),
    "a.tck": tck(counts=[]),
    "a.trx": trx(counts=[], points=POINTS[:0]),
    "b.trx": trx(header='{"NB_STREAMLINES": 0, "NB_VERTICES": 0}', without="o", points=POINTS[:0]),
    "a.vtk": b"# vtk DataFile Version 3.0\nnone\nASCII\nDATASET POLYDATA\n",
    "a.vtp": b'<VTKFile type="PolyData"><PolyData/></VTKFile>',
    "a.npy": npy(np.empty((0, 2, 3))),
    "a.npz": npz(points=np.empty((0, 3)), counts=np.empty(0, int)),
    "b.npz": npz(segments=np.empty((0, 6))),
    "a.data": usc(counts=[]),
    "a.bcc": bcc(counts=[], kind=b"PL"),
    "a.ply": b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n",
    "a.obj": b"# nothing",
    "a.swc": b"# nothing",
    "a.txt": b"\n",
}


@pytest.mark.parametrize("name", EMPTY)
def test_whole_file_without_lines_is_no_error(load, name):
    lines = load(EMPTY[name], name)
    assert len(lines) == 0
    assert lines.segments.shape == (0, 2, 3)


@pytest.mark.parametrize("name", SAMPLES)
def test_packed_by_gzip_and_in_capitals(load, name):
    plain = load(SAMPLES[name], name)
    if name.endswith(".gz"):
        packed = load(SAMPLES[name], name.upper())
    else:
        packed = load(gzip.compress(SAMPLES[name]), name.upper() + ".Gz")
    np.testing.assert_array_equal(plain.segments, packed.segments)
    np.testing.assert_array_equal(plain.strands, packed.strands)


# --- Paths ---


def test_paths_that_are_no_file(tmp_path, load):
    names = ("gone.hair", "gone.xyz", "gone", "gone.gz", "gone.abc", "gone.flt")
    for missing in (*(tmp_path / name for name in names), str(tmp_path / "gone" / "gone.trk.gz")):
        with pytest.raises(FileNotFoundError, match="no such file; check the path") as caught:
            read(missing)
        assert caught.value.filename == str(missing)
    for name in ("folder.hair", "folder", "folder.gz"):
        (tmp_path / name).mkdir()
        with pytest.raises(IsADirectoryError, match="is a directory; expected a file of lines") as is_folder:
            read(str(tmp_path / name))
        assert (is_folder.value.errno, is_folder.value.filename) == (errno.EISDIR, str(tmp_path / name))
    for name in ("pipe.hair", "pipe.xyz", "pipe.gz"):  # opening one would block
        os.mkfifo(tmp_path / name)
        with pytest.raises(InputError, match="is a device or a pipe; expected a regular file"):
            read(tmp_path / name)
    with pytest.raises(InputError, match="cannot be read"):
        read("nul\0.hair")
    with pytest.raises(OSError, match="too long"):
        read("x" * 5000 + ".hair")
    with pytest.raises(InputError, match="path is an int"):
        read(5)
    with pytest.raises(InputError, match="invalid='drop' is not a choice"):
        read(tmp_path / "gone.hair", invalid="drop")
    for name in known_formats():
        assert "is empty" in message_of(load, b"", "a" + name)


@pytest.mark.parametrize("name", ["a.xyz", "a", "a.gz", ".hair", "a.hair.bz2"])
def test_unknown_extension_lists_the_known_ones(load, name):
    text = message_of(load, b"what?", name)
    assert "unknown extension" in text
    assert all(extension in text for extension in known_formats())
    assert "name the format by format= (--format on the command line)" in text


@pytest.mark.parametrize("name", ["a.shp", "a.gpkg", "a.fgb", "a.kml"])
def test_formats_of_maps_lead_to_geopandas(load, name):
    assert "read it by geopandas.read_file, and pass the frame to fl.lines" in message_of(load, b"what?", name)


def test_the_docs_name_every_format():
    page = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    named = page.partition("`format=` takes")[2].partition("\n\n")[0]
    assert {row.name for row in known_formats().values()} <= set(re.findall(r"`(\w+)`", named))


def test_unknown_extensions_and_formats_name_the_nearest_known_ones(load):
    assert "unknown extension '.trkk'; did you mean '.trk'? known:" in message_of(load, b"what?", "a.trkk")
    for name, nearest in (("geojsn", "geojson"), (".trkk", "trk"), ("mitsubi", "mitsuba")):
        with pytest.raises(InputError, match=rf"format '{name}' is unknown; did you mean '{nearest}'\?"):
            load(b"what?", "a.bin", format=name)


@pytest.mark.parametrize("name", ["a.gz", "a.bin.gz", "A.GZ"])
@pytest.mark.parametrize("sample", ["some.trk", "some.tck", "full.hair", "some.npy", "some.bcc"])
def test_content_names_the_format_of_packed_files(load, sample, name):
    packed = load(gzip.compress(SAMPLES[sample]), name)
    np.testing.assert_array_equal(packed.segments, load(SAMPLES[sample], sample).segments)


@pytest.mark.parametrize("extension", known_formats())
def test_no_tree_is_saved_where_lines_would_be_looked_for(tmp_path, extension):
    tree = fastlines.build([[[0, 0, 0], [1, 1, 1]]])
    for name in (f"a{extension}", f"a{extension.upper()}.GZ"):
        with pytest.raises(InputError, match="hold lines, this is a tree"):
            tree.save(tmp_path / name)
    with pytest.raises(InputError, match="trees are not compressed"):
        tree.save(tmp_path / "a.flt.gz")
    assert not list(tmp_path.iterdir())


def test_examples_in_docstrings():
    assert doctest.testmod(fastlines.io).failed == 0
