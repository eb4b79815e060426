"""Readers and files that lie, are cut short or are damaged."""

from __future__ import annotations

import gzip
import io
import json
import re
import struct
import tracemalloc
import zipfile

import numpy as np
import pytest
from support.line_files import (
    COUNTS,
    PLY_HEADER,
    POINTS,
    SAMPLES,
    bcc,
    hair,
    message_of,
    npy,
    npy_of,
    npz,
    ply,
    tck,
    tfx,
    trk,
    usc,
)
from support.slow import few_of

from fastlines.errors import FastlinesError, InputError
from fastlines.io import source as sources

# --- Files that lie ---

HUGE = 2**32 - 1
NAN_POINTS = np.where(np.arange(7)[:, None] == 4, np.nan, POINTS)

LIES: list[tuple[str, bytes, str]] = [
    ("a.hair", hair(magic=b"RIAH"), "starts with b'RIAH', a .hair file with b'HAIR'"),
    ("a.hair", b"HAIR", "header fields .* do not fit into the file's 4 bytes"),
    ("a.hair", hair(strands=HUGE), "segment counts .4294967295 of 2 bytes.* do not fit"),
    ("a.hair", hair(n_points=HUGE), "points .* do not fit"),
    ("a.hair", hair(strands=3), "by their segments|do not fit|left over"),
    ("a.hair", hair(bits=2, strands=HUGE, segments=0), "4294967295 strands have 4294967295 points, but 7"),
    ("a.hair", hair(bits=2, strands=HUGE, segments=HUGE), "points, but 7"),
    ("a.hair", hair(bits=2, strands=2, segments=3), "2 strands have 8 points, but 7"),
    ("a.hair", hair(bits=2, strands=0), "0 strands have 0 points, but 7"),
    ("a.hair", hair(bits=1), r"announces the arrays 0b1; expected 0b10"),
    ("a.hair", hair(bits=3 | 64), "announces the arrays 0b1000011"),
    ("a.hair", hair() + b"\0", "1 bytes are left over"),
    ("a.hair", hair(thickness=np.nan), "default thickness must be finite"),
    ("a.hair", hair(thickness=-1), "default thickness must be finite"),
    (
        "a.hair",
        hair(bits=7)[:-4] + struct.pack("<f", -1),
        r"thickness must be finite and not negative \(see row 6\)",
    ),
    ("a.tfx", tfx(3)[:3], "version numbers .* do not fit"),
    ("a.tfx", struct.pack("<f", 5) + tfx(4)[4:], "version 5; expected 3 or 4"),
    ("a.tfx", struct.pack("<f", np.nan) + tfx(4)[4:], "version nan"),
    ("a.tfx", struct.pack(">f", 4) + tfx(4)[4:], "version .*e-41; expected 3 or 4"),
    ("a.tfx", tfx(4)[:100], "header fields .* do not fit"),
    ("a.tfx", tfx(4, strands=HUGE, vertices=HUGE), "positions .* do not fit"),
    ("a.tfx", tfx(4, vertices=0), "2 strands of 0 vertices"),
    ("a.tfx", tfx(4, strands=HUGE, vertices=0), "4294967295 strands of 0 vertices"),
    ("a.tfx", tfx(4, positions=0), "positions .* overlap version numbers"),
    ("a.tfx", tfx(3, positions=290), "positions .* overlap header fields"),
    ("a.tfx", tfx(4, positions=HUGE), "positions .* do not fit"),
    ("a.tfx", tfx(3, positions=300), "positions .* do not fit"),
    ("a.tfx", tfx(4, thickness=8), "thickness values .* overlap header"),
    ("a.tfx", tfx(4, thickness=170), "thickness values .* overlap positions"),
    ("a.tfx", tfx(4, color=HUGE), "color values .* do not fit"),
    ("a.tfx", tfx(3, uv=300), "uv values .* overlap|do not fit"),
    ("a.trk", b"TRACK", "header fields .* do not fit"),
    ("a.trk", bytes(1000), "starts with b'', a .trk file with b'TRACK'; check the extension"),
    ("a.trk", b"KCART" + trk()[5:], "starts with b'KCART'"),
    ("a.trk", trk(size=0), "says that its header has 0 bytes; expected 1000"),
    ("a.trk", trk(promised=100), "counts 100 streamlines, but the file holds 4; get a whole copy, or set the count"),
    ("a.trk", trk(promised=0, tail=b"\0\0"), "last 2 bytes are not a whole streamline; the file is cut short"),
    ("a.trk", trk(promised=0, tail=struct.pack("<i", -3)), "streamline 4 announces -3 points, which are not there"),
    ("a.trk", trk(promised=5, tail=struct.pack("<i", 2**31 - 1)), "streamline 4 announces 2147483647 points"),
    ("a.trk", trk()[:36] + b"\xfe\xff" + trk()[38:], "-2 scalars"),
    ("a.trk", trk()[:36] + b"\xff\x7f" + trk()[38:], "streamline 0 announces 3 points"),
    ("a.trk", trk()[:238] + b"\xff\xff" + trk()[240:], "-1 properties"),
    ("a.trk", trk(voxel_size=(1, 0, 1)), "voxels have the size"),
    ("a.trk", trk(voxel_size=(1, np.nan, 1)), "voxels have the size"),
    ("a.trk", trk(version=9), "has version 9 of the format; known are 1 to 3; convert it$"),
    ("a.trk", trk(to_ras=np.diag([1, 1, 0, 1])), "vox_to_ras.* cannot be inverted or is not finite; fix the header$"),
    ("a.trk", trk(to_ras=np.diag([1, 1, np.nan, 1])), "vox_to_ras.* cannot be inverted or is not finite"),
    ("a.tck", tck()[1:], "starts with b'rtrix tracks.n', a .tck file with b'mrtrix tracks'; check the extension$"),
    ("a.tck", tck(end="", marks=("last nan",)), "which would prove where its data are"),
    ("a.tck", tck(file="", end=""), "header has no line END"),
    ("a.tck", tck(file="file: other.dat 0\n"), "data are in another file, 'other.dat'; expected '.'"),
    ("a.tck", tck(file="file: . 62\n"), "ends as a whole file of type float32le does, but .* at byte 62 do not; fix"),
    ("a.tck", tck(file="", gap=b"\0\0\0"), "ends as a whole file of type float32le does, but .* fix the type"),
    ("a.tck", tck(file="file: . 7\n", marks=("last nan",)), "which would prove where its data are"),
    ("a.tck", tck(head="", marks=("last nan",)), "which would prove where its data are"),
    ("a.tck", tck(head="datatype: Int16\n"), "type .'datatype'. is 'Int16'; expected Float32LE, .*; convert it$"),
    ("a.tck", tck(head="datatype: Float32LE\ndatatype: Float32BE\n"), "is 'Float32LE, Float32BE'; expected"),
    ("a.tck", tck(head="datatype: Float64LE\n"), "ends as a whole file of type float32le does, .* of type float64le"),
    ("a.tck", tck(head="datatype: Float32BE\n"), "ends as a whole file of type float32le does"),
    ("a.tck", tck(marks=()), "last streamline does not end, neither with NaN nor with Inf"),
    ("a.tck", tck(head="count: 5\ndatatype: Float32LE\n", marks=("last nan",)), "counts 5 .* ends after the 4th"),
    (
        "a.tck",
        tck(head="count: 5\ndatatype: Float32LE\n", tail=b"more"),
        "three Inf end the data after 4, and 4 bytes",
    ),
    ("a.data", b"\1\0", "counts of strands .* do not fit"),
    ("a.data", usc(promised=-1), "announces -1 strands; expected 0 or more"),
    ("a.data", usc(promised=2**31 - 1), "announces 2147483647 strands, but ends after 4"),
    ("a.data", usc(promised=3), "16 bytes are left over"),
    ("a.data", usc(tail=b"\0\0"), "2 bytes are left over"),
    ("a.data", usc(counts=[3, -1]), "strand 1 announces -1 points, which are not there"),
    ("a.data", usc(counts=[3])[:4] + struct.pack("<i", 2**31 - 1), "strand 0 announces 2147483647 points"),
    ("a.bcc", b"BCC", "header fields .* do not fit"),
    ("a.bcc", bcc(magic=b"CCB\x44"), "starts with b'CCB', a .bcc file with b'BCC'"),
    ("a.bcc", bcc(magic=b"BCC\x48"), "has numbers of 4 and 8 bytes and 3 dimensions; expected 4 and 4"),
    ("a.bcc", bcc(dimensions=2), "4 bytes and 2 dimensions"),
    ("a.bcc", bcc(kind=b"C1"), "curves of type b'C1'; expected b'C0'.* basis='linear'"),
    ("a.bcc", bcc(promised=2**64 - 1), "announces 18446744073709551615 strands, but ends after 2"),
    ("a.bcc", bcc(promised=1), "40 bytes are left over"),
    ("a.bcc", bcc(counts=[4])[:64] + struct.pack("<i", -(2**31)), "strand 0 announces -2147483648 points"),
    ("a.ply", b"plx\n", "starts with b'plx.n', a .ply file with b'ply' on a line"),
    ("a.ply", b"ply\nformat ascii 1.0\n", "header has no line end_header"),
    ("a.ply", b"ply\nend_header\n", "header has no line format"),
    ("a.ply", ply(header=PLY_HEADER.replace("property float x", "property float32x x")), "has the type 'float32x'"),
    ("a.ply", ply(header=PLY_HEADER.replace("property float y", "property float x")), "has the property 'x' again"),
    ("a.ply", ply(header=PLY_HEADER.replace("comment", "remark")), "line 3 of its header is 'remark by hand'; fix"),
    ("a.ply", ply(header=PLY_HEADER.replace("element edge", "element vertex")), "several elements of one name"),
    ("a.ply", ply(header=PLY_HEADER.replace(" x", " a")), "'vertex' has no number 'x' .it has a, y, z"),
    (
        "a.ply",
        ply(header=PLY_HEADER.replace("element vertex", "element point")),
        "'vertex' has no number 'x' .it has none",
    ),
    ("a.ply", ply(promised=10**17), "100000000000000000 rows of element 'edge', 10 bytes each, do not fit into the 40"),
    ("a.ply", ply("", promised=5), "5 rows of element 'edge', 3 numbers each, do not fit into the 12 numbers"),
    ("a.ply", ply(edges=((0, 7),)), "edge 0 joins the vertices 0 and 7; expected 0 to 6"),
    ("a.ply", ply(edges=((0, 1), (-1, 2))), "edge 1 joins the vertices -1 and 2"),
    ("a.ply", ply("", tail=b"x"), "line 34: 'x' is not numbers; fix it"),
    ("a.ply", ply("", others=((1, 2),)).replace(b"\n9 2 ", b"\n9 2.5 "), "no number of 'vertex_indices' that can be"),
    ("a.npy", b"\x93NUMPX" + bytes(100), "does not start with the header of an array .*; check the extension"),
    ("a.npy", npy_of("'<f4'", "(4611686018427387904, 2, 3)"), "numbers .* do not fit"),
    ("a.npy", npy_of("'<f4'", "(4611686018427387904, 0, 3)"), "numbers .* do not fit"),
    ("a.npy", npy_of("'<f4'", "(-1, 6)", bytes(24)), "numbers .* do not fit"),
    ("a.npy", npy_of("'<f4'", "(1, 6)", bytes(23)), "numbers .* do not fit"),
    ("a.npy", npy_of("'<f4'", "(1, 6)", bytes(25)), "1 bytes are left over"),
    ("a.npy", npy_of("'|O'", "(1, 6)", bytes(48)), "holds object; expected real numbers"),
    ("a.npy", npy_of("'<c8'", "(1, 6)", bytes(48)), "holds complex64; expected real"),
    ("a.npy", npy_of("'(999999,)<f4'", "(1, 6)"), "expected real numbers"),
    ("a.npy", npy_of("[('x', '<f4')]", "(1, 6)", bytes(24)), "expected real numbers"),
    ("a.npy", npy_of("'<f4'", "(" * 5000), "does not start with the header of an array"),
    ("a.npy", b"\x93NUMPY\x03\x00" + npy_of("'<f4'", "(0, 6)")[8:], r"has version \(3, 0\) of the .npy format; plain"),
    ("a.npz", npz(lines=POINTS), "holds the arrays lines; expected 'segments'"),
    ("a.npz", npz(), r"not a whole .npz|holds the arrays \(none\)"),
    ("a.npz", npz(points=POINTS), "holds the arrays points; expected"),
    ("a.npz", npz(points=POINTS, counts=COUNTS, segments=POINTS), "expected 'segments'"),
    ("a.npz", npz(points=POINTS, counts=COUNTS, strands=COUNTS), "expected 'segments'"),
    ("a.npz", npz(points=POINTS, counts=[[7]]), "'counts' has shape"),
    ("a.npz", npz(points=POINTS, counts=7), r"'counts' has shape \(\)"),
    ("a.npz", npz(points=POINTS, counts=[7.0]), "'counts' is of type float64; expected integers"),
    ("a.npz", npz(points=POINTS, counts=[8, -1]), "'counts' are from -1 to 8"),
    ("a.npz", npz(points=POINTS, counts=[2**62] * 4 + [7]), "'counts' are from 7 to 4611686018427387904"),
    ("a.npz", npz(points=POINTS.ravel(), counts=COUNTS), "'points' has shape"),
    (
        "a.npz",
        npz(points=POINTS, counts=COUNTS, radius=np.ones(6)),
        r"'radius' has shape \(6,\); expected \(7,\)",
    ),
    ("a.npz", npz(points=POINTS, counts=COUNTS, age=np.ones(6)), "'age' has shape"),
    ("a.npz", npz(points=POINTS, counts=COUNTS, age=1), "'age' has shape"),
    ("a.npz", npz(segments=POINTS[:2], strands=[1]), r"'strands' has shape \(1,\)"),
    ("a.npz", npz(segments=POINTS[:2], strands=np.array([1, 2], "u8")), "'strands' is of type uint64"),
    ("a.npz", npz(segments=POINTS[:2], radius=np.ones((2, 3))), "'radius' has shape"),
    ("a.npz", npz(segments=POINTS[:2], radius=[1, -1]), "radius must be finite and not negative .see row 1"),
    (
        "a.npz",
        npz(segments=POINTS[:2], radius=[1e300, 1]),
        "radius must be finite and not negative .see row 0",
    ),
    ("a.npz", npz(segments=POINTS[:2], name=["a", "b"]), "array 'name': holds <U1; expected real"),
    ("a.npz", b"PK" + bytes(100), "not a whole .npz file .*; check the extension, or the file is cut short"),
    ("a.npy.gz", b"not packed", "is not packed by gzip although its name ends with .gz; rename it"),
    ("a.npy.gz", gzip.compress(bytes(99))[:-9], "not a whole gzip file .*; the file is cut short"),
    ("a.npy.gz", gzip.compress(b""), "is empty once unpacked"),
    ("a.npy.gz", gzip.compress(bytes(40_000_000)), "unpacks to more than .* gunzip"),
]


