"""Chunks of files: joined, they are what `fl.read` returns."""

from __future__ import annotations

import gc
import gzip
import io
import os
import tracemalloc
import zipfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import line_files
from support.line_chunks import check_chunks, check_either

import fastlines as fl
from fastlines.io import source
from fastlines.io.formats import trx, trx_streamlines


def some_lines(n_strands: int = 9, *, score: bool = False, **more: Any) -> fl.Lines:
    """Return strands of 1 to 5 points, which may have a score."""
    rng = np.random.default_rng(3)
    counts = rng.integers(1, 6, n_strands)
    points = rng.normal(size=(counts.sum(), 3)).astype(np.float32)
    scores = {"score": np.arange(len(points), dtype=np.float32) ** 0.5} if score else {}
    return fl.Lines.from_points(points, counts, attributes=scores, **more)


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("name", ["a.obj", "a.npz", "a.ply", "a.safetensors", "a.swc", "a.npz.gz"])
def test_files_that_are_read_whole_are_cut(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    fl.write(path, some_lines(radius=0.5))
    assert len(check_chunks(path)) > 2


@pytest.mark.parametrize(
    "strands", [[0, 0, 1, 1], [2, 2, 7, 9], [-1, 4, -1, -1], [3, 3, 1, 1], [0, 1, 0, 1], [-5, 1, -3, 2]]
)
def test_numbers_of_strands_count_on(tmp_path: Path, strands: list[int]) -> None:
    segments = np.random.default_rng(0).normal(size=(4, 2, 3)).astype(np.float32)
    np.savez(tmp_path / "a.npz", segments=segments, strands=np.array(strands))
    chunks = list(fl.read_chunks(tmp_path / "a.npz", 1))
    whole = fl.read(tmp_path / "a.npz")
    assert sum(map(len, chunks)) == 4
    n_strands = 0
    for chunk, first in zip(chunks, np.cumsum([0, *map(len, chunks)]), strict=False):
        own = chunk.strands[chunk.strands >= 0]
        there = whole.strands[first : first + len(chunk)]
        assert np.array_equal(own + n_strands, there[there >= 0])
        n_strands += int(own.max(initial=-1)) + 1


def test_rows_that_are_skipped_count_on(tmp_path: Path) -> None:
    segments = np.random.default_rng(0).normal(size=(20, 2, 3)).astype(np.float32)
    segments[[0, 6, 7, 8, 19], 0, 0] = np.nan
    np.savez(tmp_path / "a.npz", segments=segments, strands=np.repeat(np.arange(10), 2))
    assert len(check_chunks(tmp_path / "a.npz", invalid="skip")) > 1


def test_a_file_without_lines_is_one_chunk(tmp_path: Path) -> None:
    (tmp_path / "a.swc").write_text("# nothing\n")
    (chunk,) = check_chunks(tmp_path / "a.swc")
    assert (len(chunk), chunk.unit) == (0, "µm")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"max_segments": 0}, "max_segments=0"),
        ({"invalid": "no"}, "invalid"),
        ({"progress": "no"}, "progress='no'"),
        ({"nothing": 1}, "no option 'nothing'"),
        ({"offset": "far"}, "offset='far'"),
    ],
)
def test_arguments_are_checked_at_the_call(tmp_path: Path, arguments: dict[str, object], words: str) -> None:
    fl.write(tmp_path / "a.npz", some_lines())
    with pytest.raises(fl.InputError, match=words):
        fl.read_chunks(tmp_path / "a.npz", **arguments)
    with pytest.raises(FileNotFoundError):
        fl.read_chunks(tmp_path / "b.npz")


