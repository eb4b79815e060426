"""TRX files (``.trx``): streamlines in world millimetres (RASMM) as plain arrays in a zip archive.

Format: https://github.com/tee-ar-ex/trx-spec/blob/master/specifications.md. ``header.json`` counts streamlines and
vertices. Each array is a member of the archive, and its name tells its columns and type: ``positions.3.float16``,
``offsets.uint32`` (the first vertex of each streamline, and the number of vertices), ``dpv/NAME.float32`` (a value per
vertex), ``dps/NAME.3.uint8`` (three values per streamline), ``groups/NAME.uint32`` (numbers of streamlines).

A group becomes a boolean attribute ``group NAME``. Of its values (``dpg``) and of members that the format does not
define, a warning tells. Arrays are little-endian. They are read here, and not with trx-python, which extracts the
archive to the disk and refuses a whole file for one array of a wrong length.

The file may also be a folder, which holds the same as the archive does. The members may be in a folder of the archive.
"""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import AnyArray
from ...errors import InputError
from ...geometry.lines import Lines
from ...geometry.voxel_grid import GRID, VoxelGrid
from ..grid_reference import grid_to_write
from ..losses import conventions, free_name, strand_numbers
from ..polylines import polylines_of
from ..segment_collector import PART, Strands, lines_of, offset_for
from ..source import BAD_COPY, Source, reason
from ..stored_array import StoredArray
from .archive import Member, members
from .streamlines import UNIT, UP, split_values
from .trx_streamlines import Group, Offsets

_TYPES = {
    f"{kind}{bits}": np.dtype(f"{kind}{bits}").newbyteorder("<")
    for kind, sizes in {"float": (16, 32, 64), "int": (8, 16, 32, 64), "uint": (8, 16, 32, 64)}.items()
    for bits in sizes
}
_HEADER = "header.json"
#: What file managers leave in folders and archives.
_HIDDEN = re.compile(r"(?:^|/)(?:\.|__MACOSX/|Thumbs\.db$|desktop\.ini$)", re.IGNORECASE)
#: More groups than these do not become attributes.
MAX_GROUPS = 64
#: What the name of an attribute begins with that is a group.
GROUP = "group "
#: The positions and the offsets of a file that lacks them.
_NOTHING = StoredArray(lambda at, n: b"", np.float32, (0, 3))
_ONE_OFFSET = StoredArray(lambda at, n: bytes(n), np.int64, (1,))


def read(source: Source, invalid: str, *, bundle: str | None = None) -> Lines:
    """Read a ``.trx`` file, in RASMM.

    Parameters
    ----------
    bundle : str, optional
        Read only the streamlines of the group of this name. They are the strands 0, 1, … in the group's order.
    """
    return next(read_chunks(source, None, invalid, bundle=bundle))


