"""The top tree of a forest: which tiles a ray, a point or a box may have to do with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .. import _core
from ..arrays import FloatArray, IntArray
from ..engines import engine
from ..geometry.hit_places import Float64Array
from ..progress import ProgressCallback
from ..query.proximity.points import PointBatch
from ..query.rays import RayBatch
from ..support.computed_once import computed_once
from ..threads import get_num_threads


@dataclass(frozen=True, eq=False)
class TopTree:
    """A wide tree over the boxes of tiles. What it returns is conservative, and decides no answer.

    Lists of tiles are compressed sparse rows: those of row i are from ``offsets[i]`` up to ``offsets[i + 1]``.
    """

    #: (n_tiles, 2, 3) float32: the boxes around the axes of the primitives of each tile.
    boxes: FloatArray
    #: (n_tiles,) float32: the largest of their radii.
    max_radius: FloatArray
    #: (2, 3) float32: the frame of the forest.
    frame: FloatArray

    def __len__(self) -> int:
        return len(self.boxes)

    @computed_once
    def core(self) -> _core.TopTree:
        """The compiled tree."""
        low, high = self.frame.astype(np.float32).tolist()
        boxes, radius = (np.ascontiguousarray(array, np.float32) for array in (self.boxes, self.max_radius))
        return _core.TopTree(boxes, radius, (*low, *high))

    def tiles_of_rays(
        self, rays: RayBatch, progress: ProgressCallback | None = None
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Return the tiles that each ray may have hits in, in the order in which the ray meets them.

        Returns
        -------
        offsets, tile, enter
            ``enter`` is a lower bound of the t of hits in the tile, in units of the ray's direction.
        """
        return self.routes(rays, progress).arrays()

    def routes(self, rays: RayBatch, progress: ProgressCallback | None = None) -> _core.RayRoutes:
        """Return the same, as the walks of the core take it."""
        found: _core.RayRoutes = engine.ray_routes(self.core, rays.arrays(), get_num_threads(), progress)
        return found

    def first_tile(self, rays: RayBatch, progress: ProgressCallback | None = None) -> IntArray:
        """Return the first tile that each ray meets, or -1."""
        offsets, tile, _ = self.tiles_of_rays(rays, progress)
        found = np.full(len(rays), -1, np.int64)
        has_any = np.diff(offsets) > 0
        found[has_any] = tile[offsets[:-1][has_any]]
        return found

    def nearest_tiles(
        self, points: PointBatch, k: int, progress: ProgressCallback | None = None
    ) -> tuple[Float64Array, IntArray]:
        """Return the k tiles that may be nearest to each point, and lower bounds of their distances, (n, k) each.

        They are sorted by that. If there are fewer, the tile is -1, at infinity. Distances to surfaces are negative
        inside.
        """
        return self.core.nearest_tiles(points.points, k, points.surface, get_num_threads(), progress)

    def tiles_within(self, points: PointBatch, radius: FloatArray) -> tuple[IntArray, IntArray]:
        """Return the tiles that may be within the radius of each point, (n,) or (1,): offsets and tiles."""
        return self.core.tiles_within(points.points, np.ascontiguousarray(radius, np.float32), points.surface)

    def tiles_in_boxes(self, low: npt.ArrayLike, high: npt.ArrayLike) -> tuple[IntArray, IntArray]:
        """Return the tiles of which a part, with its radius, may be in each box, (n, 3) corners: offsets and tiles."""
        low, high = (np.ascontiguousarray(corner, np.float64).reshape(-1, 3) for corner in (low, high))
        return self.core.tiles_in_boxes(low, high, True)
