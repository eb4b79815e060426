"""Files that other programs have left odd: what is certain is read, with one warning for what is odd."""

from __future__ import annotations

import errno
import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from support.line_files import FIRST, LAST, POINTS, SAMPLES, STRANDS, tck, trk, usc

import fastlines as fl
from fastlines.io.source import Source

NAMED = "datatype: Float32LE\n"

#: Each holds the five segments of POINTS.
ODD: list[tuple[str, bytes, str]] = [
    ("a.trk", trk(promised=2), "its header counts 2 streamlines, but the file holds 4; all are read"),
    ("a.trk", trk(promised=-1), "its header counts -1 streamlines, but the file holds 4"),
    ("a.trk", trk(tail=b"\0\0"), "2 bytes after the last of its 4 streamlines are not read"),
    ("a.trk", trk(tail=b"\xfe\xff\xff\xff"), "4 bytes after the last of its 4 streamlines"),
    ("a.trk", trk(version=3), "has version 3 of the format; it is read as version 2"),
    ("a.trk", trk(to_ras=np.eye(4) + np.outer([0, 0, 0, 1], [9, 9, 9, 0])), r"last row is \[9. 9. 9. 1.\]; expected"),
    ("a.trk", trk(version=0), "has version 0 of the format; it is read as version 2"),
    ("a.tck", tck(head=f"count: 9\n{NAMED}count: 4\n"), "counts 9 and 4 streamlines; the 4 that it holds are read"),
    ("a.tck", tck(head=f"count: 9\n{NAMED}"), "counts 9 streamlines; the 4"),
    ("a.tck", tck(head=f"count: 3\n{NAMED}"), "counts 3 streamlines; the 4"),
    ("a.tck", tck(head=f"count: many\n{NAMED}"), "counts many streamlines; the 4"),
    ("a.tck", tck(head=f"count: {'9' * 500}\n{NAMED}"), "counts 9{20} streamlines; the 4"),
    ("a.tck", tck(head=f"count: \0\x1b[1m\n{NAMED}"), r"counts \?\?\[1m streamlines"),
    ("a.tck", tck(head=NAMED, end="END\ncount: 0004\nEND\n"), "its header continues after END"),
    ("a.tck", tck(end=""), "its header has no line END; its data are read from byte"),
    ("a.tck", tck(end="end\n"), "its header has no line END; its data are read from byte"),
    (
        "a.tck",
        tck(file="file: . 7\n"),
        r"where its data start \('file'\) is \. 7; they are read from behind its header",
    ),
    ("a.tck", tck(file=f"file: . {len(tck()) - 12 * 7}\n"), r"is \. [0-9]+;"),
    ("a.tck", tck(file="file: . 99999\n"), r"is \. 99999;"),
    ("a.tck", tck(file="file: . -1\n"), r"is \. -1;"),
    ("a.tck", tck(file="file: .\n"), r"is \.;"),
    ("a.tck", tck(file=""), "is missing;"),
    ("a.tck", tck(file="file: . 7\nfile: . 8\n"), r"is \. 7, \. 8;"),
    ("a.tck", tck(head="count: 4\n"), "names no type .*; its data are read as Float32LE"),
    (
        "a.tck",
        tck(marks=("last nan",)),
        "three Inf at the end are missing; it holds 4 streamlines, as its header counts",
    ),
    ("a.tck", tck(head=NAMED, marks=("last nan",)), "it holds 4 streamlines, and whether more should follow is not"),
    ("a.tck", tck(marks=("inf",)), "no NaN ends its last streamline; the end of the data does"),
    ("a.tck", tck(tail=b"\n"), "1 bytes after the three Inf that end its data are not read"),
    ("a.tck.gz", gzip.compress(tck()) + b"more", "the bytes after its packed part are not read"),
]


@pytest.mark.parametrize(("name", "data", "said"), ODD, ids=[f"{i}-{odd[2][:30]}" for i, odd in enumerate(ODD)])
def test_what_is_certain_is_read_and_what_is_odd_is_told(load, name, data, said):
    with pytest.warns(fl.FileWarning) as told:
        lines = load(data, name)
    assert len(told) == 1
    text = str(told[0].message)
    assert re.search(rf"{name}: .*{said}", text), text
    assert "\n" not in text
    np.testing.assert_allclose(lines.segments, POINTS[np.stack([FIRST, LAST], axis=1)], rtol=1e-6)
    np.testing.assert_array_equal(lines.strands, STRANDS)


