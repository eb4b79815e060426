"""Files of lines in every format, written by hand, byte by byte, and whatever we like in their headers."""

from __future__ import annotations

import gzip
import io
import struct

import numpy as np
import pytest

from fastlines.errors import FileFormatError

POINTS = np.arange(21, dtype="<f4").reshape(7, 3) ** 1.5
COUNTS = [3, 1, 2, 1]
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
            body += (next(points) + np.float32(0.5)).tobytes() + struct.pack(f"<{n_scalars}f", *range(n_scalars))
        body += struct.pack(f"<{n_properties}f", *[streamline] * n_properties)
    return bytes(header) + body + tail


def tck(*, counts: list[int] | None = None, count: str | None = None, start: int | None = None, gap: bytes = b""):
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
    "segments.npz": npz(segments=POINTS[:6].reshape(3, 2, 3), strands=[0, 0, 1], radius=np.ones(3), age=[1, 2, 3]),
    "points.npz": npz(points=POINTS, counts=COUNTS, radius=np.ones(7), compressed=True),
    "some.npy.gz": gzip.compress(npy(POINTS[:6].reshape(3, 2, 3)), mtime=0),
}
