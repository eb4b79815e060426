"""All hits of many rays in parts that fit into given memory: runs of consecutive rays, whose hits are counted ahead."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator
from typing import Unpack

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, count
from ..errors import InputError
from ..progress import ProgressCallback, check_progress, reporting
from .at import At, has_exit
from .hits import AllHits
from .queries import Query, is_merge
from .ray_arguments import RayArguments, RayOptions, shows_ray_options
from .rays import RayBatch

#: The bytes that a ray takes in a part: its offset.
BYTES_A_RAY = 8

#: How often the columns of hits are in memory while a part is made; and where Python finishes it, which joins pieces
#: of curves, tests primitives of your own, drops what is ignored, and merges hits.
COPIES, PYTHON_COPIES = 2, 10

#: The fewest rays whose hits are counted at a time.
COUNTED_RAYS = 1 << 16

#: The share of the work that counting is.
COUNTING = 1 / 3


class HitRunQueries:
    """The query for all hits in parts, for trees."""

    @abstractmethod
    def _query(self, kernel: str, given: RayArguments) -> Query:
        """Check the rays, and choose the backend."""

    @shows_ray_options
    def iter_all_hits(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        *,
        max_bytes: int,
        at: str = "closest",
        merge: str | None = None,
        kernel: str = "auto",
        **options: Unpack[RayOptions],
    ) -> Iterator[AllHits]:
        """Find every hit of each ray, in parts that fit into memory; `first_hit` explains the other parameters.

        Each part holds the hits of consecutive rays, as many as fit. Parts come in the order of the rays, and together
        they are the bits of `all_hits`. Their ``first_ray`` is the first ray of each. Rays are checked once, before the
        first part. Do not change their arrays before the last part.

        Parameters
        ----------
        max_bytes : int
            The most that a part takes while it is made. A hit counts 40 bytes: 20 in the part, and 20 in a copy. Unless
            ``at="closest"`` it counts 48, in a `Geometry` 16 more, and each ray counts 8. For curves, primitives of
            your own, ``ignore``, ``ignore_strands`` and ``merge`` a hit counts five times as much; what is ignored,
            merged and joined counts too, and so does each box of your own primitives that a ray meets.
        merge : {None, "strand"}
            As in `all_hits`.

        Yields
        ------
        AllHits
            The hits of rays ``first_ray`` to ``first_ray + len(counts)``. Its ``ray`` and `AllHits.of` count from the
            first ray of the part.

        Raises
        ------
        InputError
            As `first_hit`; if rays are in the memory of a GPU; or if their arrays have changed between two parts.
        MemoryError
            If the hits of a single ray take more than `max_bytes`. All parts before it have been given.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> rays = [[0, 0, -5], [9, 9, 9], [0, 0.5, -5]], [0, 0, 1], 0.5
        >>> for part in tree.iter_all_hits(*rays, max_bytes=100):
        ...     print(part.first_ray + part.ray, part.prim)
        [0 0] [0 1]
        [2 2] [0 1]
        """
        query = self._query(kernel, RayArguments(origins, directions, radius, **options))
        max_bytes = count("max_bytes", max_bytes, 1)
        check_progress(query.progress)
        where, merges = query.checked_at(at), is_merge(merge, at)
        if not isinstance(query.rays, RayBatch):
            raise InputError("rays of a GPU or of Dask are not listed in parts; pass NumPy arrays, or use all_hits")
        return _parts(query, query.rays, where, merges, max_bytes)


def _parts(query: Query, rays: RayBatch, at: At, merges: bool, max_bytes: int) -> Iterator[AllHits]:
    """Yield the hits of runs of rays."""
    geometry, backend = query.geometry, query.backend
    in_python = geometry.in_pieces or geometry.has_user_code or bool(rays.ignored) or merges
    columns = 20 + 4 * has_exit(at) + 8 * geometry.has_parts
    bytes_a_hit = (PYTHON_COPIES if in_python else COPIES) * columns
    done = 0.0
    with reporting(query.progress, "all hits") as callback:

        def watched(n_rays: int, share: float) -> ProgressCallback | None:
            """Return the callback of the next step, which does a share of the work of some rays."""
            nonlocal done
            before, step = done, share * n_rays / len(rays)
            done += step
            return None if callback is None else lambda of_step: callback(before + of_step * step)

        def count_bytes(begin: int, end: int) -> IntArray:
            some = rays.unchanged().part(begin, end)
            return bytes_a_hit * backend.count_candidates(some, watched(end - begin, COUNTING)) + BYTES_A_RAY

        for begin, end in _runs(len(rays), max_bytes, count_bytes):
            part = rays.unchanged().part(begin, end)
            found = backend.list_hits(part, at, None, False, watched(end - begin, 1 - COUNTING))
            hits = AllHits.from_columns(*found, part, geometry, begin)
            yield hits.merged_by_strand() if merges else hits


def _runs(n_rays: int, max_bytes: int, count_bytes: Callable[[int, int], IntArray]) -> Iterator[tuple[int, int]]:
    """Yield runs of rays from begin to end that take at most `max_bytes` each, as many rays as fit."""
    begin, before = 0, 0
    until = np.zeros(0, np.int64)  # the bytes up to and with each of the rays that are counted, from `begin` on
    while begin < n_rays:
        while (known := begin + len(until)) < n_rays and (not len(until) or until[-1] <= before + max_bytes):
            more = count_bytes(known, min(known + max(COUNTED_RAYS, len(until)), n_rays))
            until = np.concatenate([until, (until[-1] if len(until) else before) + np.cumsum(more)])
        n_fitting = int(np.searchsorted(until, before + max_bytes, side="right"))
        if n_fitting == 0:
            raise MemoryError(
                f"the hits of ray {begin} alone take {int(until[0]) - before:,} bytes, and max_bytes={max_bytes:,}; "
                "raise max_bytes, use a smaller radius, or next_hits for the nearest"
            )
        yield begin, begin + n_fitting
        begin, before, until = begin + n_fitting, int(until[n_fitting - 1]), until[n_fitting:]
