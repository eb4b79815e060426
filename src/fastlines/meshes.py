"""Geometry other than lines that a tree can be built on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt

from .arrays import INVALID, FloatArray, choice, list_rows, own_float32, refuse_rows, unusable, warn_of_rounding
from .errors import InputError
from .immutable import Immutable
from .lines import Lines, as_lines


@dataclass(frozen=True, eq=False)
class _Mesh(Immutable):
    """Primitives as an array of their corners."""

    kind: ClassVar[str]
    n_corners: ClassVar[int]

    corners: FloatArray

    def __init__(self, corners: npt.ArrayLike) -> None:
        array = own_float32(corners, self.kind)
        if array.shape == (0,):
            array = array.reshape(0, self.n_corners, 3)
        if array.ndim != 3 or array.shape[1:] != (self.n_corners, 3):
            raise InputError(f"{self.kind} have shape {array.shape}; expected (n, {self.n_corners}, 3)")
        warn_of_rounding(corners, array)
        refuse_rows(unusable(array), self.kind)
        object.__setattr__(self, "corners", array)

    def __len__(self) -> int:
        return len(self.corners)

    @property
    def core_rows(self) -> FloatArray:
        """One row of numbers for each primitive, as the core reads them: (n, 3 · n_corners) float32."""
        return self.corners.reshape(-1, 3 * self.n_corners)


class Triangles(_Mesh):
    """Triangles, as an array of their corners.

    Parameters
    ----------
    corners : (n, 3, 3) array
        Three corners each; converted to float32.

    Examples
    --------
    >>> len(Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]))
    1
    """

    kind = "triangles"
    n_corners = 3


class Boxes(_Mesh):
    """Primitives that are known only by their boxes.

    Parameters
    ----------
    corners : (n, 2, 3) array
        Lowest and highest corner of each; converted to float32.

    Examples
    --------
    >>> len(Boxes([[[0, 0, 0], [1, 1, 1]]]))
    1
    """

    kind = "boxes"
    n_corners = 2

    def __init__(self, corners: npt.ArrayLike) -> None:
        super().__init__(corners)
        inverted: npt.NDArray[np.bool_] = (self.corners[:, 1] - self.corners[:, 0]).min(axis=1, initial=0) < 0
        if inverted.any():
            raise InputError(
                f"{int(inverted.sum())} boxes have a low corner above their high one ({list_rows(inverted)})"
            )


Geometry: TypeAlias = Lines | Triangles | Boxes


def as_geometry(geometry: Geometry | npt.ArrayLike, *, invalid: str = "error") -> Geometry:
    """Return geometry as it is; take an array for segments."""
    choice("invalid", invalid, INVALID)
    return geometry if isinstance(geometry, Geometry) else as_lines(geometry, invalid=invalid)


def core_data(geometry: Geometry) -> tuple[str, FloatArray]:
    """Return what the core calls the primitives that queries test, and their numbers: one row a primitive."""
    return geometry.kind, geometry.core_rows


def spread_data(geometry: Geometry) -> tuple[str, FloatArray]:
    """Return the same for rays with a spread, for which lines without a radius are round cones of radius 0."""
    if not isinstance(geometry, Lines) or geometry.kind not in ("segments", "round cones"):
        raise InputError(f"a spread is for lines, and this tree is over {type(geometry).__name__}; leave out spread=")
    return "spread cones", geometry.cone_rows


def build_data(geometry: Geometry) -> tuple[str, FloatArray]:
    """Return what the core calls the primitives that a tree bounds, and their numbers: the axes of lines."""
    return ("segments", geometry.axes) if isinstance(geometry, Lines) else core_data(geometry)