@pytest.mark.parametrize(("name", "data", "said"), LIES, ids=[f"{i}-{lie[2][:30]}" for i, lie in enumerate(LIES)])
def test_lies_are_told_in_one_sentence(load, name, data, said):
    text = message_of(load, data, name)
    assert re.search(said, text), text


@pytest.mark.parametrize(
    ("name", "data", "rows"),
    [
        ("a.hair", hair(points=NAN_POINTS), "row 3"),
        ("a.tfx", tfx(3, points=NAN_POINTS[:6]), "row"),
        ("a.npy", npy(NAN_POINTS[:6].reshape(3, 2, 3)), "row 2"),
        ("a.npz", npz(points=NAN_POINTS, counts=COUNTS), "row 3"),
        ("a.data", usc(counts=[7], promised=1)[:8] + NAN_POINTS.astype("<f4").tobytes(), "rows 3"),
        ("a.bcc", bcc(kind=b"PL", points=NAN_POINTS), "rows 3"),
    ],
)
def test_nan_names_its_rows_or_is_skipped(load, name, data, rows):
    assert rows in message_of(load, data, name, InputError)
    lines = load(data, name, invalid="skip")
    assert len(lines.skipped) > 0
    assert np.isfinite(lines.segments).all()


def test_shape_of_segments(load):
    message_of(load, npy(POINTS), "a.npy", InputError)
    message_of(load, npy(5.0), "a.npy", InputError)
    message_of(load, npz(segments=5.0), "a.npz", FastlinesError)


