"""Readers: every format and combination from hand-written bytes, then files that lie or are damaged."""

from __future__ import annotations

import doctest
import gzip
import io
import itertools
import re
import struct
import sys
import tracemalloc
import warnings
import zipfile
from collections.abc import Callable
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import fastlines.io
from fastlines.errors import FastlinesError, FileFormatError, InputError, MissingExtraError
from fastlines.io import FORMATS, read

nibabel_data = resources.files(pytest.importorskip("nibabel")) / "tests" / "data"

POINTS = np.arange(21, dtype="<f4").reshape(7, 3) ** 1.5
COUNTS = [3, 1, 2, 1]
#: The first and last point of each segment of strands with these counts; a lone point joins itself.
FIRST, LAST = [0, 1, 3, 4, 6], [1, 2, 3, 5, 6]
STRANDS = [0, 0, 1, 2, 3]


@pytest.fixture
def load(tmp_path: Path) -> Callable[..., fastlines.io.Lines]:
    """Write bytes to a file and read it."""

    def write_and_read(data: bytes, name: str, **options):
        path = tmp_path / name
        path.write_bytes(data)
        return read(path, **options)

    return write_and_read


def message_of(load, data: bytes, name: str, error: type[Exception] = FileFormatError) -> str:
    """Return the error that reading raises, having checked that it is one line that names the file."""
    with pytest.raises(error) as caught:
        load(data, name)
    text = str(caught.value)
    assert name in text
    assert "\n" not in text
    return text


# --- Writers ---


def hair(
    *,
    bits: int = 3,
    strands: int = 4,
    n_points: int = 7,
    segments: int = 0,
    thickness: float = 0.0,
    magic: bytes = b"HAIR",
    points: np.ndarray = POINTS,
    body: bytes | None = None,
) -> bytes:
    header = struct.pack(
        "<4s4I5f88s", magic, strands, n_points, bits, segments, thickness, 0.5, 1.0, 0.5, 0.25, b"test"
    )
    arrays = [
        np.subtract(COUNTS, 1).astype("<u2"),
        points.astype("<f4"),
        np.arange(7, dtype="<f4"),
        np.linspace(0, 1, 7).astype("<f4"),
        np.arange(21, dtype="<f4") / 21,
        np.arange(14, dtype="<f4") / 14,
    ]
    if body is None:
        body = b"".join(array.tobytes() for bit, array in enumerate(arrays) if bits >> bit & 1)
    return header + body


def tfx(
    version: float,
    *,
    strands: int = 2,
    vertices: int = 3,
    points: np.ndarray = POINTS[:6],
    optional: tuple[str, ...] = (),
    gap: int = 0,
    tail: bytes = b"",
    **offsets: int,
) -> bytes:
    size = 160 if version == 4 else 296
    position = np.hstack([points, np.arange(6)[:, None]]) if version == 4 else points
    optional_arrays = {
        "thickness": np.array([0.5, 2.0]),
        "strand_uv": np.arange(4) / 4,
        "uv": np.arange(12) / 12,
        "color": np.arange(24) / 24,
    }
    body = bytes(gap)
    at = {}
    for name, array in {"positions": position, **{name: optional_arrays[name] for name in optional}}.items():
        at[name] = size + len(body)
        body += array.astype("<f4").tobytes()
    at = {name: offsets.get(name, at.get(name, 0)) for name in ("positions", *optional_arrays)}
    if version == 4:
        order = [at[name] for name in ("positions", "strand_uv", "uv", "thickness", "color")]
        header = struct.pack("<f7I128x", version, strands, vertices, *order)
    else:
        order = [at[name] for name in ("positions", "thickness", "strand_uv", "color")]
        header = struct.pack("<f3Ii124x", version, strands, vertices, 9, 1)
        header += struct.pack("<6I128x", *order, 0, at["uv"])
    assert len(header) == size
    return header + body + tail