def read_chunks(
    source: Source, max_segments: int | None, invalid: str, *, bundle: str | None = None
) -> Iterator[Lines]:
    """Read a ``.trx`` file in chunks."""
    found = _without_folder(source, members(source, ".trx"))
    header = _header(source, found.pop(_HEADER).data)
    n_streamlines, n_points = header["NB_STREAMLINES"], header["NB_VERTICES"]
    arrays: dict[str, StoredArray] = {}
    for path, member in found.items():
        _add_array(source, arrays, path, member)
    points = arrays.pop("positions", _NOTHING)
    if points.shape != (n_points, 3) or points.dtype.kind != "f":
        raise source.error(
            f"its positions are {points.dtype} of shape {points.shape}; by its header, expected floats of shape "
            f"({n_points}, 3); {BAD_COPY}"
        )
    offsets = Offsets(source, arrays.pop("offsets", _ONE_OFFSET), n_streamlines, n_points)

    # Sort the other arrays into values per point, values per streamline and groups.
    kinds: dict[str, dict[str, StoredArray]] = {"dpv": {}, "dps": {}, "groups": {}}
    for path, array in arrays.items():
        kind, _, name = path.partition("/")
        n = {"dpv": n_points, "dps": n_streamlines}.get(kind, len(array))
        if kind not in kinds:
            source.warn(f"{path!r} in it is left out, as it is not a value of a point or of a streamline")
        elif len(array) != n:
            what = "points" if kind == "dpv" else "streamlines"
            source.warn(f"{path!r} in it has {len(array)} values for {n} {what}, and is left out")
        elif kind == "groups" and not _is_rows(array[:], n_streamlines):
            source.warn(f"{path!r} in it does not hold numbers of its {n_streamlines} streamlines, and is left out")
        else:
            kinds[kind][name] = array
    per_point, per_strand, groups = kinds.values()

    grid = _grid(source, header)
    metadata = {} if grid is None else {GRID: grid.to_metadata()}
    if bundle is not None:
        if not isinstance(bundle, str) or bundle not in groups:
            raise InputError(f"there is no bundle {bundle!r}; its groups are {', '.join(groups) or '(none)'}")
        chosen = groups[bundle][:].astype(np.int64)
        rows, counts = offsets.rows_of(chosen)
        whole = Strands(
            points[:][rows],
            counts,
            {name: values[:][rows] for name, values in per_point.items()},
            {name: values[:][chosen] for name, values in per_strand.items()},
        )
        offset = offset_for(source.offset, [whole.points])
        parts, like = whole.parts(), whole.split(0)[0]
    else:
        if len(groups) > MAX_GROUPS:
            some = ", ".join(list(groups)[:5])
            source.warn(
                f"its {len(groups)} groups ({some}, …) are left out, as they are more than {MAX_GROUPS}; "
                "bundle= reads the streamlines of one"
            )
            groups = {}
        columns: dict[str, StoredArray | Group] = {**per_strand}
        columns |= {GROUP + name: Group(numbers[:], n_streamlines) for name, numbers in groups.items()}

        def part(rows: slice, strands: slice) -> Strands:
            values = {name: array[rows] for name, array in per_point.items()}
            return Strands(points[rows], offsets[strands], values, {name: v[strands] for name, v in columns.items()})

        starts = range(0, n_points, PART)
        offset = offset_for(source.offset, (points[start : start + PART] for start in starts))
        parts, like = (part(*place) for place in offsets.parts(PART)), part(slice(0), slice(0))
    yield from lines_of(parts, like, n_points, offset, metadata, max_segments, invalid)


def read_grid(source: Source) -> VoxelGrid | None:
    """Read the voxel grid alone."""
    return _grid(source, _header(source, _without_folder(source, members(source, ".trx", _HEADER))[_HEADER].data))


def write(lines: Lines, path: Path, *, reference: Any = None) -> list[str]:
    """Write positions in float32, attributes in their own type, and boolean attributes ``group NAME`` as groups.

    Positions are float64 if the lines have an offset.

    Parameters
    ----------
    reference : object or path, optional
        Whose voxel grid the header names, as of ``.trk``.
    """
    parts = polylines_of(lines)
    per_point, per_strand, lost = split_values(parts)
    arrays: dict[str, AnyArray] = {
        f"positions.3.{parts.points.dtype.name}": parts.points,
        "offsets.uint32" if len(parts.points) < 2**32 else "offsets.uint64": parts.offsets,
    }
    taken = {*per_point, *per_strand}
    for name, values in list(per_strand.items()):
        if name.startswith(GROUP) and values.dtype == np.bool_ and values.ndim == 1:
            group = free_name(name, GROUP + _safe(name.removeprefix(GROUP)), taken, lost).removeprefix(GROUP)
            arrays[f"groups/{group}.uint32"] = np.flatnonzero(per_strand.pop(name))
    for folder, several in (("dpv", per_point), ("dps", per_strand)):
        for name, values in several.items():
            _add(arrays, folder, name, values, taken, lost)
    grid, said = grid_to_write(lines, parts.points, reference, in_world=True)
    assert grid.voxel_to_rasmm is not None
    header = {
        "DIMENSIONS": grid.dimensions.tolist(),
        "VOXEL_TO_RASMM": grid.voxel_to_rasmm.tolist(),
        "NB_VERTICES": len(parts.points),
        "NB_STREAMLINES": len(parts.counts),
    }
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(zipfile.ZipInfo("header.json"), json.dumps(header))
        for name, values in arrays.items():
            dtype = _TYPES[name.rpartition(".")[2]]
            with archive.open(zipfile.ZipInfo(name), "w", force_zip64=values.nbytes > 1 << 30) as member:
                member.write(np.ascontiguousarray(values, dtype).reshape(-1).view(np.uint8).data)
    return said + lost + strand_numbers(parts.strand) + conventions(lines, UNIT, UP)


