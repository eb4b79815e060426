"""Queries on primitives of your own: the core finds the boxes that rays meet, and `hit` decides.

Answers are those of brute force, which tests all pairs. Each test is a row of an array, so its result must not depend
on the other rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...geometry.user_primitives import Rays, UserHits, UserPrimitives
from ...progress import ProgressCallback
from ...support.distinct import distinct
from ..at import At, has_exit
from ..backend import Backend, HitColumns, HitLists
from ..chunks import CHUNK_PAIRS, Chunks
from ..hit_lists import first_of_each, offsets_of
from ..rays import RayBatch

#: Rays that are searched first, to learn how many pairs they have.
FIRST_RAYS = 16
#: Boxes of a ray that are tested at a time when the first hit is searched.
AT_ONCE = 4


@dataclass(frozen=True)
class UserBackend(Backend):
    """Answers rays about primitives of your own; see `Backend`."""

    primitives: UserPrimitives
    #: Finds boxes; None for brute force.
    boxes: Backend | None

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        n = len(rays)
        prim = np.full(n, -1)
        t, distance, t_out = (np.full(n, np.inf, np.float32) for _ in range(3))
        u = np.zeros(n, np.float32)
        chunks = Chunks(n, self._first_rays(), progress)
        for rows in chunks:
            offsets, ids, enter = self._candidates(rays, rows)
            chunks.n_pairs = len(ids)
            box, end = offsets[:-1].copy(), offsets[1:]
            active = np.flatnonzero(box < end)
            while len(active):
                # Test the next boxes of each ray that it enters before its best hit.
                which = box[active, None] + np.arange(AT_ONCE)
                known = which < end[active, None]
                pair = which[known]
                ray = np.repeat(active, known.sum(axis=1))
                near = enter[pair] <= t[rows.start + ray]
                pair, ray = pair[near], ray[near]
                found = self._hit(ids[pair], rays, at, rows.start + ray)
                # Keep the best of each ray.
                order = np.lexsort((ids[pair], found.t, ray))
                best = order[np.unique(ray[order], return_index=True)[1]]
                to = rows.start + ray[best]
                new_t, new_prim = found.t[best], ids[pair][best]
                better = (new_t < t[to]) | ((new_t == t[to]) & np.isfinite(new_t) & (new_prim < prim[to]))
                best, to = best[better], to[better]
                t[to], prim[to] = found.t[best], ids[pair][best]
                u[to], distance[to], t_out[to] = found.u[best], found.distance[best], found.t_out[best]
                box[active] += AT_ONCE
                left = box[active] < end[active]
                active = active[left]
                active = active[enter[box[active]] <= t[rows.start + active]]
        return t, prim, u, distance, t_out if has_exit(at) else None

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        return np.asarray(self.first_hit(rays, at, progress)[1] >= 0)

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        counts = [np.zeros(0, np.int64)]
        chunks = Chunks(len(rays), self._first_rays(), progress)
        for rows in chunks:
            ray, _, _ = self._hits(rays, at, rows, chunks)
            counts.append(np.bincount(ray, minlength=rows.stop - rows.start))
        return np.concatenate(counts)

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`; these are the boxes that each ray meets."""
        if self.boxes is None:
            return self.count_hits(rays, "closest", progress)
        return self.boxes.count_candidates(rays, progress)

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        counts, prims, columns = (
            [np.zeros(0, np.int64)],
            [np.zeros(0, np.int64)],
            [UserHits(*[np.zeros(0, np.float32)] * 4)],
        )
        chunks = Chunks(len(rays), self._first_rays(), progress)
        for rows in chunks:
            ray, ids, found = self._hits(rays, at, rows, chunks)
            order = np.lexsort((ids, found.t, ray))
            t, u, distance, t_out = (column[order] for column in found)
            offsets = offsets_of(ray, rows.stop - rows.start)
            offsets, kept = first_of_each(offsets, (t, ids[order], u, distance, t_out), k, by_distance)
            assert kept[4] is not None
            counts.append(np.diff(offsets))
            prims.append(kept[1])
            columns.append(UserHits(kept[0], kept[2], kept[3], kept[4]))
        t, u, distance, t_out = (np.concatenate(parts) for parts in zip(*columns, strict=True))
        offsets = np.concatenate([[0], np.cumsum(np.concatenate(counts), dtype=np.int64)])
        return offsets, (t, np.concatenate(prims), u, distance, t_out if has_exit(at) else None)

    def _first_rays(self) -> int:
        return FIRST_RAYS if self.boxes is not None else max(1, CHUNK_PAIRS // max(1, len(self.primitives)))

    def _hits(self, rays: RayBatch, at: At, rows: slice, chunks: Chunks) -> tuple[IntArray, IntArray, UserHits]:
        """Return all hits of some rays, each once: the ray, counted from the first row, the primitive, and the rest."""
        offsets, ids, _ = self._candidates(rays, rows)
        chunks.n_pairs = len(ids)
        ray = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        ray, ids = np.divmod(distinct(ray * len(self.primitives) + ids), max(1, len(self.primitives)))
        parts = [slice(begin, begin + CHUNK_PAIRS) for begin in range(0, max(1, len(ids)), CHUNK_PAIRS)]
        tested = [self._hit(ids[part], rays, at, rows.start + ray[part]) for part in parts]
        found = UserHits(*map(np.concatenate, zip(*tested, strict=True)))
        hit = np.isfinite(found.t)
        return ray[hit], ids[hit], UserHits(*(column[hit] for column in found))

    def _candidates(self, rays: RayBatch, rows: slice) -> tuple[IntArray, IntArray, npt.NDArray[np.float32]]:
        """Return, as lists of each ray, the primitives whose boxes it meets, and where it enters these, rising."""
        some = np.arange(rows.start, rows.stop)
        if self.boxes is None:
            n = len(self.primitives)
            ids = np.tile(np.arange(n), len(some))
            return np.arange(len(some) + 1) * n, ids, np.full(len(ids), -np.inf, np.float32)
        offsets, (t, piece, *_) = self.boxes.list_hits(rays.some(some), "closest", None, False, None)
        return offsets, self.primitives.owner[piece], t

    def _hit(self, ids: IntArray, rays: RayBatch, at: At, row: IntArray) -> UserHits:
        """Test primitives with the rays in these rows; t of a miss is infinite."""
        origins, directions = (part[row].astype(np.float64) for part in (rays.origins, rays.directions))
        t_min, t_max, radius = (
            rays.scalar(part, row).astype(np.float64) for part in (rays.t_min, rays.t_max, rays.radius)
        )
        found = self.primitives.hit(ids, Rays(origins, directions, t_min, t_max), radius)
        if at == "entry":
            found = found._replace(t=np.where(found.t > t_min, found.t, np.float32(np.inf)))
        return found
