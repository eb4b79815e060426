"""Cem Yuksel's HAIR files (``.hair``): strands of hair as polylines.

Format: http://www.cemyuksel.com/research/hairmodels, all numbers little-endian. After a header of 128 bytes come the
arrays whose bit is set, in this order: segments per strand, points, thickness, transparency, colours, and texture
coordinates (an extension by LuxCoreRender). A strand has one point more than segments.

The format defines neither units nor axes, nor the meaning of its *thickness*. It is read as the full width, so the
radius is half of it; an importer for Unreal and a converter from Alembic's widths do the same.
"""

from __future__ import annotations

import numpy as np

from ..lines import Lines
from .source import Source

_HEADER = np.dtype(
    [
        ("magic", "S4"),
        ("strands", "<u4"),
        ("points", "<u4"),
        ("bits", "<u4"),
        ("segments", "<u4"),  # per strand, without an array of them; the next three likewise per point
        ("thickness", "<f4"),
        ("transparency", "<f4"),
        ("color", "<f4", 3),
        ("info", "S88"),
    ]
)
_SEGMENTS, _POINTS, _THICKNESS, _TRANSPARENCY, _COLORS, _UV = (1 << bit for bit in range(6))
_ALL_BITS = _SEGMENTS | _POINTS | _THICKNESS | _TRANSPARENCY | _COLORS | _UV


def read(source: Source, invalid: str) -> Lines:
    """Read a ``.hair`` file.

    ``radius`` (n, 2) is half the thickness of the array, or else half the header's default; None if that is 0. Arrays
    per point become ``attributes`` of the segment that starts there: ``transparency`` (n,), ``color`` (n, 3) and ``uv``
    (n, 2), float32. The header's default colour and transparency are not kept.
    """
    header = source.record("header fields", _HEADER)
    if header["magic"].upper() != b"HAIR":
        raise source.error(f"starts with {header['magic']!r}, a .hair file with b'HAIR'; check the extension")
    bits, n_strands, n_points = header["bits"], header["strands"], header["points"]
    if bits & ~_ALL_BITS or not bits & _POINTS:
        raise source.error(
            f"announces the arrays {bits:#b}; expected 0b10 (points), and nothing above {_ALL_BITS:#b}; "
            "the header is damaged"
        )

    # Read the arrays in the order of the file. That proves the numbers of the header before they are used.
    segments = source.array("segment counts", "<u2", (n_strands,)) if bits & _SEGMENTS else None
    points = source.array("points", "<f4", (n_points, 3))
    thickness = source.array("thicknesses", "<f4", (n_points,)) if bits & _THICKNESS else None
    attributes = {
        name: source.array(name + " values", "<f4", (n_points, *per_point))
        for name, bit, per_point in (("transparency", _TRANSPARENCY, ()), ("color", _COLORS, (3,)), ("uv", _UV, (2,)))
        if bits & bit
    }
    source.finish()

    # Count the points of each strand; they must add up.
    if segments is None:
        n_counted = n_strands * (header["segments"] + 1)
    else:
        n_counted = n_strands + int(segments.sum(dtype=np.int64))
    if n_counted != n_points:
        raise source.error(
            f"by their segments, {n_strands} strands have {n_counted} points, but {n_points} are announced; "
            "the header is damaged"
        )
    counts = np.full(n_strands, header["segments"] if segments is None else segments, np.int64) + 1

    # Take the thickness per point, or the default for all; 0 means none.
    radius = None
    if thickness is not None:
        radius = source.radius("thickness", thickness) / 2
    elif header["thickness"] != 0:
        default = source.radius("default thickness", np.array([header["thickness"]])) / 2
        radius = np.repeat(default, n_points)
    return Lines.from_points(points, counts, radius=radius, attributes=attributes, invalid=invalid)