def _add(
    arrays: dict[str, AnyArray], folder: str, name: str, values: AnyArray, taken: set[str], lost: list[str]
) -> None:
    """Add an attribute by the name of its member; or to `lost`, if the format has no such type or shape."""
    if values.dtype == np.bool_:
        lost.append(f"that {name!r} is boolean (0 and 1 are written)")
        values = values.view(np.uint8)
    if values.dtype.name not in _TYPES or values.ndim > 2 or 0 in values.shape[1:]:
        lost.append(f"{name!r}, {values.dtype} of shape {values.shape}")
        return
    columns = f".{values.shape[1]}" if values.ndim == 2 else ""
    arrays[f"{folder}/{free_name(name, _safe(name), taken, lost)}{columns}.{values.dtype.name}"] = values


def _safe(name: str) -> str:
    """Return a name without what separates the parts of members' names."""
    return re.sub(r"[^\w +()=,-]", "_", name).strip() or "_"


def _without_folder(source: Source, found: dict[str, Member]) -> dict[str, Member]:
    """Return the members by their names in the folder of the header, and none that systems leave beside them."""
    named = {name.replace("\\", "/"): member for name, member in found.items()}
    folders = [name.removesuffix(_HEADER) for name in named if f"/{name}".endswith(f"/{_HEADER}")]
    if not folders:
        raise source.error(f"holds no {_HEADER!r}, so it is not a whole .trx file; check the extension, or {BAD_COPY}")
    folder = min(folders, key=len)
    if others := [other for other in folders if not other.startswith(folder)]:
        raise source.error(
            f"holds several files of streamlines, in the folders {folder!r} and {others[0]!r}; unpack it, and read "
            "one of these folders"
        )
    within = {name.removeprefix(folder): member for name, member in named.items() if name.startswith(folder)}
    return {name: member for name, member in within.items() if not _HIDDEN.search(name)}


def _grid(source: Source, header: dict[str, Any]) -> VoxelGrid | None:
    """Return the voxel grid of a header; None if it has none, or one that cannot be used."""
    if not {"DIMENSIONS", "VOXEL_TO_RASMM"} & header.keys():
        return None
    try:
        grid = VoxelGrid.from_mapping(header, "its 'header.json'")
        if grid.voxel_to_rasmm is None:
            raise InputError("its 'header.json' has no VOXEL_TO_RASMM")
    except InputError as error:
        source.warn(f"its voxel grid is not read: {error}")
        return None
    return grid


def _header(source: Source, data: bytes) -> dict[str, Any]:
    """Return the header, which counts streamlines and points."""
    try:
        header = json.loads(data)
        numbers = [header["NB_STREAMLINES"], header["NB_VERTICES"]]
    except (ValueError, LookupError, TypeError, RecursionError) as error:
        raise source.error(
            f"its 'header.json' does not count streamlines and vertices ({reason(error)}); {BAD_COPY}"
        ) from None
    if not all(type(number) is int and number >= 0 for number in numbers):
        raise source.error("NB_STREAMLINES and NB_VERTICES in its 'header.json' are not whole numbers; fix them")
    return dict(header)


def _add_array(source: Source, arrays: dict[str, StoredArray], path: str, member: Member) -> None:
    """Add a member as an array, (n,) or (n, columns), by its path without columns and type."""
    folder, slash, last = path.rpartition("/")
    words = last.split(".")
    dtype = _TYPES.get(words.pop())
    columns = int(words.pop()) if len(words) > 1 and re.fullmatch("[0-9]{1,9}", words[-1]) else 1
    name = f"{folder}{slash}{'.'.join(words).strip()}"
    size = columns * dtype.itemsize if dtype else 0
    if dtype is None or not size or member.size % size:
        source.warn(
            f"{path!r} in it ({member.size} bytes) is left out, as its name is not that of an array of this size"
        )
    elif name in arrays:
        source.warn(f"{path!r} in it is left out, as another array has its name")
    else:
        shape = (member.size // size, columns) if columns > 1 else (member.size // size,)
        arrays[name] = StoredArray(member.read, dtype, shape)


def _is_rows(array: AnyArray, n: int) -> bool:
    """Return whether an array holds rows of another one, which has n of them."""
    return array.ndim == 1 and array.dtype.kind in "iu" and (not len(array) or (array.min() >= 0 and array.max() < n))
