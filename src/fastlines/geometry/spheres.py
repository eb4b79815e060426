"""Spheres: round cones whose axis is a point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, own_float32
from ..errors import InputError
from ..support.immutable import own
from .lines import Lines
from .offsets import reduced


class Spheres(Lines):
    """Spheres, with all that `Lines` have; each is a segment of length zero with a radius.

    Queries answer with `u` = 0 and no tangents, and `distance` is that of the centre.

    Examples
    --------
    >>> import fastlines as fl
    >>> spheres = fl.Spheres.from_centres([[0, 0, 0], [4, 0, 0]], radius=[1, 2])
    >>> hits = fl.build(spheres).first_hit([[0, 0, -9], [4, 1, -9]], [0, 0, 1], at="surface")
    >>> print(hits.prim, hits.t.round(3))
    [0 1] [8.    7.268]
    """

    run = 1
    noun = "spheres"
    has_directions = False

    @property
    def centres(self) -> FloatArray:
        """The centre of each sphere, (n, 3) float32."""
        return self.segments[:, 0]

    @classmethod
    def from_centres(
        cls,
        centres: npt.ArrayLike,
        radius: npt.ArrayLike,
        *,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        offset: Any = None,
        invalid: str = "error",
    ) -> Spheres:
        """Make spheres.

        Parameters
        ----------
        centres : (n, 3) array
            Converted to float32.
        radius : number or (n,) array
            One for all or one for each, in the unit of the centres.
        attributes : mapping of str to array of n rows, optional
        offset, invalid
            As in `Lines.from_segments`.

        Raises
        ------
        InputError
            If the shape, the type or a value cannot be used.
        """
        centres, facts = reduced(centres, offset)
        points = own_float32(centres, "centres")
        if points.shape == (0,):
            points = points.reshape(0, 3)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(f"centres have shape {points.shape}; expected (n, 3): x y z of each sphere")
        radii = own_float32(radius, "radius")
        ends = own(np.stack([points, points], axis=1))
        made = cls.from_segments(ends, radius=radii, attributes=attributes or {}, invalid=invalid)
        assert isinstance(made, cls)
        return replace(made, metadata=facts) if facts else made

    def _check_columns(self) -> None:
        super()._check_columns()
        if self.radius is None or self.radius.ndim != 1:
            raise InputError(
                f"spheres take a radius of shape ({len(self)},), one for each; Spheres.from_centres checks it"
            )
        if not np.array_equal(self.segments[:, 0], self.segments[:, 1]):
            raise InputError("spheres have segments of length zero; Spheres.from_centres makes them of centres")
