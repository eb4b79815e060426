"""Lines from objects of other libraries, which are recognised by their attributes: none of them is imported here.

| object                                                    | recognised by                                        |
|-----------------------------------------------------------|------------------------------------------------------|
| tractograms of nibabel, and files of them                 | ``streamlines``, ``data_per_point``                  |
| ``TrxFile`` of trx                                        | ``streamlines``, ``data_per_vertex``                 |
| ``ArraySequence`` and ``Streamlines`` of nibabel and dipy | ``_data``, ``_offsets``, ``_lengths``                |
| meshes of PyVista and VTK, and several of them            | see `vtk_objects`                                    |
| geometries of shapely, tables of geopandas                | see `map_features`                                   |
| ``Path3D`` of trimesh                                     | ``entities``, ``vertices``                           |
| points and offsets                                        | a tuple of (m, 3) and (k + 1,) arrays                |
| polylines                                                 | a list, a tuple or an iterator of (m, 3) arrays      |
| segments                                                  | an array; ``__dlpack__`` or ``__array__``            |
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import INVALID, AnyArray, IntArray, choice, kind_of, to_integers
from ..errors import FileWarning, InputError
from ..support.warn_caller import warn_caller
from .lines import Lines, as_lines
from .making import Making, flat_column, has
from .map_features import of_features
from .offsets import check_offset, with_offset
from .strand_attributes import with_strand_values
from .vtk_objects import of_vtk

#: What a warning says of points without z.
_FLAT = "the points have two coordinates, x and y; z is 0"


def lines(obj: Any, *, offset: Any = None, invalid: str = "error") -> Lines:
    """Make lines of an object of another library, of polylines, or of an array of segments.

    Parameters
    ----------
    obj : object
        One of these; no library has to be installed but that of the object.

        - `Lines`, which are returned as they are.
        - A tractogram of nibabel, or a ``TrxFile`` of trx. Values per point become ``end_attributes``, those per
          streamline ``attributes``. A tractogram's ``affine_to_rasmm`` is applied.
        - An ``ArraySequence`` or ``Streamlines``.
        - A ``PolyData`` or an ``UnstructuredGrid`` of PyVista or VTK: its lines, with the arrays of their points and of
          their cells; the array ``radius``, in either case, and the texts ``unit`` and ``up`` of its field data mean
          the same as in a file. Of a ``MultiBlock``, the lines of all blocks; the attribute ``block`` counts these.
        - A geometry of shapely, or several: lines and rings, those of polygons and in collections too. z is 0 where
          there is none. The attribute ``feature`` is the position of the geometry in a list or an array.
        - A ``GeoDataFrame`` or ``GeoSeries`` of geopandas: the same. Columns of numbers and texts become
          attributes, and ``frame.iloc[feature]`` is the row.
        - A ``Path3D`` of trimesh: each entity as a polyline.
        - A tuple of points, (m, 3), and offsets, (k + 1,) integers from 0 to m: strand i has the points from
          ``offsets[i]`` to ``offsets[i + 1]``. A pair of arrays that are both (m, 3) is two polylines.
        - A list, a tuple or an iterator of polylines, (m, 3) each: arrays or nested lists. Each is a strand, even if
          all have two points.
        - Segments without strands, (n, 2, 3) or (n, 6): a NumPy array, or what has ``__dlpack__`` or ``__array__``, as
          arrays of PyTorch, JAX and Arrow do.

        Points may have two coordinates, x and y, also in an array of segments (n, 2, 2); z is then 0, and a warning
        says so.

        Values by the name ``radius`` become the radius.
    offset : "auto" or three numbers, optional
        Subtracted from x, y and z in float64 before they are rounded to float32; see `fastlines.read`.
    invalid : {"error", "skip"}
        Refuse segments that hold NaN or Inf, or leave them out, as in `Lines.from_segments`.

    Raises
    ------
    InputError
        If the object is none of these, or contradicts itself.

    Warns
    -----
    FileWarning
        Of everything that lines cannot hold, and of points whose z is taken as 0.

    Examples
    --------
    >>> import numpy as np
    >>> import fastlines as fl
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 5, 0], [1, 5, 0]])
    >>> fl.lines((points, [0, 3, 5])).strands
    array([0, 0, 1])
    >>> fl.lines([points[:3], points[3:]]).strands
    array([0, 0, 1])
    """
    choice("invalid", invalid, INVALID)
    told: list[str] = []
    made = _lines_of(obj, Making(invalid, check_offset(offset), told.append))
    if isinstance(obj, Lines) and offset is not None and obj.offset != check_offset(offset):
        made = with_offset(obj, offset)
    for text in told:
        warn_caller(text, FileWarning)
    return made


def _lines_of(obj: Any, how: Making) -> Lines:
    """Make lines of an object."""
    if isinstance(obj, Lines):
        return obj
    if isinstance(obj, type):
        raise InputError(f"lines are a class, {obj.__name__}; expected an object of it")
    if has(obj, "tractogram"):
        return _lines_of(obj.tractogram, how)
    if has(obj, "streamlines", "data_per_point") or has(obj, "streamlines", "data_per_vertex"):
        return _of_tractogram(obj, how)
    if _is_sequence(obj):
        return Lines.from_points(*_points_and_counts(obj), **how.options)
    for of_others in (of_vtk, of_features):
        if (made := of_others(obj, how)) is not None:
            return made
    if has(obj, "entities", "vertices"):
        return _of_path(obj, how)
    if isinstance(obj, Iterator):
        return _lines_of(list(obj), how)
    if isinstance(obj, list | tuple) or (isinstance(obj, np.ndarray) and obj.dtype == object and obj.ndim == 1):
        return _of_list(obj, how)
    if has(obj, "control", "pieces"):
        raise InputError("lines are Curves; curves.pieces.lines are lines, and build takes curves as they are")
    if has(obj, "geometry", "first_hit"):
        raise InputError(f"lines are {kind_of(obj)}; expected lines: pass tree.geometry, or save the tree by tree.save")
    array = to_array(obj)
    return as_lines(_in_space(array, how) if _shape(array)[1:] == (2, 2) else array, **how.options)


def to_array(obj: Any) -> Any:
    """Return what can be read as an array as one, sharing memory where its library allows it; else the object."""
    if isinstance(obj, np.ndarray | str) or not (has(obj, "__dlpack__") or has(obj, "__array__")):
        return obj
    if has(obj, "type", "flatten") and hasattr(obj.type, "list_size"):  # a list of fixed size of Arrow
        if obj.null_count:
            raise InputError(f"{kind_of(obj)} has {obj.null_count} nulls; fill them, or leave their rows out")
        inner = np.asarray(to_array(obj.flatten()))
        return inner.reshape(len(obj), obj.type.list_size, *inner.shape[1:])
    if has(obj, "__dlpack__"):
        try:
            return np.from_dlpack(obj)
        except Exception as error:  # on another device, with gradients, of another type: each library has its own
            if not has(obj, "__array__"):
                raise _unreadable(obj, error) from None
    try:
        return np.asarray(obj)
    except Exception as error:
        raise _unreadable(obj, error) from None


def _unreadable(obj: object, error: Exception) -> InputError:
    why = " ".join(str(error).split())[:120]
    return InputError(f"{kind_of(obj)} cannot be read as an array ({why}); detach it, or copy it to the CPU first")


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
        return np.empty((0, *data.shape[1:]) if data.ndim > 1 else (0, 3), np.float32), counts
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
    """Make lines of a tractogram of nibabel or a TrxFile."""
    is_trx = not has(obj, "data_per_point")
    points, counts = _points_and_counts(obj.streamlines)
    affine = None if is_trx else getattr(obj, "affine_to_rasmm", None)
    if affine is not None and not np.array_equal(affine, np.eye(4)):
        matrix = np.asarray(affine, np.float64)
        points = points @ matrix[:3, :3].T + matrix[:3, 3]
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
    return replace(made, unit="mm", up="z") if is_trx or affine is not None else made


def _of_path(obj: Any, how: Making) -> Lines:
    """Make lines of the entities of a Path3D."""
    vertices = np.asarray(obj.vertices)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InputError(
            f"{kind_of(obj)} has vertices of shape {vertices.shape}; expected (m, 3), as to_3D() makes them"
        )
    parts = [np.asarray(entity.discrete(vertices, scale=obj.scale)) for entity in obj.entities]
    made = Lines.from_strands([part.reshape(-1, 3) for part in parts], **how.options)
    unit = getattr(obj, "units", None)
    return replace(made, unit=unit) if isinstance(unit, str) and unit else made


def _of_list(obj: Any, how: Making) -> Lines:
    """Make lines of points and offsets, of polylines, or of nested numbers."""
    if isinstance(obj, tuple) and len(obj) == 2:
        points, offsets = (to_array(part) for part in obj)
        if np.ndim(points) == 2 and np.ndim(offsets) == 1:
            points = _in_space(points, how) if _shape(points)[1] == 2 else points
            return _of_offsets(points, np.asarray(offsets), how)
    lead = next((part for part in map(to_array, obj) if _shape(part) not in ((0,), (0, 3))), None)
    shape = _shape(lead)
    if len(shape) != 2 or shape[1] not in (2, 3):
        return as_lines(obj, **how.options)
    parts = [to_array(part) for part in obj]
    if shape[1] == 2:
        parts = [_padded(part) if _shape(part)[1:] == (2,) else part for part in parts]
        how.warn(_FLAT)
    return Lines.from_strands(parts, **how.options)


def _in_space(points: Any, how: Making) -> AnyArray:
    """Return points (…, 2) with z = 0, and warn."""
    how.warn(_FLAT)
    return _padded(points)


def _padded(points: Any) -> AnyArray:
    array = np.asarray(points)
    return np.concatenate([array, np.zeros_like(array[..., :1])], axis=-1)


def _of_offsets(points: Any, offsets: AnyArray, how: Making) -> Lines:
    places = to_integers(offsets, "offsets")
    n = len(points)
    if not len(places) or places[0] != 0 or places[-1] != n or (np.diff(places) < 0).any():
        raise InputError(
            f"the offsets do not rise from 0 to the number of points, {n}; expected one more than there are strands; "
            "of numbers of points, Lines.from_points makes lines"
        )
    return Lines.from_points(points, np.diff(places), **how.options)


def _items(mapping: Any) -> Iterable[tuple[str, Any]]:
    keys: Sequence[str] = list(mapping.keys()) if isinstance(mapping, Mapping) or has(mapping, "keys") else []
    return [(str(key), mapping[key]) for key in keys]


def _shape(part: Any) -> tuple[int, ...]:
    try:
        return np.shape(part)
    except ValueError:  # its parts differ in length
        return ()
