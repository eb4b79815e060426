"""Chunks of files: joined, they are what `fl.read` returns."""

from __future__ import annotations

import gzip
import io
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


@pytest.mark.parametrize("strands", [[0, 0, 1, 1], [2, 2, 7, 9], [-1, 4, -1, -1], [3, 3, 1, 1], [0, 1, 0, 1]])
def test_numbers_of_strands_count_on(tmp_path: Path, strands: list[int]) -> None:
    segments = np.random.default_rng(0).normal(size=(4, 2, 3)).astype(np.float32)
    fl.write(tmp_path / "a.npz", fl.Lines(segments, np.array(strands)))
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