@pytest.mark.parametrize("most", [511, 512, 384])
def test_a_packed_file_may_unpack_to_its_limit_and_not_a_byte_more(load, monkeypatch, most):
    data = npy(np.zeros((16, 2, 3), "f4"))
    assert len(data) == 512
    monkeypatch.setattr(sources, "PIECE", 128)
    monkeypatch.setattr(sources, "UNPACK_FACTOR", 0)
    monkeypatch.setattr(sources, "UNPACK_BYTES", most)
    if most == len(data):
        assert len(load(gzip.compress(data), "a.npy.gz")) == 16
    else:
        assert f"unpacks to more than {most} bytes" in message_of(load, gzip.compress(data), "a.npy.gz")


def test_zip_that_is_no_npz_or_a_bomb(load):
    for method, size, said in [
        (zipfile.ZIP_BZIP2, 10, "'segments.npy' in it is packed by an unknown method"),
        (zipfile.ZIP_DEFLATED, 60_000_000, "unpacks to more than"),
    ]:
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", method) as archive:
            archive.writestr("segments.npy", bytes(size))
        assert said in message_of(load, stream.getvalue(), "a.npz")
    with zipfile.ZipFile(stream := io.BytesIO(), "w") as archive:
        archive.writestr("notes.txt", "segments")
    assert "'notes.txt' in it is not an array" in message_of(load, stream.getvalue(), "a.npz")


