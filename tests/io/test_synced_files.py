"""Files that are on the disk before they are renamed, and closed where the system asks for that."""

from __future__ import annotations

import errno
import os
import stat
import sys
from pathlib import Path

import pytest
from support.windows import refuse_files_in_use

import fastlines as fl
from fastlines.support.atomic_write import atomic_write

TREE = fl.build([[[0, 0, 0], [1, 1, 1]]])


def names(folder: Path) -> list[str]:
    return sorted(os.listdir(folder))


def test_files_are_on_the_disk_before_they_are_renamed_and_their_folder_after(tmp_path, monkeypatch):
    done_so_far = []
    fsync, replace = os.fsync, Path.replace

    def sync(descriptor: int) -> None:
        done_so_far.append("folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else os.fstat(descriptor).st_size)
        fsync(descriptor)

    def rename(path: Path, target: Path) -> None:
        done_so_far.append("rename")
        replace(path, target)

    monkeypatch.setattr(os, "fsync", sync)
    monkeypatch.setattr(Path, "replace", rename)
    with atomic_write(tmp_path / "a") as partial:
        partial.write_text("12345")
    assert done_so_far == [5, "rename", "folder"]


def test_file_systems_that_can_neither_sync_nor_lock(tmp_path, monkeypatch):
    def unknown(*_: object) -> None:
        raise OSError(errno.EINVAL, "Invalid argument")

    fcntl = pytest.importorskip("fcntl")
    monkeypatch.setattr(os, "fsync", unknown)
    monkeypatch.setattr(fcntl, "flock", unknown)
    left_over = "a.flt.0123456789ab.partial"
    (tmp_path / left_over).touch()
    TREE.save(tmp_path / "a.flt")
    assert names(tmp_path) == ["a.flt", left_over], "nobody knows whether it is held"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_no_file_is_replaced_or_removed_while_it_is_open(tmp_path, monkeypatch):
    """Windows refuses that."""
    refuse_files_in_use(monkeypatch)
    with (tmp_path / "open").open("w"), pytest.raises(PermissionError):
        (tmp_path / "open").unlink()
    (tmp_path / "open").unlink()
    for _ in range(2):
        TREE.save(tmp_path / "a.flt")
    with pytest.raises(OSError, match="full"), atomic_write(tmp_path / "a.flt"):
        raise OSError("the disk is full")
    assert names(tmp_path) == ["a.flt"]


def test_a_folder_that_cannot_be_synced_is_an_error(tmp_path, monkeypatch):
    """The new file is there, but nobody knows whether it outlives a power failure."""
    fsync = os.fsync

    def sync(descriptor: int) -> None:
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(errno.EIO, "Input/output error")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", sync)
    (tmp_path / "a").write_text("old")
    with pytest.raises(OSError, match=r"Input/output error: '.*a'$"), atomic_write(tmp_path / "a") as partial:
        partial.write_text("new")
    assert (tmp_path / "a").read_text() == "new"
    assert names(tmp_path) == ["a"]


def test_only_folders_that_cannot_be_synced_at_all_are_passed_over(tmp_path, monkeypatch):
    fsync, opened, failing, refused = os.fsync, os.open, [], {}

    def sync(descriptor: int) -> None:
        kind = "folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else "file"
        if kind in failing:
            raise OSError(errno.EBADF, "Bad file descriptor")
        fsync(descriptor)

    def open_(path, flags, *mode):
        if path == tmp_path and "number" in refused:
            raise OSError(refused["number"], "cannot be opened")
        return opened(path, flags, *mode)

    monkeypatch.setattr(os, "fsync", sync)
    monkeypatch.setattr(os, "open", open_)
    failing[:] = ["folder"]
    TREE.save(tmp_path / "a.flt")
    failing[:] = ["file"]
    with pytest.raises(OSError, match="Bad file descriptor"):
        TREE.save(tmp_path / "a.flt")
    failing.clear()
    refused["number"] = errno.EACCES
    TREE.save(tmp_path / "a.flt")
    refused["number"] = errno.EMFILE
    with pytest.raises(OSError, match="cannot be opened"):
        TREE.save(tmp_path / "a.flt")