def trk(
    *,
    counts: list[int] | None = None,
    promised: int | None = None,
    n_scalars: int = 0,
    n_properties: int = 0,
    voxel_size: tuple[float, float, float] = (1, 1, 1),
    tail: bytes = b"",
) -> bytes:
    counts = COUNTS if counts is None else counts
    header = bytearray(1000)
    struct.pack_into("<6s3h3f", header, 0, b"TRACK", 9, 9, 9, *voxel_size)
    struct.pack_into("<h20s", header, 36, n_scalars, b"fa")
    struct.pack_into("<h20s", header, 238, n_properties, b"fa")
    struct.pack_into("<16f", header, 440, *np.eye(4, dtype="f4").ravel())
    header[948:951] = b"RAS"
    struct.pack_into("<3i", header, 988, len(counts) if promised is None else promised, 2, 1000)
    body = b""
    points = iter(POINTS)
    for streamline, count in enumerate(counts):
        body += struct.pack("<i", count)
        for _ in range(count):
            body += (next(points) + np.float32(0.5)).tobytes() + struct.pack(
                f"<{n_scalars}f", *range(n_scalars)
            )
        body += struct.pack(f"<{n_properties}f", *[streamline] * n_properties)
    return bytes(header) + body + tail


def tck(
    *, counts: list[int] | None = None, count: str | None = None, start: int | None = None, gap: bytes = b""
):
    counts = COUNTS if counts is None else counts
    body = b""
    points = iter(POINTS)
    for n in counts:
        body += b"".join(next(points).tobytes() for _ in range(n)) + struct.pack("<3f", *[np.nan] * 3)
    body += struct.pack("<3f", *[np.inf] * 3)
    count = str(len(counts)) if count is None else count
    header = f"mrtrix tracks\ncount: {count}\ndatatype: Float32LE\nfile: . "
    start = len(header) + len("123\nEND\n") + len(gap) if start is None else start
    return f"{header}{start:03}\nEND\n".encode() + gap + body


def npy(array, **options) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.asarray(array), **options)
    return stream.getvalue()


def npy_of(descr: str, shape: str, body: bytes = b"", *, in_columns: bool = False) -> bytes:
    """Write a .npy file whose header says whatever we like."""
    header = f"{{'descr': {descr}, 'fortran_order': {in_columns}, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + body


def npz(*, compressed: bool = False, **arrays) -> bytes:
    stream = io.BytesIO()
    (np.savez_compressed if compressed else np.savez)(stream, **arrays)
    return stream.getvalue()


#: One small, whole file per format, with everything optional in it.
SAMPLES: dict[str, bytes] = {
    "full.hair": hair(bits=63),
    "default.hair": hair(bits=2, strands=1, segments=6, thickness=0.5),
    "v3.tfx": tfx(3, optional=("thickness", "strand_uv", "uv", "color")),
    "v4.tfx": tfx(4, optional=("thickness", "strand_uv", "uv", "color")),
    "some.trk": trk(n_scalars=1, n_properties=1),
    "some.tck": tck(),
    "some.npy": npy(POINTS[:6].reshape(3, 6)),
    "segments.npz": npz(
        segments=POINTS[:6].reshape(3, 2, 3), strands=[0, 0, 1], radius=np.ones(3), age=[1, 2, 3]
    ),
    "points.npz": npz(points=POINTS, counts=COUNTS, radius=np.ones(7), compressed=True),
    "some.npy.gz": gzip.compress(npy(POINTS[:6].reshape(3, 2, 3)), mtime=0),
}


# --- What each format means ---


@pytest.mark.parametrize("bits", [bits for bits in range(64) if bits & 2])
def test_hair_with_every_combination_of_arrays(load, bits):
    if bits & 1:
        lines = load(hair(bits=bits, thickness=0.5), "a.hair")
        first, last, strands = FIRST, LAST, STRANDS
    else:
        lines = load(hair(bits=bits, strands=1, segments=6, thickness=0.5), "a.hair")
        first, last, strands = range(6), range(1, 7), [0] * 6
    ends = np.stack([first, last], axis=1)
    assert lines.segments.dtype == np.float32
    np.testing.assert_array_equal(lines.segments, POINTS[ends])
    np.testing.assert_array_equal(lines.strands, strands)
    np.testing.assert_array_equal(lines.radius, ends / 2 if bits & 4 else np.full(ends.shape, 0.25))
    expected = {"transparency": bits & 8, "color": bits & 16, "uv": bits & 32}
    assert set(lines.attributes) == {name for name, there in expected.items() if there}
    if bits & 8:
        np.testing.assert_allclose(lines.attributes["transparency"], np.linspace(0, 1, 7)[first], rtol=1e-6)
    if bits & 16:
        np.testing.assert_allclose(
            lines.attributes["color"], np.arange(21).reshape(7, 3)[first] / 21, rtol=1e-6
        )
    if bits & 32:
        np.testing.assert_allclose(lines.attributes["uv"], np.arange(14).reshape(7, 2)[first] / 14, rtol=1e-6)


