"""Well-known text: the lines in texts such as ``LINESTRING (0 0, 1 1)``, as arrays of points.

Format: OGC 06-103r4, section 7 (https://www.ogc.org/standard/sfa/), and PostGIS's prefix ``SRID=4326;``.

All coordinates of a file are converted at once: the texts between parentheses are joined, and only joined text is
parsed.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from ...arrays import IntArray
from ..source import Source
from .number_text import Float64Array, parse_numbers

#: Types of geometry that hold lines, the parts of collections too.
LINES = ("LINESTRING", "MULTILINESTRING")
#: About how many characters are converted together.
_BATCH = 1 << 20
#: One line string alone, which most texts are.
_SIMPLE = re.compile(r"\s*(?:SRID=(\d+)\s*;\s*)?LINESTRING\s*(?:(ZM|Z|M)\s*)?\(([^()]*)\)\s*(?:;\s*)?", re.IGNORECASE)
#: The start of a geometry, of any type.
_TAG = re.compile(
    r"(?:SRID=(?P<srid>\d+)\s*;\s*)?\b(?P<type>[A-Z]{3,}?)\s*(?:(?P<dims>ZM|Z|M)\s*)?(?P<body>\(|\bEMPTY\b)",
    re.IGNORECASE,
)
#: What may stand between geometries.
_BETWEEN = re.compile(r"[\s,;()]*")
#: The points of a line string, and what follows them.
_PART = re.compile(r"\s*(?:\((?P<points>[^()]*)\)|EMPTY)\s*(?P<next>[,)]?)", re.IGNORECASE)
_KINDS = (
    r"(?:MULTI)?(?:POINT|LINESTRING|POLYGON|CURVE|SURFACE)|GEOMETRYCOLLECTION|LINEARRING|CIRCULARSTRING|COMPOUNDCURVE|"
    "CURVEPOLYGON|POLYHEDRALSURFACE|TIN|TRIANGLE"
)
#: The first words of a geometry of any type.
_WORDS = rf"\s*(?:SRID=\d+\s*;\s*)?(?:{_KINDS})\s*(?:(?:ZM|Z|M)\s*)?"
#: How a text with geometries may begin, of any type or of one that holds lines. A title such as "Point (m)" is none.
START = _WORDS + r"(?:\(\s*(?:[-+.\d()]|nan\b|inf|[A-Z]+\s*(?:(?:ZM|Z|M)\s*)?(?:\(|\bEMPTY\b)|EMPTY\b)|\bEMPTY\b)"
STARTS = re.compile(START, re.IGNORECASE)
BARE_START = re.compile(rf"{_WORDS}|\s*SRID=\d+\s*;\s*", re.IGNORECASE)
STARTS_LINES = re.compile(START.replace(_KINDS, "(?:MULTI)?LINESTRING|GEOMETRYCOLLECTION"), re.IGNORECASE)


@dataclass
class Wkt:
    """Line strings that are found in texts, not yet converted to numbers.

    Attributes
    ----------
    parts : list of str
        The text between the parentheses of each line string.
    dims : list of str
        What its third and fourth numbers are: ``""`` (by their count), ``"Z"``, ``"M"`` or ``"ZM"``.
    rows : list of int
        The row of each line string.
    features : list of int
        The geometry, counted over all texts, that each line string is or is in.
    srids : set of str
        The reference systems that are named.
    others : dict
        How many geometries of each other type there are.
    n_geometries : int
        How many geometries there are, those in collections not counted.
    """

    parts: list[str] = field(default_factory=list)
    dims: list[str] = field(default_factory=list)
    rows: list[int] = field(default_factory=list)
    features: list[int] = field(default_factory=list)
    srids: set[str] = field(default_factory=set)
    others: dict[str, int] = field(default_factory=dict)
    n_geometries: int = 0

    def add(self, text: str, row: int) -> str | None:
        """Find the line strings of a text; return what is wrong with it, if anything."""
        simple = _SIMPLE.fullmatch(text)
        if simple is not None:
            srid, dims, body = simple.groups()
            if srid:
                self.srids.add(srid)
            self.n_geometries += 1
            self._add(body, dims, row)
            return None
        return self._scan(text, row)

    def _add(self, body: str | None, dims: str | None, row: int) -> None:
        if body and not body.isspace():
            self.parts.append(body)
            self.dims.append((dims or "").upper())
            self.rows.append(row)
            self.features.append(self.n_geometries - 1)

    def _scan(self, text: str, row: int) -> str | None:
        """Find the line strings among geometries of any type, one after the other or in collections."""
        at, is_other, collection = 0, False, ""
        counted, depth = 0, 0  # the parentheses that are open after so many characters
        for tag in _TAG.finditer(text):
            if tag.start() < at:  # within the geometry before
                continue
            if not is_other and not _BETWEEN.fullmatch(text, at, tag.start()):
                return f"{text[at : at + 40]!r} is not a geometry"
            depth += text.count("(", counted, tag.start()) - text.count(")", counted, tag.start())
            counted = tag.start()
            self.n_geometries += depth == 0
            kind, dims = tag["type"].upper(), tag["dims"] or collection
            if tag["srid"]:
                self.srids.add(tag["srid"])
            at, is_other = tag.end(), False
            if kind == "GEOMETRYCOLLECTION":
                collection = tag["dims"] or ""
            elif kind not in LINES:
                self.others[kind] = self.others.get(kind, 0) + 1
                is_other = True  # whatever its parentheses hold
            elif tag["body"] == "(":
                # Take the parts of the geometry one by one, up to its last parenthesis.
                more = _PART.match(text, at - 1 if kind == "LINESTRING" else at)
                while more is not None:
                    self._add(more["points"], dims, row)
                    at = more.end()
                    if kind == "LINESTRING" or more["next"] == ")":
                        break
                    more = _PART.match(text, at)
                if more is None or (kind != "LINESTRING" and more["next"] != ")"):
                    return f"{text[tag.start() : tag.start() + 40]!r} does not end as it should"
        if at == 0 or (not is_other and not _BETWEEN.fullmatch(text, at)):
            return f"{text[at : at + 40]!r} is not a geometry"
        return None

    def numbers(self, source: Source) -> tuple[Float64Array, IntArray, Float64Array | None]:
        """Return the points (m, 3), the number of points of each line string, and m of each point, if any has it.

        The texts are converted in batches, and forgotten.
        """
        found = []
        first = n_letters = 0
        for i, text in enumerate(self.parts):
            n_letters += len(text)
            if n_letters > _BATCH or i == len(self.parts) - 1:
                found.append(self._batch(source, first, i + 1))
                self.parts[first : i + 1] = [""] * (i + 1 - first)
                source.advance(n_letters)
                first, n_letters = i + 1, 0
        points = np.concatenate([np.empty((0, 3)), *(batch[0] for batch in found)])
        counts = np.concatenate([np.empty(0, np.int64), *(batch[1] for batch in found)])
        m = np.concatenate([np.empty(0), *(batch[2] for batch in found)])
        return points, counts, None if np.isnan(m).all() else m

    def _batch(self, source: Source, first_part: int, end: int) -> tuple[Float64Array, IntArray, Float64Array]:
        """Convert some of the line strings; m is NaN where there is none."""
        parts = self.parts[first_part:end]
        text = ",".join(parts).encode("utf-8")
        counts = np.array([part.count(",") + 1 for part in parts], np.int64)

        # Count the numbers of each point: words start where a blank or a comma ends.
        letters = np.frombuffer(b"," + text + b",", np.uint8)
        is_comma = letters == ord(",")
        is_gap = is_comma | (letters <= ord(" "))
        starts = np.flatnonzero(is_gap[:-1] & ~is_gap[1:])
        first = np.searchsorted(starts, np.flatnonzero(is_comma))
        n_numbers = np.diff(first)
        first = first[:-1]
        part = np.repeat(np.arange(len(counts)), counts)
        expected = n_numbers[np.cumsum(counts) - counts][part]
        bad = np.flatnonzero((n_numbers != expected) | (n_numbers < 2) | (n_numbers > 4))
        values = _numbers(text)
        if len(bad) or values is None or len(values) != len(starts):
            wrong = (
                part[bad[0]]
                if len(bad)
                else next((i for i, text in enumerate(parts) if _numbers(text.encode()) is None), 0)
            )
            raise source.error(
                f"line {self.rows[first_part + wrong]}: {parts[wrong][:60]!r} is not a list of points; expected 2, 3 "
                "or 4 numbers each, equally many, and commas between points; fix it"
            )

        # Take z and m where they are.
        only_m = np.array([kind == "M" for kind in self.dims[first_part:end]])[part]
        points = np.zeros((len(part), 3))
        points[:, 0], points[:, 1] = values[first], values[first + 1]
        has_z = (n_numbers > 2) & ~only_m
        points[has_z, 2] = values[first[has_z] + 2]
        has_m = ((n_numbers == 3) & only_m) | (n_numbers == 4)
        m = np.full(len(part), np.nan)
        m[has_m] = values[(first + n_numbers)[has_m] - 1]
        return points, counts, m


def _numbers(text: bytes) -> Float64Array | None:
    """Return the numbers that blanks and commas separate; None if there is anything else."""
    return parse_numbers(text.replace(b",", b" "))
