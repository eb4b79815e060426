"""The elements of PLY files: their header, and their scalar properties as arrays."""

from __future__ import annotations

import re
import struct
from array import array
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...errors import FileFormatError
from ..source import BAD_COPY, Source
from .number_text import number_lines, unify

Columns = dict[str, npt.NDArray[Any]]

#: What PLY calls the types of numbers.
TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q", "f4": "f", "f8": "d"}
_COMMENTS = (b"comment", b"obj_info")
_ORDERS: dict[bytes, Literal["<", ">"] | None] = {
    b"ascii": None,
    b"binary_little_endian": "<",
    b"binary_big_endian": ">",
}


class Property(NamedTuple):
    """A property: its name, its type, and for a list the type of the number of values in front of them."""

    name: str
    type: str
    count_type: str | None


@dataclass
class Element:
    """An element of the header: a number of rows of some properties."""

    name: str
    n_rows: int
    properties: list[Property] = field(default_factory=list)
    names: set[str] = field(default_factory=set)


class Elements(NamedTuple):
    """How many rows each element has, and the columns of those that were wanted."""

    counts: dict[str, int]
    columns: dict[str, Columns]


def read_elements(source: Source, wanted: Collection[str]) -> Elements:
    """Read the scalar properties of some elements, and check that all elements are there."""
    elements, body, starts, n_header_lines = _header(source)
    store: _Store
    if body is None:
        text = unify(source.data[starts[0] :])
        numbers = number_lines(source, text, np.arange(text.count(b"\n") + 1) + n_header_lines).numbers
        store, starts = _Text(numbers), [0]
    else:
        store = _Binary(source.data, body)
    columns, end = _read_all(source, store, elements, starts, wanted)
    for element in elements:
        found = columns.get(element.name, {})
        for prop in element.properties:
            if prop.name in found and found[prop.name].dtype != prop.type:
                what = f"{prop.name!r} of element {element.name!r}"
                source.warn(f"some of its numbers {what} are not of their type; all are read as float64")
    if end < store.stop:
        source.warn(f"{store.stop - end} {store.unit} after its last element are not read")
    return Elements({element.name: element.n_rows for element in elements}, columns)


def _read_all(
    source: Source, store: _Store, elements: list[Element], starts: list[int], wanted: Collection[str]
) -> tuple[dict[str, Columns], int]:
    """Return the columns of the wanted elements, and where all elements end; they start at one of several places."""
    # Where the end of the header is ambiguous, the data that end with the file prove it.
    for start in starts if len(starts) > 1 else []:
        try:
            read = _read_all(source, store, elements, [start], wanted)
        except FileFormatError:
            continue
        if read[1] == store.stop:
            return read
    at = starts[0]
    columns: dict[str, Columns] = {}
    for element in elements:
        found, at = _read(source, store, element, at, keep=element.name in wanted)
        if element.name in wanted:
            columns[element.name] = found
    return columns, at


class _Store(Protocol):
    """The data behind a header; places are in `unit`, and the data end at `stop`."""

    unit: str
    stop: int

    def size(self, kind: str) -> int:
        """Return how much room a number takes."""
        ...

    def count(self, kind: str, at: int) -> int:
        """Return a number of values; -1 if it is not a whole one."""
        ...

    def column(self, kind: str, start: int, stride: int, n_rows: int) -> npt.NDArray[Any]:
        """Return numbers that are evenly spaced."""
        ...

    def scattered(self, kind: str, places: IntArray) -> npt.NDArray[Any]:
        """Return numbers that are not."""
        ...


