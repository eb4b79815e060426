"""TrackVis files (``.trk``): streamlines in the voxels of an image, with the image's place in the world.

Format: http://trackvis.org/docs/?subsect=fileformat, versions 1 to 3 in either byte order.

Points are stored in *voxel millimetres*: voxel sizes times voxel indices, from the corner of the first voxel, along the
image's own axes. The header's ``vox_to_ras`` takes voxel indices, which count from the centre of the first voxel, to
world millimetres, axes to the Right, Anterior and Superior ("RASMM"). ``voxel_order`` names the directions of the
points' axes. Where it differs from that of ``vox_to_ras``, axes are swapped and mirrored first.

Without a transform in the header, points stay in voxel millimetres, with a warning.

Files are written with voxels of 1 mm, axes to R, A and S, and a transform that undoes the half voxel between a voxel's
corner and its centre. The whole transform is the identity then, so points keep their bits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray
from ...geometry.lines import Lines
from ...geometry.strand_attributes import with_strand_values
from ..losses import conventions, keeps_values, strand_numbers
from ..polylines import polylines_of
from ..segment_collector import SegmentCollector, warn_if_coarse
from ..source import BAD_COPY, Source
from .streamlines import UNIT, UP, dimensions, split_values
from .trk_streamlines import Streamlines

HEADER_SIZE = 1000
_HEADER = np.dtype(
    {
        "names": [
            "magic", "dimensions", "voxel_size", "n_scalars", "scalar_names", "n_properties", "property_names",
            "vox_to_ras", "voxel_order", "n_streamlines", "version", "header_size",
        ],
        "formats": [
            "S6", ("<i2", 3), ("<f4", 3), "<i2", ("S20", 10), "<i2", ("S20", 10),
            ("<f4", (4, 4)), "S4", "<i4", "<i4", "<i4",
        ],
        "offsets": [0, 6, 12, 36, 38, 238, 240, 440, 948, 988, 992, 996],
        "itemsize": HEADER_SIZE,
    }
)  # fmt: skip

#: The directions of an axis: towards more and towards less of x, y and z in the world.
_DIRECTIONS = ("RL", "AP", "SI")
#: The voxel order that TrackVis assumes if it is missing.
_DEFAULT_ORDER = "LPS"
#: The most names of scalars, and of properties, and the bytes of each.
_MAX_NAMES, _NAME_SIZE = 10, 20


def read(source: Source, invalid: str) -> Lines:
    """Read a ``.trk`` file, in RASMM, or in voxel millimetres if the header has no transform.

    Scalars per point and properties per streamline become ``attributes`` by their names, float32. A segment has those
    of its first point and of its streamline.
    """
    head = Source(source.start(HEADER_SIZE), source.name)
    byte_order: Literal["<", ">"] = ">" if head.data[996:1000] == b"\0\0\x03\xe8" else "<"
    header = head.record("header fields", _HEADER.newbyteorder(byte_order))
    if header["magic"][:5] != b"TRACK":
        raise source.error(f"starts with {header['magic'][:5]!r}, a .trk file with b'TRACK'; check the extension")
    if header["header_size"] != HEADER_SIZE:
        raise source.error(f"says that its header has {header['header_size']} bytes; expected {HEADER_SIZE}; fix it")
    if min(header["n_scalars"], header["n_properties"]) < 0:
        raise source.error(
            f"announces {header['n_scalars']} scalars per point and {header['n_properties']} properties; "
            "neither can be negative; fix the header"
        )
    transform = _transform(source, header)
    names, n_scalars, n_properties = header["scalar_names"], header["n_scalars"], header["n_properties"]

    # Join the points of some streamlines at a time.
    streamlines = Streamlines(source, HEADER_SIZE, byte_order, 3 + n_scalars, n_properties)
    collector = SegmentCollector(
        source.size // (4 * (3 + n_scalars)), _columns(names, np.empty((0, n_scalars), np.float32), "scalars")
    )
    properties = [np.empty((0, n_properties), np.float32)]
    for rows, values, counts in streamlines:
        collector.add(_apply(transform, rows[:, :3]), counts, _columns(names, rows[:, 3:], "scalars"))
        properties.append(values)
    _check(source, header["n_streamlines"], streamlines)
    if collector.may_be_coarse:
        warn_if_coarse(_apply(transform, rows[:, :3]) for rows, _, _ in streamlines)
    lines = collector.lines(invalid)
    per_strand = _columns(header["property_names"], np.concatenate(properties), "properties")
    return with_strand_values(lines, per_strand, "streamline")


def write(lines: Lines, path: Path) -> list[str]:
    """Write a ``.trk`` file of version 2, in RASMM.

    Attributes become scalars or properties in float32: 10 of each, with names of up to 20 bytes.
    """
    parts = polylines_of(lines)
    per_point, per_strand, lost = split_values(parts)
    scalars, scalar_names = _named_columns(per_point, len(parts.points), "scalars per point", lost)
    properties, property_names = _named_columns(per_strand, len(parts.counts), "properties of a streamline", lost)
    header = np.zeros(1, _HEADER)[0]
    header["magic"], header["version"], header["header_size"] = b"TRACK", 2, HEADER_SIZE
    header["dimensions"], header["voxel_size"], header["voxel_order"] = dimensions(parts.points), 1, b"RAS"
    header["vox_to_ras"] = np.eye(4)
    header["vox_to_ras"][:3, 3] = 0.5
    header["n_scalars"], header["n_properties"] = scalars.shape[1], properties.shape[1]
    header["scalar_names"][: len(scalar_names)] = scalar_names
    header["property_names"][: len(property_names)] = property_names
    n = len(parts.counts)
    header["n_streamlines"] = n if n <= np.iinfo(np.int32).max else 0

    # Mix counts, points with their scalars, and properties.
    per_point_words = 3 + scalars.shape[1]
    size = 1 + parts.counts * per_point_words + properties.shape[1]
    first = np.cumsum(size) - size
    is_point = np.ones(int(size.sum()), np.bool_)
    is_point[first] = False
    where = (first + 1 + parts.counts * per_point_words)[:, None] + np.arange(properties.shape[1])
    is_point[where] = False
    numbers = np.empty(len(is_point), "<f4")
    numbers[is_point] = np.hstack([parts.points, scalars]).reshape(-1)
    numbers[where] = properties
    numbers.view("<i4")[first] = parts.counts
    with path.open("wb") as file:
        file.write(header.tobytes())
        file.write(numbers.data)
    return lost + strand_numbers(parts.strand) + conventions(lines, UNIT, UP)


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


def _apply(transform: npt.NDArray[np.float64] | None, points: FloatArray) -> npt.NDArray[np.floating]:
    """Transform points in float64."""
    if transform is None or np.array_equal(transform, np.eye(3, 4)):
        return points  # bit for bit, signs of zeros included
    with np.errstate(invalid="ignore", over="ignore"):  # NaN and Inf are reported with their rows
        return np.asarray(points @ transform[:, :3].T + transform[:, 3])


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


def _transform(source: Source, header: dict[str, Any]) -> npt.NDArray[np.float64] | None:
    """Return the matrix (3, 4) from voxel millimetres to RASMM; None if the header has none."""
    version, order = header["version"], header["voxel_order"].decode("latin-1").strip().upper()
    to_ras = np.array(header["vox_to_ras"], np.float64)
    known_order = [_axis_of(letter) for letter in order] if len(order) == 3 else []
    if version not in range(4):
        raise source.error(f"has version {version} of the format; known are 1 to 3; convert it")
    if version == 1 or to_ras[3, 3] == 0:
        axes = f"along the image's axes ({order})" if sorted(known_order) == [0, 1, 2] else "along the image's axes"
        source.warn(
            "its header has no transform to the world (vox_to_ras): points are left in millimetres from the corner of "
            f"the first voxel, {axes}; transform them yourself if other data are in world coordinates"
        )
        return None
    if version != 2:
        source.warn(f"has version {version} of the format; it is read as version 2")
    if sorted(known_order) != [0, 1, 2]:
        source.warn(f"its voxel order is {order or 'missing'!r}; {_DEFAULT_ORDER} is assumed, as TrackVis does")
        order = _DEFAULT_ORDER

    # Check the values that take voxel millimetres to indices from the centre of the first voxel.
    size, n_voxels = np.array(header["voxel_size"], np.float64), np.array(header["dimensions"])
    if not np.isfinite(size).all() or not size.all():
        raise source.error(
            f"its voxels have the size {header['voxel_size']}, which its transform cannot use; fix the header"
        )
    rotation = to_ras[:3, :3]
    if not np.isfinite(to_ras).all() or np.linalg.matrix_rank(rotation) < 3:
        raise source.error("its transform (vox_to_ras) cannot be inverted or is not finite; fix the header")

    # Pair each axis of the transform with one of the points, mirrored where their directions differ.
    indices = np.zeros((3, 4))
    for row, letter in enumerate(_axis_directions(rotation)):
        column = [_axis_of(other) for other in order].index(_axis_of(letter))
        indices[row, column], indices[row, 3] = 1 / size[column], -0.5
        if order[column] != letter:
            indices[row] *= -1
            indices[row, 3] += n_voxels[column] - 1
    matrix: npt.NDArray[np.float64] = rotation @ indices
    matrix[:, 3] += to_ras[:3, 3]
    return matrix


def _axis_of(letter: str) -> int:
    """Return which axis of the world a letter names; -1 if none."""
    return next((axis for axis, letters in enumerate(_DIRECTIONS) if letter in letters), -1)


def _axis_directions(matrix: npt.NDArray[np.float64]) -> str:
    """Name the direction of each column of a matrix (3, 3): the nearest of R L, A P, S I, each axis once."""
    # Remove shear by the nearest rotation; then let the clearest column choose first.
    u, _, vt = np.linalg.svd(matrix / np.linalg.norm(matrix, axis=0))
    rotation = u @ vt
    directions = [""] * 3
    for column in np.argsort(-np.abs(rotation).max(axis=0), kind="stable"):
        axis = int(np.abs(rotation[:, column]).argmax())
        directions[column] = _DIRECTIONS[axis][int(rotation[axis, column] < 0)]
        rotation[axis] = 0
    return "".join(directions)
