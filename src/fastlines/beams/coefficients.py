"""Checks of coefficients and of power in red, green and blue, of points, directions, boxes and parts of a scene."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import list_rows, to_float64
from ..camera import Vector
from ..errors import InputError
from ..support.counter_random import Float64Array
from ..support.vectors import dot

BoolArray: TypeAlias = npt.NDArray[np.bool_]


#: The largest coefficient or power: float32 holds the product of two.
LARGEST = 1e18


def rgb(name: str, value: npt.ArrayLike, unit: str, most: float = LARGEST) -> Vector:
    """Check a number for all channels, or three numbers, from 0 to `most`.

    Examples
    --------
    >>> rgb("power", 2, "in watts")
    (2.0, 2.0, 2.0)
    """
    given = to_float64(value, name)
    if given.shape not in ((), (3,)) or not np.isfinite(given).all() or given.min() < 0 or given.max() > most:
        raise InputError(f"{name}={value!r}; expected a number, or red, green and blue, from 0 to {most:g}, {unit}")
    red, green, blue = np.broadcast_to(given, 3).tolist()
    return red, green, blue


def point(name: str, value: npt.ArrayLike) -> Vector:
    """Check a point: three finite numbers."""
    given = to_float64(value, name)
    if given.shape != (3,) or not np.isfinite(given).all():
        raise InputError(f"{name}={value!r}; expected three finite numbers: x, y, z")
    x, y, z = given.tolist()
    return x, y, z


def unit_direction(name: str, value: npt.ArrayLike) -> Vector:
    """Check a direction, and return it at length one.

    Examples
    --------
    >>> unit_direction("direction", (0, 3, 4))
    (0.0, 0.6, 0.8)
    """
    given = np.array(point(name, value))
    if not given.any():
        raise InputError(f"{name}={value!r} has no length; expected a direction, such as (0, -1, 0)")
    given /= np.abs(given).max()
    x, y, z = (given / np.sqrt((given**2).sum())).tolist()
    return x, y, z


def unit_rays(origins: npt.ArrayLike, directions: npt.ArrayLike) -> tuple[Float64Array, Float64Array]:
    """Check rays, or one, and return them as (n, 3) float64 each, with unit directions.

    Examples
    --------
    >>> unit_rays([[0, 0, 0], [1, 0, 0]], [0, 0, 2])[1].tolist()
    [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]
    """
    given = to_float64(origins, "origins"), to_float64(directions, "directions")
    several = {len(array) for array in given if array.ndim == 2} - {1}
    if any(array.ndim not in (1, 2) or array.shape[-1] != 3 for array in given) or len(several) > 1:
        shapes = f"{given[0].shape} and {given[1].shape}"
        raise InputError(f"origins and directions have shapes {shapes}; expected (n, 3) each: x, y, z of each ray")
    starts, ways = (np.array(array) for array in np.broadcast_arrays(*map(np.atleast_2d, given)))
    length = np.sqrt(dot(ways, ways))
    bad = ~(np.isfinite(starts).all(axis=1) & np.isfinite(length) & (length > 0))
    if bad.any():
        raise InputError(f"{int(bad.sum())} of {len(bad)} rays are not finite, or have no direction ({list_rows(bad)})")
    return starts, ways / length[:, None]


def has_member(value: object, name: str) -> bool:
    """Return whether a value is an object with a member of this name, and not a class."""
    return not isinstance(value, type) and hasattr(value, name)


def check_box(name: str, box: npt.ArrayLike) -> Float64Array:
    """Check a box of some volume: its lowest and highest corner, (2, 3)."""
    corners = to_float64(box, name)
    if corners.shape != (2, 3) or not np.isfinite(corners).all() or not (corners[1] > corners[0]).all():
        raise InputError(f"{name}={corners.tolist()}; expected [[x, y, z], [x, y, z]]: its lowest and highest corner")
    return corners
