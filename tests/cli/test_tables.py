"""Tables of answers: every bit of a number, and short texts of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.table_files import table

from fastlines.cli.tables import table_writer

pytestmark = pytest.mark.usefixtures("in_own_folder")

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("name", ["a.csv", "a.parquet", "a.npz"])
def test_tables_keep_every_bit(name):
    bits = np.concatenate([RNG.integers(0, 2**32, 20_000), [0, 1, 2**31, 0x7F7FFFFF, 0x00800000, 0x7F800000]])
    f4 = bits.astype(np.uint32).view(np.float32)
    f4 = np.concatenate([f4[~np.isnan(f4)], RNG.random(70_000, np.float32)])
    f8 = np.exp(RNG.uniform(-700, 700, len(f4)))
    numbers = RNG.integers(-(2**62), 2**62, len(f4))
    with table_writer(name) as append:
        for part in (slice(None, 3), slice(3, 3), slice(3, None)):
            append({"n": numbers[part], "x": f8[part], "a b": f4[part]})
    if name.endswith(".csv"):
        text = Path(name).read_bytes().decode()
        assert text.startswith("n,x,a b\n")
        assert "\r" not in text
        rows = [line.split(",") for line in text.splitlines()[1:]]
        found = {"n": [int(row[0]) for row in rows]}
        assert found["n"] == numbers.tolist()
    read = table(name)
    assert (read["x"] == f8).all()
    assert (read["a b"].astype(np.float32).view(np.uint32) == f4.view(np.uint32)).all()


def test_texts_are_short_and_missing_cells_are_empty():
    values = np.float32([0.1, 1, -2.5, 1e-05, 16777216, 1 / 3])
    masked = np.ma.masked_array(np.arange(6), [0, 1, 0, 0, 0, 0])
    with table_writer("a.csv") as append:
        append({"u,v": values, "prim": masked})
    assert Path("a.csv").read_text() == '"u,v",prim\n0.1,0\n1,\n-2.5,2\n1e-05,3\n16777216,4\n0.33333334,5\n'
    with table_writer("a.npz") as append:
        append({"prim": masked})
    assert table("a.npz")["prim"].tolist() == list(range(6))


def test_a_table_appears_whole_or_not_at_all():
    for name in ("a.csv", "a.parquet", "a.npz"):
        with pytest.raises(RuntimeError), table_writer(name) as append:  # noqa: PT012
            append({"prim": np.arange(3)})
            raise RuntimeError
    assert sorted(path.name for path in Path().iterdir()) == []
