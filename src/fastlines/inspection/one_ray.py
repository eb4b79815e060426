"""The origin and the direction of one ray, checked."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import to_float64
from ..errors import InputError
from ..geometry.hit_places import Float64Array


def check_ray(origin: npt.ArrayLike, direction: npt.ArrayLike) -> tuple[Float64Array, Float64Array]:
    """Return the origin and the direction of a ray, (3,) float64 each.

    Raises
    ------
    InputError
        If they are not three finite numbers each, or the direction has length zero.

    Examples
    --------
    >>> check_ray([0, 0, -5], [0, 0, 1])
    (array([ 0.,  0., -5.]), array([0., 0., 1.]))
    """
    start, along = _vector("origin", origin), _vector("direction", direction)
    if not along.any():
        raise InputError("direction is 0, 0, 0, and so has length zero; expected another one")
    return start, along


def _vector(name: str, vector: npt.ArrayLike) -> Float64Array:
    values = to_float64(vector, name)
    if values.shape != (3,):
        raise InputError(f"{name} has shape {values.shape}; expected three numbers each, those of one ray")
    if not np.isfinite(values).all():
        raise InputError(
            f"{name} is {', '.join(f'{value:g}' for value in values)}, which is not finite; expected three numbers"
        )
    return values
