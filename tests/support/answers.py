"""Answers to compare bit for bit, and questions to ask of a case."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from support import nasty

#: The columns of an answer that is not a plain array.
COLUMNS = ("offsets", "t", "prim", "u", "distance", "t_out", "part", "skipped")
#: What each query can be asked for as `at`. Without t, the surface and the closest approach are the same.
PLACES = dict.fromkeys(("first_hit", "all_hits", "next_hits"), ("closest", "surface", "entry"))
PLACES |= dict.fromkeys(("any_hit", "count_hits"), ("closest", "entry"))

cases = cache(nasty.cases)


def options(query: str) -> dict[str, int]:
    return {"k": 3} if query == "next_hits" else {}


def question(case: nasty.Case) -> tuple[dict[str, Any], int]:
    """Ask all rays of a case with all its radii at once; the rays of one radius follow each other."""
    n, n_radii = len(case.origins), len(case.radii)

    def repeat(values: Any) -> Any:
        return values if np.ndim(values) == 0 else np.concatenate([values] * n_radii)

    radius = np.concatenate([np.broadcast_to(np.float32(r), n) for r in case.radii.values()])
    rays = {"origins": repeat(case.origins), "directions": repeat(case.directions), "radius": radius}
    return {**rays, "t_min": repeat(case.t_min), "t_max": repeat(case.t_max)}, n


def assert_same(got: Any, expected: Any, which: str = "") -> None:
    """Compare two answers bit for bit; say which one differs."""
    assert type(got) is type(expected)
    if isinstance(got, np.ndarray):
        pairs = {"answer": (got, expected)}
    else:
        pairs = {name: (getattr(got, name, None), getattr(expected, name, None)) for name in COLUMNS}
    for name, (a, b) in pairs.items():
        if a is None or b is None:
            assert a is b, f"{name} {which}"
            continue
        assert (a.shape, a.dtype) == (b.shape, b.dtype), f"{name} {which}"
        rows = np.flatnonzero(a.reshape(-1).view(f"u{a.itemsize}") != b.reshape(-1).view(f"u{b.itemsize}"))
        assert len(rows) == 0, f"{which} {name} differs at {rows[:5]}: {a.flat[rows[:5]]}, expected {b.flat[rows[:5]]}"
