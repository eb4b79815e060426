"""Checks of rays, and their conversion to the flat float32 arrays of the core."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import COARSE, FLOAT32_MAX, INVALID, FloatArray, IntArray, choice, to_float32
from ..engines import engine
from ..errors import InputError, PrecisionWarning, QueryWarning
from ..geometry.any_geometry import AnyGeometry
from ..geometry.offsets import Offset, reduced
from ..support.warn_caller import warn_caller
from ..threads import get_num_threads
from .at import At
from .ignore import Ignored
from .ray_arguments import RayArguments
from .row_checks import invalid_rows, one_or_each

#: The largest radius, in units of the scene's size; beyond it squares would overflow.
RADIUS_LIMIT = 1e12

#: The largest spread; with it, the cone around a ray is all that lies before its origin.
SPREAD_LIMIT = 1e12

#: No spread, for all rays.
NO_SPREAD = np.zeros(1, np.float32)

#: No limit, for all rays.
NO_LIMIT = np.full(1, np.inf, np.float32)

#: The most rays of one call: the core numbers them in 32 bits.
RAYS_LIMIT = 2**32 - 1


#: Origins, directions, radius, t_min, t_max, spread, limit.
RayArrays: TypeAlias = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray | None]


@dataclass(frozen=True, eq=False)
class RayBatch:
    """A checked batch of n rays. Those that were `skipped` miss; `shape` is the shape of the answer."""

    shape: tuple[int, ...]
    #: (n, 3) each; the next four are (n,) or (1,).
    origins: FloatArray
    directions: FloatArray
    radius: FloatArray
    t_min: FloatArray
    t_max: FloatArray
    spread: FloatArray
    skipped: IntArray
    #: A checksum of the arrays, by which hits notice that the caller has changed them.
    digest: int = 0
    #: What the rays leave out.
    ignored: tuple[Ignored, ...] = ()
    #: The parts of a `Geometry` that they see; None for all.
    parts: tuple[int, ...] | None = None
    #: (n,) or (1,): first hits, and next hits by t, with a larger t need not be found, but may be. Unlike `t_max` it
    #: clips nothing.
    limit: FloatArray = field(default_factory=lambda: NO_LIMIT)
    #: Whether the reach of any ray grows along it. It decides what tests the rays, so some of them keep that of all.
    has_spread: bool = False
    #: Whether first hits at a surface need `distance` and ``t_out``; else these may be those of a piece of a curve.
    needs_extent: bool = True

    def __len__(self) -> int:
        return len(self.origins)

    def arrays(self) -> RayArrays:
        """Return the arrays in the order of the core, those of `RayArrays`; the limit is None if there is none."""
        limit = None if self.limit is NO_LIMIT else self.limit
        return self.origins, self.directions, self.radius, self.t_min, self.t_max, self.spread, limit

    @staticmethod
    def scalar(values: FloatArray, rows: IntArray) -> FloatArray:
        """Return the values of these rays, of which there may be one for all."""
        return np.broadcast_to(values, len(rows)) if len(values) == 1 else values[rows]

    def some(self, rows: IntArray) -> RayBatch:
        """Return a batch of the rays in these rows."""
        scalars = (self.radius, self.t_min, self.t_max, self.spread, self.limit)
        radius, t_min, t_max, spread, limit = (values if len(values) == 1 else values[rows] for values in scalars)
        none = np.zeros(0, np.int64)
        arrays = self.origins[rows], self.directions[rows], radius, t_min, t_max, spread
        ignored = tuple(each.some(rows) for each in self.ignored)
        made = RayBatch(rows.shape, *arrays, none, ignored=ignored, parts=self.parts, limit=limit)
        return replace(made, has_spread=self.has_spread, needs_extent=self.needs_extent)

    def part(self, begin: int, end: int) -> RayBatch:
        """Return a batch of consecutive rays, whose arrays are views."""
        scalars = (self.radius, self.t_min, self.t_max, self.spread, self.limit)
        radius, t_min, t_max, spread, limit = (values if len(values) == 1 else values[begin:end] for values in scalars)
        arrays = self.origins[begin:end], self.directions[begin:end], radius, t_min, t_max, spread
        skipped = self.skipped[(self.skipped >= begin) & (self.skipped < end)] - begin
        ignored = tuple(each.some(slice(begin, end)) for each in self.ignored)
        made = RayBatch((end - begin,), *arrays, skipped, limit=limit)
        seen = replace(made, ignored=ignored, parts=self.parts, digest=made._checksum())
        return replace(seen, has_spread=self.has_spread, needs_extent=self.needs_extent)

    def _checksum(self) -> int:
        return engine.check_rays(self.arrays(), 0.0, 0.0, get_num_threads())[1]

    def unchanged(self) -> RayBatch:
        """Return this batch, whose arrays may be the caller's.

        Raises
        ------
        InputError
            If the arrays have changed since the query.
        """
        if self._checksum() != self.digest:
            raise InputError(
                "the arrays of rays have changed since the query, and hits do not keep copies; ask for points before "
                "you change them, or pass copies to the query"
            )
        return self


class DeviceRays(Protocol):
    """Checked rays in the memory of a GPU, which find their own answers; those are arrays of the GPU, too."""

    @property
    def has_spread(self) -> bool:
        """Whether the reach of any ray grows along it."""

    def first_hit(self, at: At) -> Any:
        """Find the nearest hit of each ray."""

    def any_hit(self, at: At) -> Any:
        """Find out for each ray whether it hits anything."""

    def count_hits(self, at: At) -> Any:
        """Count the primitives that each ray hits."""

    def list_hits(self, at: At, k: int | None, by_distance: bool) -> Any:
        """List all hits of each ray, or the k best."""


#: Rays in the memory of the host, or of a GPU.
AnyRays: TypeAlias = RayBatch | DeviceRays


def check_rays(given: RayArguments, bounds: FloatArray) -> RayBatch:
    """Check rays for a scene with these bounds; without a radius it is 0."""
    choice("invalid", given.invalid, INVALID)
    origins, directions = _vectors(given.origins, "origins"), _vectors(given.directions, "directions")
    shape = origins.shape[:-1]
    if directions.shape != origins.shape:
        try:
            shape = np.broadcast_shapes(origins.shape[:-1], directions.shape[:-1])
        except ValueError:
            raise InputError(
                f"origins {origins.shape} and directions {directions.shape} do not match; expected one direction for "
                "each origin, or one for all"
            ) from None
        origins, directions = (np.broadcast_to(array, (*shape, 3)) for array in (origins, directions))
    if math.prod(shape) > RAYS_LIMIT:
        raise InputError(
            f"{math.prod(shape)} rays are more than one call takes, {RAYS_LIMIT}; trace them in several calls"
        )
    origins, directions = (np.ascontiguousarray(array).reshape(-1, 3) for array in (origins, directions))
    scalars: dict[str, FloatArray] = {}
    radius = 0.0 if given.radius is None else given.radius
    for name, value in (("radius", radius), ("t_min", given.t_min), ("t_max", given.t_max), ("spread", given.spread)):
        if name == "spread" and isinstance(value, float) and value == 0:  # the default, and single rays are in a hurry
            scalars[name] = NO_SPREAD
            continue
        scalars[name] = one_or_each(name, value, shape, "rays")
    radii, starts, ends, spreads = scalars.values()
    low, high, largest = limits_of(bounds)
    farthest = max(map(abs, (*low, *high)))
    arrays = origins, directions, radii, starts, ends, spreads
    valid, digest = engine.check_rays((*arrays, None), largest, farthest, get_num_threads())
    if valid:
        return RayBatch(shape, *arrays, np.zeros(0, np.int64), digest, has_spread=_any_spread(spreads))

    # The core only reports that some ray may be invalid: find out which, and why.
    n_rays = len(origins)
    length, to_corner = _extents(origins, directions, np.array((low, high)))
    with np.errstate(invalid="ignore", over="ignore"):
        reach = radii + np.where(spreads > 0, spreads.astype(np.float64), 0.0) * to_corner
        too_short = to_corner + radii > length * FLOAT32_MAX
    limit = f"{largest:g} ({RADIUS_LIMIT:g} times the scene's size)"
    faults = {
        "have an origin that is not finite": ~np.isfinite(origins).all(axis=1),
        "have a direction that is not finite": ~np.isfinite(directions).all(axis=1),
        "have a direction of length zero": ~directions.any(axis=1),
        f"have a radius that is not a number from 0 to {limit}": ~((radii >= 0) & (radii <= largest)),
        f"have a spread that is not a number from 0 to {SPREAD_LIMIT:g}": ~((spreads >= 0) & (spreads <= SPREAD_LIMIT)),
        f"have a radius that their spread makes larger than {limit} somewhere in the scene": (spreads > 0)
        & ~(reach <= largest),
        "have bounds that are not numbers with t_min <= t_max": ~(starts <= ends) | (starts == np.inf),
        "have a direction so short that t in the scene is more than float32 can hold": too_short,
    }
    skipped = invalid_rows(faults, scalars, n_rays, "rays", given.invalid)
    if skipped.any():
        # Replace each by a ray that can hit nothing.
        origins, directions = origins.copy(), directions.copy()
        origins[skipped], directions[skipped] = 3e38, (0, 0, 1)
        radii, starts, ends, spreads = (np.broadcast_to(values, n_rays).copy() for values in scalars.values())
        radii[skipped] = starts[skipped] = ends[skipped] = spreads[skipped] = 0
    arrays = origins, directions, radii, starts, ends, spreads
    digest = engine.check_rays((*arrays, None), largest, farthest, get_num_threads())[1]
    return RayBatch(shape, *arrays, np.flatnonzero(skipped), digest, has_spread=_any_spread(spreads))


def _any_spread(spreads: FloatArray) -> bool:
    return spreads is not NO_SPREAD and bool(spreads.any())


def less_offset(given: RayArguments, offset: Offset, bounds: FloatArray) -> RayArguments:
    """Return rays less the offset of their scene, which has these bounds; float32 that is too coarse for that warns."""
    origins, _ = reduced(given.origins, offset)
    if origins is given.origins:  # no numbers, which is an error later
        return given
    warn_of_coarse("the origins of rays", given.origins, origins, offset, bounds)
    return replace(given, origins=origins)


def warn_of_coarse(
    what: str, given: npt.ArrayLike, less_offset: npt.NDArray[np.float64], offset: Offset, bounds: FloatArray
) -> None:
    """Warn of coordinates that are float32, where the lines have an offset because that is too coarse."""
    if (coarse := np.asarray(given)).dtype != np.float32:
        return
    low, high, _ = limits_of(bounds)
    far, near = (float(np.abs(points[np.isfinite(points)]).max(initial=0)) for points in (coarse, less_offset))
    scale = max(near, *map(abs, (*low, *high)))
    if far * 2.0**-24 > scale * COARSE:
        warn_caller(
            f"{what} are float32, which rounds {far:g} by up to {far * 2.0**-24:.2g}, and the lines have an offset, "
            f"{offset}, because that is too coarse; give {what} as float64",
            PrecisionWarning,
        )


def limits_of(bounds: FloatArray) -> tuple[list[float], list[float], float]:
    """Return the corners of a scene, zeros if it has none, and the largest radius of a query there."""
    low, high = bounds.tolist()
    if not all(map(math.isfinite, (*low, *high))):
        low = high = [0.0, 0.0, 0.0]
    side = max(b - a for a, b in zip(low, high, strict=True))
    return low, high, min(RADIUS_LIMIT * (side or 1.0), FLOAT32_MAX)


def _extents(
    origins: FloatArray, directions: FloatArray, corners: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the length of each direction, and the distance from each origin to the farthest corner of the scene."""
    with np.errstate(invalid="ignore", over="ignore"):
        from_origin = origins.astype(np.float64)
        farthest_corner = np.maximum(np.abs(corners[0] - from_origin), np.abs(corners[1] - from_origin))
        to_corner = np.sqrt((farthest_corner**2).sum(axis=1))
        return np.sqrt((directions.astype(np.float64) ** 2).sum(axis=1)), np.asarray(to_corner)


