"""GeoJSON (``.geojson``, ``.json``), also one feature a line (``.geojsonl``, ``.ndjson``).

Format: RFC 7946 (https://www.rfc-editor.org/rfc/rfc7946), RFC 8142 for sequences, and ``crs`` of GeoJSON 2008.

LineString and MultiLineString are read, in features and collections too; each line is a strand. The attribute
``feature`` counts the features of the file, and geometries outside of features. Properties of numbers, of truth values
or of texts become attributes of strands. Points, polygons and other properties are dropped, each with a warning.
Coordinates are longitude, latitude and height, and the unit is the degree, unless ``crs`` says otherwise. In float32, a
longitude of 180° is exact to 8e-6°, about 1 m.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray, is_text
from ...geometry.lines import Lines
from ...geometry.strand_attributes import FEATURE
from ...support.texts import kinds_text, printable
from ..losses import conventions, free_name, strand_numbers
from ..polylines import Polylines, polylines_of
from ..source import Source, reason
from .columns import kept_columns, radius_of, with_features

Float64Array = npt.NDArray[np.float64]

_LINES = ("LineString", "MultiLineString")
_OTHERS = ("Point", "MultiPoint", "Polygon", "MultiPolygon")
_COLLECTIONS = ("Feature", "FeatureCollection", "GeometryCollection")
#: The extensions of files that have a feature a line.
_ONE_A_LINE = (".geojsonl", ".ndjson")
#: Parts of the names of reference systems whose unit is the degree.
_DEGREES = (
    "CRS84",
    "CRS:84",
    "EPSG::4326",
    "EPSG:4326",
    "EPSG::4979",
    "EPSG::4258",
    "EPSG:4258",
    "EPSG::4269",
    "EPSG:4269",
)


def read(source: Source, invalid: str, *, radius: str | None = None) -> Lines:
    """Read the lines of features and geometries.

    Parameters
    ----------
    radius : str, optional
        The property that is the radius, in the unit of the coordinates.
    """
    found = _Found(source)
    for document in _documents(source):
        if not isinstance(document, dict) or document.get("type") not in (*_LINES, *_OTHERS, *_COLLECTIONS):
            what = f"an object of type {document.get('type')!r}" if isinstance(document, dict) else "no object"
            raise source.error(f"holds {what}; expected GeoJSON, such as a FeatureCollection")
        found.add(document)
    if found.others:
        source.warn(f"features and geometries without a line are not read: {kinds_text(found.others)}")
    if found.n_long:
        source.warn(f"{found.n_long} lines have more than 3 numbers a point; only 3 are read")

    # Spread the properties of features with lines over their strands.
    columns: dict[str, tuple[list[int], list[Any]]] = {}
    features, owner = np.unique(np.array(found.owner, np.int64), return_inverse=True)
    for row, feature in enumerate(features):
        for name, value in found.properties[feature].items():
            rows, values = columns.setdefault(printable(name), ([], []))
            rows.append(row)
            values.append(value)
    per_feature = kept_columns(source, columns, len(features), "properties")
    per_strand = {name: values[owner] for name, values in per_feature.items()}
    radii = radius_of(source, per_strand, radius, "property")
    points = np.concatenate([np.empty((0, 3)), *found.points])
    lines = Lines.from_points(points, [len(part) for part in found.points], offset=source.offset, invalid=invalid)
    return with_features(lines, found.owner, per_strand, found.unit, radii)


def _documents(source: Source) -> list[Any]:
    """Parse the file: one document, or one a line."""
    text = source.text()
    source.drop()
    try:
        try:
            return [_parse(text)]
        except json.JSONDecodeError as error:
            lines = [line for line in re.split("[\r\n]", text) if line.strip(" \t\x1e")]
            if not lines:
                raise
            try:
                return [_parse(line.strip(" \t\x1e")) for line in lines]
            except json.JSONDecodeError:
                raise error from None
    except json.JSONDecodeError as error:
        raise source.error(f"is not JSON: {error.msg} (line {error.lineno}, column {error.colno}); fix it") from None
    except (RecursionError, ValueError) as error:
        raise source.error(f"cannot be read as JSON: {reason(error)}; fix it") from None


def _parse(text: str) -> Any:
    return json.loads(text, object_hook=_as_arrays)


def _as_arrays(members: dict[str, Any]) -> dict[str, Any]:
    """Convert the coordinates of lines as soon as they are parsed, for lists of lists take much memory."""
    if "coordinates" not in members:
        return members
    match members.get("type"):
        case "LineString":
            members["coordinates"] = _points(members["coordinates"])
        case "MultiLineString" if isinstance(members["coordinates"], list):
            members["coordinates"] = [_points(part) for part in members["coordinates"]]
        case str() as kind if kind in _OTHERS:
            members.pop("coordinates", None)
    return members


def _points(given: Any) -> Float64Array | None:
    """Return the points of a line, (m, 2) or more; None if they are not lists of 2 or more numbers."""
    if not isinstance(given, list):
        return None
    if not given:
        return np.empty((0, 3))
    try:
        points = np.array(given)
    except (ValueError, OverflowError):  # positions of different lengths
        if not all(isinstance(point, list) and len(point) >= 2 for point in given):
            return None
        try:
            points = np.array([(*point[:3], 0)[:3] for point in given])
        except (ValueError, OverflowError):
            return None
    if points.ndim != 2 or points.shape[1] < 2 or points.dtype.kind not in "fiu":
        return None
    return points.astype(np.float64)


@dataclass
class _Found:
    """Lines and properties, as they are found."""

    source: Source
    points: list[Float64Array] = field(default_factory=list)
    owner: list[int] = field(default_factory=list)
    properties: list[dict[str, Any]] = field(default_factory=list)
    others: dict[str, int] = field(default_factory=dict)
    n_long: int = 0
    unit: str | None = "degree"

    def add(self, document: dict[str, Any]) -> None:
        """Find the lines of a document."""
        if "crs" in document:
            self._set_unit(document["crs"])
        waiting: list[tuple[Any, int | None]] = [(document, None)]
        while waiting:
            item, row = waiting.pop()
            kind = item.get("type") if isinstance(item, dict) else None
            if kind == "Feature":
                self.properties.append(_properties(item))
                waiting.append((item.get("geometry"), len(self.properties) - 1))
            elif kind in ("FeatureCollection", "GeometryCollection"):
                name = "features" if kind == "FeatureCollection" else "geometries"
                members = item.get(name)
                if not isinstance(members, list):
                    raise self.source.error(f"a {kind} in it has no list of {name}; fix it")
                waiting += [(member, row) for member in reversed(members)]
            elif kind in _LINES:
                self._add_lines(item, kind, row)
            else:
                if row is None:
                    self.properties.append({})
                name = kind if isinstance(kind, str) else "without a geometry" if item is None else "unknown"
                self.others[name] = self.others.get(name, 0) + 1

    def _add_lines(self, item: dict[str, Any], kind: str, row: int | None) -> None:
        parts = item.get("coordinates")
        parts = parts if kind == "MultiLineString" else [parts]
        if not isinstance(parts, list) or any(part is None for part in parts):
            raise self.source.error(
                f"line {len(self.points)} of it ({kind}) has coordinates that are not a list of points, each of 2 or 3 "
                "numbers; fix it"
            )
        if row is None:
            self.properties.append({})
            row = len(self.properties) - 1
        for part in parts:
            if not len(part):
                continue
            self.n_long += part.shape[1] > 3
            if part.shape[1] != 3:
                points = np.zeros((len(part), 3))
                points[:, : min(part.shape[1], 3)] = part[:, :3]
                part = points
            self.points.append(part)
            self.owner.append(row)

    def _set_unit(self, crs: Any) -> None:
        """Take the unit from the member crs, where null stands for an unknown one."""
        properties = crs.get("properties") if isinstance(crs, dict) else None
        name = properties.get("name") if isinstance(properties, dict) else None
        if crs is None:
            self.unit = None
        elif not (isinstance(name, str) and name.endswith(_DEGREES)):
            self.unit = None
            self.source.warn(
                f"its coordinates are in the reference system {name or crs!s:.80}, whose unit is not known here"
            )


def _properties(feature: dict[str, Any]) -> dict[str, Any]:
    """Return the properties of a feature, and its id."""
    given = feature.get("properties")
    properties = dict(given) if isinstance(given, dict) else {}
    if feature.get("id") is not None:
        properties.setdefault("id", feature["id"])
    return properties


# --- Writing ---


def write(lines: Lines, path: Path) -> list[str]:
    """Write a feature for each polyline, whose properties are its attributes; NaN is null.

    Polylines that follow one another and have the same attribute ``feature`` are one MultiLineString. Coordinates have
    as few digits as give the same float32 again, and no z where it is 0 everywhere. Without the unit degree,
    ``"crs": null`` says that they are not longitudes and latitudes. ``.geojsonl`` and ``.ndjson`` have one feature a
    line, and no place for ``crs``.
    """
    one_a_line = path.suffix in _ONE_A_LINE
    joined = polylines_of(lines)
    columns, lost = _columns(joined)
    firsts = _first_polylines(joined, columns)
    if FEATURE in joined.attributes:
        numbers = joined.attributes[FEATURE]
        if not np.array_equal(numbers, np.repeat(np.arange(len(firsts)), np.diff(firsts, append=len(numbers)))):
            lost.append("the numbers of features, which are counted from 0")
    lost += [f"{name!r} of each point" for name in joined.point_attributes]
    lost += strand_numbers(joined.strand)
    if lines.unit not in (None, "degree"):
        lost.append(f"the unit {lines.unit!r}")
    elif lines.unit is None and one_a_line and len(lines):
        lost.append("that the unit is not known (coordinates will be read as degrees)")
    lost += conventions(lines, lines.unit, "z")
    with path.open("w", encoding="utf-8", newline="\n") as file:
        if one_a_line and len(lines):
            file.writelines(f"{line}\n" for line in _features(joined, columns, firsts))
            return lost
        # Write an empty collection if there are no lines: an empty file could not be read.
        crs = "" if lines.unit == "degree" else '"crs": null, '
        file.write(f'{{"type": "FeatureCollection", {crs}"features": [')
        for i, line in enumerate(_features(joined, columns, firsts)):
            file.write(f"{',' if i else ''}\n{line}")
        file.write("]}\n" if one_a_line else "\n]}\n")
    return lost


def _first_polylines(joined: Polylines, columns: dict[str, list[str]]) -> IntArray:
    """Return the first polyline of each feature: where its number or any of its properties changes."""
    numbers = joined.attributes.get(FEATURE)
    if numbers is None or numbers.ndim != 1 or numbers.dtype.kind not in "iu":
        return np.arange(len(joined.counts))
    begins = np.append(True, (numbers[1:] != numbers[:-1]) | (numbers[1:] < 0))[: len(numbers)]
    for texts in columns.values():
        begins[1:] |= np.array([before != after for before, after in pairwise(texts)], np.bool_)
    return np.flatnonzero(begins)


def _columns(joined: Polylines) -> tuple[dict[str, list[str]], list[str]]:
    """Return the properties of polylines as JSON, and what has no place."""
    columns, lost = {}, list(joined.lost)
    taken = {*joined.attributes}
    for name, values in joined.attributes.items():
        if name == FEATURE and values.ndim == 1 and values.dtype.kind in "iu":
            continue
        if values.ndim == 1 and (values.dtype.kind in "fiub" or is_text(values)):
            columns[free_name(name, printable(name), taken, lost)] = _texts(values)
            if values.dtype.kind == "f" and np.isinf(values).any():
                lost.append(f"infinite values of {name!r}")
            if values.dtype.kind == "f" and len(values) and np.isnan(values).all():
                lost.append(f"{name!r}, which is NaN everywhere")
        else:
            lost.append(f"{name!r} ({values.dtype}, {values.ndim}-d)")
    if joined.radius is not None:
        first = joined.radius[joined.offsets[:-1]]
        if "radius" not in columns and (np.repeat(first, joined.counts) == joined.radius).all():
            columns["radius"] = _texts(first)
            lost.append("the radius, which is now a property (radius='radius' reads it as the radius)")
        else:
            lost.append("the radius, which differs along the lines")
    return columns, lost


def _texts(values: npt.NDArray[Any]) -> list[str]:
    """Return numbers as JSON, each with as few digits as its type needs, or texts."""
    if values.dtype.kind == "f":
        return [text if np.isfinite(value) else "null" for text, value in zip(values.astype(str), values, strict=True)]
    return [json.dumps(value) for value in values.tolist()]


def _features(joined: Polylines, columns: dict[str, list[str]], firsts: IntArray) -> Iterator[str]:
    """Yield the features as JSON."""
    flat = not (joined.points[:, 2].any() or np.signbit(joined.points[:, 2]).any())
    n_axes = 2 if flat else 3
    names = [json.dumps(name) for name in columns]
    starts = joined.offsets.tolist()
    for first, end in pairwise([*firsts.tolist(), len(joined.counts)]):
        parts = []
        for start, stop in pairwise(starts[first : end + 1]):
            texts = joined.points[start:stop, :n_axes].astype(str)
            points = ", ".join(f"[{', '.join(point)}]" for point in texts.tolist())
            parts.append(f"[{points}]")
        properties = ", ".join(f"{name}: {texts[first]}" for name, texts in zip(names, columns.values(), strict=True))
        kind, coordinates = ("LineString", parts[0]) if len(parts) == 1 else (_LINES[1], f"[{', '.join(parts)}]")
        yield (
            f'{{"type": "Feature", "properties": {{{properties}}}, '
            f'"geometry": {{"type": "{kind}", "coordinates": {coordinates}}}}}'
        )
