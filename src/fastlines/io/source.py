"""The bytes of a file, read array by array; each array is checked against the file first."""

from __future__ import annotations

import codecs
import math
import os
import re
import tempfile
from bisect import bisect
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, name_rows
from ..errors import FileFormatError, InputError
from ..geometry.offsets import Offset, offset_of
from ..progress import ProgressCallback
from ..support.named_errors import named
from ..support.texts import in_one_line, printable
from .stored_array import StoredArray

#: So many bytes are read at once.
PIECE = 1 << 20
#: Progress is reported when so much more of the work is done, as a fraction.
_STEP = 1e-3

#: A packed file may grow by this factor and this many bytes; one that grows more is refused as a decompression bomb.
UNPACK_FACTOR = 200
UNPACK_BYTES = 16 << 20

#: The byte order marks of text; those of UTF-32 come first, as they begin as those of UTF-16 do.
_MARKS = {
    codecs.BOM_UTF32_LE: "utf-32", codecs.BOM_UTF32_BE: "utf-32", codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16", codecs.BOM_UTF8: "utf-8",
}  # fmt: skip
#: XML names its encoding.
_XML_ENCODING = re.compile(r"\A(\s*<\?xml[^>]*encoding\s*=\s*[\"'])[\w-]+")

BAD_COPY = "the file is cut short or damaged: get a fresh copy"


def reason(error: Exception) -> str:
    """Describe an error of another library in one short printable line."""
    words = " ".join(str(error).split()) or type(error).__name__
    return printable(words[:120])


