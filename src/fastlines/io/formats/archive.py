"""The members of zip archives, which are checked before anything is unpacked; or the files of an unpacked one."""

from __future__ import annotations

import errno
import struct
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

from ...errors import FileFormatError
from .. import source as sources
from ..source import BAD_COPY, Source, reason

_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
#: The size of what is before a member's name, extra field and data, and where it says how long the first two are.
_LOCAL_HEADER, _LENGTHS = 30, 26


class Member(NamedTuple):
    """A member of an archive.

    Attributes
    ----------
    size : int
        How many bytes it has.
    read : callable
        Takes the place of a byte and a number of bytes, and returns the bytes.
    """

    size: int
    read: Callable[[int, int], bytes]

    @property
    def data(self) -> bytes:
        """All bytes."""
        return self.read(0, self.size)


def unpack(source: Source, kind: str) -> dict[str, bytes]:
    """Return the members of an archive, without folders; they may not unpack to more than `Source.unpack_limit`."""
    with _opened(source, kind, "") as (archive, found):
        return {name: _unpacked(source, archive, member) for name, member in found.items()}


def members(source: Source, kind: str, ending: str = "") -> dict[str, Member]:
    """Return the members of an archive as `unpack` does, or the files of a folder and of folders below it.

    Only those whose names end so are returned. Members that are not compressed are checked, and stay in the file.
    """
    if source.path is not None and source.path.is_dir():
        return _files(source, source.path, ending)
    with _opened(source, kind, ending) as (archive, found):
        return {name: _member(source, archive, member) for name, member in found.items()}


@contextmanager
def _opened(source: Source, kind: str, ending: str) -> Iterator[tuple[zipfile.ZipFile, dict[str, zipfile.ZipInfo]]]:
    """Open an archive; raise what is wrong with it as an error of the file."""
    try:
        with zipfile.ZipFile(source.open()) as archive:
            found: dict[str, zipfile.ZipInfo] = {}
            for member in archive.infolist():
                name = member.filename
                if member.compress_type not in _COMPRESSIONS or member.flag_bits & 1:
                    raise source.error(f"{name!r} in it is packed by an unknown method; write it again")
                if name in found:
                    raise source.error(f"holds several members named {name!r}; write it again with each name once")
                if not member.is_dir() and name.endswith(ending):
                    found[name] = member
            source.check_unpacked(sum(member.file_size for member in found.values()))
            yield archive, found
    except FileFormatError:
        raise
    except Exception as error:  # zipfile's own errors, and any of zlib and struct
        # A place before the file's start is no error of the disk.
        if source.stopped is not None or getattr(error, "errno", None) not in (None, errno.EINVAL):
            raise  # the callback's error, or the disk's
        raise source.error(f"not a whole {kind} file ({reason(error)}); check the extension, or {BAD_COPY}") from None


def _files(source: Source, folder: Path, ending: str) -> dict[str, Member]:
    """Return each file of a folder whose name ends so, by its path below the folder."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file() and path.name.endswith(ending)]
    sizes = [path.stat().st_size for path in paths]
    source.size = sum(sizes)

    def reader(path: Path) -> Callable[[int, int], bytes]:
        def read(at: int, n_bytes: int) -> bytes:
            with path.open("rb") as file:
                file.seek(at)
                data = file.read(n_bytes)
            source.advance(2 * n_bytes)
            return data

        return read

    names = [path.relative_to(folder).as_posix() for path in paths]
    return {name: Member(size, reader(path)) for name, size, path in zip(names, sizes, paths, strict=True)}


def _member(source: Source, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Member:
    """Return a member; one that is compressed is unpacked."""
    if member.compress_type != zipfile.ZIP_STORED:
        data = _unpacked(source, archive, member)
        return Member(len(data), lambda at, n_bytes: data[at : at + n_bytes])
    # Reading all of it compares the checksum.
    for piece in _pieces(archive, member):
        source.advance(len(piece))
    lengths = source.read(member.header_offset + _LENGTHS, 4)
    start = member.header_offset + _LOCAL_HEADER + sum(struct.unpack("<2H", lengths))

    def read(at: int, n_bytes: int) -> bytes:
        source.advance(n_bytes)
        return source.read(start + at, n_bytes)

    return Member(member.file_size, read)


def _unpacked(source: Source, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """Return the bytes of a member."""
    unpacked = BytesIO()
    for piece in _pieces(archive, member):
        unpacked.write(piece)
        source.advance(2 * member.compress_size * len(piece) // max(member.file_size, 1))
    return unpacked.getvalue()


def _pieces(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Iterator[bytes]:
    n_bytes = 0
    with archive.open(member) as file:
        while piece := file.read(sources.PIECE):
            n_bytes += len(piece)
            yield piece
    if n_bytes < member.file_size:
        raise zipfile.BadZipFile(f"{member.filename!r} has {n_bytes} bytes of {member.file_size}")