def test_each_oddity_is_told(load):
    with pytest.warns(fl.FileWarning) as told:
        assert len(load(tck(file="file: . 7\n", tail=b"\n"), "a.tck")) == len(FIRST)
    assert [re.sub(r".*a\.tck: ", "", str(each.message)) for each in told] == [
        "where its data start ('file') is . 7; they are read from behind its header, byte 57",
        "1 bytes after the three Inf that end its data are not read",
    ]


@pytest.mark.parametrize(
    ("marks", "tail", "oddity"),
    [
        (("last nan",), b"", "three Inf at the end are missing; it holds 4 streamlines"),
        (("last nan", "inf"), b"more", "4 bytes after the three Inf that end its data are not read"),
    ],
)
def test_tck_that_counts_too_few_is_read_to_its_end(load, marks, tail, oddity):
    with pytest.warns(fl.FileWarning) as told:
        assert len(load(tck(head="count: 3\ndatatype: Float32LE\n", marks=marks, tail=tail), "a.tck")) == len(FIRST)
    texts = [str(each.message) for each in told]
    assert any(oddity in text for text in texts)
    assert any("its header counts 3 streamlines; the 4 that it holds are read" in text for text in texts)


def test_trk_that_ends_with_zeros_has_streamlines_without_points_there(load):
    with pytest.warns(fl.FileWarning, match="counts 4 streamlines, but the file holds 5"):
        assert len(load(trk(tail=bytes(4)), "a.trk")) == len(FIRST)


PLY_POINTS = (
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
)
PDB_ATOM = "HETATM{0:5}  O   HOH A{0:4}     {0:2}0.000  10.000  10.000  1.00 20.00           O\n"
VTK_GRID = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 float\n0 0 0 1 0 0\n"
VTP = (
    '<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="2"><Points><DataArray type="Float32" '
    'NumberOfComponents="3" format="ascii">0 0 0 1 0 0</DataArray></Points></Piece></PolyData></VTKFile>'
)

#: Files of points alone.
POINTS_ALONE: list[tuple[str, str | bytes, str]] = [
    ("a.ply", f"{PLY_POINTS}0 0 0\n1 0 0\n", "its 2 vertices are not read, as no edge joins them"),
    ("a.obj", "v 0 0 0\nv 1 0 0\n", "its 2 vertices are not read, as no element l joins them"),
    ("a.obj", "v 0 0 0\nv 1 0 0\np 1 2\n", "its 1 points are not read"),
    ("a.vtk", VTK_GRID, "its 2 points are left out, as no line joins them"),
    ("a.vtp", VTP, "its 2 points are left out, as no line joins them"),
    ("a.vtu", f"{VTK_GRID}CELLS 2 4\n1 0\n1 1\nCELL_TYPES 2\n1\n1\n", "2 other cells left out"),
    ("a.geojson", '{"type": "MultiPoint", "coordinates": [[1, 2]]}', "without a line are not read: 1 MultiPoint"),
    ("a.csv", "id,wkt\n1,POINT (1 1)\n", "without a line are not read: 1 POINT"),
    ("a.gpx", '<gpx><wpt lat="1" lon="2"/></gpx>', "1 waypoints are not read"),
    ("a.data", usc(counts=[1] * 7), "no hair grows from its 7 roots, so there are no lines"),
    ("a.pdb", PDB_ATOM.format(1) + PDB_ATOM.format(2), "its 2 atoms are not read, as no bond joins them"),
]


@pytest.mark.parametrize(("name", "data", "said"), POINTS_ALONE)
def test_points_alone_are_told(load, name, data, said):
    if name == "a.pdb":
        pytest.importorskip("gemmi")
    with pytest.warns(fl.FileWarning, match=said) as told:
        assert len(load(data.encode() if isinstance(data, str) else data, name)) == 0
    assert len(told) == 1


@pytest.mark.parametrize("name", SAMPLES)
def test_whole_files_are_read_without_a_word(load, name):
    assert len(load(SAMPLES[name], name)) > 0


