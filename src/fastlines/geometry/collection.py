"""What trees are over: a container of primitives, or several of them together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

import numpy as np

from ..arrays import INVALID, FloatArray, IntArray, choice
from ..errors import InputError
from ..support.display import Shown
from ..support.immutable import own
from .boxes import Boxes
from .curves import Curves
from .foreign import lines
from .lines import Lines
from .shapes import ROUND_CONE, shape_rows
from .triangles import Triangles
from .user_primitives import UserPrimitives, has_user_methods

#: The containers that can be parts of a `Geometry`.
Part: TypeAlias = Lines | Curves | Triangles | Boxes


@dataclass(frozen=True, eq=False, repr=False)
class Geometry(Shown):
    """Several containers of primitives for one tree; hits say which `part`, and which `prim` of it.

    Boxes of its trees bound whole primitives, with their own radii. So a tree over spheres of very different sizes is
    better as a `Geometry` of them than without.

    Parameters
    ----------
    parts : sequence of Lines, Spheres, Curves, Triangles and Boxes

    Examples
    --------
    >>> import fastlines as fl
    >>> floor = fl.Triangles([[[-9, -9, 0], [9, -9, 0], [0, 9, 0]]])
    >>> ball = fl.Spheres.from_centres([[0, 0, 5]], radius=1)
    >>> tree = fl.build(fl.Geometry([floor, ball]))
    >>> hits = tree.first_hit([[0, 0, 9], [3, -5, 9], [99, 0, 9]], [0, 0, -1], at="surface")
    >>> print(hits.part, hits.prim, hits.t)
    [ 1  0 -1] [ 0  0 -1] [ 3.  9. inf]
    """

    #: What the core calls the primitives.
    kind: ClassVar[str] = "shapes"

    parts: tuple[Part, ...]

    def __init__(self, parts: Sequence[Part]) -> None:
        if not isinstance(parts, Sequence | Iterator) or isinstance(parts, str):
            raise InputError(f"parts are a {type(parts).__name__}; expected a list of {_names()}")
        parts = tuple(parts)
        for i, part in enumerate(parts):
            if has_user_methods(part) or isinstance(part, UserPrimitives):
                raise InputError(f"part {i} is a class of your own; build a tree over it alone, and query both trees")
            if not isinstance(part, Part):
                raise InputError(f"part {i} is a {type(part).__name__}; expected one of {_names()}")
        object.__setattr__(self, "parts", parts)

    def __setstate__(self, state: dict[str, Any]) -> None:
        object.__setattr__(self, "parts", state["parts"])

    def __len__(self) -> int:
        return sum(map(len, self.parts))

    def __repr__(self) -> str:
        return f"<Geometry: {', '.join(map(repr, self.parts))}>"

    @cached_property
    def first(self) -> IntArray:
        """The number of primitives in the parts before each one, and in all, (n_parts + 1,) int64."""
        counts = [len(part) for part in self.parts]
        return np.asarray(own(np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])))

    @cached_property
    def owner(self) -> IntArray:
        """The primitive of each row of `core_rows`, counted over all parts, (n_rows,) int64."""
        rows = [
            first + (part.pieces.curve if isinstance(part, Curves) else np.arange(len(part)))
            for first, part in zip(self.first, self.parts, strict=False)
        ]
        return np.asarray(own(np.concatenate([np.zeros(0, np.int64), *rows])))

    @cached_property
    def core_rows(self) -> FloatArray:
        """One row of numbers for each primitive, as the core reads them: (n, 10) float32."""
        rows = [_shapes(part) for part in self.parts]
        return np.asarray(own(np.concatenate([np.empty((0, 10), np.float32), *rows])))

    @cached_property
    def bounds(self) -> FloatArray:
        """The box of all parts as (2, 3), without their radii: lowest and highest corner."""
        boxes = [part.bounds for part in self.parts] or [np.array([[np.inf] * 3, [-np.inf] * 3], np.float32)]
        corners = np.stack(boxes)
        return np.stack([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])


#: What a tree can be over.
AnyGeometry: TypeAlias = Lines | Curves | Triangles | Boxes | Geometry | UserPrimitives


def as_geometry(geometry: Any, *, invalid: str = "error") -> AnyGeometry:
    """Return geometry as it is; take what `lines` takes, and an object with `bounds` and `hit` for your own."""
    choice("invalid", invalid, INVALID)
    if isinstance(geometry, AnyGeometry):
        return geometry
    return UserPrimitives(geometry) if has_user_methods(geometry) else lines(geometry, invalid=invalid)


def core_of(geometry: AnyGeometry) -> Lines | Triangles | Boxes | Geometry | UserPrimitives:
    """Return what the core sees: of curves, their pieces."""
    return geometry.pieces.lines if isinstance(geometry, Curves) else geometry


def core_data(geometry: AnyGeometry) -> tuple[str, FloatArray]:
    """Return what the core calls the primitives that queries test, and their numbers: one row a primitive."""
    core = core_of(geometry)
    return core.kind, core.core_rows


def spread_data(geometry: AnyGeometry) -> tuple[str, FloatArray]:
    """Return the kind and the rows of `core_data` for rays with a spread: round cones, of radius 0 for plain lines."""
    core = core_of(geometry)
    if not isinstance(core, Lines) or core.kind not in ("segments", "round cones"):
        raise InputError(f"a spread is for lines, and this tree is over {type(geometry).__name__}; leave out spread=")
    return "spread cones", core.cone_rows


def build_data(geometry: AnyGeometry) -> tuple[str, FloatArray]:
    """Return what the core calls the primitives that a tree bounds, and their numbers: the axes of lines."""
    core = core_of(geometry)
    return ("segments", core.axes) if isinstance(core, Lines) else (core.kind, core.core_rows)


def parts_of(geometry: AnyGeometry) -> tuple[AnyGeometry, ...]:
    """Return the parts of a `Geometry`; anything else is its own only part."""
    return geometry.parts if isinstance(geometry, Geometry) else (geometry,)


def count_text(geometry: AnyGeometry) -> str:
    """Return how many primitives of which kind there are, in words."""
    kinds: dict[str, int] = {}
    for part in parts_of(geometry):
        kind = "segments" if type(part) is Lines else type(part).__name__.lower()
        kinds[kind] = kinds.get(kind, 0) + len(part)
    return ", ".join(counted(n, kind) for kind, n in kinds.items()) or "nothing"


def counted(n: int, kind: str) -> str:
    """Return a number and what it counts, which is given in the plural.

    Examples
    --------
    >>> counted(1, "segments"), counted(2000, "boxes"), counted(1, "boxes")
    ('1 segment', '2,000 boxes', '1 box')
    """
    one = "box" if kind == "boxes" else kind.removesuffix("s")
    return f"{n:,} {one if n == 1 else kind}"


def needs_radius(geometry: AnyGeometry) -> bool:
    """Return whether a query needs a radius: some lines or curves have none of their own."""
    return any(isinstance(part, Lines | Curves) and part.radius is None for part in parts_of(geometry))


def radius_beyond(geometry: AnyGeometry) -> float:
    """Return how far primitives extend beyond the boxes of a tree over them."""
    return geometry.max_radius if isinstance(geometry, Lines | Curves) else 0.0


def largest_radius(geometry: AnyGeometry) -> float:
    """Return the largest radius that lines or curves have of their own; 0 if none has one."""
    return max((radius_beyond(part) for part in parts_of(geometry)), default=0.0)


def points_of(geometry: AnyGeometry) -> tuple[FloatArray, FloatArray]:
    """Return points that span a geometry, (n, 3), and the radius around each, (n,)."""
    if isinstance(geometry, Geometry):
        known = [points_of(part) for part in geometry.parts]
        all_points = np.concatenate([np.empty((0, 3), np.float32), *(points for points, _ in known)])
        return all_points, np.concatenate([np.empty(0, np.float32), *(radii for _, radii in known)])
    core = core_of(geometry)
    if isinstance(core, Lines):
        return core.segments.reshape(-1, 3), core.end_radii.reshape(-1)
    if isinstance(core, Triangles):
        points = core.corners.reshape(-1, 3)
    else:
        corners = core.corners if isinstance(core, Boxes) else np.asarray(core.bounds[None], np.float32)[: len(core)]
        ends = np.indices((2, 2, 2)).reshape(3, 8).T
        points = corners[:, ends, np.arange(3)].reshape(-1, 3)
    return points, np.zeros(len(points), np.float32)


def up_of(geometry: AnyGeometry) -> str | None:
    """Return the axis that points upwards, of the first part that knows."""
    ups = [part.up for part in parts_of(geometry) if isinstance(part, Lines | Curves)]
    return next((up for up in ups if up), None)


def unit_of(geometry: AnyGeometry) -> str | None:
    """Return the unit of length, of the first part that knows."""
    units = [part.unit for part in parts_of(geometry) if isinstance(part, Lines | Curves)]
    return next((unit for unit in units if unit), None)


def _shapes(part: Part) -> FloatArray:
    core = core_of(part)
    if not isinstance(core, Lines):
        return core.core_rows
    return shape_rows(ROUND_CONE, np.concatenate([core.axes, core.end_radii], axis=1))


def _names() -> str:
    return ", ".join(kind.__name__ for kind in (Lines, Curves, Triangles, Boxes)) + " (or Spheres)"


def in_parts(geometry: AnyGeometry, prim: IntArray) -> tuple[IntArray, IntArray]:
    """Return the part of each primitive, counted over all parts, and its number there; -1 for a miss."""
    if not isinstance(geometry, Geometry):
        return np.where(prim < 0, -1, 0), prim
    part = np.searchsorted(geometry.first, prim, side="right") - 1
    return part, np.where(prim < 0, -1, prim - geometry.first[part])
