"""Trees and their cost (thesis §3.2, 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

from .box import Box
from .primitive import Prims


@dataclass(eq=False, repr=False)
class Node:
    """The parts of primitives that lie in a box (the thesis's ∪p ∩ q), and none or two children."""

    prims: Prims
    box: Box
    left: Node | None = None
    right: Node | None = None

    def __repr__(self) -> str:
        nodes = self.nodes()
        return f"<Node: {len(self.prims)} primitives, {len(nodes)} nodes at and below it>"

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
