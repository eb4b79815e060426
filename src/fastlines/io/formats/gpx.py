"""GPX (``.gpx``): tracks and routes of satellite receivers.

Format: https://www.topografix.com/GPX/1/1/, versions 1.0 and 1.1.

Each segment of a track, and each route, is a strand. x is the longitude and y the latitude, in degrees of WGS 84; z is
the elevation in **metres**, 0 where there is none. Attributes of points are ``time``, in seconds since 1970-01-01 UTC,
and every other element of a point that holds a number, those of extensions too, such as ``hr``; NaN where missing. The
attribute ``feature`` counts the tracks and routes of the file together, in its order; ``track`` counts the tracks
alone, -1 for routes. The texts and numbers of tracks and routes, such as ``name``, are attributes too. An element of
points by one of these names becomes ``… of points``. Waypoints and texts of points are dropped, each with a warning.

Files with a document type are refused, for entities could make them grow without limit.
"""

from __future__ import annotations

from array import array
from datetime import UTC, datetime
from typing import Any
from xml.parsers import expat

import numpy as np

from ...arrays import AnyArray
from ...errors import FileFormatError
from ...geometry.lines import Lines
from ...geometry.strand_attributes import FEATURE, with_strand_values
from ...support.texts import printable
from ..source import Source, reason
from .columns import column_of, kept_columns, quoted, with_features

_POINTS = {"trkpt": "trkseg", "rtept": "rte"}
#: The attribute that counts tracks.
TRACK = "track"
#: The elements that are features, and those in them that have no text of their own.
_FEATURES = ("trk", "rte")
_WITHOUT_TEXT = ("trkseg", "rtept", "link", "extensions")
#: Bytes that are parsed at a time.
_BLOCK = 1 << 20


def read(source: Source, invalid: str, *, elevation: bool = True) -> Lines:
    """Read the tracks and routes of a ``.gpx`` file.

    Parameters
    ----------
    elevation : bool
        Whether z is the elevation, in metres beside degrees. Otherwise z is 0, and the elevation is an attribute.
    """
    reader = _Reader(source)
    reader.parse()
    if reader.n_waypoints:
        source.warn(f"{reader.n_waypoints} waypoints are not read")
    if reader.texts:
        source.warn(f"texts of points are not kept: {quoted(sorted(reader.texts))}")
    if reader.n_bad_times:
        source.warn(f"{reader.n_bad_times} times of points are not dates, and become NaN")

    points = np.zeros((len(reader.longitudes), 3))
    points[:, 0], points[:, 1] = reader.longitudes, reader.latitudes
    attributes = kept_columns(source, reader.columns, len(points), "elements of points")
    heights = attributes.get("ele")
    if elevation and heights is not None:
        del attributes["ele"]
        points[:, 2] = np.where(np.isnan(heights), 0, heights)
        if points[:, 2].any():
            source.warn("z is in metres and x and y are in degrees; elevation=False leaves z at 0")
    tracks, texts = {TRACK: np.array(reader.tracks, np.int64)}, reader.texts_of_strands()
    taken = {FEATURE, TRACK, *texts}
    attributes = {f"{name} of points" if name in taken else name: values for name, values in attributes.items()}
    lines = Lines.from_points(points, reader.counts, attributes=attributes, offset=source.offset, invalid=invalid)
    return with_strand_values(with_features(lines, reader.features, tracks, "degree"), texts)


