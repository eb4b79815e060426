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
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import AnyArray, IntArray
from ...errors import InputError
from ...geometry.lines import Lines
from ..grid_reference import grid_to_write
from ..losses import conventions, free_name, strand_numbers
from ..polylines import polylines_of
from ..segment_collector import Strands, lines_of, offset_for
from ..source import BAD_COPY, Source, reason
from ..voxel_grid import GRID, VoxelGrid
from .archive import unpack
from .streamlines import UNIT, UP, split_values

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


def read(source: Source, invalid: str, *, bundle: str | None = None) -> Lines:
    """Read a ``.trx`` file, in RASMM.

    Parameters
    ----------
    bundle : str, optional
        Read only the streamlines of the group of this name. They are the strands 0, 1, … in the group's order.
    """
    members = _without_folder(source, unpack(source, ".trx"))
    header = _header(source, members.pop(_HEADER))
    n_streamlines, n_points = header["NB_STREAMLINES"], header["NB_VERTICES"]
    arrays: dict[str, AnyArray] = {}
    for member in list(members):
        _array(source, arrays, member, members.pop(member))
    points = arrays.pop("positions", np.empty((0, 3), np.float32))
    if points.shape != (n_points, 3) or points.dtype.kind != "f":
        raise source.error(
            f"its positions are {points.dtype} of shape {points.shape}; by its header, expected floats of shape "
            f"({n_points}, 3); {BAD_COPY}"
        )
    counts = _counts(source, arrays.pop("offsets", np.zeros(1, np.int64)), n_streamlines, n_points)

    # Sort the other arrays into values per point, values per streamline and groups.
    kinds: dict[str, dict[str, AnyArray]] = {"dpv": {}, "dps": {}, "groups": {}}
    for path, array in arrays.items():
        kind, _, name = path.partition("/")
        n = {"dpv": n_points, "dps": n_streamlines}.get(kind, len(array))
        if kind not in kinds:
            source.warn(f"{path!r} in it is left out, as it is not a value of a point or of a streamline")
        elif len(array) != n:
            what = "points" if kind == "dpv" else "streamlines"
            source.warn(f"{path!r} in it has {len(array)} values for {n} {what}, and is left out")
        elif kind == "groups" and not _is_rows(array, n_streamlines):
            source.warn(f"{path!r} in it does not hold numbers of its {n_streamlines} streamlines, and is left out")
        else:
            kinds[kind][name] = array
    per_strand, groups = kinds["dps"], {name: array.astype(np.int64) for name, array in kinds["groups"].items()}

    if bundle is not None:
        if not isinstance(bundle, str) or bundle not in groups:
            raise InputError(f"there is no bundle {bundle!r}; its groups are {', '.join(groups) or '(none)'}")
        chosen = groups.pop(bundle)
        first = np.cumsum(counts) - counts
        sizes = counts[chosen]
        rows = np.repeat(first[chosen] - np.cumsum(sizes) + sizes, sizes) + np.arange(int(sizes.sum()))
        points, counts = points[rows], sizes
        kinds["dpv"] = {name: values[rows] for name, values in kinds["dpv"].items()}
        per_strand = {name: values[chosen] for name, values in per_strand.items()}
    elif len(groups) > MAX_GROUPS:
        some = ", ".join(list(groups)[:5])
        source.warn(
            f"its {len(groups)} groups ({some}, …) are left out, as they are more than {MAX_GROUPS}; "
            "bundle= reads the streamlines of one"
        )
    else:
        for name, chosen in groups.items():
            per_strand[GROUP + name] = np.bincount(chosen, minlength=n_streamlines) > 0
    grid = _grid(source, header)
    whole = Strands(points, counts, kinds["dpv"], per_strand)
    offset, metadata = offset_for(source, [points]), {} if grid is None else {GRID: grid.to_metadata()}
    return next(lines_of(whole.parts(), whole.split(0)[0], len(points), offset, metadata, None, invalid))


def read_grid(source: Source) -> VoxelGrid | None:
    """Read the voxel grid alone."""
    return _grid(source, _header(source, _without_folder(source, unpack(source, ".trx", _HEADER))[_HEADER]))


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


def _without_folder(source: Source, members: dict[str, bytes]) -> dict[str, bytes]:
    """Return the members by their names in the folder of the header, and none that systems leave beside them."""
    named = {name.replace("\\", "/"): data for name, data in members.items()}
    folders = [name.removesuffix(_HEADER) for name in named if f"/{name}".endswith(f"/{_HEADER}")]
    if not folders:
        raise source.error(f"holds no {_HEADER!r}, so it is not a whole .trx file; check the extension, or {BAD_COPY}")
    folder = min(folders, key=len)
    if others := [other for other in folders if not other.startswith(folder)]:
        raise source.error(
            f"holds several files of streamlines, in the folders {folder!r} and {others[0]!r}; unpack it, and read "
            "one of these folders"
        )
    within = {name.removeprefix(folder): data for name, data in named.items() if name.startswith(folder)}
    return {name: data for name, data in within.items() if not _HIDDEN.search(name)}


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


def _array(source: Source, arrays: dict[str, AnyArray], path: str, data: bytes) -> None:
    """Add a member as an array, (n,) or (n, columns), by its path without columns and type."""
    folder, slash, last = path.rpartition("/")
    words = last.split(".")
    dtype = _TYPES.get(words.pop())
    columns = int(words.pop()) if len(words) > 1 and re.fullmatch("[0-9]{1,9}", words[-1]) else 1
    name = f"{folder}{slash}{'.'.join(words).strip()}"
    if dtype is None or not columns or len(data) % (columns * dtype.itemsize):
        source.warn(f"{path!r} in it ({len(data)} bytes) is left out, as its name is not that of an array of this size")
    elif name in arrays:
        source.warn(f"{path!r} in it is left out, as another array has its name")
    else:
        array = np.frombuffer(data, dtype)
        arrays[name] = array.reshape(-1, columns) if columns > 1 else array


def _counts(source: Source, offsets: AnyArray, n_streamlines: int, n_points: int) -> IntArray:
    """Return the number of points of each streamline."""
    if offsets.ndim == 1 and len(offsets) == n_streamlines and n_streamlines:
        source.warn("its offsets lack the end of the last streamline, as in an older version of the format")
        offsets = np.append(offsets, np.array(n_points, offsets.dtype))
    if offsets.dtype.kind not in "iu" or offsets.shape != (n_streamlines + 1,):
        raise source.error(
            f"its offsets are {offsets.dtype} of shape {offsets.shape}; by its header, expected whole numbers of shape "
            f"({n_streamlines + 1},); {BAD_COPY}"
        )
    if offsets[0] != 0 or offsets[-1] != n_points or (offsets[1:] < offsets[:-1]).any():
        raise source.error(
            f"its {len(offsets)} offsets, from {offsets[0]} to {offsets[-1]}, do not rise from 0 to the {n_points} "
            f"points of its {n_streamlines} streamlines; its header or its offsets are wrong: write it again"
        )
    return np.asarray(np.diff(offsets.astype(np.int64)), np.int64)


def _is_rows(array: AnyArray, n: int) -> bool:
    """Return whether an array holds rows of another one, which has n of them."""
    return array.ndim == 1 and array.dtype.kind in "iu" and (not len(array) or (array.min() >= 0 and array.max() < n))
