"""The columns of answers about points and pairs, as tables have them: a row for each primitive or pair found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..query.proximity.pairs import Pairs
from .tables import Columns

#: The columns of `columns_of_points` that are not samples, in their order.
NAMES = ("point", "x", "y", "z", "prim", "u", "distance", "part", "row", "strand")


def check_samples(geometry: AnyGeometry, names: Sequence[str]) -> None:
    """Refuse, before any work, an attribute that is not there or whose name is that of another column."""
    for name in names:
        if name in NAMES:
            raise InputError(f"--sample {name!r} is the name of another column; rename the attribute")
        if names.count(name) > 1:
            raise InputError(f"--sample {name!r} is given twice; give it once")
        if name not in geometry.sample_names:
            known = ", ".join(map(repr, geometry.sample_names)) or "none"
            raise InputError(f"--sample {name!r} is not an attribute of the input; it has {known}")


def columns_of_points(answer: Any, point: npt.NDArray[np.int64], samples: Sequence[str] = ()) -> Columns:
    """Return a row for each answer about a point; those of a miss are masked.

    Parameters
    ----------
    answer : Nearest or Within
    point : (m,) int64
        The number of the point of each row.
    """
    prim = answer.prim.reshape(-1)
    miss = prim < 0
    geometry = answer.geometry
    columns: dict[str, npt.NDArray[Any]] = {"point": point}
    columns |= zip("xyz", answer.points().reshape(-1, 3).T, strict=True)
    columns |= {"prim": prim, "u": answer.u, "distance": answer.distance}
    columns |= {"part": answer.part} if answer.part is not None else {}
    columns |= {"row": answer.row} if geometry.n_skipped else {}
    columns |= {"strand": _known(answer.strand)} if geometry.n_strands else {}
    for name in samples:
        columns |= _sampled(name, answer.sample(name), answer.prim.ndim)
    masked = {
        name: np.ma.masked_array(values.reshape(-1), miss | np.ma.getmaskarray(values).reshape(-1))
        for name, values in columns.items()
    }
    return columns_without_masks(masked | {"point": point})


def no_pairs(geometry: AnyGeometry, other: AnyGeometry) -> Pairs:
    """Return no pairs, whose columns are those of any."""
    prims, places = np.zeros(0, np.int64), np.zeros(0, np.float32)
    return Pairs(prims, prims, places, places, places, False, geometry, other)


def columns_of_pairs(pairs: Pairs, points: bool = False) -> Columns:
    """Return a row for each pair, with the points of both if they are wanted."""
    columns: dict[str, npt.NDArray[Any]] = {"i": pairs.i, "j": pairs.j}
    sides: dict[str, Any] = {"i": pairs.geometry, "j": pairs.other}
    parts = {f"part_{side}": getattr(pairs, f"part_{side}") for side in sides}
    columns |= {name: part for name, part in parts.items() if part is not None}
    columns |= {f"row_{side}": getattr(pairs, f"row_{side}") for side, of in sides.items() if of.n_skipped}
    strands = {side: getattr(pairs, f"strand_{side}") for side, of in sides.items() if of.n_strands}
    columns |= {f"strand_{side}": _known(of_side) for side, of_side in strands.items()}
    columns |= {"s": pairs.s, "t": pairs.t, "distance": pairs.distance}
    if points:
        names = [f"{axis}_{side}" for side in sides for axis in "xyz"]
        columns |= zip(names, pairs.points().reshape(-1, 6).T, strict=True)
    return columns_without_masks(columns)


def columns_without_masks(columns: Columns) -> Columns:
    """Return the columns; one without missing values becomes a plain array."""
    return {name: values if np.ma.is_masked(values) else np.ma.getdata(values) for name, values in columns.items()}


def _known(strands: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
    """Mask the strand of what is of none."""
    return np.ma.masked_array(strands, strands < 0)


def _sampled(name: str, values: npt.NDArray[np.float64], n_axes: int) -> Columns:
    """Return a column for each number of an attribute, such as colour_0, colour_1 and colour_2."""
    if values.ndim == n_axes:
        return {name: values}
    flat = values.reshape(-1, int(np.prod(values.shape[n_axes:])))
    return {f"{name}_{i}": column for i, column in enumerate(flat.T)}
