"""Rank correlation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt


def ranks(values: Sequence[float]) -> npt.NDArray[np.float64]:
    """Return the rank of each value, from 1; equal values share their mean rank.

    Examples
    --------
    >>> ranks([30, 10, 20, 20])
    array([4. , 1. , 2.5, 2.5])
    """
    a = np.asarray(values, np.float64)
    below = (a[:, None] > a[None, :]).sum(axis=1)
    equal = (a[:, None] == a[None, :]).sum(axis=1)
    return np.asarray(below + (equal + 1) / 2, np.float64)


def spearman(a: Sequence[float], b: Sequence[float]) -> float | None:
    """Return Spearman's ρ, the correlation of the ranks; None if one side is constant.

    Examples
    --------
    >>> round(spearman([1, 2, 3, 4], [10, 20, 40, 30]), 6)
    0.8
    """
    x, y = (rank - rank.mean() for rank in (ranks(a), ranks(b)))
    scale = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / scale if scale > 0 else None


def kendall(a: Sequence[float], b: Sequence[float]) -> float | None:
    """Return Kendall's τ_b, from the concordant less the discordant pairs; None if one side is constant.

    Examples
    --------
    >>> round(kendall([1, 2, 3, 4], [10, 20, 40, 30]), 6)
    0.666667
    """
    x, y = (np.sign(np.subtract.outer(side, side)) for side in (ranks(a), ranks(b)))
    scale = float(np.sqrt((x * x).sum() * (y * y).sum()))
    return float((x * y).sum()) / scale if scale > 0 else None
