"""MRtrix track files (``.tck``): streamlines as triples of floats, in world millimetres (RASMM).

Format: https://mrtrix.readthedocs.io/en/latest/getting_started/image_data.html#tracks-file-format-tck. A header of
``key: value`` lines is closed by END and names the type of the data and the byte at which they start. A triple of NaN
ends each streamline, one of Inf the file.

Headers in the wild repeat keys or END, and have wrong counts or outdated offsets. The triple of Inf proves that a file
is whole, and the place and type of its data. Data that are proved are read, with a warning of each oddity.

Files are written as Float32LE. The format holds nothing but points.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...geometry.lines import Lines
from ..losses import conventions, strand_numbers
from ..polylines import polylines_of
from ..segment_collector import NO_STRANDS, Strands, lines_of, offset_for
from ..source import BAD_COPY, Source
from .streamlines import UNIT, UP

MAGIC = b"mrtrix tracks"
_TYPES = {"float32le": "<f4", "float32be": ">f4", "float64le": "<f8", "float64be": ">f8"}
_TYPE_NAMES = "Float32LE, Float32BE, Float64LE or Float64BE"

_END = re.compile(rb"\n[ \t\r]*END[ \t\r]*\n")
#: The longest beginning that can be text: it ends at a control character.
_TEXT = re.compile(rb"[^\0-\x08\x0b\x0e-\x1f\x7f]*")
#: How many bytes are searched for the end of the header; more are searched only if all of these are text.
_FIRST_BYTES = 1 << 20


def read(source: Source, invalid: str) -> Lines:
    """Read a ``.tck`` file, in RASMM and without attributes; streamlines without points count as strands."""
    return next(read_chunks(source, None, invalid))


def read_chunks(source: Source, max_segments: int | None, invalid: str) -> Iterator[Lines]:
    """Read a ``.tck`` file in chunks."""
    start_of_file = source.start(len(MAGIC))
    if start_of_file != MAGIC:
        raise source.error(f"starts with {start_of_file!r}, a .tck file with {MAGIC!r}; check the extension")
    fields, start, is_guess = _header(source)
    type_name = _type(source, fields)
    is_guess |= "datatype" not in fields
    dtype = np.dtype(_TYPES[type_name.lower()])
    streamlines = _Streamlines(source, start, dtype)

    def parts() -> Iterator[Strands]:
        n_found = n_empty = 0
        for points, counts in streamlines:
            yield Strands(points, counts, {}, {})
            n_found += len(counts)
            n_empty += int(np.count_nonzero(counts == 0))
        _check_end(source, start, type_name, is_guess, streamlines)
        _check_count(source, fields.get("count", []), n_found, n_empty, streamlines)

    offset = offset_for(source.offset, (points for points, _ in streamlines))
    like = Strands(np.empty((0, 3), dtype), NO_STRANDS, {}, {})
    yield from lines_of(parts(), like, source.size // (3 * dtype.itemsize), offset, {}, max_segments, invalid)


def write(lines: Lines, path: Path) -> list[str]:
    """Write the points to a ``.tck`` file, in Float32LE; in Float64LE if the lines have an offset."""
    parts = polylines_of(lines)
    size = parts.points.dtype.itemsize
    head = f"mrtrix tracks\ncount: {len(parts.counts)}\ndatatype: Float{8 * size}LE\nfile: . {{}}\nEND\n"
    start = -(-len(head.format("0" * 4)) // size) * size  # data of so many bytes each start at a multiple of it
    is_point = np.ones(len(parts.points) + len(parts.counts) + 1, np.bool_)
    ends = parts.offsets[1:] + np.arange(len(parts.counts))
    is_point[ends] = is_point[-1] = False
    triples = np.empty((len(is_point), 3), f"<f{size}")
    triples[is_point], triples[ends], triples[-1] = parts.points, np.nan, np.inf
    with path.open("wb") as file:
        file.write(head.format(start).encode().ljust(start, b"\0"))
        file.write(triples.data)
    names = ["radius"] * (lines.radius is not None) + [repr(name) for name in lines.attributes]
    return names + strand_numbers(parts.strand) + conventions(lines, UNIT, UP)


def _header(source: Source) -> tuple[dict[str, list[str]], int, bool]:
    """Return the header's fields, where the data start, and whether that is a guess."""
    # Find the end of the header: END, or else the end of the text.
    data = source.start(_FIRST_BYTES)
    end = _END.search(data)
    if end is None and len(data) == _FIRST_BYTES == _text_end(data):
        data = source.data
        end = _END.search(data)
    stop = end.end() if end else _text_end(data)
    fields: dict[str, list[str]] = {}
    _add_fields(fields, data[:stop])
    places = [place.split() for place in fields.get("file", [])]
    elsewhere = [place[0] for place in places if place and place[0] != "."]
    if elsewhere:
        raise source.error(f"its data are in another file, {elsewhere[0][:80]!r}; expected '.', the file itself")

    # Trust a single start that is in the file after the header.
    starts = {int(place[1]) for place in places if len(place) > 1 and re.fullmatch("[0-9]{1,18}", place[1])}
    start = starts.pop() if len(starts) == 1 else -1
    if end is None:
        if not 0 < start <= stop:
            raise source.error(f"its header has no line END; {BAD_COPY}")
        source.warn(f"its header has no line END; its data are read from byte {start} on, as it says")
        return fields, start, True
    # Accept only padding, and more of a header, between the header and the data.
    data = data if start <= len(data) else source.start(min(start, source.size))
    between = data[stop:start].strip(b"\0\t\r\n ") if start >= stop else b""
    if not stop <= start <= source.size or _text_end(between) < len(between):
        given = ", ".join(" ".join(place)[:40] for place in places) or "missing"
        source.warn(f"where its data start ('file') is {given}; they are read from behind its header, byte {stop}")
        return fields, stop, True
    if between:
        source.warn("its header continues after END; that text is read as a part of it")
        _add_fields(fields, between)
    return fields, start, False


