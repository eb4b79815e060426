"""Lines in Wavefront OBJ files (``.obj``): the elements ``l``.

Format: https://paulbourke.net/dataformats/obj/. ``v x y z`` is a vertex, and ``l v1 v2 …`` a polyline of vertices, by
their numbers from 1, or from -1 backwards from the line itself. Each ``l`` is a strand. A backslash continues a line.

Colours of vertices, ``v x y z r g b``, become an attribute. Faces, points, curves and surfaces are not read, with a
warning that counts them. Texture coordinates, groups, objects, materials, and vertices of no ``l`` are dropped. The
format defines no unit, no axes and no radius.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ...geometry.lines import Lines
from ..losses import not_held
from ..polylines import polylines_of
from ..source import Source
from .number_text import Float64Array, check_columns, number_lines, unify, words_of

#: The elements that are not read, by their keywords.
_OTHERS = {b"f": "faces", b"fo": "faces", b"p": "points", b"curv": "curves", b"curv2": "curves", b"surf": "surfaces"}
_INDENT = re.compile(rb"^[ \t]+", re.MULTILINE)
_TEXTURE = re.compile(rb"/[^\s]*")
#: White space that stands for the line end in a continued line.
_CONTINUED = b"\x0b"
_KNOWN = re.compile(rb"^(?:[vfplogs]|v[nt]|fo|curv2?|surf|mtllib|usemtl|#.*)(?:\s|$)", re.MULTILINE)
_SPACE = (ord(" "), ord("\t"), ord("\n"))


def read(source: Source, invalid: str) -> Lines:
    """Read the ``l`` elements of a ``.obj`` file; colours become the attribute ``color`` (n, 3)."""
    text = unify(source.data)
    if b"\\" in text:
        text = text.replace(b"\\\n", b" " + _CONTINUED)
    if text[:1] in b" \t" or b"\n " in text or b"\n\t" in text:
        text = _INDENT.sub(b"", text)
    raw = np.frombuffer(text, np.uint8)
    starts = np.append(0, np.flatnonzero(raw == ord("\n")) + 1)
    numbers = np.arange(len(starts)) + np.searchsorted(np.flatnonzero(raw == ord(_CONTINUED)), starts)
    if not _KNOWN.search(text):
        raise source.error("has no line that begins as one of an OBJ file does; check the extension")
    n_others = _warn_of_others(source, text, raw, starts)

    is_vertex, is_line = _keyword(raw, starts, "v"), _keyword(raw, starts, "l")
    points, color = _vertices(source, _values(text, starts, is_vertex), numbers[is_vertex])
    rows = np.flatnonzero(is_line)
    if len(points) and not len(rows) and not n_others:
        source.warn(f"its {len(points)} vertices are not read, as no element l joins them")
    elements = number_lines(source, _TEXTURE.sub(b"", _values(text, starts, is_line)), numbers[rows])
    counts = elements.counts[: len(rows)]
    del text, raw
    source.drop()

    # Turn the numbers of vertices into rows.
    with np.errstate(invalid="ignore"):
        given = np.nan_to_num(elements.numbers, nan=0.5, posinf=0.5, neginf=0.5)
    n_before = np.repeat(np.cumsum(is_vertex)[rows], counts)
    index = np.where(given < 0, n_before + given, given - 1)
    bad = np.flatnonzero((given != np.round(given)) | (given == 0) | (index < 0) | (index >= len(points)))
    if len(bad):
        line = int(np.repeat(numbers[rows], counts)[bad[0]]) + 1
        raise source.error(
            f"line {line}: the vertex {elements.numbers[bad[0]]:g} is not there; expected 1 to {len(points)}, or "
            "negative numbers back from this line; fix the file"
        )
    if n_lone := int((counts < 2).sum()):
        source.warn(f"{n_lone} of its elements l have less than two vertices; one becomes a segment of zero length")
    chosen = index.astype(np.int64)
    attributes = {} if color is None else {"color": color[chosen]}
    return Lines.from_points(points[chosen], counts, attributes=attributes, offset=source.offset, invalid=invalid)


def write(lines: Lines, path: Path) -> list[str]:
    """Write an ``l`` for each polyline, with vertices of its own, and the attribute ``color`` (m, 3), if float32."""
    polylines = polylines_of(lines)
    table: npt.NDArray[np.generic] = polylines.points
    color = polylines.point_attributes.get("color")
    kept = []
    if color is not None and color.shape[1:] == (3,) and color.dtype == np.float32:
        table = np.concatenate([polylines.points, color], axis=1)
        kept.append("color")
    with path.open("wb") as file:
        for rows in words_of(table):
            file.writelines(b"v " + b" ".join(row) + b"\n" for row in rows)
        start = 1
        for count in polylines.counts.tolist():
            file.write(b"l " + " ".join(map(str, range(start, start + count))).encode() + b"\n")
            start += count
        if not len(lines):
            file.write(b"# no lines\n")
    return not_held(lines, polylines, attributes=kept)


def _keyword(raw: npt.NDArray[np.uint8], starts: IntArray, word: str) -> npt.NDArray[np.bool_]:
    """Return which lines begin with a word, before white space or the end of the line."""
    found = np.ones(len(starts), np.bool_)
    for i, letter in enumerate(word.encode()):
        found &= _at(raw, starts + i) == letter
    return np.asarray(found & np.isin(_at(raw, starts + len(word)), _SPACE))


def _at(raw: npt.NDArray[np.uint8], places: IntArray) -> npt.NDArray[np.uint8]:
    """Return the bytes at some places; behind the end there are line ends."""
    if not len(raw):
        return np.full(len(places), ord("\n"), np.uint8)
    return np.where(places < len(raw), raw[np.minimum(places, len(raw) - 1)], np.uint8(ord("\n")))


def _values(text: bytes, starts: IntArray, chosen: npt.NDArray[np.bool_]) -> bytes | bytearray:
    """Return some lines, without their one-letter keywords and without comments."""
    stops = np.append(starts[1:], len(text) + 1)
    # Copy lines that follow each other at once.
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8)))
    runs = zip(starts[edges[::2]].tolist(), stops[edges[1::2] - 1].tolist(), strict=True)
    joined = bytearray().join([text[start:stop] for start, stop in runs])
    sizes = (stops - starts)[chosen]
    np.frombuffer(joined, np.uint8)[np.cumsum(sizes) - sizes] = ord(" ")
    return re.sub(rb"#[^\n]*", b"", joined) if b"#" in joined else joined


def _vertices(source: Source, text: bytes | bytearray, line_of: IntArray) -> tuple[Float64Array, FloatArray | None]:
    """Return the places and the colours of vertices."""
    lines = number_lines(source, text, line_of)
    counts = lines.counts[: len(line_of)]
    empty = np.flatnonzero(counts == 0)
    if len(empty):
        raise source.error(f"line {line_of[empty[0]] + 1}: a vertex has no coordinates; expected x y z; fix the line")
    check_columns(source, lines, 3, "3, x y z", line_of)
    if len(counts) and (counts == 6).all():
        table = lines.columns(6)
        return table[:, :3], table[:, 3:].astype(np.float32)
    points = lines.columns(3)
    n_more = int((counts > 3).sum())
    if n_more and not ((counts == 4).all() and (lines.columns(4)[:, 3] == 1).all()):
        source.warn(f"{n_more} of its vertices have more than x y z, but not all have a colour; the rest is not read")
    return points, None


def _warn_of_others(source: Source, text: bytes, raw: npt.NDArray[np.uint8], starts: IntArray) -> int:
    """Warn of elements that are not read, and return how many there are."""
    numbers: dict[str, int] = {}
    for word, name in _OTHERS.items():
        if word in text:
            numbers[name] = numbers.get(name, 0) + int(_keyword(raw, starts, word.decode()).sum())
    for name, number in numbers.items():
        if number:
            source.warn(f"its {number} {name} are not read; only its elements l are lines")
    return sum(numbers.values())
