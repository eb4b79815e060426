"""Lines from tractograms of nibabel, DIPY and TRX, which are recognised by their attributes.

| object                                                    | recognised by                                          |
|-----------------------------------------------------------|--------------------------------------------------------|
| files of nibabel, such as ``TrkFile``                     | ``tractogram``                                         |
| ``Tractogram`` and ``LazyTractogram`` of nibabel          | ``streamlines``, ``data_per_point``                    |
| ``StatefulTractogram`` of DIPY                            | these, and ``space``, ``origin``, ``space_attributes`` |
| ``TrxFile`` of trx                                        | ``streamlines``, ``data_per_vertex``                   |
| ``ArraySequence`` and ``Streamlines`` of nibabel and DIPY | ``_data``, ``_offsets``, ``_lengths``                  |

Points become world millimetres with axes to the Right, Anterior and Superior ("RASMM"), from the centres of voxels. The
voxel grid of a file or of a ``StatefulTractogram`` is kept in the metadata.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, IntArray, kind_of, to_integers
from ..errors import InputError
from .lines import Lines
from .making import Making, flat_column, has
from .strand_attributes import with_strand_values
from .to_array import to_array
from .voxel_grid import GRID, VoxelGrid


def of_tractogram(obj: Any, how: Making) -> Lines | None:
    """Return the lines of a tractogram or of streamlines; None if the object is none."""
    inner = obj.tractogram if has(obj, "tractogram") else obj
    if has(inner, "streamlines", "data_per_point") or has(inner, "streamlines", "data_per_vertex"):
        return _with_grid(_of_tractogram(inner, how), obj, how)
    if _is_sequence(obj):
        return Lines.from_points(*_points_and_counts(obj), **how.options)
    return None


def _is_sequence(obj: object) -> bool:
    return has(obj, "_data", "_offsets", "_lengths")


def _points_and_counts(sequence: Any) -> tuple[AnyArray, IntArray]:
    """Return the rows of all arrays of a sequence, one after the other, and how many each has."""
    if not _is_sequence(sequence):
        parts = [np.asarray(to_array(part)) for part in sequence]
        rows = np.concatenate(parts) if parts else np.empty((0, 3), np.float32)
        return rows, np.array([len(part) for part in parts], np.int64)
    data = np.asarray(sequence._data)
    offsets, counts = (to_integers(np.asarray(part), "offsets") for part in (sequence._offsets, sequence._lengths))
    if not len(counts):
        shape = data.shape[1:] if data.ndim > 1 else (3,)  # nibabel's empty sequences have no columns
        return np.empty((0, *shape), np.float32), counts
    if (
        offsets.shape != counts.shape
        or (offsets < 0).any()
        or (counts < 0).any()
        or (offsets + counts > len(data)).any()
    ):
        raise InputError(f"{kind_of(sequence)}: its offsets and lengths do not fit its {len(data)} rows")
    starts = np.cumsum(counts) - counts
    if np.array_equal(offsets, starts):
        return data[: int(counts.sum())], counts
    return data[np.repeat(offsets - starts, counts) + np.arange(int(counts.sum()))], counts


def _of_tractogram(obj: Any, how: Making) -> Lines:
    """Make lines of a tractogram of nibabel or DIPY, or of a TrxFile."""
    is_trx = not has(obj, "data_per_point")
    points, counts = _points_and_counts(obj.streamlines)
    affine = np.eye(4) if is_trx else _to_rasmm(obj)
    if affine is not None and not np.array_equal(affine, np.eye(4)):
        points = points @ affine[:3, :3].T + affine[:3, 3]
    per_point = {}
    for name, sequence in _items(obj.data_per_vertex if is_trx else obj.data_per_point):
        values, lengths = _points_and_counts(sequence)
        if not np.array_equal(lengths, counts):
            raise InputError(f"the values {name!r} per point do not have the numbers of points of the streamlines")
        per_point[name] = flat_column(values)
    per_strand = {
        name: flat_column(np.asarray(list(values) if isinstance(values, Iterator) else values))
        for name, values in _items(obj.data_per_streamline)
    }
    if left_out := [name for name in ("groups", "data_per_group") if len(getattr(obj, name, None) or ())]:
        how.warn(f"{' and '.join(left_out)} of {kind_of(obj)} are not read")
    for name, values in per_strand.items():
        if len(values) != len(counts):
            raise InputError(f"{name!r} has {len(values)} values; expected one for each streamline, {len(counts)}")
    radius = per_point.pop("radius", None)
    made = Lines.from_points(points, counts, radius=radius, attributes=per_point, **how.options)
    if "radius" in per_strand:
        of_strands = per_strand.pop("radius")
        if radius is None and of_strands.ndim == 1:
            made = made.with_radius(of_strands[made.strands])
        else:
            per_strand["radius of streamline"] = of_strands
    made = with_strand_values(made, per_strand, "streamline")
    return made if affine is None else replace(made, unit="mm", up="z")


def _with_grid(made: Lines, obj: Any, how: Making) -> Lines:
    """Return lines with the voxel grid of their tractogram in the metadata, as files of it are read, if it has one."""
    try:
        grid = VoxelGrid.of_tractogram(obj, kind_of(obj))
    except InputError as error:
        how.warn(f"the voxel grid is not kept: {error}")
        return made
    return made if grid is None else replace(made, metadata={**made.metadata, GRID: grid.to_metadata()})


def _to_rasmm(obj: Any) -> npt.NDArray[np.float64] | None:
    """Return the matrix that takes the points of a tractogram to RASMM, (4, 4); None if it is not known."""
    if not has(obj, "space", "origin", "space_attributes"):
        affine = getattr(obj, "affine_to_rasmm", None)
        return None if affine is None else np.asarray(affine, np.float64)
    # Of DIPY: three spaces beside RASMM, in which points count from the centres of voxels or from their corners.
    matrix, _, sizes, _ = obj.space_attributes
    of_voxels = np.asarray(matrix, np.float64)
    space, origin = (str(getattr(state, "value", state)) for state in (obj.space, obj.origin))
    known = {
        "rasmm": np.eye(4),
        "lpsmm": np.diag([-1.0, -1, 1, 1]),
        "vox": of_voxels,
        "voxmm": of_voxels / np.append(np.asarray(sizes, np.float64), 1),
    }
    if space not in known or origin not in ("center", "corner"):
        raise InputError(
            f"{kind_of(obj)} is in the space {space!r} with the origin {origin!r}, which are not known; call its "
            "to_rasmm() and to_center() first"
        )
    to_rasmm: npt.NDArray[np.float64] = known[space].copy()
    if origin == "corner":
        to_rasmm[:3, 3] -= of_voxels[:3, :3] @ np.full(3, 0.5)
    return to_rasmm


def _items(mapping: Any) -> Iterable[tuple[str, Any]]:
    keys: Sequence[str] = list(mapping.keys()) if isinstance(mapping, Mapping) or has(mapping, "keys") else []
    return [(str(key), mapping[key]) for key in keys]
