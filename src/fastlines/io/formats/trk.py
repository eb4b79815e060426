"""TrackVis files (``.trk``): streamlines in the voxels of an image, with the image's place in the world.

Format: http://trackvis.org/docs/?subsect=fileformat, versions 1 to 3 in either byte order.

Points are stored in the *voxel millimetres* of `geometry/voxel_grid.py`, and are read in RASMM. Without a transform in
the header, they stay in voxel millimetres, with a warning.

Lines keep the grid of their file, and what else its header says of the orientation of the image, in the metadata
``grid``. Files are written with this grid, or that of ``reference=``, or else one that holds the lines.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...arrays import FLOAT64_ADVICE, AnyArray, FloatArray, IntArray, warn_of_rounding
from ...errors import InputError
from ...geometry.lines import Lines
from ...geometry.offsets import NO_OFFSET
from ...geometry.voxel_grid import DEFAULT_ORDER, GRID, VoxelGrid, inverse, is_order, transform
from ..grid_reference import grid_to_write
from ..losses import conventions, keeps_values, strand_numbers
from ..polylines import polylines_of
from ..segment_collector import NO_STRANDS, Strands, lines_of, offset_for
from ..source import BAD_COPY, Source
from .streamlines import UNIT, UP, split_values
from .trk_streamlines import Streamlines

HEADER_SIZE = 1000
#: The largest count of streamlines that the header holds; more are written as 0, which is unknown.
MOST_COUNTED = 2**31 - 1
_HEADER = np.dtype(
    {
        "names": [
            "magic", "dimensions", "voxel_size", "n_scalars", "scalar_names", "n_properties", "property_names",
            "vox_to_ras", "voxel_order", "storage_order", "image_orientation", "flips", "n_streamlines", "version",
            "header_size",
        ],
        "formats": [
            "S6", ("<i2", 3), ("<f4", 3), "<i2", ("S20", 10), "<i2", ("S20", 10),
            ("<f4", (4, 4)), "S4", "S4", ("<f4", 6), ("u1", 6), "<i4", "<i4", "<i4",
        ],
        "offsets": [0, 6, 12, 36, 38, 238, 240, 440, 948, 952, 956, 982, 988, 992, 996],
        "itemsize": HEADER_SIZE,
    }
)  # fmt: skip

#: What TrackVis keeps of the orientation of the image, beside the transform.
_ORIENTATION = ("storage_order", "image_orientation", "flips")
#: The most names of scalars, and of properties, and the bytes of each.
_MAX_NAMES, _NAME_SIZE = 10, 20


def read(source: Source, invalid: str) -> Lines:
    """Read a ``.trk`` file, in RASMM, or in voxel millimetres if the header has no transform.

    Scalars per point and properties per streamline become ``attributes`` by their names, float32. A segment has those
    of its first point and of its streamline.
    """
    return next(read_chunks(source, None, invalid))


def read_chunks(source: Source, max_segments: int | None, invalid: str) -> Iterator[Lines]:
    """Read a ``.trk`` file in chunks."""
    header, byte_order = _read_header(source)
    if min(header["n_scalars"], header["n_properties"]) < 0:
        raise source.error(
            f"announces {header['n_scalars']} scalars per point and {header['n_properties']} properties; "
            "neither can be negative; fix the header"
        )
    grid = _grid(source, header)
    matrix = grid.to_rasmm()
    n_scalars, n_properties = header["n_scalars"], header["n_properties"]
    streamlines = Streamlines(source, HEADER_SIZE, byte_order, 3 + n_scalars, n_properties)

    def strands(rows: FloatArray, properties: FloatArray, counts: IntArray) -> Strands:
        scalars = _columns(header["scalar_names"], rows[:, 3:], "scalars")
        per_strand = _columns(header["property_names"], properties, "properties")
        return Strands(transform(matrix, rows[:, :3]), counts, scalars, per_strand)

    def parts() -> Iterator[Strands]:
        yield from (strands(*part) for part in streamlines)
        _check(source, header["n_streamlines"], streamlines)

    like = strands(np.empty((0, 3 + n_scalars), np.float32), np.empty((0, n_properties), np.float32), NO_STRANDS)
    offset = offset_for(source.offset, (strands(*part).points for part in streamlines))
    n_points = source.size // (4 * (3 + n_scalars))
    orientation = {name: header[name] for name in _ORIENTATION if any(header[name])}
    if "storage_order" in orientation:
        orientation["storage_order"] = header["storage_order"].decode("latin-1")
    metadata = {GRID: grid.to_metadata() | orientation} if grid.is_usable else {}
    yield from lines_of(parts(), like, n_points, offset, metadata, max_segments, invalid)


def read_grid(source: Source) -> VoxelGrid:
    """Read the voxel grid alone."""
    return _grid(source, _read_header(source)[0])


def write(lines: Lines, path: Path, *, reference: Any = None) -> list[str]:
    """Write a ``.trk`` file of version 2, in RASMM.

    Attributes become scalars or properties in float32: 10 of each, with names of up to 20 bytes.

    Parameters
    ----------
    reference : object or path, optional
        Whose voxel grid is written: an image of nibabel, lines of a ``.trk`` or ``.trx``, a header, or a file of one of
        these. By default, it is the grid of the file that the lines come from, or else one that holds them.
    """
    parts = polylines_of(lines)
    per_point, per_strand, lost = split_values(parts)
    scalars, scalar_names = _named_columns(per_point, len(parts.points), "scalars per point", lost)
    properties, property_names = _named_columns(per_strand, len(parts.counts), "properties of a streamline", lost)
    header = np.zeros(1, _HEADER)[0]
    header["magic"], header["version"], header["header_size"] = b"TRACK", 2, HEADER_SIZE
    grid, said = grid_to_write(lines, parts.points, reference)
    if grid.dimensions.max() > np.iinfo(np.int16).max:
        raise InputError(f"the voxel grid has {grid.dimensions} voxels; .trk counts up to {np.iinfo(np.int16).max}")
    header["dimensions"], header["voxel_size"] = grid.dimensions, grid.voxel_sizes
    header["voxel_order"] = grid.voxel_order.encode()
    if grid.voxel_to_rasmm is not None:
        header["vox_to_ras"] = grid.voxel_to_rasmm
        # Use the numbers of the header, which are rounded.
        to_ras, sizes = np.array(header["vox_to_ras"], np.float64), np.array(header["voxel_size"], np.float64)
        grid = replace(grid, voxel_to_rasmm=to_ras, voxel_sizes=sizes)
    for name, value in lines.metadata.get(GRID, {}).items() if reference is None else ():
        if name in _ORIENTATION:
            try:
                header[name] = value.encode("latin-1", "replace") if isinstance(value, str) else value
            except (TypeError, ValueError, OverflowError):
                raise InputError(f"the metadata {GRID!r}: its {name} is {value!r}, which a .trk cannot hold") from None
    points = transform(inverse(grid.to_rasmm()), parts.points)
    if lines.offset != NO_OFFSET:
        warn_of_rounding(points, points.astype(np.float32), FLOAT64_ADVICE)
    header["n_scalars"], header["n_properties"] = scalars.shape[1], properties.shape[1]
    header["scalar_names"][: len(scalar_names)] = scalar_names
    header["property_names"][: len(property_names)] = property_names
    n = len(parts.counts)
    header["n_streamlines"] = n if n <= MOST_COUNTED else 0

    # Mix counts, points with their scalars, and properties.
    per_point_words = 3 + scalars.shape[1]
    size = 1 + parts.counts * per_point_words + properties.shape[1]
    first = np.cumsum(size) - size
    is_point = np.ones(int(size.sum()), np.bool_)
    is_point[first] = False
    where = (first + 1 + parts.counts * per_point_words)[:, None] + np.arange(properties.shape[1])
    is_point[where] = False
    numbers = np.empty(len(is_point), "<f4")
    numbers[is_point] = np.hstack([points, scalars]).reshape(-1)
    numbers[where] = properties
    numbers.view("<i4")[first] = parts.counts
    with path.open("wb") as file:
        file.write(header.tobytes())
        file.write(numbers.data)
    return said + lost + strand_numbers(parts.strand) + conventions(lines, UNIT, UP)


def _check(source: Source, promised: int, streamlines: Streamlines) -> None:
    """Check by the bytes left over and the header's count, where 0 is none, that the file is whole."""
    n_found, left = streamlines.n_found, streamlines.left
    if left and not 0 < promised == n_found:
        count = streamlines.announced
        if count is None:
            raise source.error(f"its last {len(left)} bytes are not a whole streamline; {BAD_COPY}")
        raise source.error(f"streamline {n_found} announces {count} points, which are not there; {BAD_COPY}")
    if left:
        source.warn(f"{len(left)} bytes after the last of its {promised} streamlines are not read")
    elif promised > n_found:
        raise source.error(
            f"its header counts {promised} streamlines, but the file holds {n_found}; "
            "get a whole copy, or set the count to 0 to read them"
        )
    elif promised not in (0, n_found):
        source.warn(f"its header counts {promised} streamlines, but the file holds {n_found}; all are read")


