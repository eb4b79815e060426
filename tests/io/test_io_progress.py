"""Progress of reading: fractions that rise from 0 to 1, errors of the callback, and files that are closed."""

from __future__ import annotations

import gzip
import importlib.util
import os
from pathlib import Path

import numpy as np
import pytest
from support.line_files import POINTS

import fastlines as fl
from fastlines.io import source
from fastlines.io.formats import number_text

#: Of what formats have no place for.
pytestmark = pytest.mark.filterwarnings("ignore::fastlines.FileWarning")

NEEDS = {".usda": "pxr", ".parquet": "pyarrow"}
EXTENSIONS = [
    extension
    for extension in (".trk", ".tck", ".trx", ".npz", ".obj", ".swc", ".txt", ".geojson", ".ply", ".vtp", *NEEDS)
    if extension not in NEEDS or importlib.util.find_spec(NEEDS[extension])
]


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let files of a few kilobytes have many pieces."""
    monkeypatch.setattr(source, "PIECE", 1000)
    monkeypatch.setattr(number_text, "PIECE", 1000)


@pytest.fixture(params=["", ".gz"])
def packed(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def written(folder: Path, name: str) -> Path:
    points = np.random.default_rng(0).normal(size=(400, 3)).astype(np.float32)
    fl.write(folder / name, fl.Lines.from_points(points, [100] * 4, radius=0.5))
    return folder / name


def open_files() -> int:
    return len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_fractions_rise_from_0_to_1(tmp_path: Path, extension: str, packed: str) -> None:
    path = written(tmp_path, f"a{extension}{packed}")
    shares: list[float] = []
    lines = fl.read(path, progress=shares.append)
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0, 1)
    assert len(shares) > 2
    plain = fl.read(path)
    assert np.array_equal(lines.segments, plain.segments)


def test_text_reports_reading_and_parsing(tmp_path: Path) -> None:
    shares: list[float] = []
    fl.read(written(tmp_path, "a.obj"), progress=shares.append)
    assert sum(share < 0.5 for share in shares) > 5
    assert sum(0.5 < share < 1 for share in shares) > 5


def test_unpacking_reports(tmp_path: Path) -> None:
    path = tmp_path / "a.npy.gz"
    with gzip.open(path, "wb") as file:
        np.save(file, np.random.default_rng(0).normal(size=(1 << 17, 2, 3)).astype(np.float32))
    shares: list[float] = []
    fl.read(path, progress=shares.append)
    assert sum(0 < share < 0.5 for share in shares) > 1


@pytest.mark.parametrize("error", [ZeroDivisionError, fl.InputError, KeyboardInterrupt])
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_errors_of_the_callback_come_through(
    tmp_path: Path, extension: str, packed: str, error: type[BaseException]
) -> None:
    path = written(tmp_path, f"a{extension}{packed}")
    n_calls: list[float] = []
    fl.read(path, progress=n_calls.append)
    before = open_files()
    for last in {0, 1, len(n_calls) // 2, len(n_calls) - 1}:
        shares: list[float] = []

        def stop(share: float, last: int = last, shares: list[float] = shares) -> None:
            shares.append(share)
            if len(shares) > last:
                raise error("stop")

        with pytest.raises(error, match=r"^stop$"):
            fl.read(path, progress=stop)
        assert len(shares) == last + 1
    assert open_files() <= before


def test_files_that_cannot_be_read_report_no_end(tmp_path: Path) -> None:
    path = tmp_path / "a.trk"
    path.write_bytes(b"TRACK" + POINTS.tobytes() * 100)
    shares: list[float] = []
    with pytest.raises(fl.FileFormatError):
        fl.read(path, progress=shares.append)
    assert 1 not in shares


def test_a_bar(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, "a.obj")
    assert len(fl.read(path, progress=True)) == len(fl.read(path))
    assert capsys.readouterr().out == ""
