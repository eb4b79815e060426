"""Builds of forests that end early, whatever the reason: the same call goes on, and the forest is the same bytes."""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.forests import strands
from support.patience import HANGS
from support.windows import refuse_files_in_use

import fastlines as fl
from fastlines.forest.building.journal import Journal
from fastlines.support.atomic_write import atomic_write

WRITERS = ("support.container", "forest.manifest", "forest.building.journal")


def contents(folder: Path) -> dict[str, bytes]:
    """Return the bytes of all files of a folder."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def chunks(n: int = 6) -> Iterator[fl.Lines]:
    for i in range(n):
        yield replace(strands(100, i), attributes={"age": np.arange(100) + i})


def files(folder: Path, n: int = 3) -> list[Path]:
    """Write files of lines, and return their paths."""
    folder.mkdir()
    for i, lines in enumerate(chunks(n)):
        fl.write(folder / f"{i}.npz", lines)
    return sorted(folder.iterdir())


def fail_at(monkeypatch: pytest.MonkeyPatch, number: int, error: Callable[[], BaseException]) -> list[str]:
    """Raise an error in place of the file of this number; return the files that are begun."""
    begun: list[str] = []

    @contextmanager
    def write(path: Any, **options: Any) -> Iterator[Path]:
        begun.append(os.fspath(path))
        if len(begun) == number:
            raise error()
        with atomic_write(path, **options) as partial:
            yield partial

    for module in WRITERS:
        monkeypatch.setattr(f"fastlines.{module}.atomic_write", write)
    return begun


@pytest.fixture(autouse=True)
def _small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fastlines.forest.building.budget.CHUNK", 150)


@pytest.mark.parametrize("kind", ["chunks", "files"])
def test_interrupted_at_each_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    paths = files(tmp_path / "files")

    def build(name: str) -> fl.Forest:
        return fl.build_forest(paths if kind == "files" else chunks(), tmp_path / name, max_segments=130)

    expected = contents(build("whole").path)
    for number in itertools.count(1):
        with monkeypatch.context() as patch:
            begun = fail_at(patch, number, KeyboardInterrupt)
            try:
                build(f"{number}")
            except KeyboardInterrupt:
                pass
            else:
                break
        assert len(begun) >= number  # parts are written by several threads
        assert contents(build(f"{number}").path) == expected
    assert number > 15
    # Interrupted again and again, each time after two more files.
    n_times = 0
    while True:
        with monkeypatch.context() as patch:
            fail_at(patch, 3, KeyboardInterrupt)
            try:
                forest = build("often")
            except KeyboardInterrupt:
                n_times += 1
                continue
            break
    assert n_times > 5
    assert contents(forest.path) == expected


def test_a_power_failure_at_each_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was not synced by then is cut short, has lost a page, or is gone."""
    expected = contents(fl.build_forest(chunks(), tmp_path / "whole", max_segments=130).path)
    n_torn = n_gone = 0
    for number in itertools.count(1):
        folder, synced, named = tmp_path / f"{number}", set(), set()
        with monkeypatch.context() as patch:
            fsync = os.fsync

            def sync(descriptor: int, fsync: Any = fsync, synced: Any = synced, named: Any = named) -> None:
                synced.add(os.fstat(descriptor).st_ino)
                if stat.S_ISDIR(os.fstat(descriptor).st_mode):
                    with os.scandir(descriptor) as entries:
                        named.update(entry.inode() for entry in entries)
                fsync(descriptor)

            patch.setattr(os, "fsync", sync)
            fail_at(patch, number, KeyboardInterrupt)
            try:
                fl.build_forest(chunks(), folder, max_segments=130)
            except KeyboardInterrupt:
                pass
            else:
                break
        files = [path for path in folder.rglob("*") if path.is_file()]
        if number % 3 == 0:
            gone = [path for path in files if path.stat().st_ino not in named]
            n_gone += len(gone)
            for path in gone:
                path.unlink()
        torn = [path for path in files if path.exists() and path.stat().st_ino not in synced]
        for path in torn:
            data = path.read_bytes()
            path.write_bytes(data[: len(data) // 2] if number % 2 else data[:-128] + bytes(min(len(data), 128)))
        n_torn += len(torn)
        assert contents(fl.build_forest(chunks(), folder, max_segments=130).path) == expected
    assert number > 15
    assert n_torn > 10
    assert n_gone > 5


def test_a_disk_that_fills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = contents(fl.build_forest(chunks(), tmp_path / "whole", max_segments=130).path)
    for number in (2, 7, 12, 16):
        with monkeypatch.context() as patch:
            begun = fail_at(patch, number, lambda: OSError(errno.ENOSPC, "No space left on device"))
            with pytest.raises(
                OSError, match=r"not enough space on the disk \(\d+ MB are free\).*free some more, and call"
            ) as raised:
                fl.build_forest(chunks(), tmp_path / f"{number}", max_segments=130)
        assert raised.value.errno == errno.ENOSPC
        assert len(begun) >= number  # parts are written by several threads
        assert contents(fl.build_forest(chunks(), tmp_path / f"{number}", max_segments=130).path) == expected
    with monkeypatch.context() as patch:
        fail_at(patch, 3, lambda: OSError(errno.EIO, "Input/output error"))
        with pytest.raises(OSError, match=r"Input/output error: '.*other'$"):
            fl.build_forest(chunks(), tmp_path / "other", max_segments=130)


PROGRAM = """
import sys
import fastlines as fl
fl.set_num_threads(2)
fl.build_forest  # imports what it needs
print("begin", flush=True)
fl.build_forest(sys.argv[1].split(","), sys.argv[2], max_segments=700)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
def test_killed_at_random_moments(tmp_path: Path) -> None:
    paths = ",".join(map(str, files(tmp_path / "files", 20)))
    expected = contents(fl.build_forest(paths.split(","), tmp_path / "whole", max_segments=700).path)
    rng = np.random.default_rng()
    folder, n_killed = tmp_path / "killed", 0
    for _ in range(8):
        process = subprocess.Popen([sys.executable, "-c", PROGRAM, paths, str(folder)], stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(rng.uniform(0, 0.3))
        process.send_signal(signal.SIGKILL)
        n_killed += process.wait(HANGS) == -signal.SIGKILL
        process.stdout.close()
        if n_killed == 3:
            break
    assert contents(fl.build_forest(paths.split(","), folder, max_segments=700).path) == expected


def begin(folder: Path, monkeypatch: pytest.MonkeyPatch, source: Any, number: int = 5, **more: Any) -> None:
    """Begin a build that is interrupted."""
    with monkeypatch.context() as patch:
        fail_at(patch, number, KeyboardInterrupt)
        with pytest.raises(KeyboardInterrupt):
            fl.build_forest(source, folder, **{"max_segments": 130, **more})


def test_another_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths, folder = files(tmp_path / "files"), tmp_path / "forest"
    begin(folder, monkeypatch, paths)
    with pytest.raises(fl.InputError, match=r"has begun a forest with source 3 files, and 2 files was given"):
        fl.build_forest(paths[:2], folder, max_segments=130)
    with pytest.raises(fl.InputError, match=r'source \["chunks"\]|with source'):
        fl.build_forest(chunks(), folder, max_segments=130)
    os.utime(paths[1], ns=(0, 5))
    with pytest.raises(fl.InputError, match=r'1.npz".*"modified_ns": 5} was given; pass the same to go on, or delete'):
        fl.build_forest(paths, folder, max_segments=130)


def test_other_chunks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "forest"
    begin(folder, monkeypatch, chunks(), 6)
    others = [replace(chunk, attributes={"age": chunk.attributes["age"] * 2}) for chunk in chunks()]
    with pytest.raises(
        fl.InputError, match=r"the source is not the one that the forest .* was begun with: it differs from"
    ):
        fl.build_forest(others, folder, max_segments=130)
    with pytest.raises(fl.InputError, match=r"it ends after 200 segments; pass the same from its beginning, or delete"):
        fl.build_forest(chunks(2), folder, max_segments=130)
    whole = fl.build_forest(chunks(), tmp_path / "whole", max_segments=130)
    assert contents(fl.build_forest(chunks(), folder, max_segments=130).path) == contents(whole.path)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"max_segments": 140}, "max_segments 130, and 140 was given"),
        ({"method": "kd-cl"}, 'method null, and "kd-cl" was given'),
        ({"lanes": 8}, r'settings {}, and {"lanes": "8"} was given'),
        ({"offset": "auto"}, r'offset \[0.0, 0.0, 0.0\], and "auto" was given'),
        ({"invalid": "skip"}, 'invalid "error", and "skip" was given'),
    ],
)
def test_other_settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: dict[str, Any], why: str) -> None:
    begin(tmp_path / "forest", monkeypatch, chunks())
    with pytest.raises(
        fl.InputError, match=f"has begun a forest with {why}; pass the same to go on, or delete the folder"
    ):
        fl.build_forest(chunks(), tmp_path / "forest", **{"max_segments": 130, **given})


def test_other_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The memory counts only where it decides how large tiles are."""
    expected = contents(fl.build_forest(chunks(), tmp_path / "whole", max_segments=130).path)
    begin(tmp_path / "forest", monkeypatch, chunks())
    monkeypatch.setattr("fastlines.forest.building.budget.CHUNK", 40)
    assert contents(fl.build_forest(chunks(), tmp_path / "forest", max_segments=130, memory=10**9).path) == expected
    begin(tmp_path / "default", monkeypatch, chunks(), max_segments=None, memory=10**9)
    with pytest.raises(fl.InputError, match=r"memory 1000000000, and 2000000000 was given"):
        fl.build_forest(chunks(), tmp_path / "default", memory=2 * 10**9)


def test_nothing_is_begun_before_the_first_chunk(tmp_path: Path) -> None:
    """A source or a setting that was wrong does not occupy the folder."""
    (tmp_path / "bad.tck").write_text("no")
    with pytest.raises(fl.FileFormatError):
        fl.build_forest(tmp_path / "bad.tck", tmp_path / "forest")
    assert fl.build_forest(chunks(), tmp_path / "forest", max_segments=130).n_prims == 600


def test_a_forest_that_is_whole(tmp_path: Path) -> None:
    paths, folder = files(tmp_path / "files"), tmp_path / "forest"
    before = contents(fl.build_forest(paths, folder, max_segments=130).path)
    assert fl.build_forest(paths, folder, max_segments=130).n_prims == 300
    assert contents(folder) == before
    with pytest.raises(
        fl.InputError, match=r"holds a forest with max_segments 130, and 140 was given; fl.Forest opens it"
    ):
        fl.build_forest(paths, folder, max_segments=140)
    fl.build_forest(chunks(), tmp_path / "other")
    with pytest.raises(fl.InputError, match=r"holds a whole forest, and whether it is of these chunks cannot be told"):
        fl.build_forest(chunks(), tmp_path / "other")


@pytest.mark.parametrize("name", ["00001.flt", "index.fli", "forest.json"])
@pytest.mark.parametrize("damage", ["missing", "truncated", "changed"])
def test_a_damaged_forest_is_repaired(tmp_path: Path, name: str, damage: str) -> None:
    paths, folder = files(tmp_path / "files"), tmp_path / "forest"
    before = contents(fl.build_forest(paths, folder, max_segments=130).path)
    kept = (folder / "00000.flt").stat().st_ino
    path = folder / name
    data = path.read_bytes()
    path.unlink()
    if damage != "missing":
        path.write_bytes(data[:200] if damage == "truncated" else data[:-200] + bytes(200))
    assert contents(fl.build_forest(paths, folder, max_segments=130).path) == before
    if name != "forest.json":
        assert (folder / "00000.flt").stat().st_ino == kept


def test_folders_that_hold_something_else(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("text")
    with pytest.raises(fl.InputError, match=r"file is a file; expected a new folder for a forest"):
        fl.build_forest(chunks(), tmp_path / "file")
    with pytest.raises(fl.InputError, match=r"holds other files: file; name a new or an empty folder"):
        fl.build_forest(chunks(), tmp_path)
    with pytest.raises(FileNotFoundError, match=r"there is no folder .*; make it first"):
        fl.build_forest(chunks(), tmp_path / "none" / "forest")
    (tmp_path / "empty").mkdir()
    assert fl.build_forest(chunks(), tmp_path / "empty").n_prims == 600


def test_a_damaged_journal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begin(tmp_path / "forest", monkeypatch, chunks())
    (tmp_path / "forest" / "build.json").write_text("[1")
    with pytest.raises(fl.InputError, match=r"build.json is damaged; delete the folder"):
        fl.build_forest(chunks(), tmp_path / "forest", max_segments=130)


def test_chunks_that_a_power_failure_has_damaged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = contents(fl.build_forest(chunks(), tmp_path / "whole", max_segments=130).path)
    begin(tmp_path / "forest", monkeypatch, chunks(), 6)
    damaged = sorted((tmp_path / "forest" / ".building" / "chunks").iterdir())[1]
    damaged.write_bytes(bytes(damaged.stat().st_size))
    assert contents(fl.build_forest(chunks(), tmp_path / "forest", max_segments=130).path) == expected


@pytest.mark.skipif(sys.platform == "win32", reason="flock")
def test_two_builds_at_a_time(tmp_path: Path) -> None:
    def slowly() -> Iterator[fl.Lines]:
        yield from chunks(2)
        with pytest.raises(fl.InputError, match=r"another process builds the forest .*; wait for it, or name another"):
            fl.build_forest(chunks(), tmp_path / "forest", max_segments=130)

    assert fl.build_forest(slowly(), tmp_path / "forest", max_segments=130).n_prims == 200


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_fork_does_not_hold_the_lock(tmp_path: Path) -> None:
    """Workers of a pool may live on after the build is killed."""
    journal = Journal(tmp_path)
    journal.check({})
    with journal.locked():
        worker = os.fork()
        if not worker:
            time.sleep(HANGS)
            os._exit(0)
    try:
        for _ in range(100):  # until the fork has run
            with contextlib.suppress(fl.InputError), journal.locked():
                return
            time.sleep(HANGS / 100)
        pytest.fail("the fork holds the lock")
    finally:
        os.kill(worker, signal.SIGKILL)
        os.waitpid(worker, 0)


@pytest.mark.skipif(sys.platform == "win32", reason="flock")
def test_a_build_that_must_wait_leaves_no_settings(tmp_path: Path) -> None:
    """The folder still says what the build that has begun first is of."""

    def slowly() -> Iterator[fl.Lines]:
        with pytest.raises(fl.InputError, match="another process builds"):
            fl.build_forest(chunks(), tmp_path / "forest", max_segments=90)
        raise OSError("stopped")
        yield

    with pytest.raises(OSError, match="stopped"):
        fl.build_forest(slowly(), tmp_path / "forest", max_segments=130)
    assert '"max_segments": 130' in (tmp_path / "forest" / "build.json").read_text()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_no_file_is_removed_while_it_is_open_or_mapped(tmp_path, monkeypatch):
    """Windows refuses that."""
    refuse_files_in_use(monkeypatch)
    fl.build_forest(list(chunks(3)), tmp_path / "forest", max_segments=100)
    assert not list(tmp_path.rglob("lock"))
