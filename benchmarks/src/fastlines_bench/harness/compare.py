"""Compare the answers of two sides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

#: Two hits tie if their t differ by at most this fraction.
TIE = 2.0**-20


@dataclass(frozen=True)
class Difference:
    """The differences between a peer's answers and ours.

    Attributes
    ----------
    n_rays : int
        The number of rays compared.
    n_differ : int
        The number of rays with another segment, with a hit on one side only, or with another set of hits.
    n_ties : int
        The number of the latter whose two segments have the same t up to rounding, as where segments meet.
    max_dt : float
        The largest difference in t between hits that both sides report.
    """

    n_rays: int = 0
    n_differ: int = 0
    n_ties: int = 0
    max_dt: float = 0.0

    def __add__(self, other: Difference) -> Difference:
        return Difference(
            self.n_rays + other.n_rays,
            self.n_differ + other.n_differ,
            self.n_ties + other.n_ties,
            max(self.max_dt, other.max_dt),
        )

    @property
    def share(self) -> float:
        """The fraction of the rays that differ, without ties."""
        return (self.n_differ - self.n_ties) / self.n_rays if self.n_rays else 0.0


def compare(query: str, ours: Any, theirs: Any) -> Difference:
    """Return the differences between two answers to a query on the same rays."""
    if query == "any":
        return Difference(len(ours), int((ours != theirs).sum()))
    if query == "first":
        t, prim = theirs
        same = ours.prim == prim
        both = (ours.prim >= 0) & (prim >= 0)
        named, other = both & same, both & ~same
        ties = np.abs(ours.t[other] - t[other]) <= TIE * np.abs(t[other])
        return Difference(len(prim), int((~same).sum()), int(ties.sum()), _largest(ours.t[named], t[named]))
    ray, prim, t = theirs.unpack()
    n_rays = len(ours.offsets) - 1
    mine, theirs_key = ours.ray << 32 | ours.prim, ray << 32 | prim
    my_order, their_order = np.argsort(mine), np.argsort(theirs_key)
    mine, theirs_key = mine[my_order], theirs_key[their_order]
    my_t, their_t = ours.t[my_order], t[their_order]
    if len(mine) == len(theirs_key) and (mine == theirs_key).all():
        return Difference(n_rays, 0, 0, _largest(my_t, their_t))
    differ = np.concatenate([np.setxor1d(mine, theirs_key), theirs_key[1:][theirs_key[1:] == theirs_key[:-1]]]) >> 32
    _, at_mine, at_theirs = np.intersect1d(mine, theirs_key, return_indices=True)
    return Difference(n_rays, len(np.unique(differ)), 0, _largest(my_t[at_mine], their_t[at_theirs]))


def same(a: Any, b: Any) -> bool:
    """Return whether two answers of ours are the same, bit for bit."""
    names = ("t", "prim", "u", "distance", "offsets")
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names if hasattr(a, name))


def _largest(a: npt.NDArray[np.float32], b: npt.NDArray[np.float32]) -> float:
    return float(np.abs(a - b).max()) if len(a) else 0.0