@pytest.mark.filterwarnings("ignore:Duplicate name:UserWarning")
def test_arrays_of_one_name(load):
    with zipfile.ZipFile(stream := io.BytesIO(), "w") as archive:
        for value in (0, 1):
            archive.writestr("segments.npy", npy(np.full((1, 2, 3), value)))
    assert "holds several members named 'segments.npy'" in message_of(load, stream.getvalue(), "a.npz")


def test_what_is_quoted_is_short_and_printable(load):
    name = "a\x82\n" * 5000
    for data, file in [
        (json.dumps({"type": name}), "a.geojson"),
        (f"property float {name}", "a.ply"),
        (f"{name},{name}\n1,2", "a.csv"),
    ]:
        message = message_of(load, data.encode(), file)
        assert message.isprintable()
        assert len(message) < 1000


# --- Cut short and damaged ---


def shorter(data: bytes) -> set[int]:
    """Lengths to cut at: each, but for the text and padding of long headers only some."""
    return {n for n in range(len(data)) if len(data) < 800 or n % 7 == 0 or n > len(data) - 150}


@pytest.mark.parametrize("name", few_of(SAMPLES, n=2))
def test_file_cut_short_anywhere(load, name):
    # Of a .tck whose header counts its streamlines, the mark of the end can be cut off without loss.
    end = -12 if name.endswith(".tck") else None
    for n in shorter(SAMPLES[name][:end]):
        with pytest.raises(FastlinesError) as caught:
            load(SAMPLES[name][:n], name)
        assert "\n" not in str(caught.value)


def test_trk_of_unknown_count_can_only_be_cut_between_streamlines(load):
    data = trk(promised=0)
    whole = {1000, 1000 + 40, 1000 + 40 + 16, 1000 + 40 + 16 + 28}
    for n in range(996, len(data)):
        if n in whole:
            load(data[:n], "a.trk")
        else:
            message_of(load, data[:n], "a.trk")


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
@pytest.mark.parametrize("name", few_of(SAMPLES, n=2))
def test_damaged_bytes_raise_nothing_else_and_allocate_little(load, name):
    rng = np.random.default_rng(2024)
    messages = []
    tracemalloc.start()
    try:
        for trial in range(250):
            data = bytearray(SAMPLES[name])
            for at in rng.integers(len(data), size=1 + trial % 3):
                data[at] = rng.integers(256) if trial % 2 else data[at] ^ 1 << rng.integers(8)
            try:
                lines = load(bytes(data), name, invalid=("error", "skip")[trial // 2 % 2])
            except FastlinesError as error:
                messages.append(str(error))
                continue
            assert lines.segments.shape[1:] == (2, 3)
            assert len(lines.segments) == len(lines.strands)
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()
    assert messages
    assert not any("\n" in message for message in messages)
