"""Primitives around axes: what lines and curves have in common."""

from __future__ import annotations

import functools
import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, FloatArray, IntArray
from ..engines import engine
from ..errors import InputError
from ..support.computed_once import computed_once
from ..support.distinct import distinct
from ..support.immutable import own
from ..support.texts import counted
from ..support.vectors import is_zero
from ..threads import get_num_threads
from .any_geometry import AnyGeometry, CoreData
from .hit_places import Float64Array, HitFrames, HitPlaces, HitRays, perpendicular, unit
from .selection import rows_of_prims, rows_of_strands
from .shapes import ROUND_CONE, shape_rows

if TYPE_CHECKING:
    from .lines import Lines

Self = TypeVar("Self", bound="AxisGeometry")

#: Of curves: control points, radii, the first piece of each, and the parameter at both ends of each piece.
CurveArrays: TypeAlias = tuple[FloatArray, FloatArray | None, IntArray, FloatArray, FloatArray]
#: Both ends of each straight axis, with the radius at both if there is one, and the curves that they stand for.
AxisArrays: TypeAlias = tuple[FloatArray, CurveArrays | None]
#: Of hits: prim, u, t, and the row of the ray of each.
PlaceArrays: TypeAlias = tuple[IntArray, Float64Array, Float64Array, IntArray | None]


