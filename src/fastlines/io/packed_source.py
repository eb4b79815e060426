"""The bytes of a file that gzip has packed."""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from io import BytesIO
from typing import BinaryIO

from ..progress import ProgressCallback
from ..support.named_errors import named
from . import source
from .source import BAD_COPY, Source, reason

#: The first bytes of a file that gzip has packed.
MAGIC = b"\x1f\x8b"
#: How many of the last bytes are kept.
_N_END = 64


class PackedSource(Source):
    """All bytes of a packed file, unpacked up to a limit: by `pieces` as they are needed, or once by `data`.

    Until `data` has unpacked them, `size` is that of the packed file.
    """

    def __init__(self, file: BinaryIO, name: str, progress: ProgressCallback | None = None) -> None:
        super().__init__(file, name, None, progress)
        self._packed = file
        self._n_packed = self._n_unpacked = 0
        self._end = b""
        self._has_more = False

    @property
    def data(self) -> bytes:
        """All bytes. They stay in memory."""
        if self._data is None:
            data = super().data
            self._done = self.size
            return data
        return super().data

    def open(self) -> BinaryIO:
        """Return the bytes as a file to read from."""
        return BytesIO(self.data)

    def start(self, n_bytes: int) -> bytes:
        """Return the first bytes; fewer if there are no more."""
        if self._data is not None:
            return self._data[:n_bytes]
        start = b""
        for piece in self._pieces():
            start += piece
            if len(start) >= n_bytes:
                break
        return start[:n_bytes]

    def end(self, n_bytes: int) -> bytes:
        """Return the last bytes: up to 64, once all are unpacked."""
        return self._end[-n_bytes:] if self._data is None else self._data[-n_bytes:]

    def pieces(self, at: int = 0) -> Iterator[bytes]:
        """Yield the bytes from a place on, piece by piece, as they are unpacked."""
        if self._data is not None:
            yield from super().pieces(at)
            return
        self._n_packed = self._n_unpacked = 0
        for piece in self._pieces():
            packed, self._n_packed = self._n_packed, self._packed.tell()
            self._n_unpacked += len(piece)
            super().advance(self._n_packed - packed)
            self._end = (self._end + piece[-_N_END:])[-_N_END:]
            if kept := piece[max(at - self._n_unpacked + len(piece), 0) :]:
                yield kept

    def advance(self, n_bytes: int) -> None:
        """Report that `n_bytes` more are parsed."""
        if self._data is None and self._n_unpacked:
            n_bytes = n_bytes * self._n_packed // self._n_unpacked
        super().advance(n_bytes)

    def _pieces(self) -> Iterator[bytes]:
        """Yield all bytes."""
        self._packed.seek(0)
        if self._packed.read(len(MAGIC)) != MAGIC:
            raise self.error("is not packed by gzip although its name ends with .gz; rename it, or get a fresh copy")
        self._packed.seek(0)
        n_bytes, waiting = 0, bytearray()
        try:
            with gzip.GzipFile(fileobj=self._packed) as stream:
                while n_bytes <= self.unpack_limit and (part := stream.read1(source.PIECE)):
                    n_bytes += len(part)
                    waiting += part
                    if len(waiting) >= source.PIECE:
                        yield bytes(waiting)
                        waiting.clear()
        except Exception as error:  # gzip's own errors, and any of zlib and struct
            if self.stopped is not None:
                raise
            if isinstance(error, OSError) and error.errno is not None:
                self.stopped = named(error, self.name)
                raise self.stopped from None
            if not (n_bytes and str(error).startswith("Not a gzipped file")):
                raise self.error(f"not a whole gzip file ({reason(error)}); {BAD_COPY}") from None
            if not self._has_more:
                self.warn("the bytes after its packed part are not read")
            self._has_more = True
        self.check_unpacked(n_bytes, "unpack it by gunzip first")
        if not n_bytes:
            raise self.error(f"is empty once unpacked; {BAD_COPY}")
        if waiting:
            yield bytes(waiting)
