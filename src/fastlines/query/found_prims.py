"""Primitives that a query has found: rows, strands, tangents and attributes, in the shape of the answer."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.hit_places import Float64Array, HitPlaces
from ..support.computed_once import computed_once
from ..support.display import Shown
from ..support.immutable import own

Self = TypeVar("Self")


class FoundPrims(Shown):
    """Primitives of a geometry, with a place u on each; -1 is a miss. Floats are NaN for a miss."""

    prim: IntArray
    u: FloatArray
    distance: FloatArray
    skipped: IntArray
    geometry: AnyGeometry | None
    part: IntArray | None

    #: The fields that pickles leave out, besides what is computed once from them.
    unpickled: ClassVar[tuple[str, ...]] = ("geometry",)

    @computed_once
    def row(self) -> IntArray:
        """The row of the input that each segment was, int64 of the shape of ``prim``; -1 = miss. Read-only.

        It differs from ``prim`` where rows of the input were skipped.
        """
        return self._looked_up(self._known().rows_of)

    @computed_once
    def strand(self) -> IntArray:
        """The strand of each segment or curve, int64 of the shape of ``prim``; -1 = miss, or none. Read-only.

        Each part of a `Geometry` counts its own strands.
        """
        return self._looked_up(self._known().strands_of)

    def _looked_up(self, look_up: Callable[[IntArray], IntArray]) -> IntArray:
        """Return a number of each primitive that was found; -1 for a miss."""
        numbers, is_found = np.full(self.prim.shape, -1), self.prim >= 0
        numbers[is_found] = look_up(self.prim_number[is_found])
        return np.asarray(own(numbers))

    @property
    def prim_number(self) -> IntArray:
        """The primitive, counted over all parts of a `Geometry`; -1 for a miss. Else it is `prim`."""
        return self._known().number(self.part, self.prim)

    def tangents(self) -> Float64Array:
        """Return the unit vector from start to end of each segment that was found, (…, 3) float64.

        It is NaN for a segment of length zero.

        Examples
        --------
        >>> import fastlines as fl
        >>> print(fl.build([[[-1, 0, 0], [1, 0, 0]]]).first_hit([0, 0, -5], [0, 0, 1], 0.5).tangents())
        [1. 0. 0.]
        """
        return self._filled(self._known().tangents_at(self._places(on_rays=False)))

    def sample(self, name: str) -> npt.NDArray[Any]:
        """Return an attribute of what was found, or its radius, at each place; NaN for a miss.

        Values at both ends of a segment or curve are interpolated at `u`, and those at the corners of a triangle at
        the point. Whole numbers and booleans are those of the nearest end or corner. A value for the whole primitive
        is constant. Numbers become float64.

        Parameters
        ----------
        name : str
            A key of `attributes`, `end_attributes` or `corner_attributes` of the container, or "radius".

        Examples
        --------
        >>> import fastlines as fl
        >>> lines = fl.Lines.from_points([[0, 0, 0], [1, 0, 0]], [2], attributes={"fa": [0.0, 1.0]})
        >>> fl.build(lines).first_hit([[0.25, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5).sample("fa")
        array([0.25,  nan])
        """
        geometry = self._known()
        return self._filled(geometry.sample(name, self._places(on_rays=geometry.sample_needs_rays(name))))

    def _places(self, *, on_rays: bool = True) -> HitPlaces:
        """Return each place, without misses; its ray, or a ray that begins there, is left out if it is not needed."""
        is_found = self.prim >= 0
        prim, u = self.prim_number[is_found], self.u[is_found].astype(np.float64)
        return self._on_rays(prim, u) if on_rays else HitPlaces.without_rays(prim, u)

    def _on_rays(self, prim: IntArray, u: Float64Array) -> HitPlaces:
        """Return the places of these primitives with their rays."""
        raise NotImplementedError

    def _known(self) -> AnyGeometry:
        if self.geometry is None:
            raise InputError(
                "these hits do not know their geometry: a pickle has `row` and `strand` in its place; query again"
            )
        return self.geometry

    def _filled(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return values of all that was found as float64 in the shape of the answer, NaN for misses."""
        filled = np.full((*self.prim.shape, *values.shape[1:]), np.nan)
        filled[self.prim >= 0] = values
        return filled

    def __copy__(self: Self) -> Self:
        copied = object.__new__(type(self))
        copied.__dict__.update(self.__dict__)
        return copied

    def __deepcopy__(self: Self, memo: dict[int, Any]) -> Self:
        copied = copy.copy(self)
        shared = (*self.unpickled, "row", "strand")  # type: ignore[attr-defined]  # which no answer changes
        copied.__dict__.update({k: copy.deepcopy(v, memo) for k, v in self.__dict__.items() if k not in shared})
        return copied

    def __getstate__(self) -> dict[str, Any]:
        # Pickle the row and the strand of each primitive instead of the geometry.
        known = {"row": self.row, "strand": self.strand} if self.geometry is not None else {}
        kept = {name: value for name, value in self.__dict__.items() if name != "_outwards"}
        return kept | known | dict.fromkeys(self.unpickled)

    def __setstate__(self, state: dict[str, Any]) -> None:
        frozen = {name: own(state[name]) for name in ("row", "strand") if name in state}
        self.__dict__.update(state | frozen)