class _Binary:
    """Binary data of a byte order."""

    unit = "bytes"

    def __init__(self, data: bytes, order: Literal["<", ">"]) -> None:
        self.data, self.order, self.stop = data, order, len(data)

    def size(self, kind: str) -> int:
        return np.dtype(kind).itemsize

    def count(self, kind: str, at: int) -> int:
        value = struct.unpack_from(self.order + _CODES[kind], self.data, at)[0]
        return int(value) if value == value and abs(value) < 2**62 and value == int(value) else -1

    def column(self, kind: str, start: int, stride: int, n_rows: int) -> npt.NDArray[Any]:
        values = np.ndarray((n_rows,), self.order + kind, buffer=self.data, offset=start, strides=(stride,))
        return values.astype(kind)

    def scattered(self, kind: str, places: IntArray) -> npt.NDArray[Any]:
        raw = np.frombuffer(self.data, np.uint8)[places[:, None] + np.arange(self.size(kind))]
        return np.asarray(raw.view(self.order + kind)[:, 0].astype(kind))


class _Text:
    """Numbers that were text."""

    unit = "numbers"

    def __init__(self, numbers: npt.NDArray[np.float64]) -> None:
        self.numbers, self.stop = numbers, len(numbers)

    def size(self, kind: str) -> int:
        return 1

    def count(self, kind: str, at: int) -> int:
        value = float(self.numbers[at])
        return int(value) if 0 <= value < 2**62 and value == int(value) else -1

    def column(self, kind: str, start: int, stride: int, n_rows: int) -> npt.NDArray[Any]:
        return self._as(kind, self.numbers[start : start + stride * n_rows : stride])

    def scattered(self, kind: str, places: IntArray) -> npt.NDArray[Any]:
        return self._as(kind, self.numbers[places])

    def _as(self, kind: str, values: npt.NDArray[np.float64]) -> npt.NDArray[Any]:
        """Convert to the type that the header names, if the values are of that type, and else not."""
        if kind.startswith("f"):
            with np.errstate(over="ignore"):
                return values.astype(kind)
        limits = np.iinfo(kind)
        with np.errstate(invalid="ignore"):
            fits = (
                (values >= limits.min) & (values <= limits.max) & (values == np.round(values)) & (abs(values) < 2**53)
            )
        return values.astype(kind) if fits.all() else values


def _header(source: Source) -> tuple[list[Element], Literal["<", ">"] | None, list[int], int]:
    """Return the elements, the byte order (None for text), where the data may start, and the lines of the header.

    Some programs end the lines of a header differently. A carriage return and a line feed behind it are one end or two:
    the second may be the first byte of the data. Blank lines may follow the header.
    """
    begin = re.match(rb"ply[ \t]*(\r\n|\n|\r)", source.data)
    if not begin:
        raise source.error(f"starts with {source.data[:4]!r}, a .ply file with b'ply' on a line; check the extension")
    end = re.compile(rb"(?<=[\r\n])end_header[ \t]*(\r\n|\n|\r|\Z)").search(source.data, begin.end())
    if not end:
        raise source.error(f"its header has no line end_header; {BAD_COPY}")
    starts = [end.end(), end.end() - 1] if end[1] == b"\r\n" else [end.end()]
    if begin[1] == b"\r":
        starts.reverse()
    blank = len(re.match(rb"[\r\n]{0,4}", source.data[end.end() : end.end() + 4])[0])  # type: ignore[index]
    starts += range(end.end() + 1, end.end() + blank + 1)
    lines = _split_lines(source.data[begin.end() : end.start()])
    order: Literal["<", ">"] | None = None
    has_format = False
    elements: list[Element] = []
    for number, line in enumerate(lines, start=2):
        words = line.split()
        match words:
            case []:
                pass
            case [word, *_] if word in _COMMENTS:
                pass
            case [b"format", kind, *_] if kind in _ORDERS:
                order, has_format = _ORDERS[kind], True
            case [b"element", name, count] if re.fullmatch(rb"\d{1,18}", count):
                elements.append(Element(name.decode("latin-1"), int(count)))
            case [b"property", b"list", count_type, kind, name] if elements:
                _add(source, number, elements[-1], name, kind, count_type)
            case [b"property", kind, name] if elements:
                _add(source, number, elements[-1], name, kind, None)
            case _:
                raise source.error(f"line {number} of its header is {line[:60].decode('latin-1')!r}; fix it")
    if not has_format:
        raise source.error("its header has no line format; expected 'format ascii 1.0', or one of its binary kinds")
    names = [element.name for element in elements]
    if len(set(names)) < len(names):
        raise source.error(f"its header has several elements of one name ({', '.join(names)[:80]}); fix it")
    return elements, order, starts, len(lines) + 2


