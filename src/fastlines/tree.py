"""The acceleration tree with the questions that rays ask of it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import treefile
from .engines import kernel_number
from .errors import InputError
from .geometry import IntArray, Lines
from .hits import AllHits, FirstHits
from .layout import Layout, widen
from .progress import ProgressOption
from .query import Question, ask_binary, ask_layout
from .structure import TreeStructure


@dataclass(frozen=True, eq=False, repr=False)
class Tree(TreeStructure):
    """An acceleration tree over primitives, as `build` makes it.

    It is immutable. What it is: ``nodes``, ``refs``, ``cost()``, ``stats()``, ``levels()``, ``validate()``. What it
    answers: ``first_hit``, ``any_hit``, ``count_hits``, ``all_hits``, ``next_hits``, with the radius given at query
    time.
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
        kernel: str = "auto",
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
        kernel : {"auto", "single", "wave", "bundle", "binary"}
            How to search: chosen for each group of rays by how they run, or forced (docs/engine.md); "binary" goes
            through the tree as it was built. The answer is the same.

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
        question = Question("first_hit", origins, directions, radius, t_min, t_max, at, None, invalid, progress)
        hits: FirstHits = self._ask(question, kernel)
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
        kernel: str = "auto",
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
        question = Question("all_hits", origins, directions, radius, t_min, t_max, at, None, invalid, progress)
        hits: AllHits = self._ask(question, kernel)
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
        kernel: str = "auto",
    ) -> npt.NDArray[np.bool_]:
        """Tell for each ray whether it hits anything: bool of the question's shape; see `first_hit`.

        Examples
        --------
        >>> import fastlines as fl
        >>> fl.build([[[-1, 0, 0], [1, 0, 0]]]).any_hit([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)
        array([ True, False])
        """
        question = Question("any_hit", origins, directions, radius, t_min, t_max, "closest", None, invalid, progress)
        found: npt.NDArray[np.bool_] = self._ask(question, kernel)
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
        kernel: str = "auto",
    ) -> IntArray:
        """Count the segments that each ray hits: int64 of the question's shape; see `first_hit`.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> tree.count_hits([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)
        array([2, 0])
        """
        question = Question("count_hits", origins, directions, radius, t_min, t_max, "closest", None, invalid, progress)
        counts: IntArray = self._ask(question, kernel)
        return counts

    def next_hits(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike,
        k: int,
        *,
        t_min: npt.ArrayLike = 0.0,
        t_max: npt.ArrayLike = np.inf,
        at: str = "closest",
        invalid: str = "error",
        progress: ProgressOption = False,
        kernel: str = "auto",
    ) -> AllHits:
        """Find the k nearest hits of each ray, each once, sorted by t; see `first_hit` for the other parameters.

        To go on after them, ask again with t_min at the last one's t.
        """
        hits: AllHits = self._ask(
            Question("next_hits", origins, directions, radius, t_min, t_max, at, k, invalid, progress), kernel
        )
        return hits

    @cached_property
    def layout(self) -> Layout:
        """What queries run on: made at the first of them, and kept."""
        self._check_lines()
        return widen(self.geometry, *self.words(), self.nodes["box"][0])  # type: ignore[arg-type]

    def _check_lines(self) -> None:
        if not isinstance(self.geometry, Lines):
            raise InputError(f"queries are for lines; this tree is over {type(self.geometry).__name__}")

    def _ask(self, question: Question, kernel: str) -> Any:
        self._check_lines()
        if kernel_number(kernel) < 0:
            box = self.nodes["box"][0]
            return ask_binary(self.geometry, *self.words(), box, question)  # type: ignore[arg-type]
        return ask_layout(self.layout, question, kernel)

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
