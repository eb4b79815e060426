"""The acceleration tree with the questions that rays ask of it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import query, treefile
from .errors import InputError
from .geometry import IntArray, Lines
from .hits import AllHits, FirstHits
from .progress import ProgressOption
from .structure import TreeStructure


@dataclass(frozen=True, eq=False, repr=False)
class Tree(TreeStructure):
    """An acceleration tree over primitives, as `build` makes it.

    It is immutable. What it is: ``nodes``, ``refs``, ``cost()``, ``stats()``, ``levels()``, ``validate()``. What it
    answers: ``first_hit``, ``any_hit``, ``count_hits``, ``all_hits``, with the radius given at query time.
    """

    def first_hit(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike,
        *,
        t_min: npt.ArrayLike = 0.0,
        t_max: npt.ArrayLike = np.inf,
        at: str = "closest",
        invalid: str = "error",
        progress: ProgressOption = False,
    ) -> FirstHits:
        """Find the nearest hit of each ray o + t·d.

        A segment is hit if its least distance from the ray, with t in [t_min, t_max], is at most `radius`. Of hits
        with the same t the one with the lower id counts.

        Parameters
        ----------
        origins, directions : (…, 3) array
            Converted to float32. Directions need not be of unit length; t counts in them.
        radius : number or (…) array
            How near the ray must come: one for all rays or one for each.
        t_min, t_max : number or (…) array
            Bounds on t, likewise.
        at : {"closest", "surface"}
            Take t at the closest approach (the thesis), or where the ray enters the capsule of this radius around the
            segment (t_min if it starts inside); then ``t_out`` is where it leaves.
        invalid : {"error", "skip"}
            Refuse rays that are no rays (NaN, a direction of length zero, …), or let them miss and list them in
            ``skipped``.
        progress : bool or callable
            Show a bar, or call back with the share that is done.

        Returns
        -------
        FirstHits
            Arrays of the shape of the question.

        Raises
        ------
        InputError
            Names the rays that can not be asked.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
        >>> tree.first_hit([0, 0, -5], [0, 0, 1], 0.5).t
        array(5., dtype=float32)
        """
        hits: FirstHits = self._ask("first_hit", origins, directions, radius, t_min, t_max, at, invalid, progress)
        return hits

    def all_hits(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike,
        *,
        t_min: npt.ArrayLike = 0.0,
        t_max: npt.ArrayLike = np.inf,
        at: str = "closest",
        invalid: str = "error",
        progress: ProgressOption = False,
    ) -> AllHits:
        """Find every hit of each ray, each once, sorted by t; see `first_hit` for the parameters.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> hits = tree.all_hits([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)
        >>> print(hits.offsets, hits.prim, hits.t)
        [0 2 2] [0 1] [5. 6.]
        """
        hits: AllHits = self._ask("all_hits", origins, directions, radius, t_min, t_max, at, invalid, progress)
        return hits

    def any_hit(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike,
        *,
        t_min: npt.ArrayLike = 0.0,
        t_max: npt.ArrayLike = np.inf,
        invalid: str = "error",
        progress: ProgressOption = False,
    ) -> npt.NDArray[np.bool_]:
        """Tell for each ray whether it hits anything: bool of the question's shape; see `first_hit`.

        Examples
        --------
        >>> import fastlines as fl
        >>> fl.build([[[-1, 0, 0], [1, 0, 0]]]).any_hit([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)
        array([ True, False])
        """
        found: npt.NDArray[np.bool_] = self._ask(
            "any_hit", origins, directions, radius, t_min, t_max, "closest", invalid, progress
        )
        return found

    def count_hits(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike,
        *,
        t_min: npt.ArrayLike = 0.0,
        t_max: npt.ArrayLike = np.inf,
        invalid: str = "error",
        progress: ProgressOption = False,
    ) -> IntArray:
        """Count the segments that each ray hits: int64 of the question's shape; see `first_hit`.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> tree.count_hits([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)
        array([2, 0])
        """
        counts: IntArray = self._ask(
            "count_hits", origins, directions, radius, t_min, t_max, "closest", invalid, progress
        )
        return counts

    def _ask(
        self,
        name: query.QueryName,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike,
        t_min: npt.ArrayLike,
        t_max: npt.ArrayLike,
        at: str,
        invalid: str,
        progress: ProgressOption,
    ) -> Any:
        if not isinstance(self.geometry, Lines):
            raise InputError(f"queries are for lines; this tree is over {type(self.geometry).__name__}")
        return query.run(
            name,
            self.geometry,
            *self.words(),
            origins,
            directions,
            radius,
            t_min=t_min,
            t_max=t_max,
            at=at,
            invalid=invalid,
            progress=progress,
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the tree and its lines to one file, which `load` maps into memory.

        Strands and radii are kept; attributes are not.
        """
        treefile.write(self, path)


def load(path: str | os.PathLike[str]) -> Tree:
    """Map a saved tree into memory and check that it can be used.

    What a query relies on is checked: the graph, the ranges, the boxes, that the pieces of each segment tile it, and
    that each lies in its leaf's box. So no hit is lost or told twice. `Tree.validate` checks the axioms too.

    Raises
    ------
    FileFormatError
        If the file is not a whole, usable tree.
    OSError
        If it can not be read.
    """
    return Tree(**treefile.read(path))
