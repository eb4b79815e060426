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
    n_hits, n_hits_differ : int
        Of `compare_surfaces` for all hits: the number of hits of either side, and of those that one side alone reports
        or that differ in t.
    """

    n_rays: int = 0
    n_differ: int = 0
    n_ties: int = 0
    max_dt: float = 0.0
    n_hits: int = 0
    n_hits_differ: int = 0

    def __add__(self, other: Difference) -> Difference:
        return Difference(
            self.n_rays + other.n_rays,
            self.n_differ + other.n_differ,
            self.n_ties + other.n_ties,
            max(self.max_dt, other.max_dt),
            self.n_hits + other.n_hits,
            self.n_hits_differ + other.n_hits_differ,
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


def compare_surfaces(
    query: str, ours: Any, theirs: Any, tolerance: float, owner: npt.NDArray[np.int64] | None = None
) -> Difference:
    """Return the differences between two answers about solid shapes, where t is at the surface.

    Shapes may overlap, and each side has its own tolerance, so t counts more than the name of the shape: first hits
    whose t differ by at most `tolerance` tie, and hits of the same shape whose t differ by more are different.

    Parameters
    ----------
    tolerance : float
        The largest difference in t that is none.
    owner : (n,) int64, optional
        The shape to which each of our primitives belongs. A shape may be hit more than once by either side; its nearest
        hit counts.
    """
    if query == "any":
        return compare(query, ours, theirs)
    if query == "first":
        t, prim = theirs
        mine = ours.prim if owner is None else np.where(ours.prim >= 0, owner[ours.prim], -1)
        both = (mine >= 0) & (prim >= 0)
        apart = both.copy()
        apart[both] = np.abs(ours.t[both] - t[both]) > tolerance
        named = both & (mine == prim)
        differ = apart | ((mine >= 0) != (prim >= 0))
        ties = both & ~apart & ~named
        n_differ, n_ties = int((differ | ties).sum()), int(ties.sum())
        return Difference(len(prim), n_differ, n_ties, _largest(ours.t[named], t[named]))
    ray, prim, t = theirs.unpack()
    my_prim = ours.prim if owner is None else owner[ours.prim]
    mine, my_t = _nearest(ours.ray, my_prim, ours.t)
    other, their_t = _nearest(ray, prim, t)
    _, at_mine, at_other = np.intersect1d(mine, other, assume_unique=True, return_indices=True)
    apart = np.abs(my_t[at_mine] - their_t[at_other]) > tolerance
    differ = np.concatenate([np.setxor1d(mine, other, assume_unique=True), mine[at_mine[apart]]])
    n_hits = len(mine) + len(other) - len(at_mine)
    largest = _largest(my_t[at_mine], their_t[at_other])
    return Difference(len(ours.offsets) - 1, len(np.unique(differ >> 32)), 0, largest, n_hits, len(differ))


def _nearest(
    ray: npt.NDArray[np.int64], prim: npt.NDArray[np.int64], t: npt.NDArray[np.float32]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float32]]:
    """Return the keys of the different pairs of ray and primitive, sorted, and the least t of each."""
    key = ray << 32 | prim
    order = np.argsort(key)
    key, t = key[order], t[order]
    starts = np.flatnonzero(np.diff(key, prepend=-1))
    return key[starts], np.minimum.reduceat(t, starts) if len(t) else t


def same(a: Any, b: Any) -> bool:
    """Return whether two answers of ours are the same, bit for bit."""
    names = ("t", "prim", "u", "distance", "t_out", "offsets")
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names if hasattr(a, name))


def _largest(a: npt.NDArray[np.float32], b: npt.NDArray[np.float32]) -> float:
    return float(np.abs(a - b).max()) if len(a) else 0.0
