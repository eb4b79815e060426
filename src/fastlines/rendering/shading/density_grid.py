"""The density of lines in voxels, from which the number of lines that light crosses is found without a query.

`cpp/fastlines/shading/density_grid.hpp` has the formula.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, box_of
from ...engines import engine
from ...geometry.any_geometry import AnyGeometry
from ...threads import get_num_threads

#: The longest side of the box is divided into so many voxels, which have 24 bytes.
LONGEST = 128
#: Flat boxes are grown to this fraction of the longest side and the largest coordinate.
FLAT = 1e-6


@dataclass(frozen=True, eq=False)
class DensityGrid:
    """How densely lines fill the voxels of their box, and in which directions they run.

    Attributes
    ----------
    corners : (6,) floats
        The low and the high corner of the box.
    counts : three ints
        The numbers of voxels along the axes.
    tensors : tuple of two (n, 6) float32 arrays
        Those of voxels, and of blocks of them.
    radius : float
        The mean radius of the lines.
    """

    corners: tuple[float, ...]
    counts: tuple[int, ...]
    tensors: tuple[FloatArray, FloatArray]
    radius: float

    @classmethod
    def of(cls, geometry: AnyGeometry, radius: float) -> DensityGrid:
        """Fill the grid with all lines of a geometry, whose radii are `radius` larger.

        Examples
        --------
        >>> import fastlines as fl
        >>> wall = fl.lines([[[-1, y, 0], [1, y, 0]] for y in np.linspace(-1, 1, 100)])
        >>> grid = DensityGrid.of(wall, 0.005)
        >>> origin, x, z = np.float32([[[0, 0, -1]], [[1, 0, 0]], [[0, 0, 1]]])
        >>> hidden, _ = grid.optical_depth(origin, x, z, np.full((1, 3), 0.5, np.float32), far=0.1)
        >>> print(hidden.round(1))                              # half of the wall are lines
        [0.5]
        """
        lines = [found for part in geometry.each_part() if (found := part.thick_axes()) is not None]
        axes = np.concatenate([np.empty((0, 2, 3), np.float32), *(axes for axes, _ in lines)])
        radii = np.concatenate([np.empty((0, 2), np.float32), *(radii for _, radii in lines)])
        low, high = box_of(axes.reshape(-1, 3)).astype(np.float64) if len(axes) else np.zeros((2, 3))
        longest = float((high - low).max()) or 1.0
        sides = np.maximum(high - low, FLAT * (longest + np.abs([low, high]).max()))
        counts = np.clip(np.round(sides / longest * LONGEST), 1, LONGEST).astype(np.int64)
        middle = (low + high) / 2
        corners = tuple(np.concatenate([middle - sides / 2, middle + sides / 2]).tolist())
        box = corners, tuple(counts.tolist())
        tensors = engine.density_grid(axes, radii, radius, box, get_num_threads(), None)
        return cls(*box, tensors, radius + float(radii.mean(dtype=np.float64)) if len(radii) else radius)

    def optical_depth(
        self,
        points: FloatArray,
        tangents: FloatArray,
        towards: FloatArray,
        jitter: FloatArray,
        far: float,
        end: float = np.inf,
    ) -> tuple[FloatArray, FloatArray]:
        """Return the optical depth: the mean number of lines that light crosses on its way to points of lines.

        Parameters
        ----------
        points, tangents, towards : (n, 3) float32
            The points, unit vectors along their lines, and unit vectors towards the light. The line of a point does not
            count.
        jitter : (n, 3) float32
            Uniform random numbers, which jitter the points by the width of a voxel, so that its border does not show.
        far, end : float
            Two distances; `end` is not below `far`.

        Returns
        -------
        all, far : (n,) float32
            All lines up to the distance `end`, and those of them that are beyond `far`.
        """
        box = self.corners, self.counts
        return engine.optical_depth(box, *self.tensors, points, tangents, towards, jitter, self.radius, far, end)