@pytest.fixture
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let files of a few kilobytes have many pieces."""
    monkeypatch.setattr(source, "PIECE", 100)


@pytest.mark.usefixtures("small_pieces")
@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("name", ["a.trk", "a.trk.gz", "a.tck", "a.tck.gz", "a.trx"])
@pytest.mark.parametrize("options", [{}, {"offset": "auto"}, {"offset": [1000, 0.5, 2]}])
def test_streamlines(tmp_path: Path, name: str, options: dict[str, object]) -> None:
    lines = some_lines(50, score=True)
    lines = replace(lines, attributes={**lines.attributes, "length": lines.strands.astype(np.float32) / 3})
    fl.write(tmp_path / name, lines)
    for max_segments in (1, 4, 20, 1000):
        chunks = check_chunks(tmp_path / name, max_segments, **options)
        for chunk, following in pairwise(chunks):
            assert len(chunk) + np.count_nonzero(following.strands == following.strands[0]) > max_segments
    assert len(chunks) == 1
    assert ".tck" in name or list(chunks[0].attributes) == ["score", "length"]


@pytest.mark.usefixtures("small_pieces")
@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("suffix", [".trk", ".tck"])
def test_streamlines_that_are_cut_short(tmp_path: Path, suffix: str, packed: bool) -> None:
    data = (line_files.trk if suffix == ".trk" else line_files.tck)()
    path = tmp_path / (f"a{suffix}.gz" if packed else f"a{suffix}")
    for n in range(len(data) - 110, len(data) + 3):
        damaged = data[:n] + b"\0" * (n - len(data))
        path.write_bytes(gzip.compress(damaged) if packed else damaged)
        check_either(path, 1)
    if packed:
        whole = gzip.compress(data)
        for n in range(0, len(whole) + 40, 3):
            path.write_bytes(whole[:n] + b"x" * (n - len(whole)))
            check_either(path, 1)


@pytest.mark.parametrize("kind", ["stored", "deflated", "folder", "packed"])
@pytest.mark.parametrize("options", [{}, {"bundle": "left"}, {"offset": "auto"}])
def test_trx(tmp_path: Path, kind: str, options: dict[str, object]) -> None:
    method = zipfile.ZIP_DEFLATED if kind == "deflated" else zipfile.ZIP_STORED
    data = line_files.trx(extra=line_files.TRX_EXTRA, method=method)
    path = tmp_path / ("a.trx.gz" if kind == "packed" else "a.trx")
    if kind == "folder":
        zipfile.ZipFile(io.BytesIO(data)).extractall(path)
    else:
        path.write_bytes(gzip.compress(data) if kind == "packed" else data)
    chunks = check_chunks(path, 1, **options)
    assert len(chunks) == (2 if "bundle" in options else 4)
    assert "fa" in chunks[0].end_attributes
    assert ("group left" in chunks[0].attributes) == ("bundle" not in options)


def test_trx_of_many_streamlines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trx, "PART", 10)
    monkeypatch.setattr(trx_streamlines, "_BLOCK", 7)
    counts = [0, 0, 5, 1, 0, 40, 2, *[3] * 30, 0, 0]
    points = np.random.default_rng(0).random((sum(counts), 3), np.float32)
    extra = {"groups/some.int16": np.arange(1, 39, 3).astype("<i2").tobytes()}
    (tmp_path / "a.trx").write_bytes(line_files.trx(counts=counts, points=points, extra=extra))
    for max_segments in (1, 5, 30, 1000):
        check_chunks(tmp_path / "a.trx", max_segments)


@pytest.mark.parametrize("name", ["some.trk", "some.tck", "some.trx", "some.npy", "some.npy.gz"])
def test_damaged_files(tmp_path: Path, name: str) -> None:
    data, path = line_files.SAMPLES[name], tmp_path / name
    rng = np.random.default_rng(5)
    for _ in range(150):
        damaged = bytearray(data)
        for at in rng.integers(len(data), size=2):
            damaged[at] = rng.integers(256)
        path.write_bytes(damaged[: rng.integers(len(data))] if rng.random() < 0.2 else damaged)
        check_either(path, 2)
        check_either(path, 2, invalid="skip")


@pytest.mark.parametrize("dtype", ["<f4", ">f4", "<f8", "<f2", "<i8", "u1", "?"])
@pytest.mark.parametrize("shape", [(30, 2, 3), (30, 6), (0, 6)])
@pytest.mark.parametrize("options", [{}, {"offset": "auto"}, {"offset": [1000, 0.5, 2]}])
def test_npy(tmp_path: Path, dtype: str, shape: tuple[int, ...], options: dict[str, object]) -> None:
    values = np.random.default_rng(0).integers(0, 100, shape).astype(dtype)
    np.save(tmp_path / "a.npy", values)
    assert len(check_chunks(tmp_path / "a.npy", 7, **options)) == (5 if len(values) else 1)
    np.save(tmp_path / "b.npy", np.asfortranarray(values))
    check_chunks(tmp_path / "b.npy", 7, **options)
    (tmp_path / "c.npy.gz").write_bytes(gzip.compress((tmp_path / "a.npy").read_bytes()))
    check_chunks(tmp_path / "c.npy.gz", 7, **options)


@pytest.mark.parametrize("place", [4e6, 4e7])
def test_rounding_is_that_of_the_whole_file(tmp_path: Path, place: float) -> None:
    points = np.random.default_rng(0).random((400, 2, 3)) * [1, 10, 100] + [0, place, 0]
    points[5, 0, 0], points[100:200] = np.nan, 1e31
    np.save(tmp_path / "a.npy", points)
    assert len(check_chunks(tmp_path / "a.npy", 50, invalid="skip")) == 8
    check_chunks(tmp_path / "a.npy", 50, invalid="skip", offset="auto")


def test_the_error_of_a_chunk_counts_rows_of_the_file(tmp_path: Path) -> None:
    segments = np.zeros((10, 2, 3))
    segments[[5, 9]] = np.inf
    np.save(tmp_path / "a.npy", segments)
    chunks = fl.read_chunks(tmp_path / "a.npy", 4)
    assert len(next(chunks)) == 4
    with pytest.raises(fl.InputError, match=r"a\.npy: 1 of the first 8 segments hold NaN.*\(row 5\); fix them"):
        next(chunks)


NAMES = ["a.trk", "a.trk.gz", "a.tck", "a.trx", "a.npy", "a.npz"]


def open_files() -> int:
    return len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("name", NAMES)
def test_files_are_closed_when_reading_ends_early(tmp_path: Path, name: str) -> None:
    fl.write(tmp_path / name, some_lines(200))
    gc.collect()  # what other tests have left
    n_open = open_files()
    chunks = fl.read_chunks(tmp_path / name, 10)
    next(chunks)
    chunks.close()
    assert open_files() == n_open
    for _ in fl.read_chunks(tmp_path / name, 10):
        break
    gc.collect()
    assert open_files() == n_open
    with pytest.raises(StopIteration):
        next(chunks)


@pytest.mark.usefixtures("small_pieces")
@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("name", NAMES)
def test_progress_rises_from_0_to_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setattr(trx, "PART", 50)
    fl.write(tmp_path / name, some_lines(200))
    shares: list[float] = []
    n_before = []
    for _ in fl.read_chunks(tmp_path / name, 50, progress=shares.append):
        n_before.append(len(shares))
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0, 1)
    assert name == "a.npz" or n_before[0] < n_before[-1]


@pytest.mark.usefixtures("small_pieces")
@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("error", [ZeroDivisionError, fl.InputError, KeyboardInterrupt])
def test_an_error_of_the_callback_ends_reading(tmp_path: Path, name: str, error: type[BaseException]) -> None:
    fl.write(tmp_path / name, some_lines(200))
    n_open = open_files()

    def stop(share: float) -> None:
        if share > 0.3:
            raise error("stop")

    with pytest.raises(error, match=r"^stop$"):
        list(fl.read_chunks(tmp_path / name, 10, progress=stop))
    assert open_files() == n_open


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
def test_memory_is_that_of_a_chunk(tmp_path: Path) -> None:
    points = np.random.default_rng(0).random((400_000, 3), np.float32)
    lines = fl.Lines.from_points(points, [100] * 4000)
    for name in ("a.trk", "a.trk.gz", "a.tck", "a.trx", "a.npy"):
        fl.write(tmp_path / name, lines)
        list(fl.read_chunks(tmp_path / name, 20_000))
        tracemalloc.start()
        try:
            for chunk in fl.read_chunks(tmp_path / name, 20_000):
                assert len(chunk) <= 20_000
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert peak < 14e6 < lines.segments.nbytes * 1.5, name
