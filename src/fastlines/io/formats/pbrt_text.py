"""The words of pbrt files: directives, and the parameters of shapes."""

from __future__ import annotations

import gzip
import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

from ...errors import FileFormatError
from ..source import UNPACK_BYTES, UNPACK_FACTOR, Source

_BLANK = rb"\s*+(?:#[^\n\r]*+\s*+)*+"
_LIST = rb"\[[^\[\]\"#]*+(?:#[^\n\r]*+[^\[\]\"#]*+)*+\]"
_STRING = rb"\"(?:[^\"\\\n]|\\.)*+\""
#: One word: a list of numbers, which is one too; a string; a bracket around strings; or anything else.
_WORD = re.compile(_BLANK + rb"(" + _LIST + rb"|" + _STRING + rb"|\[|\]|[^\s\"\[\]#][^\s\"\[\]]*+)")
#: A parameter: its name, and a list of numbers, a string (in brackets or not), or a number.
_PARAMETER = re.compile(
    _BLANK + rb"\"\s*+\w++\s++([^\s\"]++)\s*+\"" + _BLANK
    + rb"(?:\[([^\[\]\"#]*+)\]|\[\s*+\"([^\"\\\n]*+)\"\s*+\]|\"([^\"\\\n]*+)\"|([-+.\w]++))"
)  # fmt: skip
#: A curve whose parameters are all such, up to the next directive or the end.
_CURVE = re.compile(
    _BLANK + rb"Shape\s*+\"curve\"((?:\s*+\"\s*+\w++\s++[^\s\"]++\s*+\"\s*+"
    rb"(?:\[[^\[\]\"#]*+\]|\[\s*+\"[^\"\\\n]*+\"\s*+\]|\"[^\"\\\n]*+\"|[-+.\w]++))++)(?=\s++[A-Za-z]|\s*+\Z)"
)
_COMMENT = re.compile(rb"#[^\n\r]*+")
#: Files may include each other to this depth.
_DEPTH = 32

#: Words that are values, not directives.
VALUES = (b"true", b"false")
_NUMBER_STARTS = b"+-.0123456789"


class Words:
    """The words of one file, in their order."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.text = source.data
        self.at = 0

    def next(self) -> bytes:
        """Return the next word; nothing at the end."""
        match = _WORD.match(self.text, self.at)
        if match is None:
            rest = _COMMENT.sub(b"", self.text[self.at :]).strip()
            if rest:
                raise self.error(f"{rest[:30].decode('latin-1')!r} does not end")
            self.at = len(self.text)
            return b""
        self.at = match.end()
        return match[1]

    def plain_curve(self) -> dict[bytes, bytes] | None:
        """Return the parameters of a curve that comes next, if they have the usual form; this is the fast path."""
        match = _CURVE.match(self.text, self.at)
        if match is None:
            return None
        self.source.advance(match.end() - self.at)
        self.at = match.end()
        found = _PARAMETER.findall(self.text, match.start(1), match.end(1))
        return {name: numbers or string or quoted or number for name, numbers, string, quoted, number in found}

    def string(self, what: str) -> bytes:
        """Return the next word, which must be a string, without its quotes."""
        word = self.next()
        if word[:1] != b'"':
            raise self.error(f"{what} is {word[:30].decode('latin-1')!r}; expected a string")
        return word[1:-1]

    def numbers(self, n: int, what: str) -> list[float]:
        """Return the next numbers, with or without brackets."""
        word = self.next()
        if word.startswith(b"["):
            words = _COMMENT.sub(b"", word).strip(b"[]").split()
        else:
            words = [word, *(self.next() for _ in range(n - 1))]
        try:
            values = [float(one) for one in words]
        except ValueError:
            values = []
        if len(values) != n:
            raise self.error(f"{what} has {b' '.join(words)[:40].decode('latin-1')!r}; expected {n} numbers")
        return values

    def parameters(self) -> Iterator[tuple[bytes, bytes]]:
        """Yield the name and the value of each parameter; the value is the text between brackets or quotes."""
        while True:
            while match := _PARAMETER.match(self.text, self.at):
                self.at = match.end()
                yield match[1], match[match.lastindex or 1]
            # Read others, with comments, escapes or several strings in them, word by word.
            place = self.at
            word = self.next()
            if word[:1] != b'"':
                self.at = place
                return
            words = word[1:-1].split()
            if len(words) != 2:
                raise self.error(f"{word[:40].decode('latin-1')} is not the type and the name of a parameter")
            value = self.next()
            if value == b"[":
                strings = []
                while (value := self.next()) != b"]":
                    if not value:
                        raise self.error("a list does not end")
                    strings.append(value.strip(b'"'))
                value = b" ".join(strings)
            yield words[1], _COMMENT.sub(b"", value).strip(b'[]"')

    def skip(self) -> None:
        """Skip all up to the next directive."""
        while True:
            place = self.at
            word = self.next()
            if not word or not (word[:1] in b'"[]' or word[:1] in _NUMBER_STARTS or word in VALUES):
                self.at = place
                return

    def error(self, message: str, advice: str = "fix the file") -> FileFormatError:
        """Return an error at this place of the file."""
        line = self.text.count(b"\n", 0, self.at) + 1
        return self.source.error(f"line {line}: {message}; {advice}")


class Includes:
    """The files that a file includes: those beside it, and below its folder.

    The bytes that are read in all are limited, as files may include others many times.
    """

    def __init__(self, source: Source) -> None:
        self.folder = Path(source.name).parent
        self.known: dict[Path, bytes] = {}
        self.depth = 0
        self.n_unique = self.n_read = len(source.data)
        self.main = source

    def open(self, words: Words, name: bytes) -> Words:
        """Return the words of another file."""
        text = name.decode("utf-8", "replace")
        path = Path(text)
        if path.is_absolute() or ".." in path.parts or "\0" in text or not path.parts:
            raise words.error(f"includes {text[:80]!r}, which is not in its own folder", "put it there")
        if self.depth >= _DEPTH:
            raise words.error(f"includes {text[:80]!r} at a depth of {_DEPTH} files; they include each other")
        data = self.known.get(path)
        if data is None:
            data = self.known[path] = self._load(words, path)
            self.n_unique += len(data)
        self.n_read += len(data)
        if self.n_read > UNPACK_FACTOR * self.n_unique + UNPACK_BYTES:
            raise words.error(f"includes {text[:80]!r} too often; {self.n_read} bytes would be read in all")
        source = Source(data, f"{self.main.name}, included {text[:80]!r}").as_utf8()
        source.oddities = self.main.oddities
        return Words(source)

    def _load(self, words: Words, path: Path) -> bytes:
        place = self.folder / path
        try:
            if not place.is_file():
                raise FileNotFoundError
            data = place.read_bytes()
            if path.suffix.lower() == ".gz":
                limit = UNPACK_FACTOR * len(data) + UNPACK_BYTES
                with gzip.GzipFile(fileobj=BytesIO(data)) as stream:
                    data = stream.read(limit + 1)
                if len(data) > limit:
                    raise words.error(f"includes {str(path)[:80]!r}, which unpacks to more than {limit} bytes")
        except FileNotFoundError:
            raise words.error(f"includes {str(path)[:80]!r}, which is not there", "put it there") from None
        except FileFormatError:
            raise
        except Exception as error:  # of the file system, gzip and zlib
            raise words.error(f"includes {str(path)[:80]!r}, which cannot be read ({error})") from None
        return data
