"""Streamlines of tractography, TrackVis ``.trk`` and MRtrix ``.tck``, read by nibabel (the extra ``tracts``).

Formats: http://trackvis.org/docs/?subsect=fileformat and
https://mrtrix.readthedocs.io/en/latest/getting_started/image_data.html#tracks-file-format-tck.

Coordinates are world coordinates in millimetres, axes to the Right, Anterior and Superior ("RASMM"); the
affine transform of a ``.trk`` header is applied. As nibabel does, a header without a transform is read as
the identity, one without a voxel order as LPS, and version 3 as version 2; nibabel's warnings about that
are not passed on.

nibabel believes a header's counts and stops early in silence if they are wrong, so they are checked here.
"""

from __future__ import annotations

import importlib
import re
import warnings
from io import BytesIO
from typing import Any, Literal

import numpy as np

from ..errors import MissingExtraError
from ..geometry import IntArray, Lines
from .source import BAD_COPY, Source, reason

#: The fields of the .trk header that are checked here; all others are nibabel's business.
_TRK_HEADER = np.dtype(
    {
        "names": ["magic", "voxel_size", "n_scalars", "n_properties", "n_streamlines", "header_size"],
        "formats": ["S6", ("<f4", 3), "<i2", "<i2", "<i4", "<i4"],
        "offsets": [0, 12, 36, 238, 988, 996],
        "itemsize": 1000,
    }
)


def parse_trk(source: Source, invalid: str) -> Lines:
    """Read a ``.trk`` file.

    Parameters
    ----------
    source : Source
        The file.
    invalid : {"error", "skip"}
        See `Lines.from_segments`.

    Returns
    -------
    Lines
        In RASMM. Scalars per point and properties per streamline become ``attributes`` by their names; a
        segment takes those of its first point and of its streamline.

    Raises
    ------
    FileFormatError
        If nibabel refuses the file, or if it holds less or more than its header promises.
    MissingExtraError
        If nibabel is not installed.
    """
    nibabel = _import_nibabel(".trk")
    counts = _count_trk(source)
    tractogram = _load(source, nibabel.TrkFile).tractogram

    attributes = {name: data.get_data() for name, data in tractogram.data_per_point.items()}
    for name, values in tractogram.data_per_streamline.items():
        free_name = f"{name} of streamline" if name in attributes else name
        attributes[free_name] = np.repeat(values, counts, axis=0)
    columns = {name.strip(): data[:, 0] if data.shape[1:] == (1,) else data for name, data in attributes.items()}
    return Lines.from_points(tractogram.streamlines.get_data(), counts, attributes=columns, invalid=invalid)


def parse_tck(source: Source, invalid: str) -> Lines:
    """Read a ``.tck`` file; parameters and errors as for `parse_trk`, without attributes."""
    nibabel = _import_nibabel(".tck")
    file = _load(source, nibabel.TckFile)
    start = int(file.header["file"].split()[1])
    header = re.search(rb"\n[ \t\r]*END[ \t\r]*\n", source.data)
    if header is None or start < header.end() or source.data[header.end() : start].strip(b"\0\r\n\t "):
        raise source.error(f"its data do not start at byte {start}, as its header says; {BAD_COPY}")

    # Count what there is: three NaN end each streamline, three Inf the file (nibabel has checked that).
    big_endian = file.header["datatype"].endswith("BE")
    triples = np.frombuffer(source.data, ">f4" if big_endian else "<f4", offset=start).reshape(-1, 3)
    ends = np.flatnonzero(np.isnan(triples).all(axis=1))
    counts = np.diff(np.append(-1, ends)) - 1
    promised = file.header.get("count", "").lstrip("0")
    if promised not in ("", str(len(counts)), str(np.count_nonzero(counts))):
        raise source.error(
            f"its header counts {promised[:20]!r} streamlines, but the file holds {len(counts)}; "
            "get a whole copy, or set the count to 0 to read what there is"
        )
    return Lines.from_points(file.streamlines.get_data(), counts, invalid=invalid)


def _import_nibabel(extension: str) -> Any:
    """Import nibabel's streamlines only now: it is optional and slow to import."""
    try:
        return importlib.import_module("nibabel.streamlines")
    except ImportError:
        raise MissingExtraError(f"reading {extension}", "tracts") from None


def _load(source: Source, reader: Any) -> Any:
    """Let nibabel read, and turn whatever it raises about a malformed file into one sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return reader.load(BytesIO(source.data))
    except Exception as error:  # nibabel's own kinds, and of numpy and struct whatever the bytes lead to
        raise source.error(f"nibabel can not read it ({reason(error)}); {BAD_COPY}") from None


def _count_trk(source: Source) -> IntArray:
    """Walk through a ``.trk`` file and count the points of each streamline, (k,)."""
    byte_order: Literal["<", ">"] = ">" if source.data[996:1000] == b"\0\0\x03\xe8" else "<"
    header = source.record("header fields", _TRK_HEADER.newbyteorder(byte_order))
    if header["magic"][:5] != b"TRACK" or header["header_size"] != 1000:
        raise source.error("does not start with a TrackVis header of 1000 bytes; check the extension")
    if min(header["n_scalars"], header["n_properties"], header["n_streamlines"]) < 0:
        raise source.error(
            f"announces {header['n_streamlines']} streamlines, {header['n_scalars']} scalars per point and "
            f"{header['n_properties']} properties; none can be negative; the header is damaged"
        )
    if not np.isfinite(header["voxel_size"]).all() or not np.all(header["voxel_size"]):
        raise source.error(
            f"its voxels have the size {header['voxel_size']}, which no transform can use; mend the header"
        )

    # A streamline is its number of points, the points with their scalars, its properties: words of 4 bytes.
    words = source.array("words", byte_order + "i4", ((len(source.data) - source.position) // 4,))
    per_point, per_streamline = 3 + header["n_scalars"], 1 + header["n_properties"]
    counts = []
    at = 0
    while at < len(words):
        counts.append(int(words[at]))
        at += per_streamline + counts[-1] * per_point
        if counts[-1] < 0 or at > len(words):
            raise source.error(
                f"streamline {len(counts) - 1} announces {counts[-1]} points, which are not there; {BAD_COPY}"
            )
    source.finish()
    if header["n_streamlines"] not in (0, len(counts)):
        raise source.error(
            f"its header counts {header['n_streamlines']} streamlines, but the file holds {len(counts)}; "
            "get a whole copy, or set the count to 0 to read what there is"
        )
    return np.array(counts, np.int64)
