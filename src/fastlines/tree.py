"""The acceleration tree: immutable plain data with the questions one can ask it.

Axioms, cost and theorems are those of thesis §3; see `fastlines.theory` for them as short, slow Python.
"""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _core, container, query
from .errors import FastlinesError, FileFormatError, InputError
from .geometry import IntArray, Lines
from .hits import AllHits, FirstHits
from .primitives import Geometry, core_data
from .progress import ProgressOption
from .settings import Cost, Settings, SplitSet

#: A node: its box, the index of its right child (0 = leaf; the left child is the next node), and the range of the
#: references at or below it.
NODE = np.dtype([("box", "<f4", (2, 3)), ("right", "<u4"), ("first_ref", "<u4"), ("n_refs", "<u4")])
#: A reference: a primitive, and the piece [s0, s1) of it that it stands for; s1 = inf in the last piece.
REF = np.dtype([("prim", "<u4"), ("s0", "<f4"), ("s1", "<f4")])

FORMAT = "fastlines tree 1"


class InvalidTreeError(FastlinesError):
    """A tree that breaks an axiom.

    Attributes
    ----------
    node : int
        Which node breaks it.
    axiom : str
        Which axiom: "axiom 1" to "axiom 5", "BVH axiom", "KD axiom" or "Theorem 4".
    """

    def __init__(self, node: int, axiom: str, detail: str) -> None:
        super().__init__(f"node {node} breaks {axiom}: {detail}")
        self.node = node
        self.axiom = axiom


