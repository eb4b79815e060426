"""Chunks of tables: joined, they are what `fl.read` returns."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.line_chunks import check_chunks, check_either, check_error

import fastlines as fl

pa = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

from fastlines.io.formats import arrow_chunks  # noqa: E402

N = 60
RNG = np.random.default_rng(8)
STRANDS = np.sort(RNG.integers(0, 12, N)) * 3 + 2


@pytest.fixture(autouse=True)
def few_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read few rows at a time."""
    monkeypatch.setattr(arrow_chunks, "_ROWS", 7)


def points(**more: Any) -> Any:
    x, y, z = RNG.normal(size=(3, N)) * 10
    return pa.table({"x": x, "y": y, "z": z, "strand": STRANDS} | more)


def segments(**more: Any) -> Any:
    return pa.table(dict(zip(("x0", "y0", "z0", "x1", "y1", "z1"), RNG.normal(size=(6, N)), strict=True)) | more)


def written(folder: Path, table: Any, name: str = "a.parquet") -> Path:
    """Write a table in small row groups, or in several files to a folder."""
    path = folder / name
    if name.endswith(".parquet"):
        parquet.write_table(table, path, row_group_size=11)
    elif name.endswith("/"):
        path.mkdir()
        for i in range(4):
            parquet.write_table(table.slice(15 * i, 15), path / f"part-{i}.parquet", row_group_size=4)
    else:
        kind = pa.ipc.new_file if name.endswith(".arrow") else pa.ipc.new_stream
        with pa.OSFile(str(path), "wb") as sink, kind(sink, table.schema) as writer:
            writer.write_table(table, max_chunksize=9)
    return path


NAMES = ["a.parquet", "a.arrow", "a.feather", "lines/", "lines.parquet/"]
OPTIONS: list[dict[str, Any]] = [{}, {"offset": "auto"}, {"offset": [1000, 0.5, 2]}]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("options", OPTIONS)
def test_points(tmp_path: Path, name: str, options: dict[str, Any]) -> None:
    table = points(radius=RNG.random(N), age=np.arange(N), label=["a"] * N)
    path = written(tmp_path, table, name)
    for max_segments in (1, 10, 1000):
        chunks = check_chunks(path, max_segments, **options)
    assert len(chunks) == 1


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("options", OPTIONS)
def test_segments(tmp_path: Path, name: str, options: dict[str, Any]) -> None:
    table = segments(strand=STRANDS, radius=RNG.random(N), on=RNG.random(N) < 0.5)
    table = table.replace_schema_metadata({"up": "z", "unit": "km", "metadata": '{"who": "me", "offset": [1, 2, 3]}'})
    path = written(tmp_path, table, name)
    for max_segments in (1, 10, 1000):
        chunks = check_chunks(path, max_segments, **options)
    assert (chunks[0].unit, chunks[0].metadata["who"]) == ("km", "me")


@pytest.mark.parametrize(
    "strand",
    [
        np.arange(N) % 7,  # read whole
        np.repeat([0, 1], [50, 10]),
        np.where(np.arange(N) % 5, STRANDS, -1),
        pa.array([f"track {i}" for i in np.sort(-STRANDS)]),
        pa.array([f"track {i}" for i in np.sort(-STRANDS)]).dictionary_encode(),
        pa.array([f"track {i % 7}" for i in range(N)]),
        pa.array(STRANDS, pa.uint16()),
    ],
)
@pytest.mark.parametrize("make", [points, segments])
@pytest.mark.parametrize("name", ["a.parquet", "lines/"])
def test_numbers_of_strands(tmp_path: Path, strand: Any, make: Any, name: str) -> None:
    check_either(written(tmp_path, make(strand=strand), name), 5)


def test_columns_with_empty_rows(tmp_path: Path) -> None:
    age = pa.array([None if i == 40 else i for i in range(N)])
    on = pa.array([None if i == 3 else True for i in range(N)])
    tint = pa.FixedSizeListArray.from_arrays(pa.array(np.arange(2 * N)), 2)
    weight = pa.array([None if i == 50 else float(i) for i in range(N)])
    chunks = check_chunks(written(tmp_path, segments(age=age, on=on, tint=tint, weight=weight)), 5)
    assert [chunks[0].attributes[name].dtype.kind for name in ("age", "on", "tint")] == ["f", "f", "i"]
    strand = pa.array([None if i == 40 else i for i in range(N)])
    assert "has 1 empty rows" in check_error(written(tmp_path, points(strand=strand)))
    assert "numbers from -3" in check_error(written(tmp_path, segments(strand=np.arange(N) - 3)))


def test_rows_that_are_skipped(tmp_path: Path) -> None:
    x = np.where(np.arange(N) % 6 == 1, np.nan, np.arange(N))
    check_chunks(written(tmp_path, points(x=x)), 5, invalid="skip")
    check_chunks(written(tmp_path, segments(x0=x, strand=STRANDS)), 5, invalid="skip")
    check_error(written(tmp_path, segments(x0=x)), 5)


def test_an_error_of_the_radius_counts_rows_of_the_file(tmp_path: Path) -> None:
    radius = np.where(np.arange(N) == 44, -1.0, 1.0)
    assert "row 44" in check_error(written(tmp_path, segments(radius=radius)), 5)
    assert "row 44" in check_error(written(tmp_path, points(radius=radius)), 5)


@pytest.mark.parametrize("name", ["a.parquet", "a.arrow", "a.feather"])
def test_tables_without_rows(tmp_path: Path, name: str) -> None:
    (chunk,) = check_chunks(written(tmp_path, points(age=np.arange(N)).slice(0, 0), name))
    assert "age" in chunk.attributes
    check_error(written(tmp_path, pa.table({"name": ["a"]}), name))
    check_error(written(tmp_path, pa.table({"strand": [1]}), name))


@pytest.mark.parametrize("name", ["a.parquet", "a.arrow", "a.feather"])
def test_tables_that_are_cut_short(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, points(), name)
    data = path.read_bytes()
    for n in range(0, len(data), 97):
        path.write_bytes(data[:n])
        check_either(path)


def test_folders_that_are_no_table(tmp_path: Path) -> None:
    folder = written(tmp_path, points(), "lines/")
    parquet.write_table(points().rename_columns(["x", "y", "height", "strand"]), folder / "part-4.parquet")
    assert "part-4.parquet: has the columns" in check_error(folder)
    (folder / "part-4.parquet").write_bytes(b"PAR1")
    assert "part-4.parquet: not a whole table" in check_error(folder)
    (folder / "part-4.parquet").write_bytes(b"")
    assert "part-4.parquet: is empty" in check_error(folder)
    (tmp_path / "none.parquet").mkdir()
    assert "holds no .parquet file" in check_error(tmp_path / "none.parquet")
    with pytest.raises(IsADirectoryError):
        fl.read(tmp_path)


@pytest.mark.parametrize("name", NAMES)
def test_files_are_closed_and_progress_rises(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, points(), name)
    n_open = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0
    shares: list[float] = []
    chunks = fl.read_chunks(path, 5, progress=shares.append)
    next(chunks)
    chunks.close()
    assert n_open == (len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0)
    shares.clear()
    list(fl.read_chunks(path, 5, progress=shares.append))
    assert shares == sorted(shares)
    assert shares[-1] == 1
