"""Several NumPy arrays in one file (``.npz``): segments, points or curves, and their columns.

Format: https://numpy.org/doc/stable/reference/generated/numpy.savez.html; `named_arrays.py` lists the names. The facts
``up``, ``unit``, ``metadata`` and ``tolerance`` are arrays of one text, without dimensions.
"""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from numpy.lib import format as npy_format

from ...arrays import AnyArray
from ...geometry.curves import Curves
from ...geometry.lines import Lines
from ..source import Source
from .archive import unpack
from .named_arrays import FACTS, from_arrays, to_arrays
from .npy import read_array


def read(source: Source, invalid: str) -> Lines | Curves:
    """Read lines or curves from a ``.npz`` file.

    It holds ``segments`` (n, 2, 3) or (n, 6), with or without integer ``strands`` (n,) and ``radius`` (n,) or (n, 2).
    Or it holds ``points`` (m, 3) and integer ``counts`` (k,), the numbers of points of each strand, with or without
    ``radius`` (m,). Or it holds ``control`` (n, 4, 3), the Bezier control points of curves.

    Any other array has a row for each segment, point or curve and becomes one of the ``attributes``. An array
    ``end_attributes/NAME`` (n, 2, …) becomes one of the ``end_attributes``.
    """
    arrays = _arrays(source)
    facts = {name: str(arrays.pop(name)) for name in FACTS if name in arrays and arrays[name].dtype.kind == "U"}
    return from_arrays(source, arrays, facts, invalid)


def write(geometry: Lines | Curves, path: Path) -> list[str]:
    """Write all arrays by their names in `named_arrays.py`, without compression."""
    arrays, facts, lost = to_arrays(geometry)
    texts = {name: np.array(text) for name, text in facts.items()}
    # numpy.savez has no place for arrays that are called like its own arguments.
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, array in {**arrays, **texts}.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                npy_format.write_array(file, array, allow_pickle=False)
    return lost


def _arrays(source: Source) -> dict[str, AnyArray]:
    """Return all arrays of a ``.npz``."""
    members = unpack(source, ".npz")
    for name in members:
        if not name.endswith(".npy"):
            raise source.error(
                f"{name!r} in it is not an array that numpy.savez wrote; write the file again with numpy.savez"
            )
    return {
        name: read_array(Source(members.pop(f"{name}.npy"), f"{source.name}, array {name!r}"), text=name in FACTS)
        for name in [member.removesuffix(".npy") for member in members]
    }