@dataclass(frozen=True, eq=False)
class Tree:
    """An acceleration tree over primitives, as `build` makes it.

    Attributes
    ----------
    geometry : Lines, Triangles or Boxes
        What the tree was built on.
    nodes : (n_nodes,) array of `NODE`
        In preorder.
    refs : (n_refs,) array of `REF`
        In the order of the leaves.
    settings : Settings
        What the builder was told.
    method : str
        The name of the settings; "custom" if they have none.
    limits_hit : tuple of str
        The limits that kept the builder from a split.
    """

    geometry: Geometry
    nodes: npt.NDArray[Any]
    refs: npt.NDArray[Any]
    settings: Settings
    method: str = "custom"
    limits_hit: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"<Tree {self.method}: {self.n_prims:,} primitives, {self.n_refs:,} references, {self.n_nodes:,} nodes, "
            f"cost {self.cost():.6g}>"
        )

    # ---- What it is ----

    @property
    def n_prims(self) -> int:
        """Number of primitives."""
        return len(self.geometry)

    @property
    def n_nodes(self) -> int:
        """Number of nodes, inner ones and leaves."""
        return len(self.nodes)

    @property
    def n_refs(self) -> int:
        """Number of references; one primitive can have many."""
        return len(self.refs)

    @property
    def is_leaf(self) -> npt.NDArray[np.bool_]:
        """Which nodes are leaves, (n_nodes,) bool."""
        leaf: npt.NDArray[np.bool_] = self.nodes["right"] == 0
        return leaf

    @property
    def left(self) -> IntArray:
        """Left child of each node, (n_nodes,) int64; -1 in a leaf."""
        return np.where(self.is_leaf, -1, np.arange(self.n_nodes) + 1)

    @property
    def right(self) -> IntArray:
        """Right child of each node, (n_nodes,) int64; -1 in a leaf."""
        return np.where(self.is_leaf, -1, self.nodes["right"].astype(np.int64))

    def levels(self) -> list[IntArray]:
        """The nodes of each level, the root's first.

        Returns
        -------
        list of (k,) int64
            Element d holds the indices of the nodes at depth d, rising.
        """
        levels = [np.zeros(1, np.int64)]
        while len(inner := levels[-1][~self.is_leaf[levels[-1]]]):
            levels.append(np.sort(np.concatenate([self.left[inner], self.right[inner]])))
        return levels

    @cached_property
    def _levels(self) -> list[IntArray]:
        return self.levels()

    @cached_property
    def areas(self) -> npt.NDArray[np.float64]:
        """Surface area of each node's box, (n_nodes,) float64."""
        box = self.nodes["box"].astype(np.float64)
        x, y, z = (box[:, 1] - box[:, 0]).T
        return 2 * (x * y + x * z + y * z)

    def cost(self, *, by: Literal["f", "g"] = "f", model: Cost | None = None) -> float:
        """The cost of the tree (thesis §3.3), in float64.

        Parameters
        ----------
        by : {"f", "g"}
            By recursion from the leaves (f), or as a sum over all nodes (g); Theorem 1 says that they are equal.
        model : Cost, optional
            c_trav and c_prim; those the tree was built with if not given.

        Notes
        -----
        f(leaf) = n·c_prim and f(inner) = c_trav + Σ SA(child)/SA(node)·f(child). g = Σ over inner nodes of
        SA(node)/SA(root)·c_trav + Σ over leaves of SA(leaf)/SA(root)·n·c_prim. Where an area to divide by is zero, no
        line measures the node, and its children count as visited whenever it is.
        """
        model = model or self.settings.cost
        area, leaf = self.areas, self.is_leaf
        at_leaf = self.nodes["n_refs"] * model.c_prim
        if by == "g":
            chance = area / area[0] if area[0] > 0 else np.ones_like(area)
            return float((chance * np.where(leaf, at_leaf, model.c_trav)).sum())
        if by != "f":
            raise InputError(f"by={by!r} is not a choice: use 'f' or 'g'")
        f = at_leaf.astype(np.float64)
        for level in reversed(self._levels):
            inner = level[~leaf[level]]
            f[inner] = model.c_trav
            for child in (self.left[inner], self.right[inner]):
                chance = np.divide(area[child], area[inner], out=np.ones(len(inner)), where=area[inner] > 0)
                f[inner] += chance * f[child]
        return float(f[0])

    def stats(self) -> dict[str, Any]:
        """Counts, sizes and cost, ready for JSON."""
        in_leaf = self.nodes["n_refs"][self.is_leaf]
        return {
            "method": self.method,
            "n_prims": self.n_prims,
            "n_refs": self.n_refs,
            "refs_per_prim": self.n_refs / max(1, self.n_prims),
            "n_nodes": self.n_nodes,
            "n_leaves": len(in_leaf),
            "n_empty_leaves": int((in_leaf == 0).sum()),
            "depth": len(self._levels) - 1,
            "mean_leaf_refs": float(in_leaf.mean()),
            "largest_leaf_refs": int(in_leaf.max()),
            "cost": self.cost(),
            "memory_bytes": self.nodes.nbytes + self.refs.nbytes,
            "limits_hit": list(self.limits_hit),
        }

    def validate(self) -> None:
        """Check the axioms 1 to 5 of thesis §3.2, the BVH or KD axiom, and Theorem 4.

        Raises
        ------
        InvalidTreeError
            With the node and the axiom that fails.
        """
        kind, data = core_data(self.geometry)
        found = _core.validate(kind, data, *self._core_arrays(), self.settings.boxes == "cut")
        if found is not None:
            raise InvalidTreeError(*found)

    # ---- What a ray hits ----

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
        hits = self._ask("first_hit", origins, directions, radius, t_min, t_max, at, invalid, progress)
        assert isinstance(hits, FirstHits)
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
        """Find every hit of each ray, each once, sorted by t; see `first_hit` for the parameters."""
        hits = self._ask("all_hits", origins, directions, radius, t_min, t_max, at, invalid, progress)
        assert isinstance(hits, AllHits)
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
        """Tell for each ray whether it hits anything: bool of the question's shape; see `first_hit`."""
        found = self._ask("any_hit", origins, directions, radius, t_min, t_max, "closest", invalid, progress)
        assert isinstance(found, np.ndarray)
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
        """Count the segments that each ray hits: int64 of the question's shape; see `first_hit`."""
        counts = self._ask("count_hits", origins, directions, radius, t_min, t_max, "closest", invalid, progress)
        assert isinstance(counts, np.ndarray)
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
    ) -> query.Answer:
        if not isinstance(self.geometry, Lines):
            raise InputError(f"queries are for lines; this tree is over {type(self.geometry).__name__}")
        return query.run(
            name,
            self.geometry,
            *self._core_arrays(),
            origins,
            directions,
            radius,
            t_min=t_min,
            t_max=t_max,
            at=at,
            invalid=invalid,
            progress=progress,
        )

    def _core_arrays(self) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint32]]:
        return self.nodes.view(np.uint32).reshape(-1, 9), self.refs.view(np.uint32).reshape(-1, 3)

    # ---- Files ----

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the tree and its lines to one file, which `load` maps into memory.

        Strands and radii are kept; attributes are not.
        """
        if not isinstance(self.geometry, Lines):
            raise InputError(f"only trees over lines can be saved; this one is over {type(self.geometry).__name__}")
        nodes, refs = self._core_arrays()
        arrays = {"nodes": nodes, "refs": refs, "segments": self.geometry.segments, "strands": self.geometry.strands}
        if self.geometry.radius is not None:
            arrays["radius"] = self.geometry.radius
        metadata = {
            "format": FORMAT,
            "method": self.method,
            "settings": json.dumps(_settings_to_json(self.settings)),
            "limits_hit": json.dumps(self.limits_hit),
        }
        # Eight-byte numbers first, so that every section is aligned for its type.
        ordered = dict(sorted(arrays.items(), key=lambda entry: -entry[1].itemsize))
        container.write(path, ordered, metadata)


def load(path: str | os.PathLike[str]) -> Tree:
    """Map a saved tree into memory and check that it can be used.

    What a query relies on is checked: the graph, the ranges, the boxes, the pieces. `Tree.validate` checks the axioms too.

    Raises
    ------
    FileFormatError
        If the file is not a whole, usable tree.
    OSError
        If it can not be read.
    """
    arrays, metadata = container.read(path)

    def refuse(why: str) -> FileFormatError:
        return FileFormatError(f"{path} is not a usable tree file: {why}; build and save the tree again")

    if metadata.get("format") != FORMAT:
        raise refuse(f"its format is {metadata.get('format')!r}, expected {FORMAT!r}")
    expected = {"nodes": (9,), "refs": (3,), "segments": (2, 3), "strands": ()}
    for name, row in expected.items():
        if name not in arrays or arrays[name].shape[1:] != row or arrays[name].ndim == 0:
            raise refuse(f"the section {name!r} is missing or has another shape")
    dtypes = {"nodes": "<u4", "refs": "<u4", "segments": "<f4", "strands": "<i8"}
    if any(arrays[name].dtype != dtype for name, dtype in dtypes.items()):
        raise refuse("a section has another type")
    try:
        settings = _settings_from_json(json.loads(metadata["settings"]))
        limits_hit = tuple(str(name) for name in json.loads(metadata["limits_hit"]))
        method = metadata["method"]
        lines = Lines.from_segments(arrays["segments"], strands=arrays["strands"], radius=arrays.get("radius"))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise refuse(f"{error}") from None
    tree = Tree(
        lines, arrays["nodes"].reshape(-1).view(NODE), arrays["refs"].reshape(-1).view(REF), settings, method, limits_hit
    )
    _check_usable(tree, refuse)
    return tree


def _check_usable(tree: Tree, refuse: Any) -> None:
    """Check what a query relies on, in time proportional to the file."""
    nodes, refs, leaf = tree.nodes, tree.refs, tree.is_leaf
    index = np.arange(tree.n_nodes)
    if tree.n_nodes == 0:
        raise refuse("it has no nodes")
    inner = index[~leaf]
    left, right = inner + 1, nodes["right"][inner].astype(np.int64)
    if (right <= left).any() or (right >= tree.n_nodes).any():
        raise refuse("a child does not follow its parent")
    parents = np.bincount(np.concatenate([left, right]), minlength=tree.n_nodes)
    if parents[0] != 0 or (parents[1:] != 1).any():
        raise refuse("a node does not have one parent")
    first, n_refs = nodes["first_ref"].astype(np.int64), nodes["n_refs"].astype(np.int64)
    if (first + n_refs > tree.n_refs).any():
        raise refuse("a node's references reach past the end")
    if n_refs[leaf].sum() != tree.n_refs or (np.cumsum(n_refs[leaf]) - n_refs[leaf] != first[leaf]).any():
        raise refuse("the leaves do not list each reference once")
    low, high = nodes["box"][:, 0], nodes["box"][:, 1]
    if not (np.isfinite(nodes["box"]).all() and (low <= high).all()):
        raise refuse("a box is not a box")
    if (low[inner] > np.minimum(low[left], low[right])).any() or (high[inner] < np.maximum(high[left], high[right])).any():
        raise refuse("a child's box does not lie in its parent's")
    if tree.n_prims and (nodes["box"][0] != tree.geometry.bounds).any():  # type: ignore[union-attr]
        raise refuse("the root's box does not bound the segments")
    if tree.n_refs and (refs["prim"] >= tree.n_prims).any():
        raise refuse("a reference names no segment")
    if len(np.unique(refs["prim"])) != tree.n_prims:
        raise refuse("a segment is in no leaf")
    if not ((refs["s0"] >= 0) & (refs["s0"] <= refs["s1"])).all():
        raise refuse("a reference is not a piece of its segment")


def _settings_to_json(settings: Settings) -> dict[str, Any]:
    data = dataclasses.asdict(settings)
    data["splits"] = [{"name": split.name, **dataclasses.asdict(split)} for split in settings.splits]
    return data


def _settings_from_json(data: dict[str, Any]) -> Settings:
    from . import settings

    sets: dict[str, type[SplitSet]] = {kind.name: kind for kind in SplitSet.__subclasses__()}
    splits = tuple(sets[entry.pop("name")](**entry) for entry in data["splits"])
    return Settings(
        splits, data["boxes"], tuple(data["lookahead"]), Cost(**data["cost"]), settings.Limits(**data["limits"])
    )
