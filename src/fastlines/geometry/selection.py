"""Selections: the rows that a slice, a mask, indices or numbers of strands name, in their order. -1 is never a row."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, IntArray, list_rows, to_integers
from ..errors import InputError
from ..support.distinct import distinct


def rows_of_prims(key: slice | npt.ArrayLike, n: int) -> IntArray:
    """Return the rows that a slice, a mask or indices select of n primitives.

    Examples
    --------
    >>> rows_of_prims(slice(-2, None), 5), rows_of_prims([True, False, True], 3)
    (array([3, 4]), array([0, 2]))
    """
    if isinstance(key, slice):
        return np.arange(n)[key]
    rows = _numbers("prims", key, n, "primitives", "hits.prim[hits.hit]")
    if rows.size and rows.max() >= n:
        raise InputError(f"prims hold {rows.max()}; expected numbers below {n}, the number of primitives")
    return rows


def rows_of_strands(chosen: npt.ArrayLike, strands: IntArray) -> IntArray:
    """Return the rows of some strands, one strand after the other.

    Parameters
    ----------
    chosen : (k,) array of int, or (n_strands,) array of bool
    strands : (n,) int64
        The strand of each row, -1 for none.

    Examples
    --------
    >>> rows_of_strands([9, 4], np.array([4, 4, 7, 9, -1]))
    array([3, 0, 1])
    """
    order = np.argsort(strands, kind="stable")
    in_order = strands[order]
    known = distinct(in_order[in_order >= 0])
    numbers = _numbers("strands", chosen, len(known), "strands", "np.unique(hits.strand[hits.strand >= 0])")
    if np.asarray(chosen).dtype == np.bool_:
        numbers = known[numbers]
    first, end = (np.searchsorted(in_order, numbers, side) for side in ("left", "right"))
    sizes = end - first
    if missing := [int(number) for number in numbers[sizes == 0][:5]]:
        raise InputError(
            f"strands hold {', '.join(map(str, missing))}; none of the {len(known)} strands has this number: they are "
            f"np.unique(lines.strands)"
        )
    return np.asarray(order[np.repeat(first - np.cumsum(sizes) + sizes, sizes) + np.arange(int(sizes.sum()))])


def _numbers(name: str, chosen: Any, n: int, what: str, how: str) -> IntArray:
    """Return numbers that are not negative, in one dimension; of a mask, those at which it is True."""
    array: AnyArray = np.atleast_1d(np.asarray(chosen))
    if array.dtype == np.bool_:
        if array.shape != (n,):
            raise InputError(
                f"{name}: a mask of shape {array.shape} was given; expected ({n},), one for each of {n} {what}"
            )
        return np.flatnonzero(array)
    array = to_integers(array, name)
    if array.ndim != 1:
        raise InputError(f"{name} have shape {array.shape}; expected one dimension")
    if (bad := array < 0).any():
        raise InputError(
            f"{name} hold {array.min()} ({list_rows(bad)}), which stands for a miss or for no strand; leave it out, as "
            f"in {how}"
        )
    return array