def test_hair_of_default_thickness_zero_has_no_radius(load):
    assert load(hair(thickness=0.0), "a.hair").radius is None


@pytest.mark.parametrize("version", [3, 4])
@pytest.mark.parametrize("gap", [0, 24])
@pytest.mark.parametrize(
    "optional",
    [
        names
        for n in range(5)
        for names in itertools.combinations(("thickness", "strand_uv", "uv", "color"), n)
    ],
)
def test_tfx_with_every_combination_of_arrays(load, version, gap, optional):
    lines = load(tfx(version, optional=optional, gap=gap), "a.tfx")
    first = np.array([0, 1, 3, 4])
    np.testing.assert_array_equal(lines.segments, POINTS[np.stack([first, first + 1], axis=1)])
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 1])
    if "thickness" in optional:
        np.testing.assert_array_equal(lines.radius, [[0.25] * 2, [0.25] * 2, [1] * 2, [1] * 2])
    else:
        assert lines.radius is None
    expected = {
        "strand_uv": np.arange(4).reshape(2, 2)[[0, 0, 1, 1]] / 4,
        "uv": np.arange(12).reshape(6, 2)[first] / 12,
        "color": np.arange(24).reshape(6, 4)[first] / 24,
        "inverse_mass": first,
    }
    assert set(lines.attributes) == {*optional, *["inverse_mass"] * (version == 4)} - {"thickness"}
    for name, values in lines.attributes.items():
        np.testing.assert_allclose(values, expected[name], rtol=1e-6)


def test_tfx_makes_up_no_follow_hairs_and_ignores_what_no_offset_points_to(load):
    lines = load(tfx(3, tail=b"what follows"), "a.tfx")
    assert (lines.n_strands, len(lines)) == (2, 4)


def test_strand_of_one_vertex_is_a_segment_of_zero_length(load):
    lines = load(tfx(3, strands=6, vertices=1, optional=("uv",)), "a.tfx")
    np.testing.assert_array_equal(lines.segments, np.stack([POINTS[:6]] * 2, axis=1))


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


EMPTY = {
    "a.hair": hair(strands=0, n_points=0, body=b""),
    "v3.tfx": tfx(3, strands=0, vertices=3, points=POINTS[:0]),
    "a.trk": trk(counts=[]),
    "a.tck": tck(counts=[]),
    "a.npy": npy(np.empty((0, 2, 3))),
    "a.npz": npz(points=np.empty((0, 3)), counts=np.empty(0, int)),
    "b.npz": npz(segments=np.empty((0, 6))),
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
        expected = np.concatenate(
            [np.stack([line[:-1], line[1:]], axis=1) for line in streamlines if len(line) > 1]
        )
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
    ("a.tfx", tfx(4, positions=0), "positions .* lie over version numbers"),
    ("a.tfx", tfx(3, positions=290), "positions .* lie over header fields"),
    ("a.tfx", tfx(4, positions=HUGE), "positions .* do not fit"),
    ("a.tfx", tfx(3, positions=300), "positions .* do not fit"),
    ("a.tfx", tfx(4, thickness=8), "thickness values .* lie over header"),
    ("a.tfx", tfx(4, thickness=170), "thickness values .* lie over positions"),
    ("a.tfx", tfx(4, color=HUGE), "color values .* do not fit"),
    ("a.tfx", tfx(3, uv=300), "uv values .* lie over|do not fit"),
    ("a.trk", b"TRACK", "header fields .* do not fit"),
    ("a.trk", bytes(1000), "does not start with a TrackVis header"),
    ("a.trk", b"KCART" + trk()[5:], "does not start with a TrackVis header"),
    ("a.trk", trk(promised=100), "counts 100 streamlines, but the file holds 4"),
    ("a.trk", trk(promised=2), "counts 2 streamlines, but the file holds 4"),
    ("a.trk", trk(promised=-1), "-1 streamlines.* none can be negative"),
    ("a.trk", trk(tail=b"\0\0"), "2 bytes are left over"),
    ("a.trk", trk(tail=struct.pack("<i", -3)), "announces -3 points"),
    ("a.trk", trk(tail=struct.pack("<i", 2**31 - 1)), "streamline 4 announces 2147483647 points"),
    ("a.trk", trk(tail=b"\0" * 4), "counts 4 streamlines, but the file holds 5"),
    ("a.trk", trk()[:36] + b"\xfe\xff" + trk()[38:], "-2 scalars"),
    ("a.trk", trk()[:36] + b"\xff\x7f" + trk()[38:], "streamline 0 announces 3 points"),
    ("a.trk", trk()[:238] + b"\xff\xff" + trk()[240:], "-1 properties"),
    ("a.trk", trk(voxel_size=(1, 0, 1)), "voxels have the size"),
    ("a.trk", trk(voxel_size=(1, np.nan, 1)), "voxels have the size"),
    ("a.trk", trk()[:992] + b"\x09" + trk()[993:], "nibabel can not read it"),
    ("a.trk", trk()[:440] + bytes(48) + trk()[488:], "nibabel can not read it .*affine is invalid"),
    ("a.tck", tck(count="5"), "counts '5' streamlines, but the file holds 4"),
    ("a.tck", tck(count="9" * 500), "counts '9{20}' streamlines, but the file holds 4"),
    ("a.tck", tck(count="many"), "counts 'many' streamlines"),
    ("a.tck", tck(start=len(tck()) - 12 * 7), "its data do not start at byte"),
    ("a.tck", tck(start=7), "nibabel can not read|data do not start"),
    ("a.tck", tck(start=999), "nibabel can not read"),
    ("a.tck", tck(start=-1), "nibabel can not read"),
    ("a.tck", tck().replace(b"32LE", b"64LE"), "nibabel can not read it .*float32"),
    ("a.npy", b"\x93NUMPX" + bytes(100), "does not start with the header of an array"),
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
    ("a.npy", b"\x93NUMPY\x03\x00" + npy_of("'<f4'", "(0, 6)")[8:], "format version"),
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
    ("a.npz", b"PK" + bytes(100), "not a whole .npz file"),
    ("a.npy.gz", b"not packed", "not a whole gzip file"),
    ("a.npy.gz", gzip.compress(b""), "is empty once unpacked"),
    ("a.npy.gz", gzip.compress(bytes(40_000_000)), "unpacks to more than .* gunzip"),
]


