"""How lines are made of the objects of other libraries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import AnyArray
from .offsets import Offset

#: How far the polylines of arcs and splines may be from these by default, as a fraction of the longest side of the box
#: of each.
OF_SIZE = 1e-5

#: What a warning says of points without z.
FLAT = "the points have two coordinates, x and y; z is 0"


@dataclass(frozen=True)
class Making:
    """How lines are made of an object.

    Attributes
    ----------
    invalid, offset
        As in `Lines.from_segments`.
    warn : callable
        Takes what is left out, in words.
    tolerance : float, optional
        How far the polylines of arcs and splines may be from these; by default `OF_SIZE` of the size of each.
    """

    invalid: str
    offset: Offset | str
    warn: Callable[[str], None]
    tolerance: float | None = None

    @property
    def options(self) -> dict[str, Any]:
        """The options of `Lines.from_segments` and its siblings."""
        return {"invalid": self.invalid, "offset": self.offset}


def has(obj: object, *names: str) -> bool:
    """Return whether an object has all attributes of these names, by which it is recognised."""
    return all(hasattr(obj, name) for name in names)


def flat_column(values: AnyArray) -> AnyArray:
    """Return values without a last dimension of size 1."""
    return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values


def in_space(points: Any, how: Making) -> AnyArray:
    """Return points (…, 2) with z = 0, and warn."""
    how.warn(FLAT)
    return with_z(points)


def with_z(points: Any) -> AnyArray:
    """Return points (…, 2) with z = 0."""
    array = np.asarray(points)
    return np.concatenate([array, np.zeros_like(array[..., :1])], axis=-1)
