"""Lines from geometries of shapely and tables of geopandas, which are recognised by their attributes.

| object                                             | recognised by                                     |
|----------------------------------------------------|---------------------------------------------------|
| a geometry of shapely                              | ``geom_type``, a text, and ``wkb``                |
| ``GeoDataFrame``                                   | ``geometry``, ``columns``, ``crs``                |
| ``GeoSeries`` and arrays of geometries             | ``geom_type``, ``crs``                            |
| a list, a tuple or an array of geometries          | its first member that is not None                 |

LineString, LinearRing, the rings of polygons, and those in multi-part geometries and collections are lines; each is a
strand. z is 0 where a geometry has none. The attribute ``feature`` is the position of the geometry in what was given.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from ..arrays import AnyArray, IntArray, kind_of
from ..errors import InputError
from ..support.distinct import is_among
from ..support.texts import kinds_text
from .lines import Lines
from .making import Making, has
from .strand_attributes import FEATURE, array_of, objects, with_strand_values

#: The numbers that shapely has for types of geometries.
_LINES, _POLYGON, _MANY = (1, 2), 3, (4, 5, 6, 7)
#: The unit of a reference system, by its name in PROJ.
MAP_UNITS = {"metre": "m", "foot": "ft", "kilometre": "km", "degree": "degree"}


def of_features(obj: Any, how: Making) -> Lines | None:
    """Return the lines of geometries; None if the object is none."""
    if _is_geometry(obj):
        return _of_geometries(objects([obj]), how)
    if has(obj, "geometry", "columns", "crs"):
        return _of_frame(obj, how)
    if has(obj, "geom_type", "crs"):
        return replace(_of_geometries(objects(obj), how), **_facts(obj.crs))
    if isinstance(obj, list | tuple | np.ndarray) and _is_geometry(_first(obj)):
        return _of_geometries(objects(obj), how)
    return None


def _is_geometry(obj: object) -> bool:
    return has(obj, "geom_type", "wkb") and isinstance(obj.geom_type, str)  # type: ignore[attr-defined]


def _first(obj: Any) -> object:
    if isinstance(obj, np.ndarray) and (obj.dtype != object or obj.ndim != 1):
        return None
    return next((item for item in obj if item is not None), None)


def _of_geometries(geometries: AnyArray, how: Making) -> Lines:
    """Make a strand of each line and ring."""
    shapely = import_module("shapely")  # which made the geometries
    for i, geometry in enumerate(geometries):
        if geometry is not None and not _is_geometry(geometry):
            raise InputError(f"item {i} is {kind_of(geometry)}; expected a geometry of shapely, as the others are")
    parts, owner = geometries, np.arange(len(geometries))
    others: dict[str, int] = {}
    if n_none := int(shapely.is_missing(parts).sum()):
        others["None"] = n_none
    # Take collections apart, as often as they are in each other; then polygons.
    while True:
        types = shapely.get_type_id(parts)
        is_many = is_among(types, np.array(_MANY))
        if not is_many.any():
            break
        inner, row = shapely.get_parts(parts[is_many], return_index=True)
        parts, owner = _in_order(parts, owner, is_many, inner, row)
    is_polygon = types == _POLYGON
    rings, row = shapely.get_rings(parts[is_polygon], return_index=True)
    parts, owner = _in_order(parts, owner, is_polygon, rings, row)
    types = shapely.get_type_id(parts)
    is_line = is_among(types, np.array(_LINES))
    for part in parts[~is_line & (types >= 0)]:
        others[part.geom_type] = others.get(part.geom_type, 0) + 1
    if others:
        how.warn(f"geometries without a line are not read: {kinds_text(others)}")
    is_line &= ~shapely.is_empty(parts)
    parts, owner = parts[is_line], owner[is_line]
    points, line = shapely.get_coordinates(parts, include_z=True, return_index=True)
    points[~shapely.has_z(parts)[line], 2] = 0
    made = Lines.from_points(points, np.bincount(line, minlength=len(parts)), **how.options)
    return with_strand_values(made, {FEATURE: owner})


def _in_order(
    parts: AnyArray, owner: IntArray, replaced: AnyArray, inner: AnyArray, row: IntArray
) -> tuple[AnyArray, IntArray]:
    """Put what some geometries consist of in their places."""
    place = np.concatenate([np.flatnonzero(~replaced), np.flatnonzero(replaced)[row]])
    order = np.argsort(place, kind="stable")
    return np.concatenate([parts[~replaced], inner])[order], owner[place[order]]


def _of_frame(frame: Any, how: Making) -> Lines:
    """Make lines of a table, whose columns of numbers and texts become attributes."""
    geometry = frame.geometry
    made = _of_geometries(objects(geometry), how)
    feature = made.attributes[FEATURE]
    columns, left_out, radius = {}, [], None
    for name in frame.columns:
        if str(name) == geometry.name:
            continue
        values = _values(frame[name])
        if values is None:
            left_out.append(repr(str(name)))
        elif str(name) == "radius" and values.dtype.kind in "fiub":
            radius = values[feature]
        else:
            columns[str(name)] = values
    if left_out:
        how.warn(f"columns that hold neither numbers nor texts are not kept: {', '.join(left_out)}")
    made = with_strand_values(made, {name: _per_strand(made, values) for name, values in columns.items()})
    made = made if radius is None else made.with_radius(radius)
    return replace(made, **_facts(frame.crs))


def _per_strand(made: Lines, values: AnyArray) -> AnyArray:
    """Return a row for each strand, of values with a row for each feature."""
    rows = np.zeros(int(made.strands.max(initial=-1)) + 1, np.int64)
    rows[made.strands] = made.attributes[FEATURE]
    return np.asarray(values[rows])


def _values(column: Any) -> AnyArray | None:
    """Return a column of pandas as an array of numbers, times or texts; None if it holds something else."""
    values = np.asarray(column)
    if values.dtype.kind in "fiubmM":
        return values
    listed = values.astype(object).tolist()
    missing = np.asarray(column.isna()).tolist()
    return array_of([
        None if absent else value.item() if isinstance(value, np.generic) else value
        for value, absent in zip(listed, missing, strict=True)
    ])  # fmt: skip


def _facts(crs: Any) -> dict[str, Any]:
    """Return the unit of a reference system, if it is known, and the upward axis of maps."""
    axes = getattr(crs, "axis_info", ())
    return {"unit": MAP_UNITS.get(axes[0].unit_name) if axes else None, "up": "z"}
