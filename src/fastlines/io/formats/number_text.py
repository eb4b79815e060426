"""Numbers in text, a line for each point: parsed in bulk, and written with as few digits as float32 needs."""

from __future__ import annotations

import re
import warnings
from array import array
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray, IntArray
from ..source import Source

Float64Array = npt.NDArray[np.float64]

#: How many bytes of text are parsed at once, and how many rows are written at once.
PIECE = 1 << 20
_ROWS = 1 << 16

_NUMBER = re.compile(rb"[+-]?(?:(?:\d++\.?+\d*+|\.\d++)(?:e[+-]?\d++)?+|nan(?:\(\w*\))?|inf|infinity)", re.IGNORECASE)


class NumberLines(NamedTuple):
    """The numbers of a text, float64, and how many of them each line has, int64."""

    numbers: Float64Array
    counts: IntArray

    def columns(self, n_columns: int) -> Float64Array:
        """Return the first numbers of each line that has any, (k, n_columns); none of these lines may have fewer."""
        counts = self.counts[self.counts > 0]
        if (counts == n_columns).all():
            return self.numbers.reshape(-1, n_columns)
        first = np.cumsum(counts) - counts
        return np.asarray(self.numbers[first[:, None] + np.arange(n_columns)])


def unify(data: bytes) -> bytes:
    """Return text without a byte order mark, and with line ends of one kind."""
    data = data.removeprefix(b"\xef\xbb\xbf")
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data


def number_lines(
    source: Source,
    text: bytes | bytearray,
    line_of: IntArray | None = None,
    what: str = "line",
    comment: re.Pattern[bytes] | None = None,
) -> NumberLines:
    """Parse lines of numbers that white space separates.

    Parameters
    ----------
    source : Source
        Raises the error about a line that holds something else.
    text : bytes
        As `unify` returns it. A last line without a line end is one.
    line_of : (n,) array, optional
        The number of each line in the file, from 0, where the text holds only some of them.
    what : str
        What a line is called in the error.
    comment : pattern, optional
        What is left out of lines.
    """
    numbers, counts = array("d"), array("q")  # which grow in place
    n_before = 0
    for given in _pieces(text):
        piece = given if comment is None else comment.sub(b"", given)
        parsed = _parse_words(piece)
        raw = np.frombuffer(piece, np.uint8)
        ends = np.flatnonzero(raw == ord("\n"))
        if parsed is None:
            row, line = _bad_line(piece)
            row += n_before
            raise source.error(
                f"{what} {(row if line_of is None else int(line_of[row])) + 1}: {_shown(line)} is not numbers; "
                "fix it, or check the extension"
            )
        if len(ends) == 0 or ends[-1] + 1 < len(raw):
            ends = np.append(ends, len(raw))
        numbers.frombytes(parsed.view(np.uint8).data)
        per_line = np.diff(np.searchsorted(_word_starts(raw), ends), prepend=0).astype(np.int64, copy=False)
        counts.frombytes(per_line.view(np.uint8).data)
        n_before += len(ends)
        source.advance(len(given))
    return NumberLines(np.frombuffer(numbers, np.float64), np.frombuffer(counts, np.int64))


def parse_numbers(text: bytes, dtype: npt.DTypeLike = np.float64) -> AnyArray | None:
    """Return the numbers of a text, or None if it holds anything else."""
    if not text.strip():
        return np.empty(0, dtype)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy warns of, or refuses, what it cannot parse
        try:
            return np.fromstring(text, dtype, sep=" ")
        except (DeprecationWarning, ValueError, OverflowError):
            return None


def _parse_words(text: bytes) -> Float64Array | None:
    """Return the numbers of a text, or None if any of its words is not one."""
    n_words = len(_word_starts(np.frombuffer(text, np.uint8)))
    if not n_words:
        return np.empty(0)
    numbers = None if b"\0" in text else parse_numbers(text)
    # Each word is at least one number, so equal counts show that each is just one.
    return numbers if numbers is not None and len(numbers) == n_words else None


def check_columns(
    source: Source, lines: NumberLines, least: int, expected: str, line_of: IntArray | None = None
) -> None:
    """Refuse lines that have some numbers, but fewer than `least`."""
    bad = np.flatnonzero((lines.counts > 0) & (lines.counts < least))
    if len(bad):
        row = int(bad[0])
        raise source.error(
            f"line {(row if line_of is None else int(line_of[row])) + 1} has {lines.counts[row]} numbers; expected "
            f"{expected}; fix the line, or check the extension"
        )


def first_columns(source: Source, lines: NumberLines, names: str) -> Float64Array:
    """Return a row for each line with numbers, and a column for each name; refuse fewer numbers, and warn of more."""
    n = len(names.split())
    check_columns(source, lines, n, f"{n}, {names}")
    n_long = int((lines.counts > n).sum())
    if n_long:
        source.warn(f"{n_long} of its lines have more than {n} numbers, {names}; the others are not read")
    return lines.columns(n)


def words_of(values: npt.NDArray[np.generic]) -> Iterator[list[list[bytes]]]:
    """Yield rows of numbers, (n, k), as words; float32 with as few digits as give the same number back."""
    for start in range(0, len(values), _ROWS):
        rows: list[list[bytes]] = values[start : start + _ROWS].astype("S").tolist()
        yield rows


def one_each(values: FloatArray | IntArray) -> list[bytes]:
    """Return each number of an array, (n,), as a word."""
    return [row[0] for rows in words_of(values[:, None]) for row in rows]


def _word_starts(raw: npt.NDArray[np.uint8]) -> IntArray:
    """Return where words begin."""
    is_word = (raw != ord(" ")) & ((raw < ord("\t")) | (raw > ord("\r")))
    starts = is_word.copy()
    starts[1:] &= ~is_word[:-1]
    return np.flatnonzero(starts)


def _pieces(text: bytes | bytearray) -> Iterator[bytes]:
    """Cut a text between two lines into pieces of moderate size."""
    start = 0
    while start < len(text):
        stop = text.find(b"\n", start + PIECE) + 1 or len(text)
        yield bytes(text[start:stop])
        start = stop


def _bad_line(text: bytes) -> tuple[int, bytes]:
    """Return the number, from 0, and the text of the first line that is not numbers."""
    for row, line in enumerate(text.split(b"\n")):
        if not all(_NUMBER.fullmatch(word) for word in line.split()):
            return row, line
    return 0, text.partition(b"\n")[0]


def _shown(line: bytes) -> str:
    return repr(line.strip()[:60].decode("latin-1"))
