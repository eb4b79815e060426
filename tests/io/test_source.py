"""The bytes of a file: what is read of them, and arrays that must fit them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fastlines.errors import FileFormatError
from fastlines.io.source import Source


def test_the_start_is_read_without_the_rest(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(bytes(range(200)))
    with (tmp_path / "a").open("rb", buffering=0) as file:
        source = Source(file, "a")
        assert source.start(4) == bytes(range(4))
        assert file.tell() == 4
        assert source.read(100, 5) == bytes(range(100, 105))
        assert file.tell() == 105
        assert source.end(3) == bytes(range(197, 200))
        assert source.data == bytes(range(200))
        assert source.start(4) == bytes(range(4))
        assert source.read(198, 9) == bytes([198, 199])


def test_a_file_that_grows_is_read_up_to_its_size_at_the_start(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"0123456789")
    with (tmp_path / "a").open("rb", buffering=0) as file:
        source = Source(file, "a")
        with (tmp_path / "a").open("ab") as other:
            other.write(b"more")
        assert b"".join(source.pieces()) == b"0123456789"
        assert source.data == b"0123456789"


def test_one_half_of_the_work_is_reading_the_other_parsing(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(bytes(1000))
    seen: list[float] = []
    with (tmp_path / "a").open("rb") as file:
        source = Source(file, "a", progress=seen.append)
        source.advance(0)
        assert len(source.data) == 1000
        for _ in range(4):
            source.advance(250)
    assert seen == [0.0, 0.5, 0.625, 0.75, 0.875, 1.0]


def test_bytes_that_were_dropped_are_not_asked_for() -> None:
    source = Source(b"abc", "a")
    source.drop()
    with pytest.raises(RuntimeError, match="a: its bytes are needed after they were dropped"):
        _ = source.data


def test_arrays_fit_the_file_and_do_not_overlap() -> None:
    source = Source(bytes(range(12)), "a")
    assert source.array("numbers", "u1", (4,)).tolist() == [0, 1, 2, 3]
    assert source.array("numbers", "<u2", (2, 2)).tolist() == [[0x0504, 0x0706], [0x0908, 0x0B0A]]
    source.finish()
    assert source.array("nothing", "u1", (0,), at=12).size == 0
    for shape, at in (((1,), 12), ((13,), 0), ((-1,), 0), ((0, 13), 0), ((2**70,), 0)):
        with pytest.raises(FileFormatError, match="do not fit"):
            source.array("others", "u1", shape, at=at)
    for at, n in ((0, 1), (3, 1), (3, 2), (4, 8), (11, 1), (0, 12)):
        with pytest.raises(FileFormatError, match="overlap"):
            source.array("others", "u1", (n,), at=at)


def test_bytes_behind_the_last_array_are_an_error() -> None:
    source = Source(bytes(12), "a")
    source.array("numbers", "u1", (11,))
    with pytest.raises(FileFormatError, match="1 bytes are left over behind byte 11"):
        source.finish()


@pytest.mark.parametrize("bad", [-1e-30, np.nan, np.inf, 1e300])
def test_radii_are_finite_and_not_negative(bad: float) -> None:
    source = Source(b"", "a")
    assert source.radius("radii", np.array([0.0, -0.0, 3e38])).dtype == np.float32
    with pytest.raises(FileFormatError, match=r"radii must be finite and not negative \(see row 11\)"):
        source.radius("radii", np.array([[1.0, 1], [1, bad]]), 10)
