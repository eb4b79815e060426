"""Queries for pairs of near primitives: `PairQueries` is a base of `Tree`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy.typing as npt

from ... import _core
from ...arrays import count, kind_of
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...geometry.collection import as_geometry
from ...geometry.user_primitives import Primitives
from ...progress import ProgressOption, reporting
from ...support.texts import counted
from ...threads import get_num_threads
from .along import Along, find_along
from .pair_backend import PairBackend, PairsOfSets
from .pair_query import PAIR_BYTES, SORTING_BYTES, PairQuery, check_pairs, most_pairs, no_pairs
from .pair_sets import PairSets, row_arrays
from .pairs import Pairs
from .strand_places import strand_places

#: `iter_pairs` searches the pairs of one in so many of the primitives first.
FIRST_SHARE = 64
#: How full a part of `iter_pairs` should be, so that few are searched twice; and how much larger the next one may be.
FULL, MORE = 0.7, 4


class PairQueries:
    """The queries of a tree for pairs of near primitives."""

    # A tree has this.
    geometry: AnyGeometry

    def pairs(
        self,
        radius: float,
        other: PairQueries | None = None,
        *,
        skip_neighbours: int = 1,
        skip_strand: bool = False,
        to: str | None = None,
        progress: ProgressOption = False,
    ) -> Pairs:
        """Find all pairs of segments, spheres or curves that are within a radius of each other.

        Each pair is found once. Two curves make one pair, at their nearest places.

        Parameters
        ----------
        radius : number
            The largest distance of a pair, in units of the coordinates.
        other : Tree or Forest, optional
            Pair the primitives of this tree with those of another one, which has the same `offset`. By default, pairs
            are those of this tree.
        skip_neighbours : int
            Leave out pairs of one strand whose positions along it differ by at most this. The default of 1 leaves out
            segments that share a joint of their strand, and 0 nothing. A position counts the primitives of a strand in
            the order of their numbers. In a strand whose last primitive ends where the first one starts, these two are
            neighbours. Primitives without a strand have no neighbours. Pairs of two trees are all found.
        skip_strand : bool
            Leave out all pairs of one strand.
        to : {"surface", "axis"}, optional
            Measure distances between surfaces, which is the default for what has a radius: the distance of the axes
            less both radii, where that is least; or between axes.
        progress : bool or callable
            Show a bar, or call back with the fraction that is done.

        Returns
        -------
        Pairs
            Sorted by (i, j).

        Raises
        ------
        InputError
            If the radius is negative or NaN; if a tree has triangles, boxes or primitives of your own; or if trees have
            different offsets.
        MemoryError
            If the pairs do not fit into memory; `iter_pairs` finds them in parts.

        Notes
        -----
        The CPU answers, also for a tree on a GPU. A pair takes 28 bytes, and 40 more during the query. After a `refit`,
        the same call finds the pairs of the next time step.

        Examples
        --------
        >>> import fastlines as fl
        >>> strands = [[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 0], [1, 1, 0], [2, 1, 0]]]
        >>> tree = fl.build(fl.Lines.from_strands(strands))
        >>> pairs = tree.pairs(1)
        >>> print(pairs.i, pairs.j, pairs.distance)
        [0 0 1 1] [2 3 2 3] [1. 1. 1. 1.]
        >>> tree.pairs(0.5, skip_neighbours=0)
        <Pairs: 2 pairs>
        """
        query = self._pair_query(radius, other, skip_neighbours, skip_strand, to)
        if query.is_empty:
            return query.pairs(no_pairs())
        most = most_pairs()
        with reporting(progress, "pairs") as callback:
            try:
                return query.pairs(self._pair_backend(other).pairs(query, 0, len(self.geometry), most, callback))
            except MemoryError as error:
                raise MemoryError(
                    f"the pairs within {query.radius:g} do not fit into memory, which has room for about "
                    f"{most / 1e6:,.0f} million; use a smaller radius, or iter_pairs, which finds them in parts"
                ) from error

    def iter_pairs(
        self,
        radius: float,
        other: PairQueries | None = None,
        *,
        max_bytes: int,
        skip_neighbours: int = 1,
        skip_strand: bool = False,
        to: str | None = None,
        progress: ProgressOption = False,
    ) -> Iterator[Pairs]:
        """Find the same pairs as `pairs`, in parts that fit into memory.

        The parts have consecutive ranges of i, so one after the other they are the answer of `pairs`.

        Parameters
        ----------
        max_bytes : int
            How much memory a part may take, with what is needed to find it: 68 bytes a pair.
        radius, other, skip_neighbours, skip_strand, to, progress
            As in `pairs`.

        Yields
        ------
        Pairs
            At least one pair each.

        Raises
        ------
        MemoryError
            If the pairs of one primitive alone take more than `max_bytes`.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[0, 0, z], [1, 0, z]] for z in range(9)])
        >>> [len(part) for part in tree.iter_pairs(2, max_bytes=500)]
        [2, 4, 4, 4, 1]
        """
        query = self._pair_query(radius, other, skip_neighbours, skip_strand, to)
        most = count("max_bytes", max_bytes, PAIR_BYTES + SORTING_BYTES) // (PAIR_BYTES + SORTING_BYTES)
        return self._parts(query, self._pair_backend(other), most, progress)

    def _parts(self, query: PairQuery, backend: PairBackend, most: int, progress: ProgressOption) -> Iterator[Pairs]:
        n = 0 if query.is_empty else len(self.geometry)
        begin, size = 0, max(1, n // FIRST_SHARE)
        with reporting(progress, "pairs") as callback:
            while begin < n:
                end = min(begin + size, n)
                try:
                    found = query.pairs(backend.pairs(query, begin, end, most, None))
                except MemoryError as error:
                    if end - begin == 1:
                        raise MemoryError(
                            f"primitive {begin} alone has more than the {counted(most, 'pairs')} that max_bytes holds; "
                            "raise it, or use a smaller radius"
                        ) from error
                    size = max(1, (end - begin) // MORE)
                    continue
                size = min(max(1, int((end - begin) * FULL * most / max(1, len(found)))), MORE * (end - begin))
                begin = end
                if callback is not None:
                    callback(begin / n)
                if len(found):
                    yield found

    def along(
        self, polyline: npt.ArrayLike, radius: float, *, to: str | None = None, progress: ProgressOption = False
    ) -> Along:
        """Find the primitives within a radius of a polyline, such as a needle that bends.

        Parameters
        ----------
        polyline : (m, 3) array
            Two points or more.
        radius : number
            The largest distance from the polyline, in units of the coordinates.
        to : {"surface", "axis"}, optional
            Measure distances to surfaces, which is the default for what has a radius, or to axes.
        progress : bool or callable
            Show a bar, or call back with the fraction that is done.

        Returns
        -------
        Along
            Each primitive once, at its place that is nearest to the polyline, sorted by its number.

        Raises
        ------
        InputError
            If there are fewer than two points, or one is not finite; or as `pairs` does.
        MemoryError
            If what is near each segment of the polyline does not fit into memory.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[x, -1, 0], [x, 1, 0]] for x in range(5)])
        >>> tree.along([[-9, 0, 1], [1, 0, 1], [1, 0, 9]], radius=1).prim
        array([0, 1])
        """
        query = check_pairs(self.geometry, None, radius, 0, False, to)
        with reporting(progress, "along") as callback:
            try:
                return find_along(polyline, query, self._pair_sets(), callback)
            except MemoryError as error:
                raise MemoryError(
                    f"what is within {query.radius:g} of each segment of the polyline does not fit into memory; use a "
                    "smaller radius, or a polyline of fewer points"
                ) from error

    def _pair_query(
        self, radius: object, other: PairQueries | None, skip_neighbours: int, skip_strand: bool, to: str | None
    ) -> PairQuery:
        if other is not None and not isinstance(other, PairQueries):
            raise InputError(f"other is {kind_of(other)}; expected a Tree or a Forest, such as fl.build(other)")
        second = None if other is None else other.geometry
        return check_pairs(self.geometry, second, radius, skip_neighbours, skip_strand, to)

    def _pair_sets(self) -> PairSets:
        """Return what pairs are sought in."""
        raise NotImplementedError

    def _pair_backend(self, other: PairQueries | None) -> PairBackend:
        """Return what finds pairs, of these primitives or with those of another."""
        return PairsOfSets(self._pair_sets(), None if other is None else other._pair_sets())


def brute_force_pairs(
    geometry: AnyGeometry | Primitives | npt.ArrayLike,
    radius: float,
    other: AnyGeometry | npt.ArrayLike | None = None,
    *,
    skip_neighbours: int = 1,
    skip_strand: bool = False,
    to: str | None = None,
    progress: ProgressOption = False,
) -> Pairs:
    """Find pairs by testing all of them; the answer of `Tree.pairs` is the same for every tree, bit for bit.

    Parameters
    ----------
    geometry, other : Lines, Spheres, Curves, Geometry of these, or (n, 2, 3) array
        As in `build`.
    radius, skip_neighbours, skip_strand, to, progress
        As in `Tree.pairs`.

    Returns
    -------
    Pairs

    Examples
    --------
    >>> brute_force_pairs([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 3], [0, 1, 3]]], 5).distance
    array([3.], dtype=float32)
    """
    first, second = as_geometry(geometry), None if other is None else as_geometry(other)
    query = check_pairs(first, second, radius, skip_neighbours, skip_strand, to)
    if query.is_empty:
        return query.pairs(no_pairs())
    both = first if second is None else second
    data = None if second is None else second.core_data()
    places = strand_places(first) if query.reach else None
    known = row_arrays(first, places), row_arrays(both, places)
    options = query.options(0, len(first), 2**62)
    with reporting(progress, "pairs") as callback:
        i, j, s, t, distance = _core.brute_force_pairs(
            first.core_data(), data, known, options, get_num_threads(), callback
        )
    i, s = first.parameter(i, s)
    j, t = both.parameter(j, t)
    return query.pairs((i, j, s, t, distance))