def _add_fields(fields: dict[str, list[str]], text: bytes) -> None:
    """Add the ``key: value`` lines of a text by their keys in lower case; skip comments and other lines."""
    for line in text.decode("utf-8", "replace").split("\n"):
        key, colon, value = line.partition("#")[0].partition(":")
        if colon:
            fields.setdefault(key.strip().lower(), []).append(value.strip())


def _text_end(data: bytes) -> int:
    match = _TEXT.match(data)
    return match.end() if match else 0


def _type(source: Source, fields: dict[str, list[str]]) -> str:
    """Return the type that the header names; Float32LE, with a warning, if it names none."""
    names = fields.get("datatype", [])
    if not names:
        source.warn("its header names no type ('datatype'); its data are read as Float32LE")
        return "Float32LE"
    if names[0].lower() not in _TYPES or len({name.lower() for name in names}) > 1:
        raise source.error(f"its type ('datatype') is {', '.join(names)[:80]!r}; expected {_TYPE_NAMES}; convert it")
    return names[0]


class _Streamlines:
    """Iterates over streamlines, several at a time: their points, (m, 3), and numbers of points, (k,) int64.

    Once all are read, `is_whole` says whether three Inf end them, `is_open` whether the last one lacks its NaN, and
    `n_left` how many bytes follow.
    """

    def __init__(self, source: Source, start: int, dtype: np.dtype[Any]) -> None:
        self.source, self.start, self.dtype = source, start, dtype
        self.is_whole = self.is_open = False
        self.n_left = 0

    def __iter__(self) -> Iterator[tuple[npt.NDArray[np.floating], IntArray]]:
        self.is_whole, self.n_left = False, 0
        size, rest = 3 * self.dtype.itemsize, b""
        waiting: list[npt.NDArray[np.floating]] = []
        for piece in self.source.pieces(self.start):
            if self.is_whole:
                self.n_left += len(piece)
                self.source.advance(len(piece))
                continue
            data = rest + piece
            triples = np.frombuffer(data, self.dtype, 3 * (len(data) // size)).reshape(-1, 3)
            rest = data[triples.nbytes :]

            # Find the three Inf that end the file, and the three NaN that end each streamline.
            odd = np.flatnonzero(~np.isfinite(triples[:, 0]))
            marks = odd[np.isinf(triples[odd]).all(axis=1)]
            self.is_whole = len(marks) > 0
            stop = int(marks[0]) if self.is_whole else len(triples)
            ends = odd[(odd < stop) & np.isnan(triples[odd]).all(axis=1)]
            if len(ends):
                last = int(ends[-1]) + 1
                counts = np.diff(ends, prepend=-1) - 1
                counts[0] += sum(map(len, waiting))
                yield np.concatenate([*waiting, _without(triples[:last], ends)]), counts
                waiting = [triples[last:stop]]
            else:
                waiting.append(triples[:stop])
            self.source.advance(triples.nbytes)
            self.n_left = len(data) - size * (stop + self.is_whole)
        n_open = sum(map(len, waiting))
        self.is_open = n_open > 0
        if n_open:
            yield np.concatenate(waiting), np.array([n_open])


def _without(triples: npt.NDArray[np.floating], ends: IntArray) -> npt.NDArray[np.floating]:
    """Return the triples that end no streamline; each is copied as one item."""
    is_point = np.ones(len(triples), np.bool_)
    is_point[ends] = False
    items = triples.view(f"V{3 * triples.dtype.itemsize}")[:, 0]
    return np.asarray(items[is_point].view(triples.dtype).reshape(-1, 3))


def _check_end(source: Source, start: int, type_name: str, is_guess: bool, streamlines: _Streamlines) -> None:
    """Refuse a file without three Inf at its end, unless nothing else can be missing."""
    if streamlines.is_whole:
        if streamlines.is_open:
            source.warn("no NaN ends its last streamline; the end of the data does")
        return
    last_bytes = source.end(3 * max(np.dtype(dtype).itemsize for dtype in _TYPES.values()))
    for name, dtype in _TYPES.items():
        if last_bytes.endswith(np.full(3, np.inf, dtype).tobytes()):
            raise source.error(
                f"it ends as a whole file of type {name} does, but data of type {type_name.lower()} that start at byte "
                f"{start} do not; fix the type ('datatype') or the start ('file') in its header"
            )
    if streamlines.is_open or streamlines.n_left:
        raise source.error(f"its last streamline does not end, neither with NaN nor with Inf; {BAD_COPY}")
    if is_guess:
        raise source.error(f"three Inf at the end are missing, which would prove where its data are; {BAD_COPY}")


def _check_count(source: Source, texts: list[str], n_found: int, n_empty: int, streamlines: _Streamlines) -> None:
    """Compare the header's counts with the streamlines that were found; a count of 0, or none, is unknown."""
    numbers = {int(text) if re.fullmatch("[0-9]{1,18}", text) else -1 for text in texts}
    promised = numbers - {0, -1}
    is_whole, n_left = streamlines.is_whole, streamlines.n_left
    agrees = not promised.isdisjoint({n_found, n_found - n_empty})
    given = " and ".join(text[:20] for text in texts)
    if not agrees and max(promised, default=0) > n_found:
        if not is_whole:
            raise source.error(f"its header counts {given} streamlines, but it ends after the {n_found}th; {BAD_COPY}")
        if n_left:
            raise source.error(
                f"its header counts {given} streamlines, but three Inf end the data after {n_found}, and {n_left} "
                "bytes follow; fix the file, or set the count to 0 to read the data before them"
            )
    if n_left:
        source.warn(f"{n_left} bytes after the three Inf that end its data are not read")
    if not is_whole:
        rest = "as its header counts" if agrees else "and whether more should follow is not known"
        source.warn(f"three Inf at the end are missing; it holds {n_found} streamlines, {rest}")
    if len(numbers) > 1 or -1 in numbers or (promised and not agrees):
        source.warn(f"its header counts {given} streamlines; the {n_found} that it holds are read")
