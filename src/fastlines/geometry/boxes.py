"""Boxes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from ..arrays import (
    list_rows,
)
from ..errors import InputError
from .mesh import Mesh
from .shapes import BOX


class Boxes(Mesh):
    """Solid boxes.

    A ray hits a box where it is inside. The radius of a query does not count.

    Parameters
    ----------
    corners : (n, 2, 3) array
        Lowest and highest corner of each; converted to float32.
    attributes : mapping of str to array of n rows, optional

    Examples
    --------
    >>> import fastlines as fl
    >>> hits = fl.build(Boxes([[[0, 0, 0], [1, 1, 1]]])).first_hit([0.5, 0.5, -1], [0, 0, 1], at="surface")
    >>> print(hits.t, hits.t_out)
    1.0 2.0
    """

    name = "boxes"
    shape = BOX
    n_corners = 2

    def __init__(self, corners: npt.ArrayLike, *, attributes: Mapping[str, npt.ArrayLike] | None = None) -> None:
        super().__init__(corners, attributes=attributes)
        inverted: npt.NDArray[np.bool_] = (self.corners[:, 1] - self.corners[:, 0]).min(axis=1, initial=0) < 0
        if inverted.any():
            raise InputError(
                f"{int(inverted.sum())} boxes have a low corner above their high one ({list_rows(inverted)})"
            )
