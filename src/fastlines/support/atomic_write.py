"""Files that appear whole or not at all, even if the power fails.

A file is written beside the real one, as ``NAME.<12 hex digits>.partial``. When it is whole and on the disk, it
replaces the real one. Its writer holds a lock on it (flock), which ends with the process. So a partial file without a
lock is left over from a process that was killed, and the next save to the same name removes it.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import stat
import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import InputError

try:
    import fcntl
except ImportError:  # without these locks no partial file is removed
    fcntl = None  # type: ignore[assignment]

#: How many characters of a file's name its partial file keeps: file systems limit the length of names.
_MAX_NAME = 50

#: Kinds of files that cannot be replaced, by the letter that ``ls -l`` shows.
_KINDS = {"p": "a pipe", "s": "a socket", "c": "a device", "b": "a device"}

#: How systems say that they cannot sync a file, or a folder, and that a folder cannot be opened at all.
_CANNOT_SYNC = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)
_CANNOT_SYNC_FOLDER = (*_CANNOT_SYNC, errno.EBADF)
_CANNOT_OPEN_FOLDER = (errno.EACCES, errno.EISDIR, errno.EPERM)


@contextmanager
def atomic_write(path: str | os.PathLike[str], *, durable: bool = True) -> Iterator[Path]:
    """Return a new file beside the real one to write to; it replaces the real one once it is whole.

    A file that is not durable may be damaged after a power failure, but not after the end of a process: it is not
    waited for until it is on the disk.

    A symbolic link stays one: the file that it names is written. An existing file keeps its mode and, where the
    process may set them, its owner and group. Of several writers at a time the last to end wins.

    Raises
    ------
    InputError
        If the path is a device, a pipe or a socket.
    OSError
        If it is a folder, or cannot be written: no such folder, no permission, no space. The error names `path`. If
        the folder cannot be synced, the new file is there, but a power failure may bring back the old one.
    """
    named = os.fspath(path)
    target = check_target(named)
    before = target.stat() if target.exists() else None
    _remove_left_over(target)
    outer = sys.exc_info()[1]
    lock, partial = _create(target, 0o666 if before is None else 0o600, named)
    stays_open = fcntl is not None  # Windows replaces and removes no file that is open
    if not stays_open:
        os.close(lock)
    try:
        yield partial
        if before is not None:
            _keep_owner_and_mode(partial, before)
        if durable:
            if stays_open:
                _sync(lock)
            else:
                _sync_file(partial)
        partial.replace(target)
        if durable:
            sync_folder(target.parent)
    except Exception as error:
        # Name the path that was given, not the partial file.
        failed = _with_number(error, outer) if isinstance(error, OSError) else None
        if failed is not None and str(partial) in str(failed.filename or partial):
            raise OSError(failed.errno, failed.strerror, named) from None
        if isinstance(error, OSError) and failed is None:
            raise OSError(f"{named}: {str(error).replace(str(partial), named)}") from None
        error.args = tuple(arg.replace(str(partial), named) if isinstance(arg, str) else arg for arg in error.args)
        raise
    finally:
        with contextlib.suppress(OSError):
            partial.unlink()
        if stays_open:
            with contextlib.suppress(OSError):  # nothing was written by this descriptor, and it is closed in any case
                os.close(lock)


def sync(path: str | os.PathLike[str]) -> None:
    """Wait until a file that was not durable is on the disk; its folder has to be synced, too (`sync_folder`)."""
    descriptor = os.open(path, os.O_RDWR)
    try:
        _sync(descriptor)
    except OSError as error:
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None
    finally:
        os.close(descriptor)


def sync_folder(path: Path) -> None:
    """Wait until the names of the files in a folder are on the disk, where the system supports that."""
    try:
        folder = os.open(path, os.O_RDONLY)
    except OSError as error:
        if error.errno in _CANNOT_OPEN_FOLDER:  # on Windows, or without the right to list it
            return
        raise
    try:
        _sync(folder, _CANNOT_SYNC_FOLDER)
    finally:
        with contextlib.suppress(OSError):  # nothing was written by it
            os.close(folder)


def check_target(path: str | os.PathLike[str]) -> Path:
    """Return the file that a path names, past symbolic links; refuse one that cannot be written."""
    named = os.fspath(path)
    kind = ""
    try:
        target = Path(os.path.realpath(named))
        kind = stat.filemode(os.stat(named).st_mode)[0]
    except FileNotFoundError:
        if not named:
            raise
    except ValueError as error:  # a NUL in it
        raise InputError(f"{named!r} is not the path of a file: {error}") from None
    if kind == "d":
        raise IsADirectoryError(errno.EISDIR, "is a directory; expected the name of a file to write", named)
    if kind in _KINDS:
        raise InputError(f"{named}: is {_KINDS[kind]}; expected a regular file; write to one, and copy it from there")
    folder = target.parent if os.path.islink(named) else Path(named).parent
    if not folder.is_dir():
        raise FileNotFoundError(errno.ENOENT, f"there is no folder {folder}; make it first", named)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, f"the folder {folder} cannot be written to", named)
    if kind and not os.access(named, os.W_OK):
        raise PermissionError(errno.EACCES, "the file exists and cannot be written to", named)
    return target


def _create(target: Path, mode: int, named: str) -> tuple[int, Path]:
    """Make a partial file and lock it; return the descriptor that holds the lock, and the file."""
    while True:
        partial = target.with_name(f"{target.name[:_MAX_NAME]}.{uuid.uuid4().hex[:12]}.partial")
        try:
            lock = os.open(partial, os.O_RDWR | os.O_CREAT | os.O_EXCL, mode)
        except OSError as error:
            raise OSError(error.errno, error.strerror, named) from None
        # Another process may have removed the file before the lock: then take another name.
        if _try_lock(lock) is not False and os.fstat(lock).st_nlink:
            return lock, partial
        os.close(lock)


def _remove_left_over(target: Path) -> None:
    """Remove the partial files of this target that no process holds."""
    name = re.compile(re.escape(target.name[:_MAX_NAME]) + r"\.[0-9a-f]{12}\.partial")
    others: list[str] = []
    with contextlib.suppress(OSError):  # a folder that cannot be listed
        others = os.listdir(target.parent)
    for other in others:
        partial = target.with_name(other)
        if name.fullmatch(other) and partial.is_file() and not partial.is_symlink():
            with contextlib.suppress(OSError), partial.open("r+b") as file:  # another user's, or gone
                if _try_lock(file.fileno()):
                    partial.unlink()


def _try_lock(descriptor: int) -> bool | None:
    """Lock a file; return whether that worked, or None if files cannot be locked here."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def _with_number(error: BaseException | None, outer: BaseException | None) -> OSError | None:
    """Return an error, or the first one before it but after `outer`, that has the number of the system's error.

    Libraries that fail to write say so when they close the file, which fails too, without a number.
    """
    while error is not None and error is not outer:
        if isinstance(error, OSError) and error.errno:
            return error
        error = error.__context__
    return None


def _keep_owner_and_mode(partial: Path, before: os.stat_result) -> None:
    mode = stat.S_IMODE(before.st_mode)
    now = partial.stat()
    if (now.st_uid, now.st_gid) != (before.st_uid, before.st_gid):
        try:
            os.chown(partial, before.st_uid, before.st_gid)
        except (OSError, AttributeError):
            mode &= 0o1777  # no setuid or setgid for another owner
    partial.chmod(mode)


def _sync_file(path: Path) -> None:
    with path.open("r+b") as file:
        _sync(file.fileno())


def _sync(descriptor: int, passed_over: tuple[int, ...] = _CANNOT_SYNC) -> None:
    """Wait until a file or a folder is on the disk, where the system supports that."""
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in passed_over:
            raise
