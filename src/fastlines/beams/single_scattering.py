"""Light that is scattered once: a reference that needs no beams.

For a point light of power Φ in a homogeneous medium, with t along the ray, r(t) the distance from the light and θ the
angle of scattering:

    L = ∫ σ_s · f(θ) · exp(−σ_t · (t + r)) · Φ / (4π r²) dt

With t = t₀ + h·tan α, where h is the distance of the ray from the light and t₀ the nearest point, dt / r² = dα / h. So
the integrand is smooth in α, the angle at the light, and a quadrature of Gauss and Legendre converges fast.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import list_rows
from ..errors import InputError
from ..support.counter_random import Float64Array
from ..support.phase_function import phase_function
from ..support.vectors import dot
from .coefficients import unit_rays
from .lights import PointLight
from .medium import HomogeneousMedium
from .scene import BeamScene, check_scene
from .surfaces import NoSurfaces

#: The least distance of a ray from the light, as a fraction of that of its origin; rounding hides a smaller one.
NEAREST = 1e-12


def single_scattering(
    scene: BeamScene, origins: npt.ArrayLike, directions: npt.ArrayLike, *, order: int = 128
) -> Float64Array:
    """Integrate the light that is scattered once along rays, in a scene without surfaces.

    Parameters
    ----------
    scene : BeamScene
        With a `HomogeneousMedium` and a `PointLight` in its box.
    origins, directions : (n, 3) array
        Rays, none of which lies on a line through the light.
    order : int
        Of the quadrature.

    Returns
    -------
    (n, 3) float64
        The radiance.

    Raises
    ------
    InputError
        If the scene has another medium or light, surfaces, or its light outside of its box; or if a ray lies on a line
        through the light, where the integral may be infinite.

    Examples
    --------
    >>> import fastlines as fl
    >>> fog = fl.beams.HomogeneousMedium(absorption=0, scattering=(0.1, 0.2, 0.4))
    >>> light = fl.beams.PointLight((0, 0, 0), power=100)
    >>> scene = fl.beams.BeamScene(fog, [light], box=[[-1, -1, -1], [1, 1, 1]])
    >>> single_scattering(scene, [0.1, 0, -3], [0, 0, 1]).round(3).tolist()
    [[1.653, 2.934, 4.633]]
    """
    check_scene(scene)
    medium, light = scene.medium, scene.lights[0]
    if not (isinstance(medium, HomogeneousMedium) and isinstance(light, PointLight) and len(scene.lights) == 1):
        raise InputError("single scattering is integrated for one PointLight in a HomogeneousMedium")
    if not isinstance(scene.surfaces, NoSurfaces):
        raise InputError("single scattering is integrated in a scene without surfaces; leave out surfaces=")
    place = np.asarray(light.position)
    if (place < scene.box[0]).any() or (place > scene.box[1]).any():
        raise InputError(
            f"the light at {light.position} is outside of the box of the medium, {scene.box.tolist()}; single "
            "scattering is integrated for a light within it: move the light, or give another box="
        )
    starts, ways = unit_rays(origins, directions)
    begin, end = scene.in_box(starts, ways)
    end = np.maximum(end, begin)

    # Find the nearest point to the light, and the angles of both ends as the light sees them.
    to_light = place - starts
    nearest = dot(to_light, ways)
    across = np.cross(to_light, ways)
    height = np.sqrt(dot(across, across))
    if (through := height <= NEAREST * np.sqrt(dot(to_light, to_light))).any():
        raise InputError(
            f"{int(through.sum())} of {len(through)} rays lie on a line through the light ({list_rows(through)}); move "
            "these rays aside"
        )
    first, last = np.arctan2(begin - nearest, height), np.arctan2(end - nearest, height)
    nodes, weights = np.polynomial.legendre.leggauss(order)
    angle = (first + last)[:, None] / 2 + (last - first)[:, None] / 2 * nodes
    t = nearest[:, None] + height[:, None] * np.tan(angle) - begin[:, None]
    r = height[:, None] / np.cos(angle)

    # Light flies from the light to the ray, and turns towards the origin of the ray.
    phase = phase_function(medium.g, -np.sin(angle))
    passed = np.exp(-(t + r)[..., None] * medium.extinction) * phase[..., None]
    integral = (passed * weights[:, None]).sum(axis=1) * ((last - first) / (2 * height))[:, None]
    return np.asarray(integral * medium.scattering * light.power / (4 * np.pi))
