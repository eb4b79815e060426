"""The members of zip archives, which are checked before anything is unpacked."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from io import BytesIO

from ...errors import FileFormatError
from ..source import BAD_COPY, PIECE, Source, reason

_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def unpack(source: Source, kind: str, only: Sequence[str] | None = None) -> dict[str, bytes]:
    """Return the members of an archive, or some of them, without folders.

    They may not unpack to more than `Source.unpack_limit`.
    """
    try:
        with zipfile.ZipFile(source.open()) as archive:
            members: dict[str, zipfile.ZipInfo] = {}
            for member in archive.infolist():
                name = member.filename
                if member.compress_type not in _COMPRESSIONS or member.flag_bits & 1:
                    raise source.error(f"{name!r} in it is packed by an unknown method; write it again")
                if name in members:
                    raise source.error(f"holds several members named {name!r}; write it again with each name once")
                if not member.is_dir() and (only is None or name in only):
                    members[name] = member
            source.check_unpacked(sum(member.file_size for member in members.values()))
            return {name: _unpacked(source, archive, member) for name, member in members.items()}
    except FileFormatError:
        raise
    except Exception as error:  # zipfile's own errors, and any of zlib and struct
        if source.stopped is not None or getattr(error, "errno", None) is not None:
            raise  # the callback's error, or the disk's
        raise source.error(f"not a whole {kind} file ({reason(error)}); check the extension, or {BAD_COPY}") from None


def _unpacked(source: Source, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """Return the bytes of a member."""
    unpacked = BytesIO()
    with archive.open(member) as file:
        while piece := file.read(PIECE):
            unpacked.write(piece)
            source.advance(2 * member.compress_size * len(piece) // max(member.file_size, 1))
    return unpacked.getvalue()
