"""Queries about points: a backend answers checked points, and its columns become answers; the methods of trees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray, count
from ...geometry.any_geometry import AnyGeometry
from ...progress import ProgressOption, reporting
from ...support.texts import counted
from ..memory_check import SMALL, MemoryCheck, left_bytes
from .backend import CompiledPoints, PointBackend
from .nearest import Nearest
from .point_arguments import PointArguments, PointOptions, shows_point_options
from .points import PointBatch
from .user_points import UserPoints
from .within import Within

#: The bytes of an answer: distance, prim and u.
ANSWER = 16


@dataclass(frozen=True, eq=False)
class PointQuery:
    """Checked points, and the backend that answers them."""

    backend: PointBackend
    points: PointBatch
    geometry: AnyGeometry
    progress: ProgressOption = False

    def nearest(self, k: int) -> Nearest:
        """Find the k nearest primitives of each point."""
        k = count("k", k, 0)
        n_found = min(k, len(self.geometry))
        why, n_bytes = "", k * self.points.n_given * ANSWER
        try:
            if n_bytes > SMALL and n_bytes > (left := left_bytes()):
                why = f": they take {n_bytes / 1e9:,.1f} GB, {max(left, 0) / 1e9:,.1f} GB are left"
                raise MemoryError(why)
            with reporting(self.progress, "nearest") as callback:
                columns = np.zeros(0, np.float32), np.zeros(0, np.int64), np.zeros(0, np.float32)
                if n_found and len(self.points):
                    columns = self.backend.nearest(self.points, n_found, callback)
            return Nearest.from_columns(columns, k, self.points, self.geometry)
        except MemoryError as error:
            raise MemoryError(
                f"{counted(k, 'answers')} for each of {counted(self.points.n_given, 'points')} do not fit into memory"
                f"{why}; ask for fewer points or a smaller k"
            ) from error

    def within(self) -> Within:
        """List what is within the radius of each point, unless a sample says that it will not fit in memory."""
        points, backend = self.points, self.backend

        def count_some(rows: IntArray) -> IntArray:
            return backend.count_within(points.some(rows), None)

        memory = MemoryCheck(len(points), ANSWER, count_some, len(self.geometry), "points")
        with reporting(self.progress, "within") as callback:
            watched = memory.watch(callback)
            try:
                lists = backend.within(points, watched)
            except MemoryError as error:
                raise MemoryError(
                    f"the primitives within the radius of {counted(len(points), 'points')} do not fit into "
                    f"memory{memory.why}; ask for fewer points or use a smaller radius, nearest for the nearest, or "
                    "count_within for how many there are"
                ) from error
        return Within.from_lists(lists, points, self.geometry)

    def count_within(self) -> IntArray:
        """Count what is within the radius of each point."""
        counts = np.zeros(self.points.n_given, np.int64)
        with reporting(self.progress, "count within") as callback:
            found = self.backend.count_within(self.points, callback)
        counts[slice(None) if self.points.rows is None else self.points.rows] = found
        return counts.reshape(self.points.shape)


def point_backend(geometry: AnyGeometry, functions: Any, view: Any, *, is_tree: bool = True) -> PointBackend:
    """Return the functions of a module on a view as a backend, or that of a class of the user's own."""
    backend: PointBackend = CompiledPoints(functions, view, geometry)
    if geometry.has_user_code:
        backend = UserPoints.of(geometry, backend if is_tree else None)
    return backend


class ProximityQueries:
    """The queries of a tree about points."""

    @shows_point_options
    def nearest(
        self,
        points: npt.ArrayLike,
        k: int = 1,
        *,
        max_distance: npt.ArrayLike = np.inf,
        **options: Unpack[PointOptions],
    ) -> Nearest:
        """Find the nearest primitives of each point, by their distance and then by id.

        All queries about points take these parameters. They run on the CPU, also for a tree that `Tree.to` has placed
        on a GPU.

        Parameters
        ----------
        points : (…, 3) array
            Used in float64, less the offset of the lines.
        k : int
            How many primitives to find. Where there are fewer, the rest are misses.
        max_distance : number or (…) array
            How far they may be away, in units of the coordinates: one for all points or one for each.
        to : {"axis", "surface"}, optional
            Measure distances to the axes of thick lines, or to their surfaces: then they are negative inside, the
            deepest first. The default is the surface where lines, curves or spheres have a radius. It makes no
            difference for triangles, for boxes, inside which the distance is 0, and for a class of your own.
        ignore, ignore_strands, parts
            What to leave out, as in `first_hit`: for all points, or for each.
        invalid : {"error", "skip"}
            Refuse invalid points (NaN, too far away, …), or let them miss and list them in ``skipped``.
        progress : bool or callable
            Show a bar, or call back with the fraction that is done.

        Returns
        -------
        Nearest
            Arrays of the shape of the points, and (…, k) unless k is 1.

        Raises
        ------
        InputError
            If a point is invalid, and the message lists the rows; or if a class of your own has no method `nearest`.
        MemoryError
            If the answers do not fit into memory.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> found = tree.nearest([[0.5, 0, 0.25], [0, 3, 1]])
        >>> print(found.prim, found.distance, found.u)
        [0 1] [0.25 2.  ] [0.75 1.  ]
        >>> tree.nearest([0.5, 0, 0.25], k=2).prim
        array([0, 1])
        """
        return self._point_query(PointArguments(points, max_distance, "max_distance", **options)).nearest(k)

    @shows_point_options
    def within(self, points: npt.ArrayLike, radius: npt.ArrayLike, **options: Unpack[PointOptions]) -> Within:
        """Find all primitives within a radius of each point, each once, sorted by their distance and then by id.

        `nearest` explains the other parameters.

        Parameters
        ----------
        radius : number or (…) array
            In units of the coordinates: one for all points or one for each. Distances are at most this.

        Returns
        -------
        Within
            Flat arrays with ``offsets``: entries ``offsets[i]`` to ``offsets[i + 1]`` are those of point i.

        Notes
        -----
        This is not a ray query with ``t_min = t_max = 0``, which rounds points to float32 first. A primitive takes 16
        bytes, and as many more during the query; `count_within` counts them.

        Raises
        ------
        MemoryError
            If the answers do not fit into memory. A sample of the points often shows this soon after the start.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> found = tree.within([[0, 0, 0.75], [9, 9, 9]], 1)
        >>> print(found.offsets, found.prim, found.distance)
        [0 2 2] [1 0] [0.25 0.75]
        """
        return self._point_query(PointArguments(points, radius, **options)).within()

    @shows_point_options
    def count_within(self, points: npt.ArrayLike, radius: npt.ArrayLike, **options: Unpack[PointOptions]) -> IntArray:
        """Count the primitives within a radius of each point; `within` takes the same parameters, and lists them.

        Returns
        -------
        (…) int64 array
            Of the shape of the points.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> tree.count_within([[0, 0, 0.75], [9, 9, 9]], 1)
        array([2, 0])
        """
        return self._point_query(PointArguments(points, radius, **options)).count_within()

    def _point_query(self, given: PointArguments) -> PointQuery:
        """Check the points, and choose the backend."""
        raise NotImplementedError
