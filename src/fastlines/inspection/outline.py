"""A tree as arrays, a row for each node: what pictures and the viewer read of real trees and of the theory's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, instance
from ..errors import InputError
from ..geometry.hit_places import Float64Array
from ..settings.settings import COST, Cost
from ..structure.tree_data import TreeData
from ..support.computed_once import computed_once
from ..support.ranges import ranges
from ..support.texts import counted
from ..theory.node import Node
from ..theory.primitive import Box


@dataclass(frozen=True, eq=False, repr=False)
class Outline:
    """The nodes of a tree in preorder, and the primitives of its leaves.

    Attributes
    ----------
    name : str
        The name of the method; "theory" for a tree of `fastlines.theory`.
    boxes : (n, 2, 3) float64
        The lowest and the highest corner of each node's box, without the offset of the lines.
    right : (n,) int64
        The right child of each node; 0 for a leaf. The left child is the next node.
    first_ref, n_refs : (n,) int64
        The range of the references at or below each node.
    prims : (n_refs,) int64
        The primitive of each reference, in the order of the leaves.
    spans : (n_refs, 2) float64
        The part of its primitive that each reference covers, from s0 to s1 < 1, or to inf in the last piece.
    model : Cost
        The costs of a step and of a test.
    """

    name: str
    boxes: Float64Array
    right: IntArray
    first_ref: IntArray
    n_refs: IntArray
    prims: IntArray
    spans: Float64Array
    model: Cost

    def __repr__(self) -> str:
        return f"<Outline of {self.name}: {counted(self.n_nodes, 'nodes')}, {counted(len(self.prims), 'references')}>"

    @property
    def n_nodes(self) -> int:
        """The number of nodes, inner nodes and leaves."""
        return len(self.right)

    @computed_once
    def is_leaf(self) -> npt.NDArray[np.bool_]:
        """Whether each node is a leaf, (n,) bool."""
        return np.asarray(self.right == 0)

    @computed_once
    def parent(self) -> IntArray:
        """The parent of each node, (n,) int64; -1 for the root."""
        parent = np.full(self.n_nodes, -1)
        inner = np.flatnonzero(~self.is_leaf)
        parent[inner + 1] = parent[self.right[inner]] = inner
        return parent

    @computed_once
    def level(self) -> IntArray:
        """The level of each node, (n,) int64; 0 for the root."""
        level = np.zeros(self.n_nodes, np.int64)
        for depth, nodes in enumerate(self.levels):
            level[nodes] = depth
        return level

    @computed_once
    def levels(self) -> list[IntArray]:
        """The nodes of each level, rising, the root's first."""
        levels = [np.zeros(1, np.int64)]
        while len(inner := levels[-1][~self.is_leaf[levels[-1]]]):
            levels.append(np.sort(np.concatenate([inner + 1, self.right[inner]])))
        return levels

    @computed_once
    def chance(self) -> Float64Array:
        """The probability that a line through the root's box hits each box, (n,): SA(node)/SA(root)."""
        x, y, z = (self.boxes[:, 1] - self.boxes[:, 0]).T
        area = x * y + x * z + y * z
        return np.asarray(area / area[0] if area[0] > 0 else np.ones(self.n_nodes))

    @computed_once
    def own_cost(self) -> Float64Array:
        """What each node itself adds to the cost of the tree, (n,): a term of the sum g (thesis §3.3)."""
        return np.asarray(self.chance * np.where(self.is_leaf, self.n_refs * self.model.c_prim, self.model.c_trav))

    @computed_once
    def cost_below(self) -> Float64Array:
        """What each node and all nodes below it add to the cost of the tree, (n,); g at the root."""
        # In preorder, the nodes at or below a node are a range.
        sums = np.concatenate([[0.0], np.cumsum(self.own_cost)])
        return np.asarray(sums[self.end] - sums[:-1])

    @computed_once
    def end(self) -> IntArray:
        """The node after the last one at or below each node, (n,) int64."""
        end = np.arange(1, self.n_nodes + 1)
        for nodes in reversed(self.levels):
            inner = nodes[~self.is_leaf[nodes]]
            end[inner] = end[self.right[inner]]
        return end

    @computed_once
    def split_axis(self) -> npt.NDArray[np.int8]:
        """The axis of the plane that separates the boxes of each node's children, (n,) int8; -1 if none does.

        A KD tree has such a plane at each inner node, and a BVH wherever the boxes of siblings do not overlap. Of
        several axes, it is the one along which the boxes are farthest apart.
        """
        return self._splits[0]

    @computed_once
    def split_plane(self) -> Float64Array:
        """The coordinate of that plane, (n,); NaN if there is none. Between boxes with a gap, it is in the middle."""
        return self._splits[1]

    @computed_once
    def _splits(self) -> tuple[npt.NDArray[np.int8], Float64Array]:
        axes, planes = np.full(self.n_nodes, -1, np.int8), np.full(self.n_nodes, np.nan)
        inner = np.flatnonzero(~self.is_leaf)
        if not len(inner):
            return axes, planes
        left, right = self.boxes[inner + 1], self.boxes[self.right[inner]]
        # The gap is negative where boxes overlap; a box without extent along an axis does not separate anything.
        first_is_lower = left[:, 0] + left[:, 1] <= right[:, 0] + right[:, 1]
        low = np.where(first_is_lower, left[:, 1], right[:, 1])
        high = np.where(first_is_lower, right[:, 0], left[:, 0])
        parent = self.boxes[inner]
        gap = np.where(parent[:, 1] > parent[:, 0], high - low, -np.inf)
        axis = gap.argmax(axis=1)
        rows = np.arange(len(inner))
        apart = gap[rows, axis] >= 0
        axes[inner[apart]] = axis[apart]
        planes[inner[apart]] = (0.5 * (low + high))[rows, axis][apart]
        return axes, planes

    @computed_once
    def is_kd(self) -> bool:
        """Whether children cut the box of each inner node in two at a plane: the KD axiom (thesis §3.2).

        A single node is a KD tree and a BVH.
        """
        inner = np.flatnonzero(~self.is_leaf)
        axis, plane = self.split_axis[inner].astype(np.int64), self.split_plane[inner]
        left, right = self.boxes[inner + 1], self.boxes[self.right[inner]]
        low, high = self.boxes[inner].copy(), self.boxes[inner].copy()
        rows = np.arange(len(inner))
        low[rows, 1, axis] = high[rows, 0, axis] = plane
        is_low = (left == low) & (right == high)
        is_high = (left == high) & (right == low)
        return bool((axis >= 0).all() and (is_low.all(axis=(1, 2)) | is_high.all(axis=(1, 2))).all())

    def path(self, node: int) -> IntArray:
        """Return the nodes from the root to a node, both included.

        Raises
        ------
        InputError
            If there is no such node.
        """
        if isinstance(node, bool) or not isinstance(node, int | np.integer) or not 0 <= node < self.n_nodes:
            raise InputError(f"node={node!r}; expected a number from 0 to {self.n_nodes - 1:,}")
        path = [int(node)]
        while path[-1] > 0:
            path.append(int(self.parent[path[-1]]))
        return np.array(path[::-1])

    def refs_of(self, node: int) -> slice:
        """Return the slice of the references at or below a node: ``outline.prims[outline.refs_of(3)]``."""
        first = int(self.first_ref[node])
        return slice(first, first + int(self.n_refs[node]))

    def refs_of_leaves(self, leaves: IntArray) -> IntArray:
        """Return the references of some leaves, one leaf after another, (n,) int64."""
        return ranges(self.first_ref[leaves], self.n_refs[leaves])

    @computed_once
    def is_whole(self) -> npt.NDArray[np.bool_]:
        """Whether each reference covers all of its primitive, (n_refs,) bool."""
        return np.asarray((self.spans[:, 0] == 0) & np.isinf(self.spans[:, 1]))


