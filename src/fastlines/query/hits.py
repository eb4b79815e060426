"""Hits: the answers of queries, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..support.immutable import own
from ..support.texts import counted
from .backend import HitColumns
from .compressed_rows import CompressedRows
from .crossings import crossings, merged
from .hit_geometry import HitGeometry
from .hit_lists import offsets_of
from .rays import RayBatch


@dataclass(frozen=True, eq=False, repr=False)
class FirstHits(HitGeometry):
    """The nearest hit of each ray; every array has the shape of the rays.

    Attributes
    ----------
    t : float32
        The position on the ray, in units of its direction's length; inf = miss.
    prim : int64
        The index of the segment, curve, triangle or other primitive; -1 = miss. If rows of the input were skipped, it
        counts only the rows that are left, and `row` is the index in the input.
    u : float32
        The position on the segment or curve, from 0 to 1; 0 for what has no axis.
    distance : float32
        The distance of the ray from the segment at the closest approach, from its axis if it is thick; inf = miss.
        Where a segment tapers, the closest approach is the point at which distance less radius is least.
    t_out : float32 or None
        With ``at="surface"``, t where the ray leaves the capsule around the segment, or the shape.
    skipped : (k,) int64
        With ``invalid="skip"``, the invalid rays, which count as misses.
    geometry : Lines, Geometry or another container, or None
        What the tree is over. A pickle of hits leaves out the geometry and the rays, and keeps `row` and `strand`.
    rays : RayBatch or None
        The rays of the query, for `points` and `normals`.
    part : int64 or None
        The part of a `Geometry` that was hit, -1 = miss; `prim` counts within it. None for a single container.

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
    geometry: AnyGeometry | None = None
    rays: RayBatch | None = None
    part: IntArray | None = None

    @classmethod
    def from_columns(cls, columns: HitColumns, rays: RayBatch, geometry: AnyGeometry) -> FirstHits:
        """Return the columns of a backend in the shape of the rays."""
        t, prim, u, distance, t_out = columns
        shape = rays.shape
        # NumPy prints C's name of a 64-bit integer, but not its own.
        part, prim = geometry.split(prim.reshape(shape).view(np.int64))
        t_out = None if t_out is None else t_out.reshape(shape)
        arrays = t.reshape(shape), prim, u.reshape(shape), distance.reshape(shape), t_out
        return cls(*arrays, rays.skipped, geometry, rays, part)

    def _ray_of_rows(self) -> None:
        return None

    def __repr__(self) -> str:
        return f"<FirstHits: {counted(self.prim.size, 'rays')}, {int(self.hit.sum()):,} hit>"

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """Whether each ray hits anything, bool of the shape of the rays."""
        return self.prim >= 0


@dataclass(frozen=True, eq=False, repr=False)
class AllHits(CompressedRows, HitGeometry):
    """All hits of each ray, each once, sorted by (ray, t, prim); with ``rank="distance"`` by (ray, distance, t, prim).

    Those of ray i are entries ``offsets[i]`` to ``offsets[i + 1]`` of the other arrays (compressed sparse rows).

    Attributes
    ----------
    offsets : (n_rays + 1,) int64
        The first entry of each ray, in the order of the flattened input, and the end of the last.
    t, prim, u, distance, t_out, skipped, geometry, part
        As in `FirstHits`, one entry a hit; so are `row` and `strand`.
    first_ray : int
        Of a part of `Tree.iter_all_hits`, which of all rays its first one is; else 0. In a part, `ray`, `of` and
        ``skipped`` count from there.
    """

    offsets: IntArray
    t: FloatArray
    prim: IntArray
    u: FloatArray
    distance: FloatArray
    t_out: FloatArray | None
    skipped: IntArray
    geometry: AnyGeometry | None = None
    rays: RayBatch | None = None
    part: IntArray | None = None
    first_ray: int = 0

    @classmethod
    def from_columns(
        cls, offsets: IntArray, columns: HitColumns, rays: RayBatch, geometry: AnyGeometry, first_ray: int = 0
    ) -> AllHits:
        """Wrap the lists of a backend."""
        t, prim, u, distance, t_out = columns
        part, prim = geometry.split(prim.view(np.int64))
        return cls(offsets.view(np.int64), t, prim, u, distance, t_out, rays.skipped, geometry, rays, part, first_ray)

    def _ray_of_rows(self) -> IntArray:
        return self.ray

    def __repr__(self) -> str:
        return f"<AllHits: {counted(len(self.offsets) - 1, 'rays')}, {counted(len(self), 'hits')}>"

    @property
    def ray(self) -> IntArray:
        """The index of the ray of each hit, (n_hits,) int64."""
        return self._row_of_entries

    def of(self, ray: int) -> slice:
        """Return the slice of the hits of a ray: ``hits.t[hits.of(3)]``.

        Raises
        ------
        InputError
            If there is no such ray; rays count from 0.
        """
        return self._entries_of("ray", ray)

    def merged_by_strand(self) -> AllHits:
        """Merge hits of the same ray and strand whose intervals from `t` to `t_out` overlap into one.

        A merged hit begins with its first segment and has its `prim` and `u`; it ends where the last one does. Its
        `distance` is the least of its segments. Segments without a strand stay alone.

        Raises
        ------
        InputError
            If the hits are not those ``at="surface"``, which have intervals.
        """
        if self.t_out is None:
            raise InputError("only hits at='surface' have intervals, from t to t_out, that can be merged")
        if not len(self):
            return self
        # What has no strand is a group of its own, as are strands of different parts.
        alone = self.strand.max(initial=0) + 1 + self.prim
        part = np.zeros(len(self), np.int64) if self.part is None else self.part
        groups = np.stack([part, np.where(self.strand >= 0, self.strand, alone)])
        group = np.unique(groups, axis=1, return_inverse=True)[1].reshape(-1)
        first, ends, distance = merged(
            crossings(self.ray, group, self.t, self.t_out), self.t, self.t_out, self.distance
        )
        offsets = offsets_of(self.ray[first], len(self.offsets) - 1)
        columns = self.t[first], self.prim[first], self.u[first], distance, ends
        kept = None if self.part is None else part[first]
        found = AllHits(offsets, *columns, self.skipped, self.geometry, self.rays, kept, self.first_ray)
        if self.geometry is None:  # of a pickle, which has these in its place
            found.__dict__.update(row=own(self.row[first]), strand=own(self.strand[first]))
        return found
