"""Primitives that a query has found: rows, strands, tangents and attributes, in the shape of the answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..geometry.any_geometry import AnyGeometry
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
        return self._at_places(False, lambda geometry, places: geometry.tangents_at(places))

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

    def _at_places(self, on_rays: bool, vectors: Callable[[AnyGeometry, HitPlaces], npt.NDArray[Any]]) -> Float64Array:
        """Return a vector for each place, NaN for misses."""
        geometry = self._known()
        return self._filled(vectors(geometry, self._places(on_rays=on_rays, misses=geometry.takes_misses)))

    def _places(self, *, on_rays: bool = True, misses: bool = False) -> HitPlaces:
        """Return each place; its ray, or a ray that begins there, is left out if it is not needed."""
        prim, u = self.prim_number.reshape(-1), self.u.reshape(-1)
        rows = None
        if not misses and not (is_found := prim >= 0).all():
            rows = np.flatnonzero(is_found)
            prim, u = prim[rows], u[rows]
        exact: Float64Array = u.astype(np.float64)
        return self._on_rays(prim, exact, rows) if on_rays else HitPlaces.without_rays(prim, exact)

    def _on_rays(self, prim: IntArray, u: Float64Array, rows: IntArray | None) -> HitPlaces:
        """Return the places of these primitives with their rays: all places, or those in some rows."""
        raise NotImplementedError

    def _filled(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return values of all that was found as float64 in the shape of the answer, NaN for misses."""
        if len(values) == self.prim.size:
            return np.asarray(values, np.float64).reshape((*self.prim.shape, *values.shape[1:]))
        filled = np.full((self.prim.size, *values.shape[1:]), np.nan)
        filled[self.prim.reshape(-1) >= 0] = values
        return filled.reshape((*self.prim.shape, *values.shape[1:]))
