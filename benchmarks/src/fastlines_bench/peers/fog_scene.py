"""The scene of a volumetric caustic that both sides render: a glass sphere in a box of fog, and a small rectangle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

import fastlines as fl

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class FogScene:
    """A cube of fog around the coordinate origin with a glass sphere in it, lit from above through its upper side.

    The light is not next to the fog: there, what Mitsuba 3.9 scatters twice is darker than a direct integration.

    Attributes
    ----------
    size : int
        The width and the height of the picture in pixels.
    half_side : float
        Half the side of the cube.
    absorption, scattering, g : float
        The fog, per unit of length, and the mean cosine of its phase function.
    light_corner, light_u, light_v : (3,) float
        The rectangle. It emits towards the cross product of its edges.
    power : float
    """

    size: int
    half_side: float = 1.0
    absorption: float = 0.1
    scattering: float = 0.5
    g: float = 0.0
    ball_centre: Vector = (0.0, 0.25, 0.0)
    ball_radius: float = 0.35
    ior: float = 1.5
    light_corner: Vector = (-0.1, 1.5, -0.1)
    light_u: Vector = (0.2, 0.0, 0.0)
    light_v: Vector = (0.0, 0.0, 0.2)
    power: float = 10.0

    @property
    def camera(self) -> fl.Camera:
        """A camera in front of the box, which sees the sphere and the light below it."""
        return fl.Camera(origin=(0, 0, 5), target=(0, -0.15, 0), fov_degrees=20)

    @cached_property
    def beside_glass(self) -> npt.NDArray[np.bool_]:
        """Whether a pixel sees fog alone, (size, size): its ray passes the sphere at a distance.

        Pixels of the sphere do not count: there, light that comes straight from the lamp is seen, too, which beams
        leave out.
        """
        origins, directions = self.camera.rays(self.size, self.size)
        towards = np.subtract(self.ball_centre, origins, dtype=np.float64)
        passes = np.linalg.norm(np.cross(towards, directions), axis=1)
        pixel = 2 * np.tan(np.radians(self.camera.fov_degrees) / 2) * np.linalg.norm(towards, axis=1) / self.size
        return np.reshape(passes > self.ball_radius + 2 * pixel, (self.size, self.size))

    def beams(self) -> fl.beams.BeamScene:
        """Return the scene for photon beams."""
        side = self.half_side
        ball = fl.Spheres.from_centres([self.ball_centre], radius=self.ball_radius)
        return fl.beams.BeamScene(
            fl.beams.HomogeneousMedium(self.absorption, self.scattering, self.g),
            [fl.beams.AreaLight(self.light_corner, self.light_u, self.light_v, self.power)],
            [(ball, fl.beams.Glass(self.ior))],
            self.camera,
            box=[[-side] * 3, [side] * 3],
        )
