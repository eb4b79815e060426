"""Lines in the geometries of a table: GeoParquet, and columns of GeoArrow.

Formats: https://geoparquet.org/releases/v1.1.0/ and https://geoarrow.org/format.html. Geometries are WKB, or the lists
of coordinates that GeoArrow calls linestring and multilinestring. Each line is a strand; ``feature`` is its row. Other
columns of numbers and texts become attributes. Geometries without a line are dropped, with a warning.
"""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from ...arrays import AnyArray, IntArray
from ...geometry.lines import Lines
from ...geometry.map_features import MAP_UNITS
from ...geometry.strand_attributes import NO_TEXT, objects
from ...support.texts import kinds_text
from ..source import Source
from .columns import with_features
from .wkb import Float64Array, Wkb

GEO = b"geo"
_NAME, _ABOUT = b"ARROW:extension:name", b"ARROW:extension:metadata"
#: Encodings by what GeoParquet and GeoArrow call them.
_WKB = ("wkb", "geoarrow.wkb", "ogc.wkb")
_LISTS = {
    "linestring": 1, "geoarrow.linestring": 1, "multilinestring": 2, "geoarrow.multilinestring": 2,
}  # fmt: skip
_OTHERS = ("point", "polygon", "multipoint", "multipolygon")
#: The systems of longitudes and latitudes that need no description.
_DEGREES = ("EPSG:4326", "OGC:CRS84")


class Geometries:
    """The column of geometries of a schema.

    Attributes
    ----------
    name : str
        The column.
    encoding : str
        In lower case.
    hidden : set of str
        Columns with the boxes of geometries, of which nothing is lost.
    unit : str or None
    system : str or None
        What the reference system is called, if its unit is not known.
    """

    def __init__(self, schema: Any, name: str, encoding: str, facts: dict[str, Any]) -> None:
        self.name, self.encoding = name, encoding
        covering = facts.get("covering")
        boxes = covering.get("bbox") if isinstance(covering, dict) else None
        paths = boxes.values() if isinstance(boxes, dict) else ()
        self.hidden = {path[0] for path in paths if isinstance(path, list) and path and isinstance(path[0], str)}
        # By the specification, coordinates without a reference system are longitudes and latitudes.
        is_geo = GEO in (schema.metadata or {})
        crs = facts.get("crs")
        self.unit = _unit(crs) if "crs" in facts else "degree" if is_geo else None
        called = crs.get("name") if isinstance(crs, dict) else crs
        self.system = None if crs is None or self.unit else str(called)


def find_geometries(schema: Any) -> Geometries | None:
    """Return the column of geometries that a schema names; None if there is none."""
    facts = _object((schema.metadata or {}).get(GEO, b"{}"))
    columns = facts.get("columns")
    columns = columns if isinstance(columns, dict) else {}
    usual = ("geometry", "geom") if GEO in (schema.metadata or {}) else ()
    for name in (facts.get("primary_column"), *columns, *usual):
        if not isinstance(name, str) or name not in schema.names:
            continue
        about = columns.get(name)
        about = about if isinstance(about, dict) else {}
        encoding = str(about.get("encoding", "WKB")).lower()
        if encoding in (*_WKB, *_LISTS, *_OTHERS):
            return Geometries(schema, name, encoding, about)
    for field in schema:
        known = getattr(field.type, "extension_name", "") or (field.metadata or {}).get(_NAME, b"").decode("latin-1")
        if known in (*_WKB, *_LISTS):
            about = _object((field.metadata or {}).get(_ABOUT, b"{}"))
            return Geometries(schema, field.name, known, {"crs": about["crs"]} if "crs" in about else {})
    return None


def lines_of(
    source: Source, table: Any, geometries: Geometries, per_row: dict[str, AnyArray], texts: list[str], invalid: str
) -> Lines:
    """Return the lines of a table's geometries.

    Parameters
    ----------
    per_row : dict of str to array
        The columns of numbers.
    texts : list of str
        The columns of texts.
    """
    column = table.column(geometries.name)
    if isinstance(column.type, pa.BaseExtensionType):
        column = pa.chunked_array([chunk.storage for chunk in column.chunks], column.type.storage_type)
    others = {"without a geometry": column.null_count} if column.null_count else {}
    if geometries.encoding in _WKB:
        points, counts, m, rows, found = _of_wkb(source, geometries.name, column)
        others |= found
    elif geometries.encoding in _LISTS:
        points, counts, m, rows = _of_lists(source, geometries, column)
    else:
        points, counts, m, rows = np.empty((0, 3)), np.empty(0, np.int64), None, np.empty(0, np.int64)
        others[geometries.encoding.upper()] = len(column) - column.null_count
    if others:
        source.warn(f"rows and geometries without a line are not read: {kinds_text(others)}")
    if geometries.system is not None:
        source.warn(
            f"its coordinates are in the reference system {geometries.system:.80}, whose unit is not known here"
        )
    values = {name: array[rows] for name, array in per_row.items()}
    values |= {name: _texts(table.column(name), rows) for name in texts}
    radius = None
    if "radius" in values and values["radius"].ndim == 1 and values["radius"].dtype != object:
        radius = source.radius("radius", values.pop("radius"))
    attributes = {} if m is None else {"m": m}
    lines = Lines.from_points(points, counts, attributes=attributes, offset=source.offset, invalid=invalid)
    return replace(with_features(lines, rows, values, geometries.unit, radius), up="z")


