"""Primitives of your own: a class with `bounds` and `hit`, as a container that trees can be built over."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol, cast

import numpy as np
import numpy.typing as npt

from ..arrays import COORDINATE_LIMIT, FloatArray, IntArray, refuse_rows, unusable
from ..errors import InputError
from ..support.computed_once import computed_once
from ..support.distinct import is_among
from ..support.texts import counted
from .any_geometry import AnyGeometry
from .boxes import Boxes, corners_of
from .hit_places import Float64Array, HitPlaces
from .shapes import BOUND, shape_rows

#: By how much boxes are grown, as a fraction of the scene's size plus its largest coordinate. It exceeds the rounding
#: of rays and boxes to float32.
MARGIN = 2.0**-18

#: How often the boxes of primitives are halved if there is `clipped_bounds`. Smaller boxes replace the box of a
#: primitive if their surface area is less than this fraction of its area.
HALVINGS, LESS = 3, 0.9


class Rays(NamedTuple):
    """Rays for `Primitives.hit`, one a row, float64: o + t·d for t in [t_min, t_max]."""

    origins: Float64Array
    directions: Float64Array
    t_min: Float64Array
    t_max: Float64Array


class Primitives(Protocol):
    """The methods of a class of your own that `build` needs.

    More methods are optional. Their arrays have one row for each of m primitives.

    - ``clipped_bounds(ids, boxes)`` returns boxes (m, 2, 3) around the part of each primitive in its box (m, 2, 3), or
      low > high if there is no such part. Trees are then over smaller boxes.
    - ``normals(ids, points)`` returns unit vectors (m, 3) for `FirstHits.normals`.
    - ``nearest(ids, points)`` returns the distance (m,) of each primitive from a point (m, 3), for `Tree.nearest`,
      `Tree.within` and `Tree.count_within`. It is negative inside if you define it so, and NaN or inf for none. No
      point outside of the box of a primitive may be nearer to it than to its box. A mapping has it as "distance", and
      may also have "u" and, for `Nearest.points`, the nearest "point" (m, 3).
    - ``in_box(ids, low, high)`` returns whether each primitive has a point in the box between two corners (m, 3), as
      bool (m,), for `Tree.in_box`. A corner may hold infinities.
    """

    def bounds(self) -> npt.ArrayLike:
        """Return the box of each of the n primitives, (n, 2, 3): lowest and highest corner."""

    def hit(self, ids: IntArray, rays: Rays, radius: Float64Array) -> Any:
        """Test pairs of a primitive and a ray.

        Parameters
        ----------
        ids : (m,) int64
        rays : Rays
        radius : (m,) float64
            The radius of the query; you define its meaning. A hit must lie within this distance of the primitive's box.

        Returns
        -------
        (m,) array, or mapping of str to (m,) array
            "t", in units of the direction's length; NaN or inf for a miss. A t outside of [t_min, t_max] counts as a
            miss. A mapping may also have "u", "distance" and "t_out".
        """


class UserHits(NamedTuple):
    """The answers of `Primitives.hit`, float32; t is inf for a miss."""

    t: FloatArray
    u: FloatArray
    distance: FloatArray
    t_out: FloatArray


class UserDistances(NamedTuple):
    """The answers of the optional method `nearest`; the distance is inf for none."""

    distance: FloatArray
    u: FloatArray
    point: Float64Array | None


def has_user_methods(value: object) -> bool:
    """Return whether an object, not a class, has the two methods of `Primitives`."""
    # Look for `hit` first: others have a property `bounds`, which would be computed.
    return not isinstance(value, type) and all(callable(getattr(value, name, None)) for name in ("hit", "bounds"))


@dataclass(frozen=True, eq=False, repr=False)
class UserPrimitives(AnyGeometry):
    """The container that `build` makes from an object with `bounds` and `hit`."""

    kind: ClassVar[str] = "shapes"

    source: Primitives

    def __repr__(self) -> str:
        return f"<UserPrimitives: {counted(len(self), 'primitives')} of {type(self.source).__name__}>"

    def __len__(self) -> int:
        return len(self._boxes)

    def __setstate__(self, state: dict[str, Any]) -> None:
        object.__setattr__(self, "source", state["source"])

    @computed_once
    def _boxes(self) -> Float64Array:
        """The boxes that `bounds` returns, (n, 2, 3)."""
        name = f"{type(self.source).__name__}.bounds()"
        boxes = _checked_boxes(self.source.bounds(), name)
        refuse_rows(unusable(np.asarray(boxes, np.float32)), f"boxes of {name}")
        if (boxes[:, 0] > boxes[:, 1]).any():
            raise InputError(f"{name} has boxes with a low corner above their high one; expected lowest and highest")
        return boxes

    @property
    def bounds(self) -> FloatArray:
        """The box of all primitives as (2, 3): lowest and highest corner; lowest > highest if there are none."""
        low, high = (part.reshape(-1, 3) for part in (self._boxes[:, 0], self._boxes[:, 1]))
        return np.stack([low.min(axis=0, initial=np.inf), high.max(axis=0, initial=-np.inf)]).astype(np.float32)

    @computed_once
    def _pieces(self) -> tuple[Float64Array, IntArray]:
        """The boxes that trees are over, and the primitive of each."""
        boxes, owner = self._boxes, np.arange(len(self._boxes))
        if not callable(clip := getattr(self.source, "clipped_bounds", None)):
            return boxes, owner
        name = f"{type(self.source).__name__}.clipped_bounds()"
        for _ in range(HALVINGS):
            rows, axis = np.arange(len(boxes)), (boxes[:, 1] - boxes[:, 0]).argmax(axis=1)
            halves = np.stack([boxes, boxes])
            halves[0, rows, 1, axis] = halves[1, rows, 0, axis] = boxes.mean(axis=1)[rows, axis]
            parts = [_checked_boxes(clip(owner, half), name, len(owner)) for half in halves]
            # Clip the box of each part to its half.
            found, limits = np.concatenate(parts), np.concatenate(halves)
            low, high = np.maximum(found[:, 0], limits[:, 0]), np.minimum(found[:, 1], limits[:, 1])
            is_part = (low <= high).all(axis=1)
            boxes, owner = np.stack([low, high], axis=1)[is_part], np.concatenate([owner, owner])[is_part]
        # Keep the whole box of a primitive unless its parts have less surface area.
        whole = _area(self._boxes)
        better = np.bincount(owner, _area(boxes), minlength=len(whole)) < LESS * whole
        better &= np.bincount(owner, minlength=len(whole)) > 0
        boxes = np.concatenate([boxes[better[owner]], self._boxes[~better]])
        owner = np.concatenate([owner[better[owner]], np.flatnonzero(~better)])
        order = np.argsort(owner, kind="stable")
        return boxes[order], owner[order]

    @property
    def owner(self) -> IntArray:
        """The primitive of each row of `core_rows`, (n_rows,) int64."""
        return self._pieces[1]

    @computed_once
    def core_rows(self) -> FloatArray:
        """The boxes that the core searches, grown to cover rounding: (n_rows, 10) float32."""
        boxes = self._pieces[0].copy()
        if len(boxes):
            size = float(np.ptp(boxes.reshape(-1, 3), axis=0).max())
            margin = MARGIN * (size + float(np.abs(boxes).max())) + 1e-30
            boxes += np.array([[-margin], [margin]])
        return shape_rows(
            BOUND, np.asarray(np.clip(boxes, -COORDINATE_LIMIT, COORDINATE_LIMIT), np.float32).reshape(-1, 6)
        )

    # --- What a kind of geometry answers ---

    noun = "primitives"
    has_user_code = True

    def count_text(self) -> str:
        """See `AnyGeometry`."""
        return f"{len(self):,} of your own"

    def require_gpu(self) -> None:
        """See `AnyGeometry`."""
        raise InputError(
            f"the GPU does not run a class of your own, and this tree is over {type(self.source).__name__}; query it "
            "on the CPU"
        )

    def span(self) -> tuple[FloatArray, FloatArray]:
        """Return the corners of the box of all primitives."""
        points = corners_of(np.asarray(self.bounds[None], np.float32)[: len(self)]).reshape(-1, 3)
        return points, np.zeros(len(points), np.float32)

    def normals_at(self, hits: HitPlaces) -> Float64Array:
        """Call the optional method `normals`."""
        if not callable(normals := getattr(self.source, "normals", None)):
            raise InputError(f"{type(self.source).__name__} has no method normals(ids, points); add it for normals")
        return np.asarray(normals(hits.prim, hits.on_rays()), np.float64)

    def nearest_at(self, hits: HitPlaces, surface: bool) -> Float64Array:
        """Call the optional method `nearest` again, for its points."""
        if (points := self.nearest(hits.prim, hits.origins).point) is None:
            name = f"{type(self.source).__name__}.nearest()"
            raise InputError(f"{name} returned no 'point'; for points(), return a mapping of 'distance' and 'point'")
        return points

    def drawn(self, rows: IntArray) -> Sequence[AnyGeometry]:
        """Return the boxes, perhaps several of each primitive."""
        of_rows = is_among(self.owner, rows)
        return (Boxes(self.core_rows[of_rows, :6].reshape(-1, 2, 3)),)

    def hit(self, ids: IntArray, rays: Rays, radius: Float64Array) -> UserHits:
        """Call `Primitives.hit`, and check and convert its answer."""
        arrays = self._columns("hit", self.source.hit(ids, rays, radius), ids, ("t", "u", "distance", "t_out"))
        t = arrays["t"]
        is_hit = np.isfinite(t) & (rays.t_min <= t) & (t <= rays.t_max)
        zero = np.zeros(len(ids))
        return UserHits(
            np.asarray(np.where(is_hit, t, np.inf), np.float32),
            *(
                np.asarray(np.where(is_hit, values, missing), np.float32)
                for values, missing in (
                    (arrays.get("u", zero), 0.0),
                    (arrays.get("distance", zero), np.inf),
                    (arrays.get("t_out", t), np.inf),
                )
            ),
        )

    def nearest(self, ids: IntArray, points: Float64Array) -> UserDistances:
        """Call the optional method `nearest` of `Primitives`, and check and convert its answer."""
        arrays = self._columns("nearest", self.require_nearest()(ids, points), ids, ("distance", "u", "point"))
        with np.errstate(over="ignore"):
            distance = arrays["distance"].astype(np.float32)
        distance[~np.isfinite(distance)] = np.inf
        return UserDistances(distance, arrays.get("u", np.zeros(len(ids))).astype(np.float32), arrays.get("point"))

    def in_box(self, ids: IntArray, low: Float64Array, high: Float64Array) -> npt.NDArray[np.bool_]:
        """Call the optional method `in_box` of `Primitives`, and check its answer."""
        name = f"{type(self.source).__name__}.in_box()"
        found = np.asarray(self.require_in_box()(ids, low, high))
        if found.dtype != np.bool_ or found.shape != ids.shape:
            raise InputError(f"{name} returned {found.dtype} of shape {found.shape}; expected bool of {ids.shape}")
        return found

    def require_in_box(self) -> Callable[[IntArray, Float64Array, Float64Array], Any]:
        """Return the optional method `in_box`, or say that it is missing."""
        if not callable(in_box := getattr(self.source, "in_box", None)):
            raise InputError(
                f"{type(self.source).__name__} has no method in_box(ids, low, high), which returns whether each "
                "primitive has a point in a box; add it for queries about boxes"
            )
        return cast(Callable[[IntArray, Float64Array, Float64Array], Any], in_box)

    def require_nearest(self) -> Callable[[IntArray, Float64Array], Any]:
        """Return the optional method `nearest`, or say that it is missing."""
        if not callable(nearest := getattr(self.source, "nearest", None)):
            raise InputError(
                f"{type(self.source).__name__} has no method nearest(ids, points), which returns the distance of each "
                "primitive from a point; add it for queries about points"
            )
        return cast(Callable[[IntArray, Float64Array], Any], nearest)

    def _columns(self, method: str, found: Any, ids: IntArray, names: tuple[str, ...]) -> dict[str, Float64Array]:
        """Check what a method returned for each of these primitives: the first of some columns, or a mapping."""
        name, first = f"{type(self.source).__name__}.{method}()", names[0]
        columns = dict(found) if hasattr(found, "keys") else {first: found}
        if first not in columns or (more := columns.keys() - set(names)):
            what = f"no {first!r}" if first not in columns else f"{min(more)!r}"
            others = ", ".join(map(repr, names[1:-1]))
            raise InputError(f"{name} returned {what}; expected {first!r}, and perhaps {others} and {names[-1]!r}")
        arrays = {key: np.asarray(values, np.float64) for key, values in columns.items()}
        for key, array in arrays.items():
            expected = (len(ids), 3) if key == "point" else ids.shape
            if array.shape != expected:
                raise InputError(f"{name} returned {key!r} of shape {array.shape}; expected {expected}, a row a pair")
        return arrays


def _checked_boxes(values: npt.ArrayLike, name: str, n: int | None = None) -> Float64Array:
    boxes = np.asarray(values, np.float64)
    if boxes.ndim != 3 or boxes.shape[1:] != (2, 3) or (n is not None and len(boxes) != n):
        raise InputError(f"{name} has shape {boxes.shape}; expected ({'n' if n is None else n}, 2, 3): boxes")
    return boxes


def _area(boxes: Float64Array) -> Float64Array:
    x, y, z = np.maximum(boxes[:, 1] - boxes[:, 0], 0).T
    return np.asarray(2 * (x * y + x * z + y * z))