def _columns(names: Sequence[bytes], values: FloatArray, rest: str) -> dict[str, FloatArray]:
    """Name the columns of an array: a name has one, or N if NUL and N follow it; `rest` names those left over."""
    columns: dict[str, FloatArray] = {}
    at = 0
    for raw in (*names, rest.encode() + b"\0%d" % values.shape[1]):
        text, _, number = raw.partition(b"\0")
        part = values[:, at : at + (int(number) if number.isdigit() else 1)]
        if not text or not part.shape[1]:
            continue
        name = text.decode("latin-1").strip()
        columns[f"{name} {at}" if name in columns else name] = part[:, 0] if part.shape[1] == 1 else part
        at += part.shape[1]
    return columns


def _named_columns(
    values: Mapping[str, AnyArray], n: int, what: str, lost: list[str]
) -> tuple[FloatArray, list[bytes]]:
    """Return values as columns of float32 (n, c), and their names in the header; add to `lost` what does not fit."""
    columns: list[FloatArray] = [np.empty((n, 0), np.float32)]
    names: list[bytes] = []
    for name, array in values.items():
        width = array.shape[1] if array.ndim == 2 else 1
        if array.dtype.kind not in "fiub" or array.ndim > 2 or not width or not name.strip():
            lost.append(f"{name!r}, {array.dtype} of shape {array.shape}")
            continue
        n_columns = sum(part.shape[1] for part in columns)
        if len(names) == _MAX_NAMES or n_columns + width > np.iinfo(np.int16).max:
            lost.append(f"{name!r}, as there is room for {_MAX_NAMES} {what}")
            continue
        # The name, and NUL and the number of columns if there are several.
        number = b"\0%d" % width if width > 1 else b""
        short = name.encode("latin-1", "replace").split(b"\0")[0].strip()[: _NAME_SIZE - len(number)].strip()
        if short.decode("latin-1") != name:
            lost.append(f"the whole name {name!r} ({short.decode('latin-1')!r} is written)")
        with np.errstate(over="ignore"):
            column = array.astype(np.float32)
        if array.dtype.kind == "b":
            lost.append(f"that {name!r} is boolean (0 and 1 are written)")
        elif not keeps_values(array, column):
            lost.append(f"digits of {name!r} ({array.dtype}) beyond those of float32")
        columns.append(column.reshape(n, width))
        names.append(short + number)
    return np.hstack(columns), names


