"""The members of zip archives, which are checked before anything is unpacked; or the files of an unpacked one."""

from __future__ import annotations

import errno
import zipfile
from io import BytesIO
from pathlib import Path

from ...errors import FileFormatError
from ..source import BAD_COPY, PIECE, Source, reason

_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def unpack(source: Source, kind: str, ending: str = "") -> dict[str, bytes]:
    """Return the members of an archive, without folders; they may not unpack to more than `Source.unpack_limit`.

    Of a folder, return its files, those in folders below it too. Only members whose names end so are read.
    """
    if source.path is not None and source.path.is_dir():
        return _files(source, source.path, ending)
    try:
        with zipfile.ZipFile(source.open()) as archive:
            members: dict[str, zipfile.ZipInfo] = {}
            for member in archive.infolist():
                name = member.filename
                if member.compress_type not in _COMPRESSIONS or member.flag_bits & 1:
                    raise source.error(f"{name!r} in it is packed by an unknown method; write it again")
                if name in members:
                    raise source.error(f"holds several members named {name!r}; write it again with each name once")
                if not member.is_dir() and name.endswith(ending):
                    members[name] = member
            source.check_unpacked(sum(member.file_size for member in members.values()))
            return {name: _unpacked(source, archive, member) for name, member in members.items()}
    except FileFormatError:
        raise
    except Exception as error:  # zipfile's own errors, and any of zlib and struct
        # A place before the file's start is no error of the disk.
        if source.stopped is not None or getattr(error, "errno", None) not in (None, errno.EINVAL):
            raise  # the callback's error, or the disk's
        raise source.error(f"not a whole {kind} file ({reason(error)}); check the extension, or {BAD_COPY}") from None


def _files(source: Source, folder: Path, ending: str) -> dict[str, bytes]:
    """Return the bytes of each file of a folder whose name ends so, by its path below the folder."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file() and path.name.endswith(ending)]
    source.size = sum(path.stat().st_size for path in paths)
    files = {}
    for path in paths:
        name = path.relative_to(folder).as_posix()
        files[name] = path.read_bytes()
        source.advance(2 * len(files[name]))
    return files


def _unpacked(source: Source, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """Return the bytes of a member."""
    unpacked = BytesIO()
    with archive.open(member) as file:
        while piece := file.read(PIECE):
            unpacked.write(piece)
            source.advance(2 * member.compress_size * len(piece) // max(member.file_size, 1))
    return unpacked.getvalue()
