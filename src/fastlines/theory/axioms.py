"""The axioms of a tree (thesis §3.2), and Theorem 4."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from ..errors import InvalidTreeError
from .box import Box
from .node import Node
from .primitive import Block, Primitive, Prims, hull
from .splits import BoxRule, cut, tight


def covered(part: Primitive | None, boxes: Sequence[Box], slack: float) -> bool:
    """Return whether the union of some boxes holds a part: the others hold what lies beyond the first."""
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
        yield "Theorem 4", "a leaf's primitives meet its box", len(parts) == len(ids) or node.box.area() == 0
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
