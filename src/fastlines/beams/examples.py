"""Built-in scenes: the thesis's mirrored cube, a glass sphere in fog, and a point light."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import did_you_mean
from ..camera import Camera
from ..errors import InputError
from ..geometry.spheres import Spheres
from ..geometry.triangles import Triangles
from ..scenes import beams as thesis
from .lights import PointLight, SpotLight
from .materials import Glass, Mirror
from .medium import HomogeneousMedium
from .scene import BeamScene


def mirrored_cube() -> BeamScene:
    """Return the scene of the thesis, less the front wall: a light in a cube of mirrors that is filled with a medium.

    The mirrors of the thesis are perfect. These reflect 80 %, so that the cube is not evenly bright, and less blue on
    the left and red on the right.
    """
    corners = np.array(np.unravel_index(np.arange(8), (2, 2, 2))).T
    mirrors = [
        (Mirror((0.9, 0.45, 0.2)), [[0, 1, 3, 2]]),
        (Mirror((0.2, 0.5, 0.9)), [[4, 5, 7, 6]]),
        (Mirror(0.8), [[0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4]]),
    ]
    halves = [0, 1, 2, 0, 2, 3]
    return BeamScene(
        HomogeneousMedium(thesis.EXTINCTION * (1 - thesis.ALBEDO), thesis.EXTINCTION * thesis.ALBEDO, thesis.G),
        [PointLight(thesis.LIGHT, power=1)],
        [
            (Triangles.from_mesh(corners, np.array(walls)[:, halves].reshape(-1, 3)), mirror)
            for mirror, walls in mirrors
        ],
        Camera(origin=(0.8, 0.75, 3.4), target=(0.5, 0.5, 0.6), fov_degrees=27),
    )


def glass_sphere() -> BeamScene:
    """Return a glass sphere in fog, which a spot light shines at: its light is focused behind the sphere."""
    return BeamScene(
        HomogeneousMedium(absorption=0.02, scattering=(0.22, 0.2, 0.18), g=0.2),
        [SpotLight((-1.3, 1.6, 0.2), target=(0, 0, 0), power=(30, 29, 27), angle_degrees=16)],
        [(Spheres.from_centres([[0, 0, 0]], radius=0.5), Glass(1.5))],
        Camera(origin=(0, 0.3, 5), target=(0.1, -0.05, 0), fov_degrees=34),
        box=[[-2, -2, -2], [2, 2, 2]],
    )


def point_light() -> BeamScene:
    """Return a point light in fog without surfaces; `single_scattering` integrates its light."""
    return BeamScene(
        HomogeneousMedium(absorption=0.2, scattering=0.8),
        [PointLight((0, 0, 0), power=(40, 30, 20))],
        camera=Camera(origin=(0, 0, 5), target=(0, 0, 0), fov_degrees=34),
        box=[[-1, -1, -1], [1, 1, 1]],
    )


EXAMPLES: dict[str, Callable[[], BeamScene]] = {
    "mirrored-cube": mirrored_cube,
    "glass-sphere": glass_sphere,
    "point-light": point_light,
}

#: The names of the built-in scenes.
NAMES = tuple(EXAMPLES)


def example(name: str) -> BeamScene:
    """Return a built-in scene.

    Parameters
    ----------
    name : {"mirrored-cube", "glass-sphere", "point-light"}

    Raises
    ------
    InputError
        If there is no such scene.

    Examples
    --------
    >>> example("glass-sphere").medium.g
    0.2
    """
    if name not in EXAMPLES:
        raise InputError(f"there is no scene {name!r}{did_you_mean(name, NAMES)}")
    return EXAMPLES[name]()