class AxisGeometry(AnyGeometry):
    """Straight or curved axes with a radius around them, in strands. The core reads them as straight `Lines`."""

    can_be_part = True
    #: What values are for that are given at both ends, and for a whole primitive.
    place_words: ClassVar[tuple[str, str]]

    # A subclass has these as fields.
    strands: IntArray
    skipped: IntArray
    attributes: Mapping[str, npt.NDArray[Any]]
    end_attributes: Mapping[str, npt.NDArray[Any]]

    @property
    @abstractmethod
    def straight(self) -> Lines:
        """The lines that queries test: lines themselves, or the pieces of curves."""

    @property
    @abstractmethod
    def control_points(self) -> FloatArray:
        """The ends of straight axes (n, 2, 3), or the Bezier control points of curved ones (n, 4, 3)."""

    @property
    def compiled_axes(self) -> AxisArrays:
        """The axes as compiled code reads them: straight ones and, of curves, those that they stand for."""
        straight = self.straight
        return (straight.axes if straight.radius is None else straight.cone_rows), None

    def radius_at(self, prim: IntArray, u: Float64Array) -> Float64Array:
        """Return the radius at places u."""
        return engine.hit_radii(self.compiled_axes, prim, u, get_num_threads(), None)

    # --- Words ---

    def __repr__(self) -> str:
        has = [self.count_text()] + [counted(self.n_strands, "strands")] * (self.n_strands > 0)
        has += ["radius"] * (self.radius is not None) + list(self.attributes)
        has += [f"{len(self.skipped):,} skipped"] * (len(self.skipped) > 0)
        return f"<{type(self).__name__}: {', '.join(has)}>"

    # --- Selections ---

    def __getitem__(self: Self, prims: slice | npt.ArrayLike) -> Self:
        """Return some of the primitives; see `select`."""
        rows = rows_of_prims(prims, len(self))

        def some(values: AnyArray) -> AnyArray:
            return own(values[rows])

        arrays = {name: getattr(self, name) for name in self.sections if name != "skipped"}
        return replace(
            self,
            **{name: some(values) for name, values in arrays.items() if values is not None},
            attributes={name: some(values) for name, values in self.attributes.items()},
            end_attributes={name: some(values) for name, values in self.end_attributes.items()},
            skipped=np.empty(0, np.int64),
        )

    #: A container is no sequence of containers: loop over its arrays instead.
    __iter__ = None

    def __array__(self, *_: Any, **__: Any) -> npt.NDArray[np.object_]:
        """Return an array of one object, without dimensions: NumPy would index what is a sequence to it."""
        array = np.empty((), object)
        array[()] = self
        return array

    def select(self: Self, *, strands: npt.ArrayLike | None = None, prims: slice | npt.ArrayLike | None = None) -> Self:
        """Return some of the strands, or some of the segments or curves, with all that is known of them.

        They keep their radii, attributes and numbers of strands, and the unit, the upward axis and the metadata. They
        stand in the order in which they were named. `skipped` is empty: `rows` counts what was selected.

        Parameters
        ----------
        strands : (k,) array of int or (n_strands,) array of bool, optional
            The numbers of strands, such as ``np.unique(hits.strand[hits.strand >= 0])``; or which of the strands, in
            the order of their numbers, as `strand_lengths` has them.
        prims : slice, (k,) array of int or (n,) array of bool, optional
            Positions of segments or curves, or which of them. ``lines[prims]`` is the same.

        Raises
        ------
        InputError
            If there is no such strand, segment or curve; -1 is none.

        Examples
        --------
        >>> import fastlines as fl
        >>> lines = fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 5, 0], [1, 5, 0]]])
        >>> hits = fl.build(lines).first_hit([[0.5, 5, -1], [9, 9, -1]], [0, 0, 1], 0.1)
        >>> lines.select(strands=np.unique(hits.strand[hits.hit]))
        <Lines: 1 segment, 1 strand>
        >>> lines.select(strands=lines.strand_lengths() > 1.5).strands, lines[:2].strands
        (array([0, 0]), array([0, 0]))
        """
        if (strands is None) == (prims is None):
            raise InputError("select takes either strands= or prims=")
        return self[prims if strands is None else rows_of_strands(strands, self.strands)]  # type: ignore[index]

    # --- What the core gets ---

    @property
    def kind(self) -> str:
        """See `AnyGeometry`."""
        return self.straight.kind

    @property
    def core_rows(self) -> FloatArray:
        """See `AnyGeometry`."""
        return self.straight.core_rows

    def build_data(self) -> CoreData:
        """Return the axes: trees bound them without radii."""
        return "segments", self.straight.axes

    @property
    def takes_spread(self) -> bool:
        """Whether the core knows the primitives as round cones."""
        return self.kind in ("segments", "round cones")

    def spread_data(self) -> CoreData:
        """See `AnyGeometry`."""
        return ("spread cones", self.straight.cone_rows) if self.takes_spread else super().spread_data()

    @property
    def shape_rows(self) -> FloatArray:
        """See `AnyGeometry`."""
        return shape_rows(ROUND_CONE, self.straight.cone_rows)

    # --- Extent ---

    def span(self) -> tuple[FloatArray, FloatArray]:
        """See `AnyGeometry`."""
        return self.straight.segments.reshape(-1, 3), self.straight.end_radii.reshape(-1)

    def thick_axes(self) -> tuple[FloatArray, FloatArray]:
        """See `AnyGeometry`."""
        return self.straight.segments, self.straight.end_radii

    @property
    def radius_range(self) -> tuple[float, float] | None:
        """See `AnyGeometry`."""
        if self.radius is None or not len(self):
            return None
        return max(0.0, float(self.radius.min())), self.max_radius

    @property
    def needs_radius(self) -> bool:
        """See `AnyGeometry`."""
        return self.radius is None

    def radius_of(self, prim: IntArray) -> Float64Array:
        """See `AnyGeometry`."""
        if self.radius is None or not len(self):
            return np.zeros(len(prim))
        columns = self.radius[prim].reshape(len(prim), math.prod(self.radius.shape[1:])).T
        return np.asarray(functools.reduce(np.maximum, columns, np.zeros(len(prim))))

    # --- Hits ---

    @property
    def has_axes(self) -> bool:
        """Always, whatever the radius."""
        return True

    takes_misses = has_directions = True

    def points_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return engine.hit_points(self.compiled_axes, *_arrays(hits), hits.at_surface, None, get_num_threads(), None)

    def points_outside(self, hits: HitPlaces, distance: Float64Array) -> Float64Array:
        """See `AnyGeometry`."""
        return engine.hit_points(self.compiled_axes, *_arrays(hits), hits.at_surface, distance, get_num_threads(), None)

    def normals_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return engine.hit_normals(self.compiled_axes, *_arrays(hits), hits.at_surface, get_num_threads(), None)

    def tangents_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return engine.hit_tangents(self.compiled_axes, hits.prim, hits.u, get_num_threads(), None)

    def frames_at(self, hits: HitPlaces, lift: float) -> HitFrames:
        """See `AnyGeometry`."""
        return HitFrames(*engine.hit_frames(self.compiled_axes, *_arrays(hits), lift, get_num_threads(), None))

    def lines_at(self, prim: IntArray, u: FloatArray) -> FloatArray:
        """See `AnyGeometry`."""
        if not self.in_pieces:
            return np.asarray(self.straight.cone_rows[prim])
        found, places = super().lines_at(prim, u), HitPlaces.without_rays(prim, u.astype(np.float64))
        found[:, 3:6] = np.nan_to_num(self.tangents_at(places))
        if self.radius is not None:
            found[:, 6:] = self.radius_at(prim, places.u)[:, None]
        return found

    def nearest_at(self, hits: HitPlaces, surface: bool) -> Float64Array:
        """Return the point of the axis at u, or that of the surface towards the origin."""
        axis = self.axis_points(hits.prim, hits.u)
        if not surface:
            return axis
        away = hits.origins - axis
        centred = np.flatnonzero(is_zero(away))
        away[centred] = perpendicular(self.tangents_at(hits.some(centred)))
        return np.asarray(axis + self.radius_at(hits.prim, hits.u)[:, None] * unit(away))

    def rows_of(self, prim: IntArray) -> IntArray:
        """See `AnyGeometry`."""
        # Count the skipped rows before each: those whose position among the kept rows is at or before its own.
        before = np.searchsorted(self.skipped - np.arange(len(self.skipped)), prim, side="right")
        return np.asarray(prim + before)

    def strands_of(self, prim: IntArray) -> IntArray:
        """See `AnyGeometry`."""
        return np.maximum(self.strands[prim], -1)

    @property
    def end_of_strands(self) -> int:
        """See `AnyGeometry`."""
        return int(self.strands.max(initial=-1)) + 1

    # --- Attributes ---

    @property
    def place_attributes(self) -> Mapping[str, npt.NDArray[Any]]:
        """The values at both ends."""
        return self.end_attributes

    def place_weights(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return np.stack([1 - hits.u, hits.u], axis=1)

    def _samples_radius(self, name: str) -> bool:
        return name == "radius" and self.radius is not None and name not in self.end_attributes

    @property
    def sample_names(self) -> Mapping[str, None]:
        """The names of attributes, and "radius"."""
        radius = ["radius"] if self.radius is not None else []
        return dict.fromkeys([*self.end_attributes, *radius, *self.attributes])

    def sample(self, name: str, hits: HitPlaces) -> npt.NDArray[Any]:
        """See `AnyGeometry`."""
        return self.radius_at(hits.prim, hits.u) if self._samples_radius(name) else super().sample(name, hits)

    def sample_shape(self, name: str) -> tuple[int, ...]:
        """See `AnyGeometry`."""
        return () if self._samples_radius(name) else super().sample_shape(name)

    def arrays_of(self, name: str) -> list[tuple[AnyArray, int]]:
        """See `AnyGeometry`."""
        radius = [] if name != "radius" or self.radius is None else [(self.radius, self.radius.ndim)]
        return super().arrays_of(name) + radius

    def place_of(self, name: str) -> str:
        """See `AnyGeometry`."""
        if name in self.end_attributes:
            return self.place_words[0]
        values, strands = self.attributes[name], self.strands
        if 0 < self.n_strands < len(self) and (strands >= 0).all():
            _, first, strand = np.unique(strands, return_index=True, return_inverse=True)
            if np.array_equal(values, values[first][strand], equal_nan=values.dtype.kind in "fc"):
                return "strand"
        return self.place_words[1]

    # --- Strands, and how lines run ---

    @computed_once
    def n_strands(self) -> int:
        """The number of different strands of the segments or curves."""
        strands = self.strands[self.strands >= 0]
        if (strands[1:] >= strands[:-1]).all():
            return int(np.count_nonzero(strands[1:] > strands[:-1])) + (len(strands) > 0)
        if strands.max() < 4 * len(self):
            return int(np.count_nonzero(np.bincount(strands)))
        return len(distinct(strands))

    @property
    def n_skipped(self) -> int:
        """See `AnyGeometry`."""
        return len(self.skipped)

    @property
    def rows(self) -> IntArray:
        """The row of the input that each segment or curve was, (n,) int64; `FirstHits.row` has it for hits."""
        return np.delete(np.arange(len(self) + len(self.skipped)), self.skipped)

    def strand_sizes(self) -> IntArray:
        """See `AnyGeometry`."""
        return np.unique(self.strands[self.strands >= 0], return_counts=True)[1]

    @property
    def ends(self) -> FloatArray:
        """Both ends of each segment or curve, (n, 2, 3)."""
        return self.control_points[:, :: self.control_points.shape[1] - 1]

    def ends_of(self, prim: IntArray) -> FloatArray:
        """Return both ends of some segments or curves, (m, 2, 3)."""
        return self.ends[prim]

    def first_directions_of(self, prim: IntArray) -> FloatArray:
        """Return the direction at the start of some segments or curves, of any length, (m, 3)."""
        return np.asarray(self.control_points[prim, 1] - self.control_points[prim, 0])

    def begins(self) -> npt.NDArray[np.bool_]:
        """See `AnyGeometry`."""
        begins = np.ones(len(self), np.bool_)
        if not len(self):
            return begins
        same = (self.strands[1:] == self.strands[:-1]) & (self.strands[1:] >= 0)
        for axis in range(3):
            same &= self.ends[1:, 0, axis] == self.ends[:-1, 1, axis]
        begins[1:] = ~same
        return begins

    @property
    def total_length(self) -> float:
        """See `AnyGeometry`."""
        return float(self.straight.lengths().sum())

    def strand_lengths(self) -> Float64Array:
        """Return the length of each strand, in the order of their numbers, (n_strands,) float64."""
        lines = self.straight
        has = lines.strands >= 0
        strands = lines.strands[has]
        steps = strands[1:] - strands[:-1]
        if (steps >= 0).all():
            strand = np.cumsum(np.append(np.zeros(min(1, len(strands)), bool), steps > 0))
        else:
            strand = np.unique(strands, return_inverse=True)[1]
        return np.asarray(np.bincount(strand, lines.lengths()[has]), np.float64)

    def count_points(self) -> int:
        """See `AnyGeometry`."""
        points = self.control_points
        same = np.ones(len(points), np.bool_)
        for axis in range(3):
            same &= (points[:, 1:, axis] == points[:, :1, axis]).all(axis=1)
        return int(same.sum())

    def count_repeats(self) -> int:
        """See `AnyGeometry`."""
        n, size = len(self), 3 * self.control_points.shape[1]
        points = self.control_points + np.float32(0)  # no negative zeros
        forwards, backwards = points.reshape(n, size), points[:, ::-1].reshape(n, size)
        rows, first = np.arange(n), (forwards != backwards).argmax(axis=1)
        turned = forwards[rows, first] > backwards[rows, first]
        return n - len(np.unique(np.where(turned[:, None], backwards, forwards), axis=0))


def _arrays(hits: HitPlaces) -> tuple[PlaceArrays, HitRays]:
    """Return hits and their rays as compiled code reads them."""
    assert hits.rays is not None
    return (hits.prim, hits.u, hits.t, hits.ray), hits.rays
