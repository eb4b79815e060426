"""SPLITS (thesis §4.1): functions that yield the candidate splits of a node."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple, TypeAlias

from ..support.texts import counted, number_text
from .primitive import Box, Primitive, Prims, f32, hull

#: The primitives and the box of a child.
Child: TypeAlias = tuple[Prims, Box]
Splits: TypeAlias = Callable[[Prims, Box], Iterable[tuple[Child, Child]]]
BoxRule: TypeAlias = Callable[[Prims, Box], "Box | None"]


class Split(NamedTuple):
    """A candidate split: the primitives and the box of each child. A plain tuple of both will do, too."""

    left: Child
    right: Child

    def __repr__(self) -> str:
        (left, left_box), (right, right_box) = self
        areas = f"{number_text(left_box.area())} and {number_text(right_box.area())}"
        return f"<Split: {len(left)} and {counted(len(right), 'primitives')}, in boxes of area {areas}>"


def tight(prims: Prims, half: Box) -> Box | None:
    """Return the box of a child in a BVH: tight around its primitives, or None without any."""
    return hull(prims) if prims else None


def cut(prims: Prims, half: Box) -> Box | None:
    """Return the box of a child in a KD tree: half of the parent's box, even if it is empty space."""
    return half


def divide(prims: Prims, box: Box, axis: int, plane: float) -> tuple[Prims, Prims]:
    """Cut the primitives that straddle a plane inside the box; one in the plane goes left."""
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
    return left, right


def at_plane(prims: Prims, box: Box, axis: int, plane: float, rule: BoxRule) -> Iterator[Split]:
    """Yield the split at a plane inside the box, if each half makes a child."""
    if not box.lo[axis] < plane < box.hi[axis]:
        return
    left, right = divide(prims, box, axis, plane)
    low, high = box.split(axis, plane)
    left_box, right_box = rule(left, low), rule(right, high)
    if left_box and right_box:
        yield Split((left, left_box), (right, right_box))


def at_object(ordered: Prims, n_left: int) -> Split:
    """Split a list of primitives without cutting any."""
    left, right = ordered[:n_left], ordered[n_left:]
    return Split((left, hull(left)), (right, hull(right)))


def by_centre(prims: Prims, axis: int) -> Prims:
    """Sort by the centres of boxes, and equal ones by id."""
    return sorted(prims, key=lambda prim: (prim.bounds().centre(axis), prim.id))


def object_sweep(prims: Prims, box: Box) -> Iterator[Split]:
    """Yield all divisions of the primitives sorted by centre, on each axis (§1.5); for BVHs."""
    for axis in range(3):
        ordered = by_centre(prims, axis)
        for n_left in range(1, len(ordered)):
            yield at_object(ordered, n_left)


def plane_grid(prims: Prims, box: Box, n_planes: int = 16, rule: BoxRule = tight) -> Iterator[Split]:
    """Yield the splits at `n_planes` planes on each axis, evenly over the box (§4.3)."""
    for axis, side in enumerate(box.sides()):
        for i in range(1, n_planes + 1):
            yield from at_plane(prims, box, axis, f32(box.lo[axis] + side * i / (n_planes + 1)), rule)


def plane_events(prims: Prims, box: Box, rule: BoxRule = cut) -> Iterator[Split]:
    """Yield the splits at the sides of the primitives' boxes (§1.5); the outermost cut off empty space."""
    for axis in range(3):
        for plane in sorted({corner[axis] for prim in prims for corner in prim.bounds()}):
            yield from at_plane(prims, box, axis, plane, rule)


def median(prims: Prims, box: Box, rule: BoxRule = tight) -> Iterator[Split]:
    """Yield one split at the median primitive, on the axis with the least sum of both areas (§1.4.1)."""
    found: list[Split] = []
    for axis in range(3):
        ordered, half = by_centre(prims, axis), len(prims) // 2
        if rule is tight and half > 0:
            found.append(at_object(ordered, half))
        if rule is cut and prims:
            found += at_plane(prims, box, axis, f32(ordered[half].bounds().centre(axis)), rule)
    yield from sorted(found, key=lambda split: split[0][1].area() + split[1][1].area())[:1]


def middle(prims: Prims, box: Box, rule: BoxRule = tight) -> Iterator[Split]:
    """Yield the split in the middle of the longest side (§1.4.1)."""
    axis = box.sides().index(max(box.sides()))
    yield from at_plane(prims, box, axis, f32(box.centre(axis)), rule)


def union(*sets: Splits) -> Splits:
    """Return the union of several sets of splits."""
    return lambda prims, box: (split for splits in sets for split in splits(prims, box))
