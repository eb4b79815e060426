"""The acceleration tree with the questions that rays ask of it."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core, tree_file
from .arrays import IntArray
from .backend import engine, kernel_number
from .errors import InputError
from .hits import AllHits, FirstHits
from .immutable import own
from .layout import Layout, refit_layout, widen
from .lines import Lines, as_lines
from .progress import ProgressCallback, ProgressOption, reporting
from .queries import Planes, Question, ask_binary, ask_layout
from .threads import get_num_threads
from .tree_data import NODE, TreeData

#: Trees of fewer references are refitted on one thread: a second would hardly have started.
SHORT_REFIT = 20_000


@dataclass(frozen=True, eq=False, repr=False)
class Tree(TreeData):
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

        A hit takes 20 bytes (24 with ``at="surface"``), and 20 more while it is being found; `count_hits` tells how
        many there are.

        Raises
        ------
        MemoryError
            If the hits do not fit into memory. Where a sample of the rays tells so, that is soon after the start.

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

        To go on after them, ask for more. With t_min at the last one's t the ray would start there, where all
        that it has come near may still be within its radius.
        """
        hits: AllHits = self._ask(
            Question("next_hits", origins, directions, radius, t_min, t_max, at, k, invalid, progress), kernel
        )
        return hits

    def __getstate__(self) -> dict[str, Any]:
        made = {"layout": self.layout} if "layout" in self.__dict__ else {}
        return super().__getstate__() | made

    @cached_property
    def layout(self) -> Layout:
        """What queries run on: made at the first of them, and kept."""
        self._check_lines()
        return widen(self.geometry, *self.words(), self.nodes["box"][0])  # type: ignore[arg-type]

    @cached_property
    def planes(self) -> Planes:
        """What ``kernel="binary"`` searches in a KD tree: made at the first query, and kept."""
        nodes, prims, depth = _core.planes(*self.words())
        return Planes(own(nodes), own(prims), depth, tuple(self.nodes["box"][0].reshape(-1).tolist()))

    def _check_lines(self) -> None:
        if not isinstance(self.geometry, Lines):
            raise InputError(f"queries are for lines; this tree is over {type(self.geometry).__name__}")

    def _ask(self, question: Question, kernel: str) -> Any:
        self._check_lines()
        if kernel_number(kernel) < 0:
            tree = self.planes if self.settings.boxes == "cut" else self.words()
            return ask_binary(self.geometry, tree, self.nodes["box"][0], question)  # type: ignore[arg-type]
        return ask_layout(self.layout, question, kernel)

    # ---- Moving segments ----

    def refit(self, lines: Lines | npt.ArrayLike, *, progress: ProgressOption = False) -> Tree:
        """Make the same tree over segments that have moved: same nodes and pieces, boxes fitted anew (docs/refit.md).

        It takes a small part of the time of a build, and answers are exact; but boxes overlap the more, the more
        neighbours part. `growth` tells by how much the cost has grown, `RebuildPolicy` when to build anew. If the tree
        has its `layout`, the new one has its own, fitted likewise.

        Parameters
        ----------
        lines : Lines or (n, 2, 3) array
            As many segments as the tree has, in the same order. With an array, strands, radii and attributes stay. An
            array that somebody could change is copied.
        progress : bool or callable
            Show a bar, or call back with the share that is done.

        Returns
        -------
        Tree
            A BVH, of a KD tree too: where lines have moved, its boxes can not cut space in two any more.

        Raises
        ------
        InputError
            If there are more or fewer segments, or one holds NaN or Inf.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
        >>> tree.refit([[[-1, -1, 0], [1, 1, 2]]]).first_hit([0, 0, -5], [0, 0, 1], 0.5).t
        array(6., dtype=float32)
        """
        if not isinstance(self.geometry, Lines):
            raise InputError(f"refits are for lines; this tree is over {type(self.geometry).__name__}: build it anew")
        moved = as_lines(lines)
        if len(moved) != self.n_prims:
            left = "; it skipped some rows: pass array[tree.geometry.rows]" if len(self.geometry.skipped) else ""
            raise InputError(f"{len(moved)} segments were given for a tree over {self.n_prims}; expected as many{left}")
        if moved is not lines:
            moved = replace(self.geometry, segments=moved.segments)
        tight = self.settings if self.settings.boxes == "tight" else replace(self.settings, boxes="tight")
        with reporting(progress, "refit") as callback:
            changes = {
                "geometry": moved,
                "nodes": self._refit_nodes(moved, callback),
                "settings": tight,
                "method": self.method if tight is self.settings else "custom",
                "built_cost": self._cost_when_built,
            }
            # What is the same was checked when this tree was made.
            tree = object.__new__(type(self))
            for field in fields(self):
                object.__setattr__(tree, field.name, changes.get(field.name, getattr(self, field.name)))
            if "layout" in self.__dict__:
                box = tree.nodes["box"][0]
                tree.__dict__["layout"] = refit_layout(self.layout, moved, box, self._refit_threads, callback)
        return tree

    def _refit_nodes(self, lines: Lines, callback: ProgressCallback | None) -> npt.NDArray[Any]:
        segments = lines.segments.reshape(-1, 6)
        words = engine().refit_tree(segments, *self.words(), self._refit_threads, callback)
        return own(words).reshape(-1).view(NODE)

    @property
    def _refit_threads(self) -> int:
        return 1 if self.n_refs < SHORT_REFIT else get_num_threads()

    @cached_property
    def _cost_when_built(self) -> float:
        """What `growth` is measured by: of a KD tree, the cost with boxes as tight as those of a refit."""
        if self.built_cost is not None:
            return self.built_cost
        model = self.settings.cost
        if self.settings.boxes == "tight":
            return _core.cost(self.words()[0], model.c_trav, model.c_prim)
        assert isinstance(self.geometry, Lines)
        nodes = self._refit_nodes(self.geometry, None).view(np.uint32).reshape(-1, 9)
        return _core.cost(nodes, model.c_trav, model.c_prim)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the tree and its lines to one file, which `load` maps into memory.

        All that the lines have is kept, but for attributes that are neither booleans nor whole numbers or floats of up
        to 8 bytes: a warning names those. The file appears whole or not at all. A symbolic link stays one, and a file
        that is there keeps its mode.

        Raises
        ------
        InputError
            If the tree is not over lines, or the path is a device, a pipe or a socket, or has the extension of lines.
        OSError
            If the path is a folder, or can not be written.
        """
        tree_file.write(self, path)


def load(path: str | os.PathLike[str], *, verify: bool | None = None) -> Tree:
    """Map a saved tree into memory and check that it can be used.

    What queries rely on is checked, as of every tree (`Tree`): the graph and its depth, the ranges, the boxes, that the
    pieces of each segment tile it, and that each lies in its leaf's box. So no hit is lost or told twice.
    `Tree.validate` checks the axioms too. What changes or truncates the file later changes the tree (docs/files.md).

    Parameters
    ----------
    path : str or path
    verify : bool, optional
        Whether to verify the checksums, which tell of damage that leaves a tree a tree, such as another coordinate. By
        default those of files of up to 1 GiB are verified, if there are any. Older versions wrote none: such files are
        loaded, unless True asks for a verification.

    Raises
    ------
    FileFormatError
        If the file is not a whole, usable tree, or its checksums differ.
    OSError
        If it can not be read.
    """
    return tree_file.read(Tree, path, verify)
