"""AMD TressFX files (``.tfx``), versions 3 and 4: strands of hair, all with the same number of vertices.

Format: ``TressFXFileFormat.h`` of TressFX 3.0 and 4.x, all numbers little-endian. A header gives the numbers of strands
and of vertices per strand, and the byte at which each array starts; 0 means that there is none. The strands of a file
are the *guides*. A renderer places random "follow hairs" around them. No file holds these (AMD's files end with the
last guide), and none are made here.

Thickness is one number per strand, read as the full width: the radius is half of it.
"""

from __future__ import annotations

import numpy as np

from ...geometry.lines import Lines
from ..source import Source

_COUNTS = [("strands", "<u4"), ("vertices", "<u4")]
_HEADERS = {
    3.0: np.dtype(
        [
            *_COUNTS,
            ("follow_hairs", "<u4"),  # per guide, made by a renderer
            ("both_ends_fixed", "<i4"),  # for a simulation
            ("reserved", "<u4", 31),
            ("positions", "<u4"),
            ("thickness", "<u4"),
            ("strand_uv", "<u4"),
            ("color", "<u4"),
            ("guide", "<u4"),
            ("uv", "<u4"),
            ("reserved2", "<u4", 32),
        ]
    ),
    4.0: np.dtype(
        [
            *_COUNTS,
            ("positions", "<u4"),
            ("strand_uv", "<u4"),
            ("uv", "<u4"),
            ("thickness", "<u4"),
            ("color", "<u4"),
            ("reserved", "<u4", 32),
        ]
    ),
}
#: Numbers per position: x y z, and in version 4 the inverse mass.
_N_COORDINATES = {3.0: 3, 4.0: 4}


def read(source: Source, invalid: str) -> Lines:
    """Read the guides of a ``.tfx`` file of version 3 or 4.

    ``radius`` (n, 2) is half the thickness; None if the file has none. The other arrays become ``attributes``, float32:
    ``uv`` (n, 2), ``color`` (n, 4) and in version 4 ``inverse_mass`` (n,) of a segment's first vertex, and
    ``strand_uv`` (n, 2) of its strand. Version 3's guide indices, and bytes to which no offset points, are not read.
    """
    version = float(source.array("version numbers", "<f4", (1,))[0])
    if version not in _HEADERS:
        raise source.error(f"has TressFX version {version:g}; expected 3 or 4; convert it, or check the extension")
    header = source.record("header fields", _HEADERS[version])
    n_strands, n_vertices = header["strands"], header["vertices"]
    if n_strands and not n_vertices:
        raise source.error(f"announces {n_strands} strands of 0 vertices; the header is damaged")

    # Read the positions, which prove the counts, then the optional arrays per strand or per vertex.
    n_points = n_strands * n_vertices
    positions = source.array("positions", "<f4", (n_points, _N_COORDINATES[version]), at=header["positions"])
    attributes = {"inverse_mass": positions[:, 3]} if version == 4.0 else {}
    for name, n_rows, n_columns in (
        ("thickness", n_strands, 1),
        ("strand_uv", n_strands, 2),
        ("uv", n_points, 2),
        ("color", n_points, 4),
    ):
        if header[name]:
            values = source.array(name + " values", "<f4", (n_rows, n_columns), at=header[name])
            attributes[name] = values if n_rows == n_points else np.repeat(values, n_vertices, axis=0)

    radius = None
    if "thickness" in attributes:
        radius = source.radius("thickness", attributes.pop("thickness")[:, 0]) / 2
    counts = np.full(n_strands, n_vertices, np.int64)
    return Lines.from_points(
        positions[:, :3], counts, radius=radius, attributes=attributes, offset=source.offset, invalid=invalid
    )