@pytest.mark.parametrize(
    ("name", "data", "said"), LIES, ids=[f"{i}-{lie[2][:30]}" for i, lie in enumerate(LIES)]
)
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


def test_zip_that_is_no_npz_or_a_bomb(load):
    for method, size, said in [
        (zipfile.ZIP_BZIP2, 10, "is not an array"),
        (zipfile.ZIP_DEFLATED, 60_000_000, "unpacks to more than"),
    ]:
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", method) as archive:
            archive.writestr("segments.npy", bytes(size))
        assert said in message_of(load, stream.getvalue(), "a.npz")
    with zipfile.ZipFile(stream := io.BytesIO(), "w") as archive:
        archive.writestr("notes.txt", "segments")
    assert "'notes.txt' in it is not an array" in message_of(load, stream.getvalue(), "a.npz")


def test_paths_that_are_no_file(tmp_path, load):
    with pytest.raises(InputError, match=r"gone\.hair: no such file"):
        read(tmp_path / "gone.hair")
    (tmp_path / "folder.hair").mkdir()
    with pytest.raises(InputError, match="is a directory; expected a regular file"):
        read(str(tmp_path / "folder.hair"))
    with pytest.raises(InputError, match=r"can not be read|no such file"):
        read("nul\0.hair")
    with pytest.raises(InputError, match="can not be read"):
        read("x" * 5000 + ".hair")
    with pytest.raises(InputError, match="path is a int"):
        read(5)
    with pytest.raises(InputError, match="invalid='drop' is not a choice"):
        read(tmp_path / "gone.hair", invalid="drop")
    for name in FORMATS:
        assert "is empty" in message_of(load, b"", "a" + name)


@pytest.mark.parametrize("name", ["a.obj", "a", "a.gz", ".hair", "a.hair.bz2"])
def test_unknown_extension_lists_the_known_ones(load, name):
    text = message_of(load, b"HAIR", name)
    assert "unknown extension" in text
    assert all(extension in text for extension in FORMATS)


# --- Cut short and damaged ---


def shorter(data: bytes) -> set[int]:
    """Lengths to cut at: each, but for the text and padding of long headers only some."""
    return {n for n in range(len(data)) if len(data) < 800 or n % 7 == 0 or n > len(data) - 150}


@pytest.mark.parametrize("name", SAMPLES)
def test_file_cut_short_anywhere(load, name):
    for n in shorter(SAMPLES[name]):
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


@pytest.mark.parametrize("name", SAMPLES)
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


def test_examples_in_docstrings():
    assert doctest.testmod(fastlines.io).failed == 0
