"""Files that are written whole or not at all: what they replace, what is left behind, and what errors name."""

from __future__ import annotations

import errno
import os
import socket
import stat
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from support.command_line import done, refused
from support.patience import HANGS

import fastlines as fl
from fastlines.rendering.pictures.images import write_depth, write_picture
from fastlines.support.atomic_write import atomic_write

TREE = fl.build([[[0, 0, 0], [1, 1, 1]]])
LEFT_OVER = "a.flt.0123456789ab.partial"


def write(path: Path, text: str = "new") -> None:
    with atomic_write(path) as partial:
        partial.write_text(text)


def names(folder: Path) -> list[str]:
    return sorted(os.listdir(folder))


def mode_of(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


# --- What is written ---


@pytest.mark.parametrize("there", [True, False])
def test_a_link_stays_and_what_it_names_is_written(tmp_path, there):
    (tmp_path / "real").mkdir()
    target = tmp_path / "real" / "target.flt"
    if there:
        target.write_bytes(b"old")
    (tmp_path / "link.flt").symlink_to(Path("real") / "target.flt")
    (tmp_path / "to link.flt").symlink_to("link.flt")
    TREE.save(tmp_path / "to link.flt")
    assert (tmp_path / "link.flt").is_symlink()
    assert (tmp_path / "to link.flt").is_symlink()
    assert len(fl.load(target).geometry) == 1
    assert names(tmp_path) == ["link.flt", "real", "to link.flt"]
    assert names(tmp_path / "real") == ["target.flt"]


def test_a_link_that_leads_nowhere(tmp_path):
    (tmp_path / "a").symlink_to("missing/a")
    with pytest.raises(FileNotFoundError, match=r"there is no folder .*missing; make it first"):
        write(tmp_path / "a")
    (tmp_path / "b").symlink_to("b")
    with pytest.raises(OSError, match=r"b'$"):
        write(tmp_path / "b")
    assert names(tmp_path) == ["a", "b"]


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664, 0o755])
def test_a_file_keeps_its_mode(tmp_path, mode):
    for name, save in {
        "a.flt": TREE.save,
        "a.png": lambda path: write_picture(path, np.zeros((2, 2), np.uint8)),
        "a.exr": lambda path: write_depth(path, np.zeros((2, 2), np.float32)),
    }.items():
        if name == "a.exr":
            pytest.importorskip("OpenEXR")
        path = tmp_path / name
        path.write_bytes(b"old")
        path.chmod(mode)
        save(path)
        assert path.read_bytes() != b"old"
        assert mode_of(path) == mode


@pytest.mark.parametrize(("mask", "mode"), [(0o022, 0o644), (0o027, 0o640), (0o077, 0o600)])
def test_a_new_file_gets_the_usual_mode(tmp_path, mask, mode):
    before = os.umask(mask)
    try:
        write(tmp_path / "a")
    finally:
        os.umask(before)
    assert mode_of(tmp_path / "a") == mode


def test_a_file_is_not_open_to_others_before_it_is_whole(tmp_path):
    (tmp_path / "a").touch(0o600)
    with atomic_write(tmp_path / "a") as partial:
        assert mode_of(partial) == 0o600


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root may give files away")
def test_a_file_keeps_its_owner_where_that_can_be(tmp_path, monkeypatch):
    def refuse(*_: object) -> None:
        raise PermissionError(errno.EPERM, "Operation not permitted")

    path = tmp_path / "a"
    path.touch()
    os.chown(path, 1234, 4321)
    path.chmod(0o4755)
    write(path)
    assert (path.stat().st_uid, path.stat().st_gid, mode_of(path)) == (1234, 4321, 0o4755)
    monkeypatch.setattr(os, "chown", refuse)
    write(path)
    assert (path.stat().st_uid, mode_of(path)) == (os.getuid(), 0o755), "nobody's programs run as somebody else"


def test_other_hard_links_keep_the_old_content(tmp_path):
    write(tmp_path / "a", "old")
    os.link(tmp_path / "a", tmp_path / "b")
    write(tmp_path / "a")
    assert ((tmp_path / "a").read_text(), (tmp_path / "b").read_text()) == ("new", "old")


# --- What is not a regular file ---


