"""Checks of batches of rays or points: values that are one for all or one for each, and rows that are invalid."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, list_rows, to_float32
from ..errors import InputError


def one_or_each(name: str, value: npt.ArrayLike, shape: tuple[int, ...], nouns: str) -> FloatArray:
    """Return one number for all, (1,), or one for each of the rays or points of this shape, (n,), as float32."""
    array = to_float32(value, name)
    if array.ndim:
        try:
            array = np.ascontiguousarray(np.broadcast_to(array, shape))
        except ValueError:
            raise InputError(
                f"{name} has shape {array.shape}; expected a number, or one for each of the {nouns} {shape}"
            ) from None
    return array.reshape(-1)


def invalid_rows(
    faults: Mapping[str, npt.NDArray[np.bool_]], scalars: Mapping[str, FloatArray], n: int, nouns: str, invalid: str
) -> npt.NDArray[np.bool_]:
    """Return which of n rays or points have a fault; refuse them unless invalid ones are skipped.

    Parameters
    ----------
    faults : mapping of str to (n,) or (1,) bool
        What is wrong with some of them, such as "have a radius that …", or with all. Each has its first fault.
    scalars : mapping of str to (n,) or (1,) float32
        Values that faults may name.

    Raises
    ------
    InputError
        With ``invalid="error"``, if there is a fault; it names the rows.
    """
    skipped = np.zeros(n, bool)
    found = []
    for fault, rows in faults.items():
        bad = np.broadcast_to(rows, n) & ~skipped
        if bad.any():
            once = ", ".join(f"{name} = {values[0]:g}" for name, values in scalars.items() if name in fault)
            where = f" ({list_rows(bad)})" if len(rows) == n else f": {once}, for all"
            where += f": {once}" if once and n == 1 else ""
            found.append(f"{int(bad.sum())} of {n} {nouns} {fault}{where}")
        skipped |= bad
    if found and invalid == "error":
        raise InputError(f"{'; '.join(found)}; fix them, or let them miss (in Python: invalid='skip')")
    return skipped
