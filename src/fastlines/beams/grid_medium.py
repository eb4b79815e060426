"""A medium on a grid: smoke, clouds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray, to_float64
from ..camera import Vector
from ..errors import InputError
from ..support.counter_random import Float64Array
from ..support.immutable import frozen
from .coefficients import LARGEST, check_box
from .medium import Coefficients, Sources

#: How many steps a path takes through a voxel, across the longest axis of a grid.
STEPS_PER_VOXEL = 2
#: How many pieces a beam is cut into, a voxel.
PIECES_PER_VOXEL = 2
#: For which extinction along a piece it is cut further, and into how many at most.
MAX_DECAY, MAX_CUTS = 0.1, 8
#: How many places of a grid are looked up at a time.
LOOKUPS = 1 << 20


@dataclass(frozen=True, eq=False)
class GridMedium(Coefficients):
    """A medium whose density is given at the centres of voxels, linear in between.

    Parameters
    ----------
    density : (nx, ny, nz) array
        What absorption and scattering are multiplied by; not negative.
    box : (2, 3) array
        The lowest and the highest corner of the grid. The medium is nowhere else.
    absorption, scattering, g
        As in `HomogeneousMedium`, where the density is 1.

    Raises
    ------
    InputError
        If the density holds NaN or a negative number, or is 0 everywhere; if the box is empty; and as in
        `HomogeneousMedium`.

    Examples
    --------
    >>> smoke = GridMedium(np.ones((2, 2, 2)), [[0, 0, 0], [1, 1, 1]], absorption=0, scattering=2)
    >>> t, depth = smoke.distance_at(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]]), np.array([1.0]), np.array([0.25]))
    >>> t.tolist(), depth.tolist()
    ([0.25], [0.25])
    """

    density: FloatArray
    box: Float64Array
    absorption: Vector
    scattering: Vector
    g: float = 0.0
    #: How many equal steps a path takes.
    n_steps: int = field(default=0, init=False, repr=False)

    def __init__(
        self,
        density: npt.ArrayLike,
        box: npt.ArrayLike,
        absorption: npt.ArrayLike,
        scattering: npt.ArrayLike,
        g: float = 0.0,
    ) -> None:
        corners, grid = check_box("box", box), to_float64(density, "density")
        if grid.ndim != 3 or not grid.size:
            raise InputError(f"density has shape {grid.shape}; expected (nx, ny, nz): one number for each voxel")
        if bad := int((~np.isfinite(grid)).sum()):
            raise InputError(f"density holds NaN or Inf in {bad} of {grid.size} voxels; give each a finite number")
        if grid.min() < 0 or not 0 < grid.max() <= LARGEST:
            raise InputError(
                f"density is from {grid.min():g} to {grid.max():g}; expected numbers from 0 to {LARGEST:g}, and some "
                "above 0"
            )
        values = {"density": grid.astype(np.float32), "box": corners, "n_steps": STEPS_PER_VOXEL * max(grid.shape) + 1}
        for name, value in values.items():
            object.__setattr__(self, name, frozen(value))
        for name, given in (("absorption", absorption), ("scattering", scattering), ("g", g)):
            object.__setattr__(self, name, given)
        self._check()

    def density_at(self, points: Float64Array) -> Float64Array:
        """Return the density at points (n, 3); outside the box it is that of the nearest voxel."""
        shape = np.array(self.density.shape)
        place = (points - self.box[0]) / (self.box[1] - self.box[0]) * shape - 0.5
        place = np.clip(place, 0, shape - 1)
        low = np.minimum(place.astype(np.int64), np.maximum(shape - 2, 0))
        part = place - low
        step = (shape > 1) * np.array([shape[1] * shape[2], shape[2], 1])
        first = low @ np.array([shape[1] * shape[2], shape[2], 1])
        flat, found = self.density.reshape(-1), np.zeros(len(points))
        for x, y, z in np.ndindex(2, 2, 2):
            weight = np.ones(len(points))
            for axis, high in enumerate((x, y, z)):
                weight *= part[:, axis] if high else 1 - part[:, axis]
            found += weight * flat[first + x * step[0] + y * step[1] + z * step[2]]
        return found

    def columns(self, origins: Float64Array, directions: Float64Array, lengths: Float64Array) -> Float64Array:
        """Return the column depth at `n_steps` equal steps of paths, from 0 to their lengths, (n, n_steps)."""
        depth = np.empty((len(origins), self.n_steps))
        for rows, columns in self._columns(origins, directions, lengths):
            depth[rows] = columns
        return depth

    def _columns(
        self, origins: Float64Array, directions: Float64Array, lengths: Float64Array
    ) -> Iterator[tuple[slice, Float64Array]]:
        """Yield rows of `columns`, so many at a time that memory does not grow with the grid."""
        parts = np.linspace(0, 1, self.n_steps)
        block = max(LOOKUPS // self.n_steps, 1)
        for begin in range(0, len(origins), block):
            rows = slice(begin, begin + block)
            way = (directions[rows] * lengths[rows, None])[:, None] * parts[:, None]
            density = self.density_at((origins[rows, None] + way).reshape(-1, 3)).reshape(-1, self.n_steps)
            steps = (density[:, 1:] + density[:, :-1]) * (lengths[rows, None] / (2 * (self.n_steps - 1)))
            columns = np.zeros(density.shape)
            np.cumsum(steps, axis=1, out=columns[:, 1:])
            yield rows, columns

    def distance_at(
        self, origins: Float64Array, directions: Float64Array, lengths: Float64Array, depths: Float64Array
    ) -> tuple[Float64Array, Float64Array]:
        """See `Medium`."""
        step, before, after, whole = np.empty((4, len(origins)))
        for rows, columns in self._columns(origins, directions, lengths):
            above = np.clip((columns < depths[rows, None]).sum(axis=1), 1, self.n_steps - 1)
            each = np.arange(len(above))
            step[rows], whole[rows] = above - 1, columns[:, -1]
            before[rows], after[rows] = columns[each, above - 1], columns[each, above]
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.where(after > before, (depths - before) / (after - before), 0.0)
        t = lengths * (step + part) / (self.n_steps - 1)
        return np.where(depths >= whole, lengths, t), np.minimum(depths, whole)

    def gather_options(
        self, origins: Float64Array, directions: Float64Array, lengths: Float64Array
    ) -> Mapping[str, Any]:
        """See `Medium`."""
        depths = self.columns(origins, directions, lengths)[..., None] * self.extinction
        return {"optical_depth": depths.astype(np.float32)}

    def transmittance(self, origins: Float64Array, directions: Float64Array, lengths: Float64Array) -> Float64Array:
        """See `Medium`."""
        whole = np.empty((len(origins), 1))
        for rows, columns in self._columns(origins, directions, lengths):
            whole[rows] = columns[:, -1:]
        return np.exp(-whole * self.extinction)

    def sources(self, segments: FloatArray, decay: Float64Array) -> Sources:
        """See `Medium`; beams are cut into pieces of at most half a voxel, and shorter ones where the medium is dense.

        A piece has the density of its middle, and the mean of the power that is left along it.
        """
        start, way = segments[:, 0].astype(np.float64), np.diff(segments.astype(np.float64), axis=1)[:, 0]
        length = np.sqrt((way**2).sum(axis=1))
        voxel = ((self.box[1] - self.box[0]) / self.density.shape).min()
        beam, part = _cut(np.tile([0.0, 1.0], (len(segments), 1)), length * PIECES_PER_VOXEL / voxel)
        column = self.density_at(start[beam] + way[beam] * part.mean(axis=1)[:, None]) * _length(part) * length[beam]
        piece, part = _cut(part, np.minimum(column * decay.max() / MAX_DECAY, MAX_CUTS))
        beam = beam[piece]
        ends = start[beam, None] + way[beam, None] * part[..., None]

        # Add up the column depth of each beam to the start of its pieces.
        density = self.density_at(ends.mean(axis=1))
        column = density * _length(part) * length[beam]
        total = np.cumsum(column) - column
        to_start = total - total[np.searchsorted(beam, beam)]
        depth = column[:, None] * decay
        mean = np.divide(-np.expm1(-depth), depth, out=np.ones_like(depth), where=depth > 0)
        scattered = density[:, None] * self.scattering * np.exp(-to_start[:, None] * decay) * mean
        return Sources(ends.astype(np.float32), beam, scattered, np.zeros(3))


def _cut(parts: Float64Array, counts: Float64Array) -> tuple[IntArray, Float64Array]:
    """Cut intervals, (m, 2), into equal ones, at least 1 each; return the interval that each is a part of, and all."""
    whole = np.maximum(np.ceil(counts), 1).astype(np.int64)
    of = np.repeat(np.arange(len(parts)), whole)
    number_of = np.arange(len(of)) - (np.cumsum(whole) - whole)[of]
    steps = (number_of[:, None] + [0, 1]) / whole[of, None]
    return of, parts[of, :1] + _length(parts)[of, None] * steps


def _length(intervals: Float64Array) -> Float64Array:
    return intervals[:, 1] - intervals[:, 0]
