"""The queries of the benchmark of generated streamlines, and the columns of answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from . import streamlines

#: The radius of all rays, and of points.
RADIUS = 0.005

#: The columns that an answer may have.
COLUMNS = ("offsets", "t", "prim", "u", "distance", "t_out", "i", "j", "s", "segment", "strand", "row")


def columns_of(answer: Any) -> Mapping[str, npt.NDArray[Any]]:
    """Return the arrays of an answer by name."""
    if isinstance(answer, np.ndarray):
        return {"": answer}
    return {name: getattr(answer, name) for name in COLUMNS if getattr(answer, name, None) is not None}


def same(a: Mapping[str, npt.NDArray[Any]], b: Mapping[str, npt.NDArray[Any]]) -> bool:
    """Return whether two answers are the same: names, types, shapes and bits."""
    return a.keys() == b.keys() and all(
        a[name].dtype == b[name].dtype and a[name].shape == b[name].shape and a[name].tobytes() == b[name].tobytes()
        for name in a
    )


def _picture(of: Any, n_rays: int) -> Any:
    return of.first_hit(*streamlines.picture(int(n_rays**0.5)), RADIUS)


def _random(of: Any, n_rays: int) -> Any:
    return of.first_hit(*streamlines.rays(n_rays), RADIUS)


def _all(of: Any, n_rays: int) -> Any:
    return of.all_hits(*streamlines.rays(max(1, n_rays // 16), 1), RADIUS)


def _count(of: Any, n_rays: int) -> Any:
    return of.count_hits(*streamlines.rays(n_rays, 2), RADIUS)


def _nearest(of: Any, n_rays: int) -> Any:
    origins, directions = streamlines.rays(n_rays, 3)
    return of.nearest(origins + 300 * directions)


#: The questions: each takes a tree or a forest, and the number of rays.
QUESTIONS: dict[str, Callable[[Any, int], Any]] = {
    "first hits of a picture": _picture,
    "first hits of random rays": _random,
    "all hits": _all,
    "count of hits": _count,
    "nearest": _nearest,
}