def _split_lines(header: bytes) -> list[bytes]:
    """Return the lines of a header, whatever ends each of them; comments may hold carriage returns."""
    if b"\n" not in header:
        return header.split(b"\r")
    *ended, last = header.split(b"\n")
    lines = [*(line.rstrip(b"\r") for line in ended), last]
    return [part for line in lines for part in ([line] if line.startswith(_COMMENTS) else line.split(b"\r"))]


def _add(source: Source, number: int, element: Element, name: bytes, kind: bytes, count_type: bytes | None) -> None:
    """Add a property to an element."""
    for given in (kind, count_type):
        if given is not None and given.decode("latin-1") not in TYPES:
            raise source.error(
                f"line {number} of its header has the type {given[:20].decode('latin-1')!r}; known: char, …"
            )
    text = name.decode("latin-1")
    if text in element.names:
        raise source.error(f"line {number} of its header has the property {text[:60]!r} again; fix it")
    counted = None if count_type is None else TYPES[count_type.decode()]
    element.names.add(text)
    element.properties.append(Property(text, TYPES[kind.decode()], counted))


def _read(source: Source, store: _Store, element: Element, at: int, *, keep: bool) -> tuple[Columns, int]:
    """Read an element that starts at a place; return its columns and where it ends."""
    n_rows, properties = element.n_rows, element.properties
    if not n_rows or not properties:
        return {prop.name: np.zeros(0, prop.type) for prop in properties if prop.count_type is None}, at

    # Measure the first row, and assume that the lists of all are as long.
    offsets, lists = _measure(source, store, element, at, 0)
    size = offsets[-1]
    is_even = at + size * n_rows <= store.stop and all(
        (store.column(str(prop.count_type), at + offset, size, n_rows) == length).all()
        for prop, offset, length in lists
    )
    scalars = [(prop, offset) for prop, offset in zip(properties, offsets, strict=False) if prop.count_type is None]
    if is_even:
        columns = {prop.name: store.column(prop.type, at + offset, size, n_rows) for prop, offset in scalars if keep}
        return columns, at + size * n_rows
    if not lists:
        raise source.error(
            f"its {n_rows} rows of element {element.name!r}, {size} {store.unit} each, do not fit into the "
            f"{store.stop - at} {store.unit} that are left; {BAD_COPY}"
        )

    # Else walk all rows.
    places = array("q")
    for row in range(n_rows):
        offsets, _ = _measure(source, store, element, at, row)
        if keep:
            places.extend(
                at + offset for prop, offset in zip(properties, offsets, strict=False) if prop.count_type is None
            )
        at += offsets[-1]
    if not keep:
        return {}, at
    table = np.array(places, np.int64).reshape(n_rows, len(scalars))
    return {prop.name: store.scattered(prop.type, table[:, i]) for i, (prop, _) in enumerate(scalars)}, at


def _measure(
    source: Source, store: _Store, element: Element, at: int, row: int
) -> tuple[list[int], list[tuple[Property, int, int]]]:
    """Return where each property of a row begins, and its end, from its start; and its lists, with their lengths."""
    offsets = [0]
    lists = []
    for prop in element.properties:
        offset = offsets[-1]
        size = store.size(prop.type)
        if prop.count_type is not None:
            first = store.size(prop.count_type)
            n_values = store.count(prop.count_type, at + offset) if at + offset + first <= store.stop else -1
            if n_values < 0:
                raise source.error(
                    f"row {row} of element {element.name!r} has no number of {prop.name!r} that can be used; {BAD_COPY}"
                )
            lists.append((prop, offset, n_values))
            size = first + size * n_values
        offsets.append(offset + size)
        if at + offsets[-1] > store.stop:
            raise source.error(
                f"row {row} of its {element.n_rows} of element {element.name!r} is not whole; {BAD_COPY}"
            )
    return offsets, lists
