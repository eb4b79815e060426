"""Trees, their axioms and their cost (thesis §3.2, 3.3), and Theorem 4."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ..arrays import count
from ..errors import InvalidTreeError
from ..support.graphviz import MAX_LEVEL, DotNode, dot_text
from ..support.texts import counted, number_text
from .drawing import levels_svg
from .primitive import Block, Box, Primitive, Prims, hull
from .splits import BoxRule, cut, tight


@dataclass(eq=False, repr=False)
class Node:
    """The parts of primitives that lie in a box (the thesis's ∪p ∩ q), and none or two children."""

    prims: Prims
    box: Box
    left: Node | None = None
    right: Node | None = None

    def __repr__(self) -> str:
        n_prims, n_nodes = counted(len(self.prims), "primitives"), counted(len(self.nodes()), "nodes")
        return f"<Node: {n_prims}, {n_nodes} at and below it>"

    def nodes(self) -> list[Node]:
        """List this node and all below it, in preorder."""
        return [self, *(node for child in self.children() for node in child.nodes())]

    def children(self) -> list[Node]:
        """List the left and the right child, if there are any."""
        return [child for child in (self.left, self.right) if child]

    def levels(self) -> list[list[Node]]:
        """List the nodes of each level at and below this one, from the left to the right."""
        levels = [[self]]
        while below := [child for node in levels[-1] for child in node.children()]:
            levels.append(below)
        return levels

    def to_dot(self, *, max_level: int | None = MAX_LEVEL, c_trav: float = 2.0, c_prim: float = 1.0) -> str:
        r"""Return this tree in DOT, the language of Graphviz.

        Parameters
        ----------
        max_level : int, optional
            The last level to draw; the caption says how many nodes are left out. None draws all.
        c_trav, c_prim : float
            Those of the costs, which are `f` of each node.

        Examples
        --------
        >>> from fastlines import theory as th
        >>> tree = th.build(th.segments([[[0, 0, 0], [1, 1, 1]], [[7, 7, 7], [8, 8, 8]]]), th.object_sweep, c_trav=0.1)
        >>> print(tree.to_dot(c_trav=0.1))
        digraph tree {
          graph [label="a tree of 2 primitives: 3 nodes"]
          node [shape=box]
          n0 [label="0: 2 primitives\ncost 0.1313, area 384"]
          n1 [label="1: 1 primitive\ncost 1, area 6", shape=ellipse]
          n2 [label="2: 1 primitive\ncost 1, area 6", shape=ellipse]
          n0 -> n1
          n0 -> n2
        }
        <BLANKLINE>
        """
        last = math.inf if max_level is None else count("max_level", max_level, 0)

        def drawn(node: Node, number: int, parent: int | None, level: int) -> Iterator[DotNode]:
            cost, n_prims = number_text(f(node, c_trav, c_prim)), counted(len(node.prims), "primitives")
            label = n_prims, f"cost {cost}, area {number_text(node.box.area())}"
            n_left_out = len(node.nodes()) - 1 if level == last else 0
            yield DotNode(number, parent, label, not node.children(), n_left_out)
            at = number + 1
            for child in node.children() if level < last else []:
                yield from drawn(child, at, number, level + 1)
                at += len(child.nodes())

        return dot_text(f"a tree of {counted(len(self.prims), 'primitives')}", [*drawn(self, 0, None, 0)])

    def _repr_svg_(self) -> str | None:
        levels = [[(node.box, not node.children()) for node in level] for level in self.levels()]
        return levels_svg(repr(self), self.prims, levels)


def chance(child: Box, parent: Box) -> float:
    """Return the probability that a line through the parent hits the child; 1 where no line measures the parent."""
    return child.area() / parent.area() if parent.area() > 0 else 1.0


def f(node: Node, c_trav: float = 2.0, c_prim: float = 1.0) -> float:
    """Return the cost of a tree by recursion."""
    if not (node.left and node.right):
        return len(node.prims) * c_prim
    left = chance(node.left.box, node.box) * f(node.left, c_trav, c_prim)
    right = chance(node.right.box, node.box) * f(node.right, c_trav, c_prim)
    return c_trav + left + right


def g(tree: Node, c_trav: float = 2.0, c_prim: float = 1.0) -> float:
    """Return the cost of a tree as a sum over its nodes."""
    return sum(chance(n.box, tree.box) * (c_trav if n.left else len(n.prims) * c_prim) for n in tree.nodes())


def covered(part: Primitive | None, boxes: Sequence[Box], slack: float) -> bool:
    """Return whether the union of some boxes holds a part: the others must hold the rest outside the first."""
    if part is None or not boxes:
        return part is None
    (lo, hi), space = boxes[0], Box((-math.inf,) * 3, (math.inf,) * 3)
    beyond = [space.split(k, lo[k] - slack)[0] for k in range(3)] + [space.split(k, hi[k] + slack)[1] for k in range(3)]
    return all(covered(part.clip(half), boxes[1:], slack) for half in beyond)


def laws(node: Node, tree: Node, prims: Prims, rule: BoxRule | None) -> Iterator[tuple[str, str, bool]]:
    """Yield every law of a node of a tree over `prims`: axiom, text, and whether it holds."""
    children = node.children()
    yield "axiom 1", "a node has none or two children", len(children) != 1
    yield "axiom 1", "a node has one parent", tree.nodes().count(node) == 1
    ids = [prim.id for prim in node.prims]
    yield "axiom 2", "p ⊆ P", {*ids} <= {prim.id for prim in prims} and len({*ids}) == len(ids)
    yield "axiom 2", "q is a box", all(0 <= side < math.inf for side in node.box.sides())
    if node is tree:
        yield "axiom 3", "the root is (P, AABB(∪P))", len(ids) == len(prims) and node.box == hull(prims)
    parts = [part for prim in node.prims if (part := prim.clip(node.box))]  # ∪p ∩ q
    if rule is tight:
        yield "BVH axiom", "q = AABB(∪p ∩ q)", bool(parts) and node.box == hull(parts)
    if not children:
        yield "Theorem 4", "a leaf's primitives intersect its box", len(parts) == len(ids) or node.box.area() == 0
        return
    boxes = [child.box for child in children]
    yield "axiom 4", "q₁ ∪ q₂ ⊆ q", hull([Block(0, box) for box in (node.box, *boxes)]) == node.box
    if rule is cut:
        in_two = any(boxes == [*node.box.split(axis, boxes[0].hi[axis])] for axis in range(3))
        yield "KD axiom", "q₁ ∪ q₂ = q and dim(q₁ ∩ q₂) ≤ 2", in_two
    below = [part for child in children for prim in child.prims if (part := prim.clip(child.box))]
    slack = 2**-21 * max(abs(x) for corner in tree.box for x in corner)
    for some, others in ((parts, below), (below, parts)):
        for part in some:
            held = [other.bounds() for other in others if other.id == part.id]
            yield "axiom 5", "(∪p₁ ∩ q₁) ∪ (∪p₂ ∩ q₂) = ∪p ∩ q", covered(part, held, slack)


def check(tree: Node, prims: Prims, rule: BoxRule | None = None) -> None:
    """Check the axioms of a tree over `prims`, of a BVH (rule `tight`) or a KD tree (`cut`), and Theorem 4.

    Raises
    ------
    InvalidTreeError
        With the number of the node in preorder, and the axiom. Sets of points are compared up to rounding.
    """
    for number, node in reversed([*enumerate(tree.nodes())]):
        for axiom, text, holds in laws(node, tree, prims, rule):
            if not holds:
                raise InvalidTreeError(number, axiom, f"not true that {text}")
