"""Tables with a column of well-known text (``.csv``, ``.tsv``), and well-known text alone (``.wkt``).

Formats: RFC 4180 for tables, and OGC 06-103r4 for well-known text; `wkt_text` reads the latter.

LINESTRING and MULTILINESTRING are read, in collections too, with z and m. Each line string is a strand; m is an
attribute of each point. The attribute ``feature`` counts the rows of the table below its names, blank lines left out,
or the geometries of plain text, one in a collection not counted. Columns of numbers, of truth values or of texts become
attributes of strands. Other geometries are dropped with a warning, and so are words that stand for none, such as NULL.
In a table with a single column, lines need no quotes.
"""

from __future__ import annotations

import csv
import io
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ...geometry.lines import Lines
from ...support.texts import kinds_text, printable
from ..source import Source, reason
from .columns import MISSING, column_of, kept_columns, quoted, radius_of, with_features
from .wkt_text import BARE_START, START, STARTS, STARTS_LINES, Wkt

#: Names of a column of geometries, in lower case, the usual ones first.
NAMES = ("geometry", "wkt", "geom", "the_geom", "wkt_geom", "shape", "geography", "linestring")
DELIMITERS = ",;\t|"
#: What no text holds: the delimiter of tables with one column.
_NO_DELIMITER = "\x1f"
#: Reference systems whose unit is the degree: WGS 84 and those of North America and Europe like it.
DEGREES = frozenset(("4326", "4269", "4258", "4979"))
#: The largest limit on fields that the csv module takes everywhere: it is a C long, which has 32 bits on Windows.
_MAX_FIELD = 2**31 - 1
#: Guards the two numbers below.
_LOCK = threading.Lock()
#: The limit of the csv module on fields is global: how many readers need none, and what it was before them.
_n_readers, _limit = 0, 0

#: Comments, and lines for geometries that are missing.
_COMMENTS = re.compile(r"(?:\s*+(?:#[^\n]*+|(?:NULL|None|N/?A|NaN|EMPTY)[ \t\r]*+)\n)*+", re.IGNORECASE)
_QUOTED_START = re.compile(rf"(['\"]){START}", re.IGNORECASE)
_QUOTED = re.compile(r"\s*(['\"])(.*)\1\s*")
_ENDS = re.compile(r"(?:\)|\bEMPTY)\s*+(?:;\s*+)?$", re.IGNORECASE)
_BINARY = re.compile(r"\s*(?:\\x)?0[01](?:[0-9A-F]{2}){8,}\s*", re.IGNORECASE)


def read(source: Source, invalid: str, *, column: str | None = None, radius: str | None = None) -> Lines:
    """Read the lines of a table, or of plain text.

    The unit is ``"degree"`` if the texts name a reference system of longitudes and latitudes (``SRID=4326;``).

    Parameters
    ----------
    column : str, optional
        The column of the lines. By default it is named geometry, wkt, geom, the_geom, shape or alike, in either case,
        or is the first that begins with a line, or else with another geometry.
    radius : str, optional
        The column of the radius, in the unit of the coordinates.
    """
    text = source.text()
    start = _COMMENTS.match(text).end()  # type: ignore[union-attr]  # it matches everywhere
    if column is None and STARTS.match(text, start) and not _is_table(text, start):
        return _plain(source, text, invalid, radius)
    quoted = _QUOTED_START.search(text)
    quote = (quoted and quoted[1]) or '"'
    head = text[: 1 << 16].lstrip()
    delimiter = max(DELIMITERS, key=lambda mark: _score(head, mark, quote))
    if _score(head, delimiter, quote)[1] == 1:  # lines need no quotes in a single column
        delimiter = _NO_DELIMITER
    del text, quoted  # which hold a copy of the file
    names, rows = _table(source, delimiter, quote)
    at = _geometry_column(source, names, rows, column)

    # Find the line strings of each row.
    wkt, empty, long = Wkt(), 0, 0
    for line, row in rows:
        found = row[at] if at < len(row) else ""
        long += len(row) > len(names)
        if _is_missing(found):
            empty += 1
            continue
        if _BINARY.fullmatch(found):
            raise source.error(
                f"line {line}: the column {names[at]!r} holds binary geometries (WKB); write them as text, by ST_AsText"
            )
        wrong = wkt.add(found, line)
        if wrong is not None:
            raise source.error(f"line {line}: {wrong}; expected a LINESTRING or another geometry, in quotes")
        row[at] = ""  # it is no longer needed
    if long:
        source.warn(f"{long} rows have more fields than the {len(names)} of the header; the last are not read")
    return _lines(source, wkt, names, at, rows, empty, invalid, radius)


