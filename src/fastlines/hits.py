"""Hits: the answers of queries, as plain arrays."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from .arrays import FloatArray, IntArray
from .backend import HitColumns
from .errors import InputError
from .hit_geometry import HitGeometry
from .immutable import own
from .lines import Lines
from .rays import RayBatch

Self = TypeVar("Self")


class _OfLines(HitGeometry):
    """The rows and strands of the segments that were hit, looked up on first use."""

    @cached_property
    def row(self) -> IntArray:
        """The row of the input that each segment was, int64 of the shape of ``prim``; -1 = miss. Read-only.

        It differs from ``prim`` where rows of the input were skipped.
        """
        skipped = self._known_lines().skipped
        # Count the skipped rows before each segment: those whose position among the kept rows is at or before its own.
        before = np.searchsorted(skipped - np.arange(len(skipped)), self.prim, side="right")
        return own(np.asarray(self.prim + before))

    @cached_property
    def strand(self) -> IntArray:
        """The strand of each segment, int64 of the shape of ``prim``; -1 = miss, or without a strand. Read-only."""
        strands = self._known_lines().strands
        hit = self.prim >= 0
        found = np.full(self.prim.shape, -1)
        found[hit] = np.maximum(strands[self.prim[hit]], -1)
        return own(found)

    def __copy__(self: Self) -> Self:
        copied = object.__new__(type(self))
        copied.__dict__.update(self.__dict__)
        return copied

    def __deepcopy__(self: Self, memo: dict[int, Any]) -> Self:
        copied, shared = copy.copy(self), ("lines", "rays", "row", "strand")  # which no hit changes
        copied.__dict__.update({k: copy.deepcopy(v, memo) for k, v in self.__dict__.items() if k not in shared})
        return copied

    def __getstate__(self) -> dict[str, Any]:
        # Pickle the row and the strand of each hit instead of all lines.
        known = {"row": self.row, "strand": self.strand} if self.lines is not None else {}
        return self.__dict__ | known | {"lines": None, "rays": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        frozen = {name: own(state[name]) for name in ("row", "strand") if name in state}
        self.__dict__.update(state | frozen)


@dataclass(frozen=True, eq=False, repr=False)
class FirstHits(_OfLines):
    """The nearest hit of each ray; every array has the shape of the rays.

    Attributes
    ----------
    t : float32
        The position on the ray, in units of its direction's length; inf = miss.
    prim : int64
        The index of the segment; -1 = miss. If rows of the input were skipped, it counts only the rows that are left,
        and `row` is the index in the input.
    u : float32
        The position on the segment, from 0 to 1.
    distance : float32
        The distance of the ray from the segment at the closest approach, from its axis if it is thick; inf = miss. It
        is the least distance, unless the segment tapers: then it is where the ray lies deepest in it (docs/answers.md).
    t_out : float32 or None
        With ``at="surface"``, t where the ray leaves the capsule around the segment.
    skipped : (k,) int64
        With ``invalid="skip"``, the invalid rays, which count as misses.
    lines : Lines or None
        The lines of the query. A pickle of hits leaves out the lines and the rays, and keeps `row` and `strand`.
    rays : RayBatch or None
        The rays of the query, for `points` and `normals`.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 5, 0], [1, 5, 0]]])
    >>> hits = fl.build(lines).first_hit([[1.5, 0, -1], [0.5, 5, -1], [9, 9, -1]], [0, 0, 1], 0.1)
    >>> print(hits.prim, hits.strand)
    [ 1  2 -1] [ 0  1 -1]
    """

    t: FloatArray
    prim: IntArray
    u: FloatArray
    distance: FloatArray
    t_out: FloatArray | None
    skipped: IntArray
    lines: Lines | None = None
    rays: RayBatch | None = None

    @classmethod
    def from_columns(cls, columns: HitColumns, rays: RayBatch, lines: Lines) -> FirstHits:
        """Return the columns of a backend in the shape of the rays."""
        t, prim, u, distance, t_out = columns
        shape = rays.shape
        # NumPy prints C's name of a 64-bit integer, but not its own.
        prim = prim.reshape(shape).view(np.int64)
        t_out = None if t_out is None else t_out.reshape(shape)
        return cls(t.reshape(shape), prim, u.reshape(shape), distance.reshape(shape), t_out, rays.skipped, lines, rays)

    def _ray_of_hits(self) -> IntArray:
        return np.flatnonzero(self.hit)

    def __repr__(self) -> str:
        return f"<FirstHits: {self.prim.size:,} rays, {int(self.hit.sum()):,} hit>"

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """Whether each ray hits anything, bool of the shape of the rays."""
        return self.prim >= 0


@dataclass(frozen=True, eq=False, repr=False)
class AllHits(_OfLines):
    """All hits of each ray, each once, sorted by (ray, t, prim); with ``rank="distance"`` by (ray, distance, t, prim).

    Those of ray i are entries ``offsets[i]`` to ``offsets[i + 1]`` of the other arrays (compressed sparse rows).

    Attributes
    ----------
    offsets : (n_rays + 1,) int64
        The first entry of each ray, in the order of the flattened input, and the end of the last.
    t, prim, u, distance, t_out, skipped, lines
        As in `FirstHits`, one entry a hit; so are `row` and `strand`.
    """

    offsets: IntArray
    t: FloatArray
    prim: IntArray
    u: FloatArray
    distance: FloatArray
    t_out: FloatArray | None
    skipped: IntArray
    lines: Lines | None = None
    rays: RayBatch | None = None

    @classmethod
    def from_columns(cls, offsets: IntArray, columns: HitColumns, rays: RayBatch, lines: Lines) -> AllHits:
        """Wrap the lists of a backend."""
        t, prim, u, distance, t_out = columns
        offsets, prim = offsets.view(np.int64), prim.view(np.int64)
        return cls(offsets, t, prim, u, distance, t_out, rays.skipped, lines, rays)

    def _ray_of_hits(self) -> IntArray:
        return self.ray

    def __len__(self) -> int:
        return len(self.prim)

    def __repr__(self) -> str:
        return f"<AllHits: {len(self.offsets) - 1:,} rays, {len(self):,} hits>"

    @property
    def counts(self) -> IntArray:
        """The number of hits of each ray, (n_rays,) int64."""
        return np.diff(self.offsets)

    @property
    def ray(self) -> IntArray:
        """The index of the ray of each hit, (n_hits,) int64."""
        return np.repeat(np.arange(len(self.offsets) - 1), self.counts)

    def of(self, ray: int) -> slice:
        """Return the slice of the hits of a ray: ``hits.t[hits.of(3)]``.

        Raises
        ------
        InputError
            If there is no such ray; rays count from 0.
        """
        n_rays = len(self.offsets) - 1
        if not 0 <= ray < n_rays:
            raise InputError(f"ray={ray}: there are {n_rays:,} rays, which count from 0")
        return slice(int(self.offsets[ray]), int(self.offsets[ray + 1]))

    def merged_by_strand(self) -> AllHits:
        """Merge hits of the same ray and strand whose intervals from `t` to `t_out` overlap into one.

        A merged hit begins with its first segment and has its `prim`, `u` and `distance`; it ends where the last one
        does. Segments without a strand stay alone.

        Raises
        ------
        InputError
            If the hits are not those ``at="surface"``, which have intervals.
        """
        if self.t_out is None:
            raise InputError("only hits at='surface' have intervals, from t to t_out, that can be merged")
        if not len(self):
            return self
        # Sort by ray, strand, t and segment.
        ray, strand = self.ray, np.where(self.strand >= 0, self.strand, self.strand.max(initial=0) + 1 + self.prim)
        order = np.lexsort((self.prim, self.t, strand, ray))
        ray, strand, t, t_out = ray[order], strand[order], self.t[order], self.t_out[order]
        is_first = np.ones(len(order), bool)
        is_first[1:] = (ray[1:] != ray[:-1]) | (strand[1:] != strand[:-1])
        # Find the largest t_out up to each hit of its ray and strand, by ranks; those of later groups are larger.
        by_end = np.argsort(t_out, kind="stable")
        rank = np.empty_like(by_end)
        rank[by_end] = np.arange(len(by_end))
        group = np.cumsum(is_first) - 1
        latest = t_out[by_end[np.maximum.accumulate(group * len(order) + rank) % len(order)]]
        # A hit that begins behind all hits before it begins a new one.
        begins = is_first.copy()
        begins[1:] |= t[1:] > latest[:-1]
        starts = np.flatnonzero(begins)
        ends = latest[np.append(starts[1:], len(order)) - 1]
        # Restore the order of lists: by ray, t and segment.
        kept = order[starts]
        again = np.lexsort((self.prim[kept], self.t[kept], ray[starts]))
        kept, ends = kept[again], ends[again]
        counts = np.bincount(ray[starts], minlength=len(self.offsets) - 1)
        offsets = np.concatenate([[0], np.cumsum(counts)])
        columns = self.t[kept], self.prim[kept], self.u[kept], self.distance[kept], ends
        return AllHits(offsets, *columns, self.skipped, self.lines, self.rays)
