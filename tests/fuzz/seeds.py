"""Small whole files to begin with: those of `tests/support`, and others of the same builders."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from support import line_files, vtk_files
from support.line_files import COUNTS, POINTS, SAMPLES
from support.text_files import TEXTS


def samples(*extensions: str) -> Callable[[], list[bytes]]:
    """Return the files of `tests/support` with these extensions."""
    known = {**SAMPLES, **TEXTS}
    return lambda: [data for name, data in known.items() if Path(name).suffix in extensions]


def hairs() -> list[bytes]:
    """Hair with and without each array."""
    return [line_files.hair(bits=bits) for bits in (3, 7, 11)]


def tracts() -> list[bytes]:
    """Streamlines of TrackVis in both byte orders, with and without what they may have."""
    return [line_files.trk(), line_files.trk(byte_order=">", n_scalars=2), line_files.trk(promised=0)]


def tracks() -> list[bytes]:
    """Streamlines of MRtrix of other types."""
    return [
        line_files.tck(head="datatype: Float64BE\n", dtype=">f8"),
        line_files.tck(head="count: 4\ndatatype: Float32LE\n"),
    ]


def arrays() -> list[bytes]:
    """NumPy arrays of several types and orders."""
    cube = POINTS[:6].reshape(3, 2, 3)
    return [line_files.npy(cube.astype(dtype)) for dtype in (">f8", "<i2", "?")] + [
        line_files.npy(np.asfortranarray(cube)),
        line_files.npy_of("'<f4'", "(0, 6)"),
    ]


def archives() -> list[bytes]:
    """Archives of arrays: strands and curves."""
    control = np.arange(24, dtype="<f4").reshape(2, 4, 3)
    return [
        line_files.npz(control=control, strands=[0, 0], radius=np.ones((2, 4), "<f4")),
        line_files.npz(points=POINTS, counts=COUNTS, fa=np.arange(7)),
    ]


def vtk_texts() -> list[bytes]:
    """Legacy files."""
    return [vtk_files.legacy(), vtk_files.legacy(binary=True), vtk_files.legacy(binary=True, version="5.1")]


def vtk_xmls() -> list[bytes]:
    """XML files: plain, encoded, appended, compressed."""
    return [
        vtk_files.xml(),
        vtk_files.xml(form="binary"),
        vtk_files.xml(form="appended", size_type="UInt64", order=">"),
        vtk_files.xml(form="binary", packer="vtkZLibDataCompressor"),
        vtk_files.xml(form="appended", packer="vtkLZMADataCompressor", raw=False),
    ]


def bundles() -> list[bytes]:
    """Archives of streamlines, one of them compressed."""
    return [
        line_files.trx(extra=line_files.TRX_EXTRA, method=zipfile.ZIP_DEFLATED),
        line_files.trx(points=POINTS.astype("<f2"), last_offset=False),
    ]


def geometries() -> list[bytes]:
    """Well-known binary of several types."""
    line = struct.pack("<BII6d", 1, 1002, 2, *range(6))
    return [
        struct.pack("<BII4d", 1, 2, 2, *range(4)),
        struct.pack(">BII8d", 0, 3002, 2, *range(8)),
        struct.pack("<BII", 1, 5, 2) + line * 2,
        struct.pack("<BIII", 1, 0x20000007, 4326, 3) + line + struct.pack("<BI2d", 1, 1, 0, 0) + line,
        struct.pack("<BIII6d", 1, 3, 1, 3, *range(6)),
    ]