def test_what_is_no_regular_file_is_refused_and_stays(tmp_path):
    os.mkfifo(tmp_path / "pipe.flt")
    (tmp_path / "link.flt").symlink_to("pipe.flt")
    with socket.socket(socket.AF_UNIX) as server:
        folder = os.getcwd()
        os.chdir(tmp_path)  # the path of a socket must be short
        try:
            server.bind("socket.flt")
        finally:
            os.chdir(folder)
        for name, kind in {"pipe.flt": "a pipe", "link.flt": "a pipe", "socket.flt": "a socket"}.items():
            with pytest.raises(fl.InputError, match=rf"{name}: is {kind}; expected a regular file; write to one"):
                TREE.save(tmp_path / name)
    with pytest.raises(fl.InputError, match="/dev/null: is a device; expected a regular file"):
        TREE.save("/dev/null")
    with pytest.raises(IsADirectoryError, match="is a directory; expected the name of a file to write"):
        TREE.save(tmp_path)
    assert stat.S_ISFIFO((tmp_path / "pipe.flt").stat().st_mode)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    assert names(tmp_path) == ["link.flt", "pipe.flt", "socket.flt"]


@pytest.mark.usefixtures("in_own_folder")
def test_the_command_line_refuses_them_before_the_work():
    os.mkfifo("pipe.flt")
    assert refused("build", "scene:spaghetti:99999999", "-o", "pipe.flt")[1].startswith("error: pipe.flt: is a pipe;")
    os.symlink("real.flt", "link.flt")
    done("build", "scene:spaghetti:20", "-o", "link.flt")
    assert os.path.islink("link.flt")
    done("validate", "real.flt")


def test_paths_that_are_none(tmp_path):
    with pytest.raises(fl.InputError, match=r"is not the path of a file"):
        write(tmp_path / "a\0b")
    with pytest.raises(FileNotFoundError):
        write("")


# --- Partial files ---


def test_partial_files_of_killed_processes_are_removed_by_the_next_save(tmp_path):
    kill = f"""if True:
        import os, signal
        from fastlines.support.atomic_write import atomic_write
        with atomic_write({str(tmp_path / "a.flt")!r}) as partial:
            partial.write_bytes(b"half")
            os.kill(os.getpid(), signal.SIGKILL)"""
    subprocess.run([sys.executable, "-c", kill], check=False, timeout=HANGS)
    (tmp_path / LEFT_OVER).touch()
    assert len(names(tmp_path)) == 2
    others = ["a.flt.partial", "b.flt.0123456789ab.partial", "a.flt.0123456789ab.partial.txt"]
    for name in others:
        (tmp_path / name).touch()
    TREE.save(tmp_path / "a.flt")
    assert names(tmp_path) == sorted(["a.flt", *others])


def test_what_looks_like_a_partial_file_and_is_none(tmp_path):
    (tmp_path / LEFT_OVER).mkdir()
    (tmp_path / LEFT_OVER.replace("0", "f")).symlink_to("victim")
    (tmp_path / "victim").touch()
    os.mkfifo(tmp_path / LEFT_OVER.replace("0", "e"))
    before = names(tmp_path)
    TREE.save(tmp_path / "a.flt")
    assert names(tmp_path) == sorted([*before, "a.flt"])


def test_partial_files_of_living_writers_stay_and_the_last_wins(tmp_path):
    path = tmp_path / "a.flt"
    with atomic_write(path) as mine:
        mine.write_text("mine")
        write(path, "this thread's")
        other = threading.Thread(target=write, args=(path, "another thread's"))
        other.start()
        other.join()
        subprocess.run(
            [sys.executable, "-c", f"import fastlines as fl; fl.build([[[0, 0, 0], [1, 1, 1]]]).save({str(path)!r})"],
            check=True,
            timeout=HANGS,
        )
        assert len(fl.load(path).geometry) == 1
        assert mine.read_text() == "mine"
    assert path.read_text() == "mine"
    assert names(tmp_path) == ["a.flt"]


def test_many_savers_at_a_time(tmp_path):
    path = tmp_path / "a"
    texts = [str(i) * 100_000 for i in range(8)]
    failures: list[BaseException] = []

    def save(text: str) -> None:
        try:
            for _ in range(20):
                write(path, text)
                assert path.read_text() in texts
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=save, args=(text,)) for text in texts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []
    assert path.read_text() in texts
    assert names(tmp_path) == ["a"]


