"""All hits of many rays in parts that fit into given memory: the method of what rays can be traced through."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import Unpack

import numpy.typing as npt

from ..arrays import count
from ..errors import InputError
from ..progress import check_progress, reporting
from .at import At, has_exit
from .hits import AllHits
from .queries import Query, is_merge
from .ray_arguments import RayArguments, RayOptions, shows_ray_options
from .rays import RayBatch
from .run_lists import list_runs

#: How often the columns of hits are in memory while a part is made; and where Python finishes it, which joins pieces
#: of curves, tests primitives of your own, drops what is ignored, and merges hits.
COPIES, PYTHON_COPIES = 2, 10


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
    geometry = query.geometry
    in_python = geometry.in_pieces or geometry.has_user_code or bool(rays.ignored) or merges
    columns = 20 + 4 * has_exit(at) + 8 * geometry.has_parts
    bytes_a_hit = (PYTHON_COPIES if in_python else COPIES) * columns
    with reporting(query.progress, "all hits") as callback:
        for begin, part, found in list_runs(query.backend, rays, at, bytes_a_hit, max_bytes, callback):
            hits = AllHits.from_columns(*found, part, geometry, begin)
            yield hits.merged_by_strand() if merges else hits
