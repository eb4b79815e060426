"""The acceleration tree as an object of the theory: axioms, cost, counts, levels.

Axioms, cost and theorems are those of thesis §3; see `fastlines.theory` for them as short, slow Python.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import InitVar, dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _core
from ..arrays import IntArray, choice, count, instance
from ..errors import InputError, InvalidTreeError
from ..geometry.any_geometry import AnyGeometry
from ..settings.settings import COST, Cost, Settings
from ..support.computed_once import computed_once
from ..support.display import Shown
from ..support.graphviz import MAX_LEVEL, dot_nodes, dot_text
from ..support.immutable import Immutable, frozen, own
from ..support.texts import counted
from .frame import frame_around

#: A node: its box, the index of its right child (0 = leaf; the left child is the next node), and the range of the
#: references at or below it.
NODE = np.dtype([("box", "<f4", (2, 3)), ("right", "<u4"), ("first_ref", "<u4"), ("n_refs", "<u4")])
#: A reference: a primitive, and the piece [s0, s1) of it that the reference covers; s1 = inf in the last piece.
REF = np.dtype([("prim", "<u4"), ("s0", "<f4"), ("s1", "<f4")])

#: The deepest level of a node.
MAX_DEPTH = _core.MAX_DEPTH


class Planes(NamedTuple):
    """A KD tree as the core searches it by its planes (cpp/fastlines/query/plane_tree.hpp).

    `nodes` (n, 2) have an axis and a plane each, or a range of references; siblings are adjacent. `prims` has the
    primitive of each reference. `depth` is the level of the deepest node, `corners` the root's box, and `frame_corners`
    that of the frame.
    """

    nodes: npt.NDArray[np.uint32]
    prims: npt.NDArray[np.uint32]
    depth: int
    corners: tuple[float, ...]
    frame_corners: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class TreeData(Shown, Immutable):
    """An acceleration tree over primitives, as plain immutable data.

    The constructor checks all that queries rely on: axioms 1 to 4, a depth of at most `MAX_DEPTH`, and the KD axiom
    where boxes are cut. The pieces of each primitive must tile it and lie in the boxes of their leaves; a primitive
    without pieces must be covered by the leaves that list it. `validate` checks the rest.

    Attributes
    ----------
    geometry : Lines, Spheres, Curves, Triangles, Boxes, Geometry or UserPrimitives
        The primitives that the tree is over.
    nodes : (n_nodes,) array of `NODE`
        In preorder.
    refs : (n_refs,) array of `REF`
        In the order of the leaves.
    settings : Settings
        The settings of the build.
    method : str
        The name of the settings; "custom" if they have none.
    limits_hit : mapping of str to int
        The limits that took effect, and at how many nodes. ``max_depth`` kept a node from a split, ``max_refs`` refused
        a split, or ``max_leaf_refs`` forced one.
    built_cost : float, optional
        The cost of a refitted tree before its segments moved.
    searched : mapping of str to int
        After a build with a lookahead of 2 or more: how many ``candidates`` the search had, and how many of them were
        ``carried_out``. Files do not keep it.
    frame : (2, 3) float32, optional
        The box whose centre and size define the coordinates that queries compute in; without it, the root's. Trees over
        parts of a scene that have the frame of the whole answer as one tree over all of it.

    Other Parameters
    ----------------
    made_by_core : bool
        Whether the core has just made nodes and references, which need no check. Unchecked others could crash queries.
    """

    geometry: AnyGeometry
    nodes: npt.NDArray[Any]
    refs: npt.NDArray[Any]
    settings: Settings
    method: str = "custom"
    limits_hit: Mapping[str, int] = field(default_factory=dict)
    built_cost: float | None = None
    searched: Mapping[str, int] = field(default_factory=dict)
    frame: npt.NDArray[np.float32] | None = None
    made_by_core: InitVar[bool] = False

    def __post_init__(self, made_by_core: bool) -> None:
        for name, dtype in (("nodes", NODE), ("refs", REF)):
            array = frozen(getattr(self, name))
            object.__setattr__(self, name, array)
            if not isinstance(array, np.ndarray) or array.dtype != dtype or array.ndim != 1:
                raise InputError(f"{name} are not a 1-d array of fastlines.structure.tree_data.{name[:-1].upper()}")
            if not array.flags.c_contiguous:
                raise InputError(f"{name} are not contiguous; pass np.ascontiguousarray({name})")
        for name in ("limits_hit", "searched"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        instance("settings", self.settings, Settings, "fl.Settings(…)")
        if self.built_cost is not None and not 0 <= self.built_cost < np.inf:
            raise InputError(f"built_cost={self.built_cost!r}; expected a cost, or None without a refit")
        if not made_by_core:
            found = _core.check(*self.geometry.build_data(), *self.words(), self.settings.boxes)
            if found is not None:
                raise InvalidTreeError(*found)
        box = self.box if self.n_refs else None
        object.__setattr__(self, "frame", frame_around(box, self.frame))

    def __repr__(self) -> str:
        return (
            f"<Tree {self.method}: {counted(self.n_prims, 'primitives')}, {counted(self.n_refs, 'references')}, "
            f"{counted(self.n_nodes, 'nodes')}, cost {self.cost():.6g}>"
        )

    @property
    def n_prims(self) -> int:
        """The number of primitives that references name: of curves, the pieces."""
        return len(self.geometry.build_data()[1])

    @property
    def box(self) -> npt.NDArray[np.float32]:
        """The box of the root, (2, 3): its lowest and its highest corner."""
        return np.asarray(self.nodes["box"][0])

    @property
    def n_nodes(self) -> int:
        """The number of nodes, inner nodes and leaves."""
        return len(self.nodes)

    @property
    def n_refs(self) -> int:
        """The number of references; one primitive can have many."""
        return len(self.refs)

    @computed_once
    def frame_box(self) -> npt.NDArray[np.float32]:
        """The box that defines the coordinates that queries compute in, (2, 3): `frame`, or the root's box."""
        return np.asarray(self.box if self.frame is None else self.frame)

    @property
    def is_leaf(self) -> npt.NDArray[np.bool_]:
        """Whether each node is a leaf, (n_nodes,) bool."""
        return np.asarray(self.nodes["right"] == 0)

    @property
    def left(self) -> IntArray:
        """The left child of each node, (n_nodes,) int64; -1 for a leaf."""
        return np.where(self.is_leaf, -1, np.arange(self.n_nodes) + 1)

    @property
    def right(self) -> IntArray:
        """The right child of each node, (n_nodes,) int64; -1 for a leaf."""
        return np.where(self.is_leaf, -1, self.nodes["right"].astype(np.int64))

    def levels(self) -> list[IntArray]:
        """Return the nodes of each level, the root's first.

        Returns
        -------
        list of (k,) int64
            Element d holds the indices of the nodes at depth d, rising.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "bvh-cl", cost=fl.Cost(0.1))
        >>> tree.levels()
        [array([0]), array([1, 2])]
        """
        levels = [np.zeros(1, np.int64)]
        while len(inner := levels[-1][self.nodes["right"][levels[-1]] > 0]):
            levels.append(np.sort(np.concatenate(self._children(inner))))
        return levels

    def _children(self, inner: IntArray) -> tuple[IntArray, IntArray]:
        return inner + 1, self.nodes["right"][inner].astype(np.int64)

    @computed_once
    def _levels(self) -> list[IntArray]:
        return self.levels()

    @computed_once
    def areas(self) -> npt.NDArray[np.float64]:
        """The surface area of each node's box, (n_nodes,) float64."""
        box = self.nodes["box"].astype(np.float64)
        x, y, z = (box[:, 1] - box[:, 0]).T
        return np.asarray(2 * (x * y + x * z + y * z))

    def cost(self, *, by: Literal["f", "g"] = "f", model: Cost | None = None) -> float:
        """Compute the cost of the tree (thesis §3.3), in float64.

        Parameters
        ----------
        by : {"f", "g"}
            By recursion from the leaves (f), or as a sum over all nodes (g); Theorem 1 says that they are equal.
        model : Cost, optional
            c_trav and c_prim; by default those of the build.

        Notes
        -----
        f(leaf) = n·c_prim and f(inner) = c_trav + Σ SA(child)/SA(node)·f(child). g = Σ over inner nodes of
        SA(node)/SA(root)·c_trav + Σ over leaves of SA(leaf)/SA(root)·n·c_prim. Where an area to divide by is zero, no
        line measures the node, and its children count as visited whenever it is.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
        >>> tree.cost(), tree.cost(by="g", model=fl.Cost(c_prim=3))
        (1.0, 3.0)
        """
        choice("by", by, ("f", "g"))
        model = self.settings.cost if model is None else model
        instance("model", model, Cost, COST)
        if by == "g":
            area, at_leaf = self.areas, self.nodes["n_refs"] * model.c_prim
            chance = area / area[0] if area[0] > 0 else np.ones_like(area)
            return float((chance * np.where(self.is_leaf, at_leaf, model.c_trav)).sum())
        return float(self._node_costs(model)[0])

    def _node_costs(self, model: Cost) -> npt.NDArray[np.float64]:
        """Return f of each node, (n_nodes,) float64."""
        area, leaf = self.areas, self.is_leaf
        f = np.asarray(self.nodes["n_refs"] * model.c_prim, np.float64)
        for level in reversed(self._levels):
            inner = level[~leaf[level]]
            f[inner] = model.c_trav
            for child in self._children(inner):
                chance = np.divide(area[child], area[inner], out=np.ones(len(inner)), where=area[inner] > 0)
                f[inner] += chance * f[child]
        return f

    def to_dot(self, *, max_level: int | None = MAX_LEVEL) -> str:
        r"""Return the tree in DOT, the language of Graphviz; ``dot -Tsvg tree.dot -o tree.svg`` draws it.

        Nodes have their number, the number of references, the cost below them and the area of their box. Leaves are
        ellipses. Where levels are left out, frames are dashed.

        Parameters
        ----------
        max_level : int, optional
            The last level to draw; the caption says how many nodes are left out. None draws all.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[7, 7, 7], [8, 8, 8]]], "bvh-cl", cost=fl.Cost(0.1))
        >>> print(tree.to_dot().splitlines()[4])
          n1 [label="1: 1 reference\ncost 1, area 6", shape=ellipse]
        """
        costs, areas = self._node_costs(self.settings.cost), self.areas
        last = math.inf if max_level is None else count("max_level", max_level, 0)
        drawn = dot_nodes(self.nodes["right"], self.nodes["n_refs"], costs, areas, last)
        return dot_text(f"{self.method}, a tree of {counted(self.n_prims, 'primitives')}", drawn)

    @computed_once
    def growth(self) -> float:
        """The factor by which the cost has grown since the tree was built; 1 unless it was refitted.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "bvh-cl", cost=fl.Cost(0.1))
        >>> tree.growth, tree.refit([[[0, 0, 0], [9, 9, 9]], [[0, 9, 0], [9, 0, 9]]]).growth > 10
        (1.0, True)
        """
        if not self.built_cost:
            return 1.0
        model = self.settings.cost
        return _core.cost(self.words()[0], model.c_trav, model.c_prim) / self.built_cost

    def stats(self) -> dict[str, Any]:
        """Return counts, sizes and cost, ready for JSON.

        Examples
        --------
        >>> import fastlines as fl
        >>> stats = fl.build([[[-1, -1, -1], [1, 1, 1]]]).stats()
        >>> stats["n_refs"], stats["depth"], stats["memory_bytes"]
        (1, 0, 48)
        """
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
            "growth": self.growth,
            "memory_bytes": self.nodes.nbytes + self.refs.nbytes,
            "limits_hit": dict(self.limits_hit),
        }

    def validate(self) -> None:
        """Check the axioms 1 to 5 of thesis §3.2, the BVH or KD axiom, and Theorem 4.

        A tree that was presplit, reinserted or refitted is checked as a tree over pieces of lines.

        Raises
        ------
        InvalidTreeError
            If a node breaks an axiom; the error has both.
        """
        changed = self.settings.presplit is not None or self.settings.reinsertion > 0
        over_pieces = changed or self.built_cost is not None
        found = _core.validate(*self.geometry.build_data(), *self.words(), self.settings.boxes, over_pieces)
        if found is not None:
            raise InvalidTreeError(*found)

    @computed_once
    def planes(self) -> Planes:
        """A KD tree in the form that ``kernel="binary"`` searches; made on the first such query, and kept."""
        corners, frame = (tuple(box.reshape(-1).tolist()) for box in (self.box, self.frame_box))
        nodes, prims, depth = _core.planes(*self.words(), frame)
        return Planes(own(nodes), own(prims), depth, corners, frame)

    def words(self) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint32]]:
        """Return nodes and references as rows of 32-bit words, the form of the core and of files; no copy."""
        return self.nodes.view(np.uint32).reshape(-1, 9), self.refs.view(np.uint32).reshape(-1, 3)