class Source:
    """All bytes of one file, unpacked, and its name in errors; `path` is where they are as they stand, if anywhere.

    No header is trusted: an array is made only if the file holds it. So a wrong header can neither allocate more memory
    than the file has bytes nor read outside the file.

    Parameters
    ----------
    data : bytes or binary file
        The bytes of an open file are read on first use.
    name : str
        What errors call the file.
    path : Path, optional
        Where these bytes are on the disk.
    progress : callable, optional
        Called with the fraction of the work that is done. One half is reading the bytes, the other is parsing them.
    """

    def __init__(
        self, data: bytes | BinaryIO, name: str, path: Path | None = None, progress: ProgressCallback | None = None
    ) -> None:
        self._data = data if isinstance(data, bytes) else None
        self._file = None if isinstance(data, bytes) else data
        #: The number of bytes.
        self.size = len(data) if isinstance(data, bytes) else os.fstat(data.fileno()).st_size
        self.name = name
        self.path = path
        self.position = 0
        #: The encoding that `text` has found.
        self.encoding = "utf-8-sig"
        #: What is subtracted from coordinates in float64: None, "auto" or three numbers.
        self.offset: Offset | str | None = None
        self.oddities: list[str] = []
        self._taken: list[tuple[int, int, str]] = []
        #: The error of the callback or of the disk, which is raised again as it is.
        self.stopped: Exception | None = None
        self._progress = progress
        self._done = 0 if self._file else self.size
        self._shown = -1.0
        self._is_dropped = False

    @property
    def data(self) -> bytes:
        """All bytes. They stay in memory; `pieces` does not keep them."""
        if self._is_dropped:
            raise RuntimeError(f"{self.name}: its bytes are needed after they were dropped")
        if self._data is None:
            whole = BytesIO()  # which neither copies when it grows, nor when it hands out its bytes
            for piece in self.pieces():
                whole.write(piece)
            self._data = whole.getvalue()
            self.size = len(self._data)
        return self._data

    def offset_or(self, metadata: Mapping[str, Any]) -> Offset | str | None:
        """Return the offset that was asked for, or else that of the file's metadata."""
        if self.offset is not None:
            return self.offset
        try:
            return offset_of(metadata)
        except InputError as error:
            raise self.error(f"{error}; fix the file") from None

    def drop(self) -> None:
        """Free the bytes, once they are needed no longer; to ask for them again is an error of the program."""
        self._data = b""
        self._is_dropped = True

    def open(self) -> BinaryIO:
        """Return the bytes as a file to read from; the caller does not close it."""
        if self._file is None or self._data is not None:
            return BytesIO(self.data)
        self._file.seek(0)
        return self._file

    def start(self, n_bytes: int) -> bytes:
        """Return the first bytes; fewer if there are no more."""
        return self.open().read(n_bytes)

    def read(self, at: int, n_bytes: int) -> bytes:
        """Return bytes from a place on; fewer if there are no more."""
        file = self.open()
        file.seek(at)
        return file.read(n_bytes)

    def end(self, n_bytes: int) -> bytes:
        """Return the last bytes; fewer if there are no more."""
        return self.read(max(0, self.size - n_bytes), n_bytes)

    def pieces(self, at: int = 0) -> Iterator[bytes]:
        """Yield the bytes from a place on, piece by piece."""
        if self._file is None or self._data is not None:
            data = self.data
            yield from (data[start : start + PIECE] for start in range(at, len(data), PIECE))
            return
        try:
            self._file.seek(at)
            while piece := self._file.read(min(PIECE, self.size - at)):
                at += len(piece)
                self.advance(len(piece))
                yield piece
        except OSError as error:
            self.stopped = named(error, self.name)
            raise self.stopped from None

    def advance(self, n_bytes: int) -> None:
        """Report that `n_bytes` more are read or parsed."""
        self._done += n_bytes
        share = min(1.0, self._done / max(2 * self.size, 1))
        if self._progress is None or share < min(self._shown + _STEP, 1.0) or share <= self._shown:
            return
        self._shown = share
        try:
            self._progress(share)
        except Exception as error:
            self.stopped = error
            raise

    def error(self, message: str) -> FileFormatError:
        """Return an error about this file."""
        return FileFormatError(f"{self.name}: {in_one_line(message)}")

    def warn(self, message: str) -> None:
        """Record an oddity, of which `read` warns once the file is read."""
        self.oddities.append(f"{self.name}: {in_one_line(message)}")

    def text(self) -> str:
        """Return the file as text: UTF-8, or else Latin-1; with or without a byte order mark."""
        try:
            return self.data.decode("utf-8-sig")
        except UnicodeDecodeError:
            self.encoding = "latin-1"
            return self.data.decode("latin-1")

    def as_utf8(self) -> Source:
        """Return text as UTF-8 without a byte order mark, where it is UTF-16 or UTF-32, or has such a mark."""
        start = self.start(64)
        encoding = next((name for mark, name in _MARKS.items() if start.startswith(mark)), None)
        if encoding is None and len(start) >= 4:
            # Without a mark, every second byte is zero.
            odd, even = start[::2], start[1::2]
            encoding = (
                "utf-16-le" if all(odd) and not any(even) else "utf-16-be" if all(even) and not any(odd) else None
            )
        if encoding is None:
            return self
        data = self.data.removeprefix(codecs.BOM_UTF8)
        if encoding != "utf-8":
            try:
                text = data.decode(encoding)
            except UnicodeDecodeError as error:
                name = encoding[:6].upper()
                raise self.error(f"is {name} text, but not whole ({reason(error)}); save it as UTF-8") from None
            data = _XML_ENCODING.sub(r"\g<1>utf-8", text).encode()
        utf8 = Source(data, self.name, progress=self._progress)
        utf8.oddities += self.oddities
        self.drop()
        return utf8

    @contextmanager
    def file(self, extension: str) -> Iterator[Path]:
        """Return a file with this extension that holds these bytes, for libraries that open files themselves."""
        if self.path is not None and self.path.suffix.lower() == extension:
            yield self.path
            return
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"lines{extension}"
            path.write_bytes(self.data)
            yield path

    @property
    def unpack_limit(self) -> int:
        """The most bytes to which a packed file of this size may unpack."""
        return UNPACK_FACTOR * self.size + UNPACK_BYTES

    def check_unpacked(self, n_bytes: int, fix: str = "write it again without compression") -> None:
        """Refuse to unpack more than `unpack_limit`."""
        if n_bytes > self.unpack_limit:
            raise self.error(
                f"unpacks to more than {self.unpack_limit} bytes, far more than lines would; if it is valid, {fix}"
            )

    def array(
        self, what: str, dtype: npt.DTypeLike, shape: tuple[int, ...], *, at: int | None = None
    ) -> npt.NDArray[Any]:
        """Return a read-only view of an array in the file, which starts at byte `at`, or at the end of the last one.

        `what` names its numbers in errors, in the plural. The shape comes from a header and may be nonsense. A
        FileFormatError is raised if the array does not fit into the file, or shares bytes with an earlier array.
        """
        data = self.data
        return np.ndarray(shape, dtype, buffer=data, offset=self._take(what, np.dtype(dtype), shape, at))

    def stored(self, what: str, dtype: npt.DTypeLike, shape: tuple[int, ...], *, at: int | None = None) -> StoredArray:
        """Return an array that is checked as `array` does it, but stays in the file."""
        return StoredArray(self.read, dtype, shape, self._take(what, np.dtype(dtype), shape, at))

    def _take(self, what: str, dtype: np.dtype[Any], shape: tuple[int, ...], at: int | None) -> int:
        """Return where an array starts, once it is checked."""
        start = self.position if at is None else at
        stop = start + math.prod(shape) * dtype.itemsize
        if stop > self.size or any(not 0 <= size <= self.size for size in shape):
            dims = " × ".join(str(size) for size in shape)
            raise self.error(
                f"{what} ({dims} of {dtype.itemsize} bytes, from byte {start}) do not fit into "
                f"the file's {self.size} bytes; {BAD_COPY}"
            )
        if start < stop:
            # The arrays so far are sorted, and none overlaps another one.
            at = bisect(self._taken, (start, stop))
            for other_start, other_stop, other in self._taken[max(at - 1, 0) : at + 1]:
                if max(start, other_start) < min(stop, other_stop):
                    raise self.error(
                        f"{what} (bytes {start} to {stop}) overlap {other} "
                        f"(bytes {other_start} to {other_stop}); its header is damaged or was written wrongly: fix it"
                    )
            self._taken.insert(at, (start, stop, what))
        self.position = stop
        return start

    def record(self, what: str, dtype: npt.DTypeLike) -> dict[str, Any]:
        """Return one record of named fields, such as a header, as plain Python numbers and bytes."""
        record = self.array(what, dtype, (1,)).copy()[0]  # a copy, as it may outlive the bytes
        return dict(zip(record.dtype.names, record.tolist(), strict=True))

    def finish(self) -> None:
        """Refuse a file with bytes after its last array."""
        n_left = self.size - self.position
        if n_left:
            raise self.error(
                f"{n_left} bytes are left over behind byte {self.position}, where the data that the header "
                "promises end; its counts are wrong, or something was appended: write the file again"
            )

    def radius(self, what: str, values: npt.NDArray[Any], first_row: int = 0) -> FloatArray:
        """Return radii or thicknesses as float32; each must be finite and not negative.

        Errors count the rows from the first one's number on.
        """
        with np.errstate(over="ignore"):
            radius = values.astype(np.float32)
        bad = ~(np.isfinite(radius) & (radius >= 0))
        if bad.any():
            rows = name_rows(np.flatnonzero(bad.reshape(len(bad), -1).max(axis=1)) + first_row)
            raise self.error(f"the {what} must be finite and not negative (see {rows}); fix the file")
        return radius
