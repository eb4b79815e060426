"""A scene of photon beams: a medium in a box, lights, surfaces and a camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import kind_of
from ..camera import Camera
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..support.counter_random import Float64Array, UInt64Array, random_bits, uniform
from .coefficients import check_box, has_member
from .lights import Emission, Light
from .materials import Material
from .medium import HomogeneousMedium, Medium
from .surfaces import NoSurfaces, Surfaces, TracedSurfaces

#: How many mean free paths long a box may be, so that float32 tells the ends of flights apart.
THICKEST = 1e9
#: How many photons of a light say whether it is in glass.
PROBES = 16


def check_scene(scene: object) -> None:
    """Refuse what is no scene."""
    if not isinstance(scene, BeamScene):
        raise InputError(f"scene is {kind_of(scene)}; expected a BeamScene, such as fl.beams.example('glass-sphere')")


@dataclass(frozen=True, eq=False)
class BeamScene:
    """A medium in a box, lights, surfaces and a camera.

    Parameters
    ----------
    medium : HomogeneousMedium, GridMedium or Medium
        Fills the box, but for the inside of glass.
    lights : sequence of PointLight, SpotLight, AreaLight, DirectionalLight or Light
        They and the camera are outside of glass.
    surfaces : sequence of pairs (geometry, material), or Surfaces
        See `TracedSurfaces`.
    camera : Camera, optional
        A pinhole. Pictures need one.
    box : (2, 3) array, optional
        The lowest and the highest corner of the medium; by default those of its grid, or else of the surfaces. A medium
        on a grid is in the part that is in both.

    Raises
    ------
    InputError
        If there is no light, the medium, a light, a surface or the camera cannot be used, a light or the camera is in
        glass, or nothing says where the medium is.

    Examples
    --------
    >>> import fastlines as fl
    >>> fog = fl.beams.HomogeneousMedium(absorption=0, scattering=1)
    >>> scene = BeamScene(fog, [fl.beams.PointLight((0, 0, 0), power=1)], box=[[-1, -1, -1], [1, 1, 1]])
    >>> scene.box.tolist()
    [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]
    """

    medium: Medium
    lights: tuple[Light, ...]
    surfaces: Surfaces
    camera: Camera | None
    box: Float64Array

    def __init__(
        self,
        medium: Medium,
        lights: Sequence[Light],
        surfaces: Sequence[tuple[AnyGeometry, Material]] | Surfaces = (),
        camera: Camera | None = None,
        box: npt.ArrayLike | None = None,
    ) -> None:
        if not has_member(medium, "distance_at"):
            raise InputError(f"medium is {kind_of(medium)}; expected fl.beams.HomogeneousMedium or GridMedium")
        several = tuple(lights) if isinstance(lights, Sequence) else (lights,)
        if not several:
            raise InputError("there are no lights; give one, such as fl.beams.PointLight((0, 1, 0), power=1)")
        for i, light in enumerate(several):
            if not has_member(light, "emit"):
                raise InputError(
                    f"light {i} is {kind_of(light)}; expected a light, such as fl.beams.PointLight((0, 1, 0), power=1)"
                )
        if camera is not None and not isinstance(camera, Camera):
            raise InputError(f"camera is {kind_of(camera)}; expected fl.Camera")
        if camera is not None and camera.lens_radius:
            raise InputError(f"{camera!r} has a lens; expected a pinhole, which has lens_radius=0")
        if isinstance(surfaces, Sequence):
            surfaces = TracedSurfaces(surfaces) if surfaces else NoSurfaces()
        elif not has_member(surfaces, "intersect"):
            raise InputError(f"surfaces are {kind_of(surfaces)}; expected a list of pairs (geometry, material)")
        of_medium: Float64Array | None = getattr(medium, "box", None)
        known = next((one for one in (box, of_medium, surfaces.bounds) if one is not None), None)
        if known is None:
            raise InputError("nothing says where the medium is; give box=[[x, y, z], [x, y, z]], its corners")
        corners = check_box("box", known)
        if of_medium is not None:
            common = np.maximum(corners[0], of_medium[0]), np.minimum(corners[1], of_medium[1])
            if not (common[0] < common[1]).all():
                raise InputError(
                    f"box={corners.tolist()} and that of the medium, {of_medium.tolist()}, do not overlap; leave out "
                    "box=, or move one of them"
                )
            corners = np.stack(common)
        _check_thickness(medium, corners)
        parts = medium, several, surfaces, camera, corners
        for name, value in zip(("medium", "lights", "surfaces", "camera", "box"), parts, strict=True):
            object.__setattr__(self, name, value)
        self._refuse_places_in_glass()

    def _refuse_places_in_glass(self) -> None:
        """Refuse a light or a camera in glass: what leaves it would be taken for outside while it is inside."""
        if not isinstance(self.surfaces, TracedSurfaces):
            return
        keys = random_bits(0, np.arange(PROBES))
        emissions = [light.emit(keys, self.bounds) for light in self.lights]
        places = [(f"light {i}", one.origins[one.in_medium]) for i, one in enumerate(emissions)]
        if self.camera is not None:
            places.append(("the camera", np.array([self.camera.origin])))
        for surface in self.surfaces.glass:
            for name, points in places:
                if self.surfaces.encloses(surface, points).any():
                    raise InputError(
                        f"{name} is inside of surface {surface}, which is of Glass; expected lights and the camera "
                        "outside of glass: move one of them"
                    )

    @property
    def bounds(self) -> Float64Array:
        """The lowest and the highest corner of the medium and of all surfaces, (2, 3) float64."""
        if self.surfaces.bounds is None:
            return self.box
        low, high = np.stack([self.box, self.surfaces.bounds], axis=1)
        return np.stack([low.min(axis=0), high.max(axis=0)])

    @property
    def power(self) -> Float64Array:
        """The power of all lights, (3,) float64."""
        bounds = self.bounds
        return np.asarray(np.array([light.total_power(bounds) for light in self.lights]).sum(axis=0))

    def emit(self, keys: UInt64Array) -> Emission:
        """Emit a photon for each key, (n,) uint64, from a light chosen by its power; the mean of power is `power`."""
        bounds = self.bounds
        if len(self.lights) == 1:
            return self.lights[0].emit(keys, bounds)
        chances = np.array([sum(light.total_power(bounds)) for light in self.lights])
        chances /= chances.sum()
        chosen = np.searchsorted(np.cumsum(chances)[:-1], uniform(keys, 63), side="right")
        origins, directions, power = np.empty((3, len(keys), 3))
        made = Emission(origins, directions, power, np.empty(len(keys), np.bool_))
        for i, light in enumerate(self.lights):
            here = np.flatnonzero(chosen == i)
            one = light.emit(keys[here], bounds)
            for column, values in zip(made, one._replace(power=one.power / chances[i]), strict=True):
                column[here] = values
        return made

    def in_box(self, origins: Float64Array, directions: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Return where rays, (n, 3) each, enter the box of the medium, at least 0, and leave it; t in > t out = miss.

        Examples
        --------
        >>> import fastlines as fl
        >>> fog, light = fl.beams.HomogeneousMedium(0, 1), fl.beams.PointLight((0, 0, 0), power=1)
        >>> scene = BeamScene(fog, [light], box=[[-1, -1, -1], [1, 1, 1]])
        >>> scene.in_box(np.array([[0.0, 0.0, -3.0]]), np.array([[0.0, 0.0, 1.0]]))
        (array([2.]), array([4.]))
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            planes = (self.box[:, None] - origins) / directions
        # A ray along a plane is between its two planes everywhere, or nowhere.
        beside = np.isnan(planes)
        low = np.where(beside, -np.inf, planes).min(axis=0).max(axis=1)
        high = np.where(beside, np.inf, planes).max(axis=0).min(axis=1)
        return np.maximum(low, 0.0), high


def _check_thickness(medium: Medium, box: Float64Array) -> None:
    """Refuse a medium in which no photon flies far enough to be seen."""
    side = float((box[1] - box[0]).max())
    if isinstance(medium, HomogeneousMedium) and medium.extinction.max() * side > THICKEST:
        raise InputError(
            f"absorption={medium.absorption} and scattering={medium.scattering} let no light pass a box of the size "
            f"{side:g}; expected a sum of at most {THICKEST / side:g} per unit of length"
        )