def _read_header(source: Source) -> tuple[dict[str, Any], Literal["<", ">"]]:
    """Return the fields of the header, and its byte order."""
    head = Source(source.start(HEADER_SIZE), source.name)
    byte_order: Literal["<", ">"] = ">" if head.data[996:1000] == b"\0\0\x03\xe8" else "<"
    header = head.record("header fields", _HEADER.newbyteorder(byte_order))
    if header["magic"][:5] != b"TRACK":
        raise source.error(f"starts with {header['magic'][:5]!r}, a .trk file with b'TRACK'; check the extension")
    if header["header_size"] != HEADER_SIZE:
        raise source.error(f"says that its header has {header['header_size']} bytes; expected {HEADER_SIZE}; fix it")
    return header, byte_order


def _grid(source: Source, header: dict[str, Any]) -> VoxelGrid:
    """Return the voxel grid of a header, which has a transform that can be used, or none."""
    version, order = header["version"], header["voxel_order"].decode("latin-1").strip().upper()
    to_ras, sizes = np.array(header["vox_to_ras"], np.float64), np.array(header["voxel_size"], np.float64)
    n_voxels = np.array(header["dimensions"], np.int64)
    if version not in range(4):
        raise source.error(f"has version {version} of the format; known are 1 to 3; convert it")
    if version == 1 or to_ras[3, 3] == 0:
        axes = f"along the image's axes ({order})" if is_order(order) else "along the image's axes"
        source.warn(
            "its header has no transform to the world (vox_to_ras): points are left in millimetres from the corner of "
            f"the first voxel, {axes}; transform them yourself if other data are in world coordinates"
        )
        return VoxelGrid(n_voxels, sizes, order if is_order(order) else DEFAULT_ORDER, None)
    if version != 2:
        source.warn(f"has version {version} of the format; it is read as version 2")
    if not is_order(order):
        source.warn(f"its voxel order is {order or 'missing'!r}; {DEFAULT_ORDER} is assumed, as TrackVis does")
        order = DEFAULT_ORDER
    if not np.isfinite(sizes).all() or not sizes.all():
        raise source.error(
            f"its voxels have the size {header['voxel_size']}, which its transform cannot use; fix the header"
        )
    if (sizes < 0).any() or (n_voxels < 0).any() or to_ras[3].tolist() != [0, 0, 0, 1]:
        source.warn(
            f"its header has voxels of the size {header['voxel_size']}, the dimensions {header['dimensions']} and a "
            f"transform whose last row is {header['vox_to_ras'][3]}; expected numbers above 0, and (0, 0, 0, 1): check "
            "that its points are where they should be"
        )
    if not np.isfinite(to_ras).all() or np.linalg.matrix_rank(to_ras[:3, :3]) < 3:
        raise source.error("its transform (vox_to_ras) cannot be inverted or is not finite; fix the header")
    return VoxelGrid(n_voxels, sizes, order, to_ras)