def _of_wkb(
    source: Source, name: str, column: Any
) -> tuple[Float64Array, IntArray, Float64Array | None, IntArray, dict[str, int]]:
    if pa.types.is_dictionary(column.type):
        # Small dictionaries could stand for far more bytes than the file has.
        sizes = (pc.take(pc.binary_length(chunk.dictionary), chunk.indices) for chunk in column.chunks)
        source.check_unpacked(sum(pc.sum(size).as_py() or 0 for size in sizes))
        column = column.cast(column.type.value_type)
    if not (pa.types.is_binary(column.type) or pa.types.is_large_binary(column.type)):
        raise source.error(f"the column {name!r} is of type {column.type}; expected WKB, which is binary")
    wkb, row = Wkb(), 0
    for chunk in column.chunks:
        for data in chunk:
            if data.is_valid:
                try:
                    wkb.add(data.as_py(), row)
                except ValueError as error:
                    raise source.error(f"row {row}: the column {name!r} holds no WKB: {error}; fix it") from None
            row += 1
        source.advance(chunk.nbytes)
    points, counts, m = wkb.arrays()
    return points, counts, m, np.array(wkb.rows, np.int64), wkb.others


def _of_lists(
    source: Source, geometries: Geometries, column: Any
) -> tuple[Float64Array, IntArray, Float64Array | None, IntArray]:
    """Return the lines in lists of coordinates, which are structs or lists of fixed size."""
    array = pa.concat_arrays(column.chunks) if column.num_chunks != 1 else column.chunk(0)
    rows = np.arange(len(array))
    owners = counts = np.zeros(0, np.int64)
    for _ in range(_LISTS[geometries.encoding]):
        if not (pa.types.is_list(array.type) or pa.types.is_large_list(array.type)):
            raise source.error(f"the column {geometries.name!r} is of type {column.type}; expected lists of points")
        counts = np.asarray(pc.fill_null(pc.list_value_length(array), 0), np.int64)
        owners, rows, array = rows, np.repeat(rows, counts), array.flatten()
    axes: dict[str, AnyArray] = {}
    if pa.types.is_struct(array.type):
        axes = {field.name: np.asarray(array.field(field.name), np.float64) for field in array.type}
    elif pa.types.is_fixed_size_list(array.type):
        width = array.type.list_size
        names = array.type.value_field.name if set(array.type.value_field.name) <= set("xyzm") else "xyzm"[:width]
        table = np.asarray(array.flatten(), np.float64).reshape(-1, width)
        axes = dict(zip(names, table.T, strict=False))
    if not {"x", "y"} <= axes.keys():
        raise source.error(f"the column {geometries.name!r} is of type {column.type}; expected points of x and y")
    points = np.stack([axes["x"], axes["y"], axes.get("z", np.zeros(len(axes["x"])))], axis=1)
    # Lines without z have NaN there beside lines with z.
    line = np.repeat(np.arange(len(counts)), counts)
    n_known = np.bincount(line, ~np.isnan(points[:, 2]), len(counts))
    points[n_known[line] == 0, 2] = 0
    return points, counts, axes.get("m"), owners


def _texts(column: Any, rows: IntArray) -> AnyArray:
    """Return some rows of a column of texts; equal texts are one object."""
    column = column if pa.types.is_dictionary(column.type) else column.dictionary_encode()
    values: list[AnyArray] = [objects([])]
    for chunk in column.chunks:
        words = objects([*(NO_TEXT if word is None else word for word in chunk.dictionary.to_pylist()), NO_TEXT])
        values.append(words[np.asarray(pc.fill_null(chunk.indices, len(words) - 1), np.int64)])
    return np.asarray(np.concatenate(values)[rows])


def _object(text: bytes) -> dict[str, Any]:
    """Return an object in JSON, such as what a schema says of geometries; an empty one if it is none."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _unit(crs: Any) -> str | None:
    """Return the unit of the first axis of a reference system in PROJJSON, or of one by its name."""
    if isinstance(crs, str) and crs.upper() in _DEGREES:
        return "degree"
    system = crs.get("coordinate_system") if isinstance(crs, dict) else None
    axes = system.get("axis") if isinstance(system, dict) else None
    unit = axes[0].get("unit") if isinstance(axes, list) and axes and isinstance(axes[0], dict) else None
    if isinstance(unit, dict):
        unit = unit.get("name")
    identity = crs.get("id") if isinstance(crs, dict) else None
    if unit is None and isinstance(identity, dict) and str(identity.get("code")) in ("4326", "CRS84"):
        return "degree"
    return MAP_UNITS.get(unit) if isinstance(unit, str) else None
