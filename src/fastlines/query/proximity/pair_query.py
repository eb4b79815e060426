"""A checked query for pairs, and what the core gets of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray, count, number
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ..memory_check import SMALL, left_bytes
from ..rays import RADIUS_LIMIT
from .pairs import Pairs
from .points import is_to_surface
from .strand_places import Int32Array

#: The memory of a pair, and what it takes while pairs are sorted, in bytes.
PAIR_BYTES, SORTING_BYTES = 28, 40

#: What rounding may change in a distance, as a fraction of it and of the scene's size; more than the exact test does.
ROUNDING = 2.0**-14

#: Pairs: i, j, s, t, distance.
PairColumns = tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]


#: Of each row of the core its primitive, if rows are not primitives; its number in the whole, if its set is a part of
#: one; and its place along a strand (`strand_places`), if neighbours are left out.
RowArrays = tuple[IntArray | None, IntArray | None, Int32Array | None]


@dataclass(frozen=True, eq=False)
class PairQuery:
    """A checked query for the pairs of a geometry, or of two."""

    geometry: AnyGeometry
    other: AnyGeometry | None
    radius: float
    surface: bool
    #: By how much the positions along a strand of a pair that is left out differ at most; 0 if none is.
    reach: int

    @property
    def second(self) -> AnyGeometry:
        """What the second primitives of pairs are of."""
        return self.geometry if self.other is None else self.other

    @property
    def is_empty(self) -> bool:
        """Whether there can be no pairs."""
        return not len(self.geometry) or not len(self.second)

    def options(self, begin: int, end: int, max_pairs: int) -> tuple[float, bool, int, int, int, int]:
        """Return the options as the core takes them; first primitives are from begin up to end."""
        return self.radius, self.surface, self.reach, begin, end, max_pairs

    def pairs(self, columns: PairColumns) -> Pairs:
        """Wrap the pairs that a backend has found."""
        return Pairs(*columns, self.surface, self.geometry, self.second)


def no_pairs() -> PairColumns:
    """Return the columns of no pairs."""
    ids, places = np.zeros(0, np.int64), np.zeros(0, np.float32)
    return ids, ids, places, places, places


def reach_of(query: PairQuery) -> float:
    """Return how far boxes of axes with radii may be apart if they hold a pair, whatever the exact test rounds."""
    both = [(of.bounds, of.max_radius) for of in (query.geometry, query.other) if of is not None and len(of)]
    size = max(float(np.ptp(bounds, axis=0).max() + np.abs(bounds).max()) + radius for bounds, radius in both)
    return query.radius + ROUNDING * (query.radius + size)


def check_pairs(
    geometry: AnyGeometry,
    other: AnyGeometry | None,
    radius: object,
    skip_neighbours: int,
    skip_strand: bool,
    to: str | None,
) -> PairQuery:
    """Check a query for pairs."""
    both = [geometry] if other is None else [geometry, other]
    for of in both:
        _require_axes(of)
    surface = max(is_to_surface(of, to) for of in both)  # checks the option for each
    size = max((float(np.ptp(of.bounds, axis=0).max()) for of in both if len(of)), default=0.0)
    limit = RADIUS_LIMIT * (size or 1.0)
    checked = number(
        "radius", radius, f"a distance from 0 to {limit:g} ({RADIUS_LIMIT:g} times the scene's size)", 0.0, limit
    )
    n, most = count("skip_neighbours", skip_neighbours, 0), int(np.iinfo(np.int32).max)
    if other is not None and skip_strand:
        raise InputError(
            "skip_strand=True leaves out pairs of one strand, and those of two trees never are; leave it out"
        )
    if other is not None and geometry.offset != other.offset and len(geometry) and len(other):
        raise InputError(
            f"the trees have different offsets, {geometry.offset} and {other.offset}; read or make the lines of both "
            "with the same offset="
        )
    reach = 0 if other is not None else most if skip_strand else min(n, most)
    return PairQuery(geometry, other, checked, surface, reach)


def _require_axes(geometry: AnyGeometry) -> None:
    """Refuse what has no axes: the distance between triangles or boxes is not computed."""
    for part in geometry.each_part():
        if len(part) and not part.has_axes:
            raise InputError(
                f"distances between primitives are known for lines, spheres and curves, and not for "
                f"{part.count_text()}; build a tree without them"
            )


def most_pairs() -> int:
    """Return how many pairs fit into the memory that is left."""
    left = max(SMALL, left_bytes())
    return int(left / (PAIR_BYTES + SORTING_BYTES)) if math.isfinite(left) else 2**62
