"""The thesis's chapters 3 and 4 as short, slow Python: what a tree is, what it costs, how to build it.

The core does the same a thousand times faster and is tested against this text node for node. So what the core stores
as float32 is rounded to float32 here too (`f32`). Its budgets, `max_refs` and `max_leaf_refs`, are its own affair.

======================  =====================================================================================
thesis                  here
======================  =====================================================================================
§3.1 primitive          `Primitive`: anything with an id, `bounds` and `clip`; `Segment`, `Block`, or your own
§3.1 box, SA, AABB      `Box`, `Box.area`, `hull`
§3.2 acceleration tree  `Node`; axioms 1 to 5, BVH and KD axiom, and Theorem 4: `check`
§3.3 cost f₀ and g      `f`, `g`; Theorem 1: f = g; Theorem 3: neither reads the primitives of an inner node
§4.1 the algorithm      `best_split` and `build`; lookahead 1 is SAH (§1.5); where it ends: §1.4.2
§4.1 SPLITS             a generator over (prims, box): `object_sweep`, `plane_grid`, `plane_events`, `median`,
                        `middle`, a `union` of them, or your own; with box rule `tight` (BVH) or `cut` (KD)
======================  =====================================================================================

The diagonals of a cube in a KD tree, whose planes cut boxes in the middle. SAH sees no gain and makes a leaf:

>>> from functools import partial
>>> ends = [[[0, 0, 0], [8, 8, 8]], [[0, 8, 0], [8, 0, 8]], [[0, 0, 8], [8, 8, 0]], [[8, 0, 0], [0, 8, 8]]]
>>> for lookahead in 1, 2:
...     tree = build(segments(ends), partial(middle, rule=cut), lookahead, c_trav=0.2)
...     check(tree, segments(ends), cut)
...     print(len(tree.nodes()), round(f(tree, c_trav=0.2), 6), round(g(tree, c_trav=0.2), 6))
1 4.0 4.0
15 2.8 2.8
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from .errors import InvalidTreeError

# ---- §3.1 Boxes and primitives ----

Point: TypeAlias = tuple[float, ...]


def f32(x: float) -> float:
    """Round to what a float32 can hold."""
    return float(np.float32(x))


def put(point: Point, axis: int, x: float) -> Point:
    """Replace one coordinate."""
    return (*point[:axis], x, *point[axis + 1 :])


class Box(NamedTuple):
    """All points from one corner to another."""

    lo: Point
    hi: Point

    def sides(self) -> Point:
        """Give the lengths of its sides."""
        return tuple(hi - lo for lo, hi in zip(self.lo, self.hi, strict=True))

    def area(self) -> float:
        """Give the area of its surface, SA(q)."""
        x, y, z = self.sides()
        return 2 * (x * y + x * z + y * z)

    def centre(self, axis: int) -> float:
        """Give the middle of one side."""
        return (self.lo[axis] + self.hi[axis]) / 2

    def split(self, axis: int, plane: float) -> tuple[Box, Box]:
        """Cut it in two."""
        return Box(self.lo, put(self.hi, axis, plane)), Box(put(self.lo, axis, plane), self.hi)


class Primitive(Protocol):
    """What a primitive answers, and the part of a primitive that a node holds."""

    @property
    def id(self) -> int:
        """Say which primitive this is or is a part of."""

    def bounds(self) -> Box:
        """Give the least box that holds it, AABB(p)."""

    def clip(self, box: Box) -> Primitive | None:
        """Give the part of it that lies in a box, if there is one; the part is a primitive again."""


def hull(prims: Sequence[Primitive]) -> Box:
    """Give the least box that holds some primitives, AABB(∪p)."""
    los, his = zip(*(prim.bounds() for prim in prims), strict=True)
    return Box(tuple(map(min, zip(*los, strict=True))), tuple(map(max, zip(*his, strict=True))))


class Segment(NamedTuple):
    """The piece of a line p + s·(q − p) with s from s0 to s1, which goes from `start` to `end`.

    A cut is reckoned from p and q, so that pieces of pieces do not drift; the last piece has s1 = ∞.
    """

    id: int
    p: Point
    q: Point
    start: Point
    end: Point
    s0: float = 0.0
    s1: float = math.inf

    def bounds(self) -> Box:
        """Bound both ends."""
        return Box(tuple(map(min, self.start, self.end)), tuple(map(max, self.start, self.end)))

    def clip(self, box: Box) -> Segment | None:
        """Cut off what lies beyond each side of a box."""
        part = self
        for axis in range(3):
            lo, hi = sorted((part.start[axis], part.end[axis]))
            if hi < box.lo[axis] or lo > box.hi[axis]:
                return None
            if lo < box.lo[axis]:
                _, part = part.cut(axis, box.lo[axis])
            if hi > box.hi[axis]:
                part, _ = part.cut(axis, box.hi[axis])
        return part

    def cut(self, axis: int, plane: float) -> tuple[Segment, Segment]:
        """Cut it at a plane into what lies below and above."""
        p, q = self.p, self.q
        s = f32((plane - p[axis]) * (1 / (q[axis] - p[axis])))
        s = sorted((self.s0, s, min(self.s1, 1.0)))[1]  # the one in the middle
        at = q if s == 1 else tuple(f32(a + s * (b - a)) for a, b in zip(p, q, strict=True))
        at = tuple(sorted(three)[1] for three in zip(self.start, put(at, axis, plane), self.end, strict=True))
        first, second = self._replace(end=at, s1=s), self._replace(start=at, s0=s)
        return (first, second) if p[axis] <= q[axis] else (second, first)


def segments(ends: npt.ArrayLike) -> list[Segment]:
    """Make primitives of an (n, 2, 3) array."""
    rows = np.asarray(ends, np.float32).reshape(-1, 2, 3).tolist()
    return [Segment(i, tuple(p), tuple(q), tuple(p), tuple(q)) for i, (p, q) in enumerate(rows)]


class Block(NamedTuple):
    """A primitive that fills its box: the least that it takes to put something else into a tree."""

    id: int
    box: Box

    def bounds(self) -> Box:
        """Give the box."""
        return self.box

    def clip(self, box: Box) -> Block | None:
        """Intersect two boxes."""
        both = Box(tuple(map(max, self.box.lo, box.lo)), tuple(map(min, self.box.hi, box.hi)))
        return Block(self.id, both) if min(both.sides()) >= 0 else None


# ---- §3.2, 3.3 Trees and their cost ----


@dataclass(eq=False)
class Node:
    """The parts of primitives that lie in a box (the thesis's ∪p ∩ q), and none or two children."""

    prims: Prims
    box: Box
    left: Node | None = None
    right: Node | None = None

    def nodes(self) -> list[Node]:
        """List this node and all below it, in preorder."""
        return [self, *(node for child in (self.left, self.right) if child for node in child.nodes())]


def chance(child: Box, parent: Box) -> float:
    """Tell how likely a line through one box meets the other; 1 where no line measures the outer one."""
    return child.area() / parent.area() if parent.area() > 0 else 1.0


def f(node: Node, c_trav: float = 2.0, c_prim: float = 1.0) -> float:
    """Give the cost of a tree by recursion."""
    if not (node.left and node.right):
        return len(node.prims) * c_prim
    left = chance(node.left.box, node.box) * f(node.left, c_trav, c_prim)
    right = chance(node.right.box, node.box) * f(node.right, c_trav, c_prim)
    return c_trav + left + right


def g(tree: Node, c_trav: float = 2.0, c_prim: float = 1.0) -> float:
    """Give the cost of a tree as a sum over its nodes."""
    return sum(chance(n.box, tree.box) * (c_trav if n.left else len(n.prims) * c_prim) for n in tree.nodes())


def covered(part: Primitive | None, boxes: Sequence[Box], slack: float) -> bool:
    """Tell whether some boxes hold a part between them: what lies beyond the first must lie in the others."""
    if part is None or not boxes:
        return part is None
    (lo, hi), space = boxes[0], Box((-math.inf,) * 3, (math.inf,) * 3)
    beyond = [space.split(k, lo[k] - slack)[0] for k in range(3)] + [space.split(k, hi[k] + slack)[1] for k in range(3)]
    return all(covered(part.clip(half), boxes[1:], slack) for half in beyond)


def laws(node: Node, tree: Node, prims: Prims, rule: BoxRule | None) -> Iterator[tuple[str, str, bool]]:
    """Go through what must hold at a node of a tree over `prims`: axiom, text, and whether it does."""
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
        With the place of the node in preorder, and the axiom. Sets of points are compared up to rounding.
    """
    for number, node in reversed([*enumerate(tree.nodes())]):
        for axiom, text, holds in laws(node, tree, prims, rule):
            if not holds:
                raise InvalidTreeError(number, axiom, f"not true that {text}")


# ---- §4.1 SPLITS: functions that show the candidate splits of a node, one after the other ----

Prims: TypeAlias = Sequence[Primitive]
Split: TypeAlias = tuple[tuple[Prims, Box], tuple[Prims, Box]]
Splits: TypeAlias = Callable[[Prims, Box], Iterable[Split]]
BoxRule: TypeAlias = Callable[[Prims, Box], "Box | None"]
Best: TypeAlias = tuple[float, "Split | None"]


def tight(prims: Prims, half: Box) -> Box | None:
    """Box rule of a BVH: tight around the child's primitives; without any it is no child."""
    return hull(prims) if prims else None


def cut(prims: Prims, half: Box) -> Box | None:
    """Box rule of a KD tree: half of the parent's box, be it empty space."""
    return half


def at_plane(prims: Prims, box: Box, axis: int, plane: float, rule: BoxRule) -> Iterator[Split]:
    """Split at a plane inside the box: it cuts the primitives that straddle it; one that lies in it goes left."""
    if not box.lo[axis] < plane < box.hi[axis]:
        return
    low, high = box.split(axis, plane)
    left, right = list[Primitive](), list[Primitive]()
    for prim in prims:
        bounds = prim.bounds()
        if bounds.hi[axis] <= plane:
            left.append(prim)
        elif bounds.lo[axis] >= plane:
            right.append(prim)
        else:
            left += filter(None, [prim.clip(low)])
            right += filter(None, [prim.clip(high)])
    left_box, right_box = rule(left, low), rule(right, high)
    if left_box and right_box:
        yield (left, left_box), (right, right_box)


def at_object(ordered: Prims, n_left: int) -> Split:
    """Split a list of primitives, none of which is cut."""
    left, right = ordered[:n_left], ordered[n_left:]
    return (left, hull(left)), (right, hull(right))


def by_centre(prims: Prims, axis: int) -> Prims:
    """Sort by the centres of boxes, and equal ones by id."""
    return sorted(prims, key=lambda prim: (prim.bounds().centre(axis), prim.id))


def object_sweep(prims: Prims, box: Box) -> Iterator[Split]:
    """All cuts of the list of primitives sorted by centre, on each axis (§1.5). A BVH's."""
    for axis in range(3):
        ordered = by_centre(prims, axis)
        for n_left in range(1, len(ordered)):
            yield at_object(ordered, n_left)


def plane_grid(prims: Prims, box: Box, n_planes: int = 16, rule: BoxRule = tight) -> Iterator[Split]:
    """So many planes on each axis, evenly over the box (§4.3)."""
    for axis, side in enumerate(box.sides()):
        for i in range(1, n_planes + 1):
            yield from at_plane(prims, box, axis, f32(box.lo[axis] + side * i / (n_planes + 1)), rule)


def plane_events(prims: Prims, box: Box, rule: BoxRule = cut) -> Iterator[Split]:
    """Planes at the sides of the primitives' boxes (§1.5); the outermost cut off empty space."""
    for axis in range(3):
        for plane in sorted({corner[axis] for prim in prims for corner in prim.bounds()}):
            yield from at_plane(prims, box, axis, plane, rule)


def median(prims: Prims, box: Box, rule: BoxRule = tight) -> Iterator[Split]:
    """One split at the median primitive, on the axis where both areas add up to least (§1.4.1)."""
    found: list[Split] = []
    for axis in range(3):
        ordered, half = by_centre(prims, axis), len(prims) // 2
        if rule is tight and half > 0:
            found.append(at_object(ordered, half))
        if rule is cut and prims:
            found += at_plane(prims, box, axis, f32(ordered[half].bounds().centre(axis)), rule)
    yield from sorted(found, key=lambda split: split[0][1].area() + split[1][1].area())[:1]


def middle(prims: Prims, box: Box, rule: BoxRule = tight) -> Iterator[Split]:
    """One plane, in the middle of the longest side (§1.4.1)."""
    axis = box.sides().index(max(box.sides()))
    yield from at_plane(prims, box, axis, f32(box.centre(axis)), rule)


def union(*sets: Splits) -> Splits:
    """Try several sets of splits in turn."""
    return lambda prims, box: (split for splits in sets for split in splits(prims, box))


def best_split(prims: Prims, box: Box, splits: Splits, lookahead: int, c_trav: float, c_prim: float) -> Best:
    """Find the cheapest tree of so many levels (§4.1): its cost and its first split, None for a leaf."""
    best_cost, best = len(prims) * c_prim, None
    if lookahead == 0:
        return best_cost, best
    for split in splits(prims, box):
        (_, lb), (_, rb) = split
        left, right = (best_split(*part, splits, lookahead - 1, c_trav, c_prim)[0] for part in split)
        area = box.area()
        cost = c_trav + ((lb.area() * left + rb.area() * right) / area if area > 0 else left + right)
        if cost < best_cost:
            best_cost, best = cost, split
    return best_cost, best


def build(
    prims: Prims,
    splits: Splits,
    lookahead: int | Sequence[int] = 1,
    c_trav: float = 2.0,
    c_prim: float = 1.0,
    *,
    max_depth: int = 64,
    leaf_refs: int = 1,
    leaf_size: float = 0.0,
) -> Node:
    """Build a tree over one primitive or more (§4.1).

    Parameters
    ----------
    prims : sequence of Primitive
        P.
    splits : function of (prims, box)
        SPLITS: gives ((left prims, left box), (right prims, right box)) for each candidate.
    lookahead : int or sequence of int
        How many levels to search; of several, each is tried where the one before says leaf.
    c_trav, c_prim : float
        What a step to a node and a test of a primitive cost.
    max_depth, leaf_refs, leaf_size
        A node so deep, of so few primitives, or of sides so short is a leaf.
    """
    turns = [lookahead] if isinstance(lookahead, int) else lookahead

    def build_node(prims: Prims, box: Box, depth: int) -> Node:
        if depth < max_depth and len(prims) > leaf_refs and max(box.sides()) > leaf_size:
            for levels in turns:
                _, split = best_split(prims, box, splits, levels, c_trav, c_prim)
                if split:
                    return Node(prims, box, *(build_node(*part, depth + 1) for part in split))
        return Node(prims, box)

    return build_node(prims, hull(prims), 0)
