"""Files of lines in every format, written by hand, byte by byte, and whatever we like in their headers."""

from __future__ import annotations

import gzip
import io
import json
import struct
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import FileFormatError

#: Powers of float32 are not the same on each processor, but products and roots are.
POINTS = (np.arange(21) * np.sqrt(np.arange(21))).astype("<f4").reshape(7, 3)
COUNTS = [3, 1, 2, 1]
#: Metadata of lines with a voxel grid around these points, whose voxel millimetres are those of the world.
AROUND = {"grid": {"dimensions": [100] * 3, "voxel_to_rasmm": np.eye(4) + 0.5 * np.eye(4)[3] * [[1], [1], [1], [0]]}}
#: The first and last point of each segment of strands with these counts; a lone point joins itself.
FIRST, LAST = [0, 1, 3, 4, 6], [1, 2, 3, 5, 6]
STRANDS = [0, 0, 1, 2, 3]


def message_of(load, data: bytes, name: str, error: type[Exception] = FileFormatError) -> str:
    """Return the error that reading raises, having checked that it is one line that names the file."""
    with pytest.raises(error) as caught:
        load(data, name)
    text = str(caught.value)
    assert name in text
    assert "\n" not in text
    return text


def lost_by(path: Path, lines: fl.Lines) -> list[str]:
    """Write lines to a file, and return what the one warning lists as lost; nothing if there is no warning."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        fl.write(path, lines)
    assert len(told) < 2
    return str(told[0].message).partition("no place for it: ")[2].split("; ") if told else []


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
    names: tuple[bytes, ...] = (b"fa",),
    voxel_size: tuple[float, float, float] = (1, 1, 1),
    to_ras: np.ndarray = np.eye(4),  # noqa: B008
    order: bytes = b"RAS",
    version: int = 2,
    size: int = 1000,
    byte_order: str = "<",
    tail: bytes = b"",
) -> bytes:
    """Write a .trk of an image of 9 x 8 x 7 voxels, whose points are those of POINTS with no more than the defaults."""
    counts = COUNTS if counts is None else counts
    header = bytearray(1000)
    struct.pack_into(f"{byte_order}6s3h3f", header, 0, b"TRACK", 9, 8, 7, *voxel_size)
    name_format = byte_order + "h" + "20s" * len(names)
    struct.pack_into(name_format, header, 36, n_scalars, *names)
    struct.pack_into(name_format, header, 238, n_properties, *names)
    header[440:504] = np.asarray(to_ras).astype(byte_order + "f4").tobytes()
    header[948 : 948 + len(order)] = order
    promised = len(counts) if promised is None else promised
    struct.pack_into(byte_order + "3i", header, 988, promised, version, size)
    body = b""
    points = iter(POINTS)
    for streamline, count in enumerate(counts):
        body += struct.pack(byte_order + "i", count)
        for _ in range(count):
            row = [*(next(points) + np.float32(0.5)), *range(n_scalars)]
            body += struct.pack(f"{byte_order}{len(row)}f", *row)
        body += struct.pack(f"{byte_order}{n_properties}f", *[streamline] * n_properties)
    return bytes(header) + body + tail


def tck(
    *,
    counts: list[int] | None = None,
    head: str | None = None,
    dtype: str = "<f4",
    file: str | None = None,
    end: str = "END\n",
    gap: bytes = b"",
    marks: tuple[str, ...] = ("last nan", "inf"),
    tail: bytes = b"",
) -> bytes:
    """Write a .tck; `head` are its lines, `file` what it says of where its data start, `marks` how they end."""
    counts = COUNTS if counts is None else counts
    rows: list[np.ndarray] = []
    points = iter(POINTS)
    for n in counts:
        rows += [next(points) for _ in range(n)] + [np.full(3, np.nan)]
    rows = rows if "last nan" in marks else rows[:-1]
    rows += [np.full(3, np.inf)] * ("inf" in marks)
    head = f"count: {len(counts)}\ndatatype: Float32LE\n" if head is None else head
    head = f"mrtrix tracks\n{head}"
    place = "file: . {:03}\n" if file is None else file
    start = len((head + place.format(0) + end).encode()) + len(gap)
    return (head + place.format(start) + end).encode() + gap + np.array(rows, dtype).tobytes() + tail


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


def counted(counts: list[int], points: np.ndarray = POINTS) -> bytes:
    """Write strands, each as its count and its points; a count below 0 marks a strand."""
    body, at = b"", 0
    for count in counts:
        body += struct.pack("<i", count) + points[at : at + abs(count)].astype("<f4").tobytes()
        at += abs(count)
    return body


def usc(*, counts: list[int] | None = None, promised: int | None = None, tail: bytes = b"") -> bytes:
    counts = COUNTS if counts is None else counts
    return struct.pack("<i", len(counts) if promised is None else promised) + counted(counts) + tail


def bcc(
    *,
    counts: list[int] | None = None,
    promised: int | None = None,
    n_points: int | None = None,
    magic: bytes = b"BCC\x44",
    kind: bytes = b"C0",
    dimensions: int = 3,
    up: int = 1,
    points: np.ndarray = POINTS,
    tail: bytes = b"",
) -> bytes:
    counts = [4, -3] if counts is None else counts
    promised = len(counts) if promised is None else promised
    n_points = sum(map(abs, counts)) if n_points is None else n_points
    header = struct.pack("<4s2sBBQQ40s", magic, kind, dimensions, up, promised, n_points, b"test")
    return header + counted(counts, points) + tail


PLY_HEADER = """ply
format {format} 1.0
comment by hand
element vertex {vertices}
property float x
property float y
property float z
property float radius
property uchar red
property float uv_0
property float uv_1
element {other} {others}
property uchar flags
property list uchar int vertex_indices
element edge {edges}
property int vertex1
property int vertex2
property short age
end_header
"""


def ply(
    order: str = "<",
    *,
    edges: tuple[tuple[int, int], ...] = ((0, 1), (1, 2), (3, 4), (5, 6)),
    others: tuple[tuple[int, ...], ...] = ((0, 1, 2), (0, 1, 2, 3)),
    other: str = "patch",
    promised: int | None = None,
    header: str = PLY_HEADER,
    tail: bytes = b"",
) -> bytes:
    """Write POINTS as vertices, an element with lists, and edges; `order` is a byte order, or none for text."""
    kind = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    promised = len(edges) if promised is None else promised
    data = header.format(format=kind, vertices=7, other=other, others=len(others), edges=promised).encode()
    rows: list[tuple[str, tuple[float, ...]]] = [
        ("4fB2f", (*map(float, point), i / 2, 200 + i, i, i / 4)) for i, point in enumerate(POINTS)
    ]
    rows += [(f"BB{len(row)}i", (9, len(row), *row)) for row in others]
    rows += [("2ih", (*edge, -i)) for i, edge in enumerate(edges)]
    for form, row in rows:
        data += struct.pack(order + form, *row) if order else " ".join(map(str, row)).encode() + b"\n"
    return data + tail


def safetensors(
    metadata: dict[str, str] | None = None, *, header: bytes | None = None, tail: bytes = b"", **arrays
) -> bytes:
    """Write a .safetensors file; `header` is what its header says instead of the truth."""
    names = {"i8": "I64", "f4": "F32", "f8": "F64", "u1": "U8", "i4": "I32", "f2": "F16"}
    entries, body = {} if metadata is None else {"__metadata__": metadata}, b""
    for name, given in arrays.items():
        data = np.asarray(given).tobytes()
        offsets = [len(body), len(body) + len(data)]
        kind = names[np.asarray(given).dtype.str[1:]]
        entries[name] = {"dtype": kind, "shape": np.shape(given), "data_offsets": offsets}
        body += data
    text = json.dumps(entries).encode() if header is None else header
    return struct.pack("<Q", len(text)) + text + body + tail


def trx(
    *,
    counts: list[int] | None = None,
    points: np.ndarray = POINTS,
    last_offset: bool = True,
    header: str | None = None,
    extra: dict[str, bytes] | None = None,
    method: int = zipfile.ZIP_STORED,
    without: str = "",
) -> bytes:
    counts = COUNTS if counts is None else counts
    offsets = np.cumsum([0, *counts])[: None if last_offset else -1]
    if header is None:
        header = json.dumps({"NB_STREAMLINES": len(counts), "NB_VERTICES": len(points)})
    members = {
        "header.json": header.encode(),
        f"positions.3.{points.dtype.name}": points.tobytes(),
        "offsets.uint32": offsets.astype("<u4").tobytes(),
        **(extra or {}),
    }
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, data in members.items():
            if not (without and name.startswith(without)):
                archive.writestr(zipfile.ZipInfo(name), data, method)
    return stream.getvalue()


#: Members of a .trx beside those that it must have.
TRX_EXTRA = {
    "dpv/fa.float32": np.arange(7, dtype="<f4").tobytes(),
    "dps/colour.3.uint8": bytes(range(12)),
    "groups/left.uint32": np.array([0, 3], "<u4").tobytes(),
}


#: One small, whole file per format, with everything optional in it.
SAMPLES: dict[str, bytes] = {
    "full.hair": hair(bits=63),
    "default.hair": hair(bits=2, strands=1, segments=6, thickness=0.5),
    "v3.tfx": tfx(3, optional=("thickness", "strand_uv", "uv", "color")),
    "v4.tfx": tfx(4, optional=("thickness", "strand_uv", "uv", "color")),
    "some.trk": trk(n_scalars=1, n_properties=1),
    "some.tck": tck(),
    "some.data": usc(),
    "some.bcc": bcc(kind=b"PL"),
    "little.ply": ply("<"),
    "big.ply": ply(">", others=((0, 1, 2), (3, 4, 5))),
    "some.trx": trx(extra=TRX_EXTRA),
    "some.npy": npy(POINTS[:6].reshape(3, 6)),
    "segments.npz": npz(segments=POINTS[:6].reshape(3, 2, 3), strands=[0, 0, 1], radius=np.ones(3), age=[1, 2, 3]),
    "points.npz": npz(points=POINTS, counts=COUNTS, radius=np.ones(7), compressed=True),
    "segments.safetensors": safetensors(
        {"unit": "mm", "up": "z"},
        segments=POINTS[:6].reshape(3, 2, 3),
        strands=[0, 0, 1],
        radius=np.ones(3, "<f4"),
        **{"end_attributes/age": np.arange(6).reshape(3, 2)},
    ),
    "some.npy.gz": gzip.compress(npy(POINTS[:6].reshape(3, 2, 3)), mtime=0),
}
