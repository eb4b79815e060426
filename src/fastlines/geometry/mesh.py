"""Primitives as an array of their corners."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..arrays import (
    SHIFT_ADVICE,
    FloatArray,
    IntArray,
    box_of,
    column,
    own_float32,
    refuse_rows,
    unusable,
    warn_of_rounding,
)
from ..errors import InputError
from ..support.computed_once import computed_once
from ..support.immutable import frozen
from .any_geometry import AnyGeometry
from .hit_places import Float64Array
from .shapes import shape_rows


@dataclass(frozen=True, eq=False)
class Mesh(AnyGeometry):
    """Primitives as an array of their corners."""

    kind: ClassVar[str] = "shapes"
    can_be_part = True
    #: The primitives' name, and that of one of them.
    name: ClassVar[str]
    word: ClassVar[str]
    shape: ClassVar[int]
    n_corners: ClassVar[int]

    corners: FloatArray
    attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    corner_attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)

    def __init__(
        self,
        corners: npt.ArrayLike,
        *,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        corner_attributes: Mapping[str, npt.ArrayLike] | None = None,
    ) -> None:
        array = own_float32(corners, self.name)
        if array.shape == (0,):
            array = array.reshape(0, self.n_corners, 3)
        if array.ndim != 3 or array.shape[1:] != (self.n_corners, 3):
            raise InputError(f"{self.name} have shape {array.shape}; expected (n, {self.n_corners}, 3)")
        warn_of_rounding(corners, array, SHIFT_ADVICE)
        refuse_rows(unusable(array), self.name)
        object.__setattr__(self, "corners", array)
        for kind, given in (("attributes", attributes), ("corner_attributes", corner_attributes)):
            columns = {name: column(values, name, len(array), self.name) for name, values in (given or {}).items()}
            object.__setattr__(self, kind, frozen(columns))
        for name, values in self.corner_attributes.items():
            if values.shape[:2] != (len(array), self.n_corners):
                raise InputError(
                    f"{name} has shape {values.shape}; expected ({len(array)}, {self.n_corners}, …): a value for each "
                    f"corner of the {self.name}"
                )

    def __len__(self) -> int:
        return len(self.corners)

    def __repr__(self) -> str:
        has = [self.count_text(), *self.attributes, *self.corner_attributes]
        return f"<{type(self).__name__}: {', '.join(has)}>"

    @property
    def noun(self) -> str:
        """What the primitives are called, in the plural."""
        return self.name

    @computed_once
    def core_rows(self) -> FloatArray:
        """One row of numbers for each primitive, as the core reads them: (n, 10) float32."""
        return shape_rows(self.shape, self.corners.reshape(-1, 3 * self.n_corners))

    @property
    def bounds(self) -> FloatArray:
        """The box of all primitives as (2, 3): lowest and highest corner; lowest > highest if there are none."""
        return box_of(self.corners.reshape(-1, 3))

    # --- What a kind of geometry answers ---

    @property
    def takes_radius(self) -> bool:
        """See `AnyGeometry`."""
        return False

    def span(self) -> tuple[FloatArray, FloatArray]:
        """Return the corners."""
        points = self.corners.reshape(-1, 3)
        return points, np.zeros(len(points), np.float32)

    @property
    def place_attributes(self) -> Mapping[str, npt.NDArray[Any]]:
        """The values at the corners."""
        return self.corner_attributes

    def sample_needs_rays(self, name: str) -> bool:
        """Values at corners are interpolated at the points of hits."""
        return name in self.corner_attributes

    def place_of(self, name: str) -> str:
        """See `AnyGeometry`."""
        return "corner" if name in self.corner_attributes else self.word

    def drawn(self, rows: IntArray) -> Sequence[AnyGeometry]:
        """See `AnyGeometry`."""
        return (type(self)(self.corners[rows]),)

    def outlines(self) -> tuple[Float64Array, Float64Array]:
        """Return the corners."""
        return self.corners.astype(np.float64), np.zeros(self.corners.shape[:2])