def _vectors(values: npt.ArrayLike, name: str) -> FloatArray:
    array = to_float32(values, name)
    if array.shape == (0,):
        return array.reshape(0, 3)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise InputError(f"{name} have shape {array.shape}; expected (…, 3): x y z of each ray")
    return array


def seen_of(geometry: AnyGeometry, parts: tuple[int, ...] | None) -> tuple[AnyGeometry, ...]:
    """Return the parts that rays see, or the whole."""
    return (geometry,) if parts is None else tuple(geometry.each_part()[i] for i in parts)


def require_radius(
    geometry: AnyGeometry,
    radius: npt.ArrayLike | None,
    spread: npt.ArrayLike = 0.0,
    seen_parts: tuple[int, ...] | None = None,
) -> None:
    """Refuse a query without a radius and a spread on lines without a radius."""
    if radius is not None or np.ndim(spread) > 0 or spread != 0:
        return
    if any(part.needs_radius for part in seen_of(geometry, seen_parts)):
        pass_it = "pass radius=, or --radius on the command line, in the unit of the coordinates"
        if not geometry.has_parts:
            raise InputError(f"these lines have no radius of their own, so a query needs one: {pass_it}, or spread=")
        parts = enumerate(geometry.each_part())
        bare = [f"part {i} ({part.count_text()})" for i, part in parts if part.needs_radius]
        raise InputError(
            f"{', '.join(bare)} of this Geometry has no radius of its own, so a query needs one: {pass_it}, or make "
            "the parts with one, as lines.with_radius(…) does"
        )


def warn_of_radius(geometry: AnyGeometry, radius: npt.ArrayLike, seen_parts: tuple[int, ...] | None = None) -> None:
    """Warn of a radius that counts for nothing that rays see."""
    seen = seen_of(geometry, seen_parts)
    if not seen or any(part.takes_radius for part in seen) or not np.any(np.asarray(radius) > 0):
        return
    what = ", ".join(part.count_text() for part in seen)
    warn_caller(
        f"the radius of a query does not count for triangles and boxes, and rays see nothing else here ({what}): they "
        "hit what they cross, and nothing near it; leave radius= out",
        QueryWarning,
    )


def scene_bounds(geometry: AnyGeometry, box: FloatArray) -> FloatArray:
    """Return the box of all primitives, from that of their axes; refuse radii that are too large for it."""
    margin = geometry.radius_beyond
    if margin > 0 and margin > RADIUS_LIMIT * (size := float(np.ptp(box, axis=0).max()) or 1.0):
        raise InputError(
            f"the largest radius of the lines, {margin:g}, is more than {RADIUS_LIMIT:g} times the size of their axes "
            f"together, {size:g}; leave such lines out"
        )
    return box + np.array([[-margin], [margin]], np.float32)