class _Reader:
    """Handlers for the elements of a file, and what they find."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.longitudes = array("d")
        self.latitudes = array("d")
        self.counts: list[int] = []
        self.tracks: list[int] = []
        self.features: list[int] = []
        self.properties: list[dict[str, str]] = []
        self.columns: dict[str, tuple[array[int], array[float]]] = {}
        self.texts: set[str] = set()
        self.n_waypoints = self.n_bad_times = 0
        self._track = -1
        self._path: list[str] = []
        #: The elements that are open inside of the current point; -1 outside of points.
        self._inside = -1
        self._text: list[str] = []
        self._parser = expat.ParserCreate()
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.StartDoctypeDeclHandler = self._refuse

    def parse(self) -> None:
        """Parse the whole file."""
        data = self.source.data
        try:
            for start in range(0, len(data), _BLOCK):
                self._parser.Parse(data[start : start + _BLOCK], start + _BLOCK >= len(data))
                self.source.advance(_BLOCK)
        except FileFormatError:
            raise
        except expat.ExpatError as error:
            raise self.source.error(f"is not complete XML: {reason(error)}; fix it, or get a fresh copy") from None
        except (LookupError, ValueError) as error:  # an encoding that Python does not know
            raise self.source.error(f"cannot be read as XML: {reason(error)}; write it again as UTF-8") from None

    def _refuse(self, *_: Any) -> None:
        raise self.source.error("has a document type (DOCTYPE), which GPX does not need; remove it")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if self._inside >= 0:
            self._inside += 1
            self._text = []
            return
        name = tag.rpartition(":")[2]
        if not self._path and name != "gpx":
            raise self.source.error(f"its root is <{name[:40]}>; expected <gpx>")
        self._path.append(name)
        if name in _POINTS and self._path[-2] == _POINTS[name] and self.counts:
            self._inside = 0
            self._add(attributes)
            self._parser.CharacterDataHandler = self._text_handler
        elif name in _FEATURES and len(self._path) == 2:
            self.properties.append({})
            self._track += name == "trk"
            if name == "rte":
                self._begin(-1)
        elif name == "trkseg" and self._path[-2] == "trk":
            self._begin(self._track)
        elif name == "wpt":
            self.n_waypoints += 1
        elif self._is_property():
            self._text = []
            self._parser.CharacterDataHandler = self._text_handler

    def _begin(self, track: int) -> None:
        """Begin a strand."""
        self.counts.append(0)
        self.tracks.append(track)
        self.features.append(len(self.properties) - 1)

    def _is_property(self) -> bool:
        """Whether the element that is open has a text about a track or a route."""
        is_direct = len(self._path) == 3 and self._path[-2] in _FEATURES
        return is_direct and bool(self.properties) and self._path[-1] not in _WITHOUT_TEXT

    def _add(self, attributes: dict[str, str]) -> None:
        """Add a point."""
        try:
            longitude, latitude = float(attributes["lon"]), float(attributes["lat"])
        except (KeyError, ValueError):
            line = self._parser.CurrentLineNumber
            raise self.source.error(f"line {line}: a point has no lon and lat that are numbers; fix it") from None
        self.longitudes.append(longitude)
        self.latitudes.append(latitude)
        self.counts[-1] += 1

    def _text_handler(self, text: str) -> None:
        self._text.append(text)

    def _end(self, tag: str) -> None:
        if self._inside <= 0:
            if self._inside < 0 and self._is_property() and (text := "".join(self._text).strip()):
                self.properties[-1].setdefault(self._path[-1], text)
            self._path.pop()
            self._inside = -1
            self._parser.CharacterDataHandler = None
            return
        self._inside -= 1
        text = "".join(self._text).strip()
        self._text = []
        if text:
            self._keep(tag.rpartition(":")[2], text, self._inside == 0)

    def _keep(self, name: str, text: str, is_own: bool) -> None:
        """Keep the text of an element of the current point, if it is a number, or the time of the point itself."""
        if not is_own and name in ("ele", "time"):
            name = f"{name} of extension"
        is_time = name == "time"
        try:
            value = _seconds(text) if is_time else float(text)
        except (ValueError, OverflowError):
            if is_time:
                self.n_bad_times += 1
            else:
                self.texts.add(name)
            return
        rows, values = self.columns.get(name) or self.columns.setdefault(name, (array("q"), array("d")))
        rows.append(len(self.longitudes) - 1)
        values.append(value)

    def texts_of_strands(self) -> dict[str, AnyArray]:
        """Return what the texts of tracks and routes say, a row for each strand; numbers where all of them are."""
        found: dict[str, tuple[list[int], list[str]]] = {}
        for row, feature in enumerate(self.features):
            for name, text in self.properties[feature].items():
                rows, texts = found.setdefault(printable(name), ([], []))
                rows.append(row)
                texts.append(text)
        columns = {name: (rows, column_of(texts)) for name, (rows, texts) in found.items()}
        return kept_columns(self.source, columns, len(self.features), "elements of tracks")


def _seconds(text: str) -> float:
    """Return a time as seconds since 1970; without a time zone it is UTC.

    Examples
    --------
    >>> _seconds("1970-01-02T00:00:00.5Z"), _seconds("1970-01-01T01:00:00+01:00"), _seconds("1970-01-01 00:00:01")
    (86400.5, 0.0, 1.0)
    """
    time = datetime.fromisoformat(text)
    return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()