@pytest.mark.filterwarnings("default::fastlines.FileWarning")
def test_the_command_line_tells_what_is_odd_in_one_line(in_own_folder, tmp_path):
    from support.command_line import run

    (tmp_path / "a.tck").write_bytes(tck(marks=("inf",)))
    result = run("info", "a.tck")
    assert result.exit_code == 0
    assert result.stderr.splitlines() == ["warning: a.tck: no NaN ends its last streamline; the end of the data does"]


@pytest.mark.parametrize("missing", ["END", "the triple of Inf", "both"])
def test_a_tck_without_its_end_is_read_piece_by_piece(tmp_path, monkeypatch, missing):
    """Only its last bytes are looked at, so that it is neither read twice nor in memory as a whole."""
    n = 200_000  # more than the bytes that are searched for END
    triples = np.ones((n + 2, 3), "<f4")
    triples[-2], triples[-1] = np.nan, np.inf
    head = b"mrtrix tracks\ndatatype: Float32LE\ncount: 1\nfile: . 80\n"
    head = (head if missing in ("END", "both") else head + b"END\n").ljust(80, b"\n")
    body = triples.tobytes() if missing == "END" else triples[:-1].tobytes()
    (tmp_path / "a.tck").write_bytes(head + body)

    def whole(self):
        raise AssertionError("the whole file is in memory")

    monkeypatch.setattr(Source, "data", property(whole))
    if missing == "both":
        with pytest.raises(fl.FileFormatError, match="which would prove where its data are"):
            fl.read(tmp_path / "a.tck")
        return
    with pytest.warns(fl.FileWarning, match="three Inf" if missing != "END" else "no line END"):
        assert len(fl.read(tmp_path / "a.tck")) == n - 1


def test_bytes_that_were_dropped_are_not_an_empty_file():
    source = Source(b"some bytes", "a.xyz")
    assert source.end(5) == b"bytes"
    source.drop()
    for ask in (
        lambda: source.data,
        source.text,
        lambda: source.start(3),
        lambda: list(source.pieces()),
    ):
        with pytest.raises(RuntimeError, match=r"a\.xyz: its bytes are needed after they were dropped"):
            ask()


class Broken:
    """A file that the disk cannot read."""

    def __init__(self, file):
        self.file = file

    def read(self, *_):
        raise OSError(errno.EIO, "Input/output error")

    read1 = readinto = read

    def __getattr__(self, name):
        return getattr(self.file, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("extension", [".npy", ".tck", ".trk", ".txt", ".ply", ".tck.gz", ".flt"])
def test_a_disk_that_cannot_be_read_is_named(tmp_path, monkeypatch, extension):
    path = tmp_path / f"a{extension}"
    lines = fl.Lines.from_strands([[[0, 0, 0], [1, 1, 1], [2, 1, 0]]])
    if extension == ".flt":
        fl.build(lines).save(path)
    else:
        fl.write(path, lines)
    opened = Path.open
    monkeypatch.setattr(Path, "open", lambda path, *mode: Broken(opened(path, *mode)))

    def cannot_map(*_):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr("fastlines.support.container.np.memmap", cannot_map)
    with pytest.raises(OSError, match=r"^\[Errno 5\] Input/output error: '.*a\..*'$"):
        (fl.load if extension == ".flt" else fl.read)(path)


def test_voxels_that_mirror_or_shift_points_are_told(load):
    """Their size and their number are above 0; points are where the header says."""
    with pytest.warns(fl.FileWarning, match=r"voxels of the size \[-1.  1.  1.\].*; expected numbers above 0"):
        mirrored = load(trk(voxel_size=(-1, 1, 1)), "a.trk")
    np.testing.assert_array_equal(mirrored.segments[..., 0], -1 - POINTS[[FIRST, LAST], 0].T)
    data = bytearray(trk(order=b"LPS"))
    data[6:12] = np.array([0, -3, 0], "<i2").tobytes()
    with pytest.warns(fl.FileWarning, match=r"the dimensions \[ 0 -3  0\]"):
        load(bytes(data), "a.trk")


@pytest.mark.parametrize("name", ["a.trk", "a.swc", "a.geojson", "a.npy"])
def test_a_packed_file_without_its_extension(load, name):
    with pytest.raises(fl.FileFormatError, match=f"{name}: is packed by gzip; add .gz to its name, or unpack it$"):
        load(gzip.compress(b"0 1 2"), name)
