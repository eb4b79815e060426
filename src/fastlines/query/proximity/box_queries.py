"""Queries about axis-parallel boxes: the core lists rows in them, and rows become primitives."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias, cast

import numpy as np
import numpy.typing as npt

from ... import _core
from ...arrays import IntArray
from ...geometry.any_geometry import AnyGeometry
from ...geometry.collection import as_geometry
from ...geometry.user_primitives import Primitives, UserPrimitives
from ...progress import ProgressCallback, ProgressOption, reporting
from ...support.texts import counted
from ...threads import get_num_threads
from ..chunks import CHUNK_PAIRS
from ..hit_lists import offsets_of
from ..memory_check import MemoryCheck
from .in_box import InBox
from .regions import Regions

#: Lists of rows of the core: offsets, and the rows of each box, rising.
RowLists: TypeAlias = tuple[IntArray, IntArray]

#: Finds the rows in checked boxes, with a number of threads and a callback.
FindRows: TypeAlias = Callable[[Regions, int, ProgressCallback | None], RowLists]

#: The bytes of a row in a list, and of its copy in the answer.
ROW = 12


class BoxQueries:
    """The queries of a tree about boxes."""

    # A tree has this.
    geometry: AnyGeometry

    def in_box(
        self, low: npt.ArrayLike, high: npt.ArrayLike, *, to: str | None = None, progress: ProgressOption = False
    ) -> InBox:
        """Find the primitives that have a point in an axis-parallel box, its sides included.

        It runs on the CPU, also for a tree that `to` has placed on a GPU.

        Parameters
        ----------
        low, high : (…, 3) array
            The lowest and the highest corner of each box, in units of the coordinates; used in float64, less the offset
            of the lines. They may be infinite: ``low=[0, -np.inf, -np.inf], high=np.inf`` is a half-space. Their shapes
            broadcast.
        to : {"axis", "surface"}, optional
            Whether the axis of a thick line must have a point in the box, or the line as a whole. The default is the
            whole where lines, curves or spheres have a radius. For triangles and boxes it makes no difference.
        progress : bool or callable
            Show a bar, or call back with the fraction that is done.

        Returns
        -------
        InBox
            Lists, one for each box.

        Raises
        ------
        InputError
            If a corner holds NaN, or a low corner is above its high one.
        MemoryError
            If the lists do not fit into memory.

        Examples
        --------
        >>> import fastlines as fl
        >>> lines = fl.Lines.from_segments([[[0, 0, 0], [4, 0, 0]], [[0, 2, 0], [4, 2, 0]]], radius=[0.5, 1.5])
        >>> tree = fl.build(lines)
        >>> print(tree.in_box([1, 0.5, -1], [3, 1, 1]).prim, tree.in_box([1, 0, -1], [3, 1, 1], to="axis").prim)
        [0 1] [0]
        """
        return _listed(self.geometry, Regions.of(self.geometry, low, high, to), self._find_in_boxes, progress)

    def _find_in_boxes(self, regions: Regions, n_threads: int, progress: ProgressCallback | None) -> RowLists:
        """List the rows in checked boxes."""
        raise NotImplementedError


def brute_force_in_box(
    geometry: AnyGeometry | Primitives | npt.ArrayLike,
    low: npt.ArrayLike,
    high: npt.ArrayLike,
    *,
    to: str | None = None,
    progress: ProgressOption = False,
) -> InBox:
    """Find what is in boxes by testing every primitive; the answer of every tree is the same, bit for bit.

    Parameters
    ----------
    geometry : Lines, Geometry, another container, or (n, 2, 3) array
        As in `build`.
    low, high, to, progress
        As in `Tree.in_box`.

    Returns
    -------
    InBox

    Examples
    --------
    >>> brute_force_in_box([[[-1, 0, 0], [1, 0, 0]], [[-1, 0, 3], [1, 0, 3]]], [0, -1, 2], [1, 1, 4]).prim
    array([1])
    """
    known = as_geometry(geometry)
    regions = Regions.of(known, low, high, to)

    def find(some: Regions, n_threads: int, callback: ProgressCallback | None) -> RowLists:
        kind, rows = known.core_data()
        return _core.in_box(kind, rows, some.low, some.high, some.surface, n_threads, callback)

    return _listed(known, regions, None if known.has_user_code else find, progress)


def _listed(
    geometry: AnyGeometry,
    regions: Regions,
    find: FindRows | None,
    progress: ProgressOption,
) -> InBox:
    """List the primitives in regions, from the rows of the core there; without a function that finds rows, from all."""

    def count_some(boxes: IntArray) -> IntArray:
        return np.zeros(0, np.int64) if find is None else np.diff(find(regions.some(boxes), 1, None)[0])

    memory = MemoryCheck(0 if find is None else len(regions), ROW, count_some, nouns="boxes")
    with reporting(progress, "in box") as callback:
        watched = memory.watch(callback)
        try:
            offsets, prim = (np.zeros(len(regions) + 1, np.int64), np.zeros(0, np.int64))
            if geometry.has_user_code:
                offsets, prim = _of_user(cast(UserPrimitives, geometry), regions, find, callback)
            elif find is not None:
                offsets, prim = _joined(geometry, *find(regions, get_num_threads(), watched))
        except MemoryError as error:
            raise MemoryError(
                f"what is in {counted(len(regions), 'boxes')} does not fit into memory{memory.why}; ask for fewer or "
                "smaller boxes"
            ) from error
    part, prim = geometry.split(prim.view(np.int64))
    return InBox(offsets.view(np.int64), prim, geometry, part)


def _joined(geometry: AnyGeometry, offsets: IntArray, rows: IntArray) -> RowLists:
    """Replace rows of the core by their primitives, each once in each box."""
    if not (geometry.in_pieces or geometry.has_user_code):
        return offsets, rows
    prim, box = geometry.owner[rows], np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    is_new = np.ones(len(prim), np.bool_)
    is_new[1:] = (prim[1:] != prim[:-1]) | (box[1:] != box[:-1])
    return offsets_of(box[is_new], len(offsets) - 1), prim[is_new]


def _of_user(
    primitives: UserPrimitives, regions: Regions, find: FindRows | None, progress: ProgressCallback | None
) -> RowLists:
    """List primitives of the user's own: their method decides about those whose boxes are found, or about all."""
    primitives.require_in_box()
    n_boxes, n_prims = len(regions), len(primitives)
    lists = None if find is None else _joined(primitives, *find(regions, get_num_threads(), None))
    n_pairs = n_boxes * n_prims if lists is None else len(lists[1])
    boxes, prims = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for begin in range(0, n_pairs, CHUNK_PAIRS):
        pair = np.arange(begin, min(begin + CHUNK_PAIRS, n_pairs))
        if lists is None:
            box, prim = np.divmod(pair, n_prims)
        else:
            box, prim = np.searchsorted(lists[0], pair, side="right") - 1, lists[1][pair]
        is_in = primitives.in_box(prim, regions.low[box], regions.high[box])
        boxes.append(box[is_in])
        prims.append(prim[is_in])
        if progress is not None:
            progress((begin + len(pair)) / n_pairs)
    return offsets_of(np.concatenate(boxes), n_boxes), np.concatenate(prims)
