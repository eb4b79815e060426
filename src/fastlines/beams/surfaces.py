"""Surfaces that photons and rays of a camera hit.

`Surfaces` is the protocol, by which the shapes and materials of other renderers can be used as well. `TracedSurfaces`
traces geometry of ours through one tree. A ray hits a shape where it enters it or, from within a sphere or a box, where
it leaves it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, kind_of
from ..builder import build
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.collection import Geometry
from ..geometry.shapes import TRIANGLE
from ..query.hits import FirstHits
from ..rendering.state import describe, digest
from ..support.counter_random import Float64Array, UInt64Array
from ..support.vectors import dot
from .coefficients import BoolArray, has_member
from .materials import Glass, Material

#: How far from a surface light goes on, so that float32 tells these points apart: as a fraction of the size of all
#: surfaces and their largest coordinate together.
OFF = 2.0**-18
#: How far behind a solid the opposite ray starts, likewise: even a grazing one must start outside.
BEYOND = 2.0**-8
#: A direction along no axis or diagonal.
ASKEW = (0.48, 0.64, 0.6)


class Scattered(NamedTuple):
    """How light goes on from surfaces, n rows.

    Attributes
    ----------
    origins : (n, 3) float64
        Where it begins, a little off the surface.
    directions : (n, 3) float64
        Unit vectors.
    weight : (n, 3) float64
        What is left of the power: 0 where it is absorbed.
    in_medium : (n,) bool
        Whether it goes on where the medium may be, and not in glass.
    is_specular : (n,) bool
        Whether a camera's ray follows it.
    """

    origins: Float64Array
    directions: Float64Array
    weight: Float64Array
    in_medium: BoolArray
    is_specular: BoolArray


class SurfaceHits(Protocol):
    """What n rays have hit.

    Attributes
    ----------
    t : (n,) float64
        The distance; inf = miss.
    """

    @property
    def t(self) -> Float64Array:
        """The distance of each."""

    def scatter(self, rows: IntArray, in_medium: BoolArray, keys: UInt64Array, *, camera: bool = False) -> Scattered:
        """Scatter the light of some rays, none of which misses.

        Parameters
        ----------
        rows : (m,) int
            The rays.
        in_medium : (m,) bool
            Whether they are not in glass before.
        keys : (m,) uint64
            Of their random numbers, by `uniform`.
        camera : bool
            Whether the rays are those of a camera, which carry radiance backwards, and not photons.
        """


class Surfaces(Protocol):
    """What a scene asks of its surfaces."""

    @property
    def bounds(self) -> Float64Array | None:
        """The lowest and the highest corner of all, (2, 3); None if there are none."""

    def intersect(self, origins: Float64Array, directions: Float64Array) -> SurfaceHits:
        """Find the nearest surface along rays, (n, 3) each, of unit directions."""

    def fingerprint(self) -> str:
        """Return a text that other surfaces do not have, by which an unfinished picture knows its scene."""


@dataclass(frozen=True)
class NoSurfaces:
    """No surfaces: every ray misses."""

    bounds: None = None

    def intersect(self, origins: Float64Array, directions: Float64Array) -> TracedHits:
        """See `Surfaces`."""
        none = np.zeros((len(origins), 3))
        return TracedHits((), np.full(len(origins), np.inf), np.zeros(len(origins), np.int64), none, none, none, 0.0)

    def fingerprint(self) -> str:
        """See `Surfaces`."""
        return "none"


@dataclass(frozen=True, eq=False)
class TracedHits:
    """What rays have hit of `TracedSurfaces`; see `SurfaceHits`."""

    materials: tuple[Material, ...]
    t: Float64Array
    part: IntArray
    points: Float64Array
    #: Outwards.
    normals: Float64Array
    directions: Float64Array
    off: float

    def scatter(self, rows: IntArray, in_medium: BoolArray, keys: UInt64Array, *, camera: bool = False) -> Scattered:
        """See `SurfaceHits`."""
        n = len(rows)
        directions, weight = np.empty((n, 3)), np.empty((n, 3))
        passes, is_specular = np.zeros(n, np.bool_), np.zeros(n, np.bool_)
        part, before, normals = self.part[rows], self.directions[rows], self.normals[rows]
        for i, material in enumerate(self.materials):
            here = np.flatnonzero(part == i)
            if len(here):
                turn = material.turn(before[here], normals[here], keys[here])
                directions[here], weight[here], passes[here] = turn
                is_specular[here] = material.is_specular
        outside = dot(directions, normals) > 0
        origins = self.points[rows] + np.where(outside, self.off, -self.off)[:, None] * normals
        return Scattered(origins, directions, weight, np.where(passes, outside, in_medium), is_specular)


class TracedSurfaces:
    """Geometry of ours with a material each, in one tree.

    Parameters
    ----------
    surfaces : sequence of pairs (geometry, material)
        `Triangles`, `Spheres` or `Boxes`, and `Mirror`, `Glass` or `Diffuse`. Spheres or boxes of one geometry must not
        overlap. Triangles of glass are a closed surface whose corners run counter-clockwise, seen from outside. There
        is no glass in other glass; a mesh is not checked for glass in it.

    Raises
    ------
    InputError
        If a surface is not such a pair, or glass is in the glass of a sphere or a box.

    Examples
    --------
    >>> import fastlines as fl
    >>> ball = TracedSurfaces([(fl.Spheres.from_centres([[0, 0, 0]], radius=1), fl.beams.Glass())])
    >>> ball.intersect(np.array([[0.0, 0, -5], [0, 0, 0]]), np.array([[0.0, 0, 1], [0, 0, 1]])).t.round(6).tolist()
    [4.0, 1.0]
    """

    def __init__(self, surfaces: Sequence[tuple[AnyGeometry, Material]]) -> None:
        for i, pair in enumerate(surfaces):
            if not isinstance(pair, tuple | list) or len(pair) != 2:
                raise InputError(
                    f"surface {i} is {kind_of(pair)}; expected a pair of a geometry and a material, such as "
                    "(fl.Spheres.from_centres([[0, 0, 0]], radius=1), fl.beams.Glass())"
                )
            geometry, material = pair
            if not has_member(geometry, "can_be_part") or not geometry.can_be_part or geometry.has_directions:
                raise InputError(
                    f"the geometry of surface {i} is {kind_of(geometry)}; expected Triangles, Spheres or Boxes"
                )
            if not has_member(material, "turn"):
                raise InputError(
                    f"the material of surface {i} is {kind_of(material)}; expected a material, such as fl.beams.Glass()"
                )
        self.geometry = Geometry([geometry for geometry, _ in surfaces])
        if empty := [i for i, part in enumerate(self.geometry.parts) if not len(part)]:
            raise InputError(f"surface {empty[0]} has no primitives; leave it out")
        self.materials = tuple(material for _, material in surfaces)
        self.tree = build(self.geometry)
        points, radii = (values.astype(np.float64) for values in self.geometry.span())
        self.bounds = np.stack([(points - radii[:, None]).min(axis=0), (points + radii[:, None]).max(axis=0)])
        size = float((self.bounds[1] - self.bounds[0]).max() + np.abs(self.bounds).max())
        self.off, self.beyond = OFF * size, BEYOND * size
        parts: Sequence[Any] = self.geometry.parts
        #: The corners of triangles, by their part; rays may be inside of the other parts.
        self.meshes = {i: part.corners for i, part in enumerate(parts) if getattr(part, "shape", None) == TRIANGLE}
        self.solids = [i for i in range(len(parts)) if i not in self.meshes]
        self._refuse_nested_glass()

    def intersect(self, origins: Float64Array, directions: Float64Array) -> TracedHits:
        """See `Surfaces`."""
        # Begin with float32, in which the tree answers.
        begin, way = origins.astype(np.float32), directions.astype(np.float32)
        entered = self.tree.first_hit(begin, way, at="entry")
        t, part = entered.t.astype(np.float64), np.array(entered.part)
        points, normals = entered.points(), self._outward(entered)
        for i in self.solids:
            around = self.tree.first_hit(begin, way, at="surface", parts=i)
            assert around.t_out is not None
            leaves = np.flatnonzero(around.hit & (around.t == 0) & (around.t_out > 0) & (around.t_out < t))
            if not len(leaves):
                continue
            t[leaves], part[leaves] = around.t_out[leaves], i
            # The ray leaves where the opposite one enters.
            ends = begin[leaves] + around.t_out[leaves, None] * way[leaves]
            back = self.tree.first_hit(ends + self.beyond * way[leaves], -way[leaves], at="entry", parts=i)
            is_same = (back.prim == around.prim[leaves])[:, None]
            points[leaves] = np.where(is_same, back.points(), ends)
            normals[leaves] = np.where(is_same, back.normals(), way[leaves])
        return TracedHits(self.materials, t, part, points, normals, directions, self.off)

    def fingerprint(self) -> str:
        """See `Surfaces`."""
        return f"{digest(self.geometry)} {describe(self.materials)}"

    @property
    def glass(self) -> list[int]:
        """The surfaces that are of glass."""
        return [i for i, material in enumerate(self.materials) if isinstance(material, Glass)]

    def encloses(self, surface: int, points: npt.ArrayLike) -> BoolArray:
        """Return which points, (n, 3), are inside of a solid or a closed mesh.

        Examples
        --------
        >>> import fastlines as fl
        >>> ball = TracedSurfaces([(fl.Spheres.from_centres([[0, 0, 0]], radius=1), fl.beams.Glass())])
        >>> ball.encloses(0, [[0, 0, 0.9], [0, 0, 1], [0, 0, 1.1]]).tolist()
        [True, False, False]
        """
        places = np.asarray(points, np.float32)
        is_inside = np.ones(len(places), np.bool_)
        for way in (ASKEW, np.negative(ASKEW)):  # a point that only touches is not inside both ways
            if surface in self.meshes:
                met = self.tree.first_hit(places, way, at="entry", parts=surface)
                is_inside &= met.hit & (met.t > self.off) & (self._outward(met) @ way > 0)
            else:
                around = self.tree.first_hit(places, way, at="surface", parts=surface)
                assert around.t_out is not None
                is_inside &= around.hit & (around.t == 0) & (around.t_out > self.off)
        return is_inside

    def _refuse_nested_glass(self) -> None:
        """Refuse glass in the glass of a solid: light that leaves the inner one would be in the medium."""
        for outer in set(self.glass) & set(self.solids):
            for inner in set(self.glass) - {outer}:
                points, _ = self.geometry.parts[inner].span()
                if self.encloses(outer, points).any():
                    raise InputError(
                        f"surface {inner} is inside of surface {outer}, and both are of Glass; expected glass that is "
                        "not in other glass: leave one of them out, or move them apart"
                    )

    def _outward(self, entered: FirstHits) -> Float64Array:
        """Return the normals of what rays enter; those of triangles by the order of their corners."""
        normals = entered.normals()
        assert entered.part is not None
        for i, corners in self.meshes.items():
            if len(rows := np.flatnonzero(entered.part == i)):
                first, second, third = np.moveaxis(corners[entered.prim[rows]].astype(np.float64), 1, 0)
                is_back = dot(np.cross(second - first, third - first), normals[rows]) < 0
                normals[rows[is_back]] *= -1
        return normals
