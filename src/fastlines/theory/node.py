"""Trees, their axioms and their cost (thesis §3.2, 3.3), and Theorem 4."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ..errors import InvalidTreeError
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
        return f"<Node: {len(self.prims)} primitives, {len(self.nodes())} nodes at and below it>"

    def nodes(self) -> list[Node]:
        """List this node and all below it, in preorder."""
        return [self, *(node for child in (self.left, self.right) if child for node in child.nodes())]


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
    children = [child for child in (node.left, node.right) if child]
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
