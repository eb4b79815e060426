"""Balls as a class of one's own: what the soak tests user primitives with. It is written into tests as it stands."""

from __future__ import annotations

from typing import Any

import numpy as np


class Balls:
    """Solid balls, which are larger by the radius of a query."""

    def __init__(self, centres: Any, radius: Any) -> None:
        self.centre, self.own = np.asarray(centres, np.float64), np.asarray(radius, np.float64)

    def bounds(self) -> Any:
        """See `fastlines.Primitives`."""
        return np.stack([self.centre - self.own[:, None], self.centre + self.own[:, None]], axis=1)

    def hit(self, ids: Any, rays: Any, radius: Any) -> Any:
        """See `fastlines.Primitives`."""
        d2 = (rays.directions**2).sum(axis=1)
        from_centre = rays.origins - self.centre[ids]
        middle = -(from_centre * rays.directions).sum(axis=1) / d2
        nearest = from_centre + middle[:, None] * rays.directions
        half2 = ((self.own[ids] + radius) ** 2 - (nearest**2).sum(axis=1)) / d2
        half = np.sqrt(np.maximum(half2, 0))
        t, t_out = np.maximum(middle - half, rays.t_min), np.minimum(middle + half, rays.t_max)
        return {"t": np.where((half2 >= 0) & (t <= t_out), t, np.inf), "t_out": t_out}

    def nearest(self, ids: Any, points: Any) -> Any:
        """See `fastlines.Primitives`; negative inside."""
        away = points - self.centre[ids]
        return {"distance": np.sqrt((away**2).sum(axis=1)) - self.own[ids]}

    def in_box(self, ids: Any, low: Any, high: Any) -> Any:
        """See `fastlines.Primitives`."""
        outside = np.maximum(np.maximum(low - self.centre[ids], self.centre[ids] - high), 0)
        return np.sqrt((outside**2).sum(axis=1)) <= self.own[ids]
