"""The parts of heads of hair: a head, strands that fall along it, and points evenly spaced along a strand.

y points up, z to the face, x from the right ear to the left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..camera import Float64Array, Vector
from ..geometry.lines import Lines

#: The middle of the scalp as a direction from the middle of the head: up, and back from the forehead.
CROWN = np.array([0.0, 0.876, -0.482])


@dataclass(frozen=True)
class Head:
    """An ellipsoid with hair on the part around the crown."""

    centre: Vector
    radii: Vector

    def roots(self, uniform: Float64Array, hairline: float = 0.09) -> Float64Array:
        """Place roots evenly over the scalp: unit vectors (s, 3) from the middle of the head, which `at` takes to it.

        `uniform` (s, 2) is random in [0, 1); `hairline` is the cosine of the angle between the crown and the hairline.
        """
        cosine = 1 - (1 - hairline) * uniform[:, :1]
        sine = np.sqrt(1 - cosine**2)
        azimuth = 2 * np.pi * uniform[:, 1:]
        across = np.array([1.0, 0.0, 0.0])
        along = np.cross(CROWN, across)
        return np.asarray(cosine * CROWN + sine * (np.cos(azimuth) * across + np.sin(azimuth) * along))

    def at(self, directions: Float64Array, height: npt.ArrayLike = 0.0) -> Float64Array:
        """Find points at a height above the surface, for unit vectors (..., 3) and heights (...)."""
        return np.asarray(self.centre + directions * (self.radii + np.asarray(height)[..., None]))

    def push_out(self, points: Float64Array, height: npt.ArrayLike = 0.0) -> Float64Array:
        """Move points (..., 3) that are lower than a height (...) above the surface up to it."""
        from_centre = points - self.centre
        depth = unit_length(from_centre / (self.radii + np.asarray(height)[..., None]))
        return np.asarray(self.centre + from_centre / np.minimum(depth, 1))

    def fall(
        self,
        roots: Float64Array,
        directions: Float64Array,
        height: Float64Array,
        pull: Float64Array,
        length: float,
        n_steps: int,
    ) -> Float64Array:
        """Let strands grow from their roots, fall, and slide down along the head: (s, n_steps + 1, 3).

        They start at `roots` (s, 3) in the unit `directions` (s, 3), with a least `height` (s,) above the head. `pull`
        (s, 3) is the change of a strand's unit direction per unit of length: gravity, and other bending.
        """
        step = length / n_steps
        points = [self.at(roots)]
        for i in range(n_steps):
            directions = unit(directions + step * pull)
            # Rise to the full height over the first steps: the root itself is on the skin.
            low = height * min(1.0, (i + 1) / 8)
            points.append(self.push_out(points[-1] + step * directions, low))
            directions = unit(points[-1] - points[-2])
        return np.stack(points, axis=1)


def unit_length(vectors: Float64Array) -> Float64Array:
    """Return the lengths of vectors (..., 3), as (..., 1)."""
    return np.asarray(np.sqrt((vectors**2).sum(axis=-1, keepdims=True)))


def unit(vectors: Float64Array) -> Float64Array:
    """Scale vectors (..., 3) to the length 1."""
    return np.asarray(vectors / unit_length(vectors))


def resample(strands: Float64Array, n_segments: int, last: npt.NDArray[np.int64] | None = None) -> Float64Array:
    """Find points at equal distances along strands (s, m, 3), whose points may repeat: (s, n_segments + 1, 3).

    With `last` (s, 1) each strand ends at this point.

    Examples
    --------
    >>> corner = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 3, 0]]])
    >>> resample(corner, 2).tolist()
    [[[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 3.0, 0.0]]]
    """
    if last is not None:
        kept = np.minimum(np.arange(strands.shape[1]), last)
        strands = np.take_along_axis(strands, kept[..., None], axis=1)
    n_strands = len(strands)
    if n_strands == 0:
        return np.empty((0, n_segments + 1, 3))
    along = np.cumsum(unit_length(np.diff(strands, axis=1, prepend=strands[:, :1]))[..., 0], axis=1)
    along /= along[:, -1:]
    # One call for all: strand i takes the numbers from 2i to 2i + 1.
    offset = 2.0 * np.arange(n_strands)[:, None]
    wanted = (np.linspace(0, 1, n_segments + 1) + offset).ravel()
    known = (along + offset).ravel()
    columns = [np.interp(wanted, known, strands[..., axis].ravel()) for axis in range(3)]
    return np.stack(columns, axis=1).reshape(n_strands, n_segments + 1, 3)


def to_lines(strands: Float64Array, n_segments: int) -> Lines:
    """Make lines of the first segments of strands (s, m, 3)."""
    segments = np.stack([strands[:, :-1], strands[:, 1:]], axis=2).reshape(-1, 2, 3)
    numbers = np.repeat(np.arange(len(strands)), strands.shape[1] - 1)
    return Lines.from_segments(segments[:n_segments], strands=numbers[:n_segments])
