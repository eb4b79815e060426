"""Primitives that a query has found: rows, strands, tangents and attributes, in the shape of the answer."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..geometry.hit_places import Float64Array, HitPlaces
from .prim_numbers import PrimNumbers


class FoundPrims(PrimNumbers):
    """Primitives of a geometry, with a place u on each; -1 is a miss. Floats are NaN for a miss."""

    u: FloatArray
    distance: FloatArray

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

    def _filled(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return values of all that was found as float64 in the shape of the answer, NaN for misses."""
        filled = np.full((*self.prim.shape, *values.shape[1:]), np.nan)
        filled[self.prim >= 0] = values
        return filled
