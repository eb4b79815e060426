"""What a picture is shaded with: the tree, the camera, the lights, and what can be seen from a point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray
from ...camera import Camera
from ...geometry.any_geometry import AnyGeometry
from ...support.computed_once import computed_once
from ...tree import Tree
from .density_grid import DensityGrid
from .depth import View
from .depth_tone import PROBE, SPOT, THIN, Tone, pixel_size, probe
from .lighting import Rig

#: Lines without a radius are counted within this multiple of the radius of a shadow ray, each for less.
WIDE = 3.0


@dataclass(frozen=True)
class ShadingContext:
    """What the fragments of a picture are shaded with.

    Attributes
    ----------
    tree : Tree
    radius : float
        Added to the radius of the lines.
    camera : Camera
    rig : Rig
    pixel : float
        The side of a pixel at the middle of the geometry.
    thin : bool
        Whether lines are thinner than a pixel, so that they have no surfaces to see.
    """

    tree: Tree
    radius: float
    camera: Camera
    rig: Rig
    pixel: float
    thin: bool

    @classmethod
    def of(cls, tree: Tree, camera: Camera, height: int, radius: float, rig: Rig) -> ShadingContext:
        """Return the context of a picture of some height."""
        pixel = pixel_size(tree.geometry, camera, height)
        largest = radius + tree.geometry.max_radius
        thin = tree.geometry.takes_spread and largest < THIN * pixel
        return cls(tree, radius, camera, rig, pixel, thin)

    @computed_once
    def size(self) -> float:
        """The diagonal of the box of the points of the geometry, without their radius."""
        points, _ = self.tree.geometry.span()
        return float(np.sqrt((np.ptp(points, axis=0).astype(np.float64) ** 2).sum())) if len(points) else 0.0

    @computed_once
    def extent(self) -> float:
        """The size and the largest coordinate together: rounding errors are fractions of it."""
        return self.size + float(np.abs(self.tree.box).max())

    @computed_once
    def up(self) -> FloatArray:
        """The upward direction, a unit vector."""
        up = np.asarray(self.camera.up, np.float64)
        return np.asarray(up / np.sqrt((up**2).sum()), np.float32)

    @computed_once
    def lamps(self) -> FloatArray:
        """The distant lights as compiled shading takes them; see `Rig.rows`."""
        return self.rig.rows(self.camera)

    @computed_once
    def sky(self) -> tuple[float, ...]:
        """The sky as compiled shading takes it; see `Sky.row`."""
        return tuple(map(float, self.rig.sky.row(self.up)))

    @computed_once
    def depth_tone(self) -> Tone:
        """The brightness of depths."""
        view = View(self.tree, self.camera, PROBE, PROBE)
        return Tone(probe(view, SPOT * self.pixel if self.thin else self.radius))

    @computed_once
    def _start(self) -> float:
        """How far from a line its rays start: beyond itself, if it has no surface to start from."""
        return max(2 * self.pixel, 4 * self.radius) if self.thin else 0.0

    @computed_once
    def density(self) -> DensityGrid | None:
        """The density of the lines; None if no lines are in memory."""
        geometry = self.tree.geometry
        return DensityGrid.of(geometry, self.radius) if any(map(_has_axes, geometry.each_part())) else None

    def optical_depth(
        self, points: FloatArray, tangents: FloatArray, directions: FloatArray, jitter: FloatArray, far: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return how many lines light crosses on average, and of these those beyond `far`; see `DensityGrid`.

        All other shapes hide all light if they are beyond `far`.
        """
        if self.density is None:
            crossed, beyond = self.count_crossings(points, directions), np.zeros(len(points), np.float32)
        else:
            crossed, beyond = self.density.optical_depth(points, tangents, directions, jitter, far)
        if not all(map(_has_axes, self.tree.geometry.each_part())):
            beyond = np.where(self.unoccluded(points, directions, beyond=far), beyond, np.float32(np.inf))
        return crossed, beyond

    def count_crossings(self, points: FloatArray, directions: FloatArray) -> FloatArray:
        """Return how many lines hide the light from a direction: of thin lines some fraction, from the mean."""
        own = self.tree.geometry.max_radius
        wide = 1.0 if own > 0 else WIDE
        start = max(self._start, 2 * wide * (self.radius + own))  # beyond the line itself
        counts = self.tree.count_hits(points, directions, wide * self.radius, t_min=start)
        return np.asarray(counts / np.float32(wide), np.float32)

    def unoccluded(
        self, points: FloatArray, directions: FloatArray, distance: float = np.inf, beyond: float = 0.0
    ) -> npt.NDArray[np.bool_]:
        """Return from which points nothing is hit in some direction, beyond one distance and up to another."""
        start = max(min(self._start, 0.25 * distance), beyond)
        return ~self.tree.any_hit(points, directions, self.radius, t_min=start, t_max=distance)


def _has_axes(part: AnyGeometry) -> bool:
    """Return whether these are lines or curves in memory."""
    return part.thick_axes() is not None