def _lines(
    source: Source,
    wkt: Wkt,
    names: list[str],
    at: int,
    rows: list[tuple[int, list[str]]],
    n_empty: int,
    invalid: str,
    radius: str | None,
) -> Lines:
    """Convert the line strings, and the columns beside them."""
    without = {"without a geometry": n_empty} if n_empty else {}
    if without or wkt.others:
        source.warn(f"rows and geometries without a line are not read: {kinds_text({**without, **wkt.others})}")
    points, counts, m = wkt.numbers(source)
    row_of = {line: (number, row) for number, (line, row) in enumerate(rows)}
    features, owners = [row_of[line][0] for line in wkt.rows], [row_of[line][1] for line in wkt.rows]
    table = {
        name: (range(len(owners)), column_of([row[i] if i < len(row) else "" for row in owners]))
        for i, name in enumerate(names)
        if i != at and owners
    }
    lines_too = [name for name, (_, words) in table.items() if any(map(_is_line, words))]
    if lines_too:
        source.warn(f"other columns of lines are not read (column= names the one to read): {quoted(sorted(lines_too))}")
    table = {name: column for name, column in table.items() if name not in lines_too}
    per_strand = kept_columns(source, table, len(owners), "columns")
    radii = radius_of(source, per_strand, radius, "column")
    attributes = {} if m is None else {"m": m}
    lines = Lines.from_points(points, counts, attributes=attributes, offset=source.offset, invalid=invalid)
    unit = "degree" if wkt.srids and wkt.srids <= DEGREES else None
    return with_features(lines, features if names else wkt.features, per_strand, unit, radii)


def _is_missing(text: str) -> bool:
    return text.strip().lower() in (*MISSING, "empty")


def _is_line(word: object) -> bool:
    return isinstance(word, str) and STARTS.match(word) is not None


def _is_table(text: str, start: int) -> bool:
    """Return whether text that begins with a geometry has other columns too."""
    first = text[start : start + (1 << 16)].lstrip().partition("\n")[0]
    return first.count("(") == first.count(")") and not (_ENDS.search(first) or BARE_START.fullmatch(first))


def _plain(source: Source, text: str, invalid: str, radius: str | None) -> Lines:
    """Read geometries one after the other: one a line, or over several lines."""
    source.drop()
    lines = [(i, line) for i, line in enumerate(text.splitlines(), start=1) if line.strip() and line[0] != "#"]
    if any(line.count("(") != line.count(")") or BARE_START.fullmatch(line) for _, line in lines):
        lines = [(1, "\n".join(line for _, line in lines))]
    wkt, empty = Wkt(), 0
    for number, line in lines:
        if _is_missing(line):
            empty += 1
            wkt.n_geometries += 1
            continue
        quoted = _QUOTED.fullmatch(line)
        wrong = wkt.add(quoted[2] if quoted else line, number)
        if wrong is not None:
            raise source.error(f"line {number}: {wrong}; expected a LINESTRING or another geometry")
    return _lines(source, wkt, [], -1, [(number, []) for number, _ in lines], empty, invalid, radius)


# --- Tables ---


def _table(source: Source, delimiter: str, quote: str) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return the names of the columns, and the rows with the number of the line that each ends at."""
    try:
        with _long_fields():
            rows = list(_rows(source, delimiter, quote))
    except csv.Error as error:
        raise source.error(f"is not a table that can be read ({reason(error)}); write it again as CSV") from None
    if not rows:
        raise source.error("holds only blank lines; expected a row of names, and a row for each line")
    if any(STARTS.match(word) for word in rows[0][1]):  # without a row of names
        names = [f"column {i}" for i in range(1, len(rows[0][1]) + 1)]
        return names, rows
    distinct: dict[str, None] = {}
    for i, word in enumerate(rows[0][1], start=1):
        name = printable(word.strip()) or f"column {i}"
        while name in distinct:
            name += f" {i}"
        distinct[name] = None
    return list(distinct), rows[1:]


@contextmanager
def _long_fields() -> Iterator[None]:
    """Let the csv module read fields of any length, in several threads."""
    global _n_readers, _limit
    with _LOCK:
        if _n_readers == 0:
            _limit = csv.field_size_limit(_MAX_FIELD)
        _n_readers += 1
    try:
        yield
    finally:
        with _LOCK:
            _n_readers -= 1
            if _n_readers == 0:
                csv.field_size_limit(_limit)


def _rows(source: Source, delimiter: str, quote: str) -> Iterator[tuple[int, list[str]]]:
    text = io.TextIOWrapper(io.BytesIO(source.data), source.encoding, newline="")
    reader = csv.reader(text, delimiter=delimiter, quotechar=quote, skipinitialspace=True)
    for row in reader:
        if any(word.strip() for word in row):
            yield reader.line_num, row


def _score(head: str, delimiter: str, quote: str) -> tuple[bool, int]:
    """Rate a delimiter by the first row: whether it sets a known name apart, and how many fields there are."""
    try:
        row = next(csv.reader(io.StringIO(head, newline=""), delimiter=delimiter, quotechar=quote), [])
    except csv.Error:
        return False, 0
    return any(word.strip().lower() in NAMES or STARTS.match(word) for word in row), len(row)


def _geometry_column(source: Source, names: list[str], rows: list[tuple[int, list[str]]], column: str | None) -> int:
    """Return which column holds the lines."""
    lower = [name.lower() for name in names]
    if column is not None:
        if column in names:
            return names.index(column)
        if str(column).lower() in lower:
            return lower.index(str(column).lower())
        raise source.error(f"has no column {column!r}; its columns are {', '.join(map(repr, names))}")
    for name in NAMES:
        if name in lower:
            return lower.index(name)
    for starts in (STARTS_LINES, STARTS):
        for _, row in rows[:100]:
            for i, word in enumerate(row[: len(names)]):
                if starts.match(word):
                    return i
    raise source.error(
        f"has no column of lines (named {', '.join(NAMES[:4])} …, or with LINESTRING in it); its columns are "
        f"{', '.join(map(repr, names[:20]))}; name it with column=, or read columns of x, y and z by NumPy and pass "
        "them to Lines.from_points"
    )
