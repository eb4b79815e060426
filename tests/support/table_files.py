"""Tables that commands write, read back."""

from __future__ import annotations

import csv

import numpy as np
import pytest


def table(name):
    """Read a table of any format as arrays: float64 or int64 where nothing is missing, else with NaN."""
    if name.endswith(".csv"):
        with open(name, newline="") as file:
            names, *rows = csv.reader(file)
        cells = np.array([[cell or "nan" for cell in row] for row in rows]).reshape(len(rows), len(names))
        return {name: cells[:, i].astype(np.float64) for i, name in enumerate(names)}
    if name.endswith(".parquet"):
        read = pytest.importorskip("pyarrow.parquet").read_table(name)
        return {name: read.column(name).to_numpy() for name in read.column_names}
    with np.load(name) as arrays:
        return dict(arrays)


def same(found, expected, dtype):
    """Return whether numbers are the same bits once they have the type of the expected ones."""
    return np.array_equal(found.astype(dtype), np.asarray(expected, dtype).reshape(-1), equal_nan=True)