def outline_of(tree: TreeData | Node, model: Cost | None = None) -> Outline:
    """Return the nodes of a tree as arrays.

    Parameters
    ----------
    tree : Tree or theory.Node
    model : Cost, optional
        The costs of a step and of a test; by default those of the build, and for a tree of `fastlines.theory` those of
        ``fl.Cost()``.

    Raises
    ------
    InputError
        If `tree` is neither.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines import theory as th
    >>> segments = [[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]]
    >>> tree = fl.build(segments, "bvh-cl", cost=fl.Cost(0.1))
    >>> outline_of(tree).level, outline_of(tree).path(2)
    (array([0, 1, 1]), array([0, 2]))
    >>> lesson = outline_of(th.build(th.segments(segments), th.object_sweep, c_trav=0.1), fl.Cost(0.1))
    >>> bool(lesson.cost_below[0] == outline_of(tree).cost_below[0])
    True
    """
    if model is not None:
        instance("model", model, Cost, COST)
    if isinstance(tree, TreeData):
        return _of_tree(tree, tree.settings.cost if model is None else model)
    if isinstance(tree, Node):
        return _of_theory(tree, Cost() if model is None else model)
    raise InputError(f"tree is {type(tree).__name__}; expected a Tree, as fl.build makes it, or a Node of fl.theory")


def _of_tree(tree: TreeData, model: Cost) -> Outline:
    right, first_ref, n_refs = (tree.nodes[name].astype(np.int64) for name in ("right", "first_ref", "n_refs"))
    boxes, prims = tree.nodes["box"].astype(np.float64), tree.refs["prim"].astype(np.int64)
    spans = np.stack([tree.refs["s0"], tree.refs["s1"]], axis=1).astype(np.float64)
    return Outline(tree.method, boxes, right, first_ref, n_refs, prims, spans, model)


def _of_theory(tree: Node, model: Cost) -> Outline:
    boxes, right, first_ref, n_refs, prims = list[Box](), list[int](), list[int](), list[int](), list[int]()

    def add(node: Node) -> None:
        row = len(boxes)
        boxes.append(node.box)
        right.append(0)
        first_ref.append(len(prims))
        n_refs.append(0)
        if node.left and node.right:
            add(node.left)
            right[row] = len(boxes)
            add(node.right)
        else:
            prims.extend(prim.id for prim in node.prims)
        n_refs[row] = len(prims) - first_ref[row]

    add(tree)
    spans = np.tile([0.0, np.inf], (len(prims), 1))
    nodes = np.array([right, first_ref, n_refs], np.int64)
    of_refs = np.array(prims, np.int64), spans
    return Outline("theory", np.array(boxes, np.float64), nodes[0], nodes[1], nodes[2], *of_refs, model)
