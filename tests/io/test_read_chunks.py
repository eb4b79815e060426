"""Chunks of files: joined, they are what `fl.read` returns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.line_chunks import check_chunks

import fastlines as fl


def some_lines(n_strands: int = 9, **more: object) -> fl.Lines:
    """Return strands of 1 to 5 points."""
    rng = np.random.default_rng(3)
    counts = rng.integers(1, 6, n_strands)
    points = rng.normal(size=(counts.sum(), 3)).astype(np.float32)
    return fl.Lines.from_points(points, counts, **more)


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