def test_a_writer_whose_partial_file_was_taken_for_left_over_takes_another(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")
    flock = fcntl.flock
    seen: list[str] = []

    def held_or_removed_at_first(descriptor: int, how: int) -> None:
        (partial,) = names(tmp_path)
        seen.append(partial)
        if len(seen) == 1:
            raise BlockingIOError
        if len(seen) == 2:
            os.unlink(tmp_path / partial)
        flock(descriptor, how)

    def forget(descriptor: int) -> None:
        close(descriptor)
        for name in names(tmp_path):
            os.unlink(tmp_path / name)

    close = os.close
    monkeypatch.setattr(fcntl, "flock", held_or_removed_at_first)
    monkeypatch.setattr(os, "close", lambda descriptor: forget(descriptor) if len(seen) < 3 else close(descriptor))
    write(tmp_path / "a")
    assert len(set(seen)) == 3
    assert names(tmp_path) == ["a"]


def test_a_name_as_long_as_names_can_be(tmp_path):
    for name in ("a" * 255, "ž" * 127):
        write(tmp_path / name)
        assert (tmp_path / name).read_text() == "new"


# --- Errors ---


def test_errors_name_the_path_that_was_given(tmp_path, monkeypatch):
    path = tmp_path / "a.flt"
    path.write_text("old")
    monkeypatch.chdir(tmp_path)

    def fails(error: Exception) -> str:
        with pytest.raises(type(error)) as caught, atomic_write("a.flt"):
            raise error
        assert ".partial" not in str(caught.value) + str(getattr(caught.value, "filename", ""))
        assert names(tmp_path) == ["a.flt"]
        assert path.read_text() == "old"
        return str(caught.value)

    assert fails(OSError(errno.ENOSPC, "No space left on device")) == "[Errno 28] No space left on device: 'a.flt'"
    assert fails(OSError(errno.EIO, "Input/output error", "b.flt")) == "[Errno 5] Input/output error: 'b.flt'"
    assert fails(OSError("disk full")) == "a.flt: disk full"

    def refuse(partial: Path, target: Path) -> None:
        raise OSError(errno.EXDEV, "Invalid cross-device link", str(partial), None, str(target))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", refuse)
        with pytest.raises(OSError, match=r"^\[Errno 18\] Invalid cross-device link: 'a\.flt'$"):
            write(Path("a.flt"))
    with pytest.raises(RuntimeError, match=r"^cannot open file a\.flt$"), atomic_write("a.flt") as partial:
        raise RuntimeError(f"cannot open file {partial}")
    with pytest.raises(NotADirectoryError, match=r"'a\.flt'$"), atomic_write("a.flt") as partial:
        (partial / "x").read_bytes()
    assert names(tmp_path) == ["a.flt"]


def test_the_first_error_of_a_library_is_named_not_its_last(tmp_path):
    def closed():
        raise OSError("error closing file")

    def write_and_close():
        try:
            raise OSError(errno.ENOSPC, "No space left on device")
        finally:
            closed()

    path = tmp_path / "a.flt"
    with pytest.raises(OSError, match=r"\[Errno 28\] No space left on device: '.*a\.flt'"), atomic_write(path):
        write_and_close()
    try:
        raise FileNotFoundError(errno.ENOENT, "another error, which is being handled", "b.flt")
    except FileNotFoundError:
        with pytest.raises(OSError, match=r"^.*a\.flt: error closing file$"), atomic_write(path):
            closed()
    assert names(tmp_path) == []


def test_a_lock_that_does_not_close_is_no_error(tmp_path, monkeypatch):
    close = os.close

    def failing(descriptor):
        close(descriptor)
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "close", failing)
    write(tmp_path / "a.flt")
    monkeypatch.undo()
    assert names(tmp_path) == ["a.flt"]
    assert (tmp_path / "a.flt").read_text() == "new"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_no_permission(tmp_path):
    (tmp_path / "locked").mkdir(0o500)
    with pytest.raises(PermissionError, match=r"the folder .*locked cannot be written to: '.*a\.flt'"):
        TREE.save(tmp_path / "locked" / "a.flt")
    (tmp_path / "a.flt").touch(0o400)
    with pytest.raises(PermissionError, match=r"the file exists and cannot be written to: '.*a\.flt'"):
        TREE.save(tmp_path / "a.flt")
