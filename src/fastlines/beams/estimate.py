"""Estimates of the light that a medium scatters towards a camera, from beams of light.

A ray o + t·ω crosses a beam p + s·d at the distance u, at the angle θ. Light that leaves the beam towards the camera
has turned by the angle of cosine −ω·d. With Φ the power of the beam, N the number of photons, Tr the transmittance and
f the phase function, the *beam × beam* estimate with a one-dimensional kernel is (Jarosz et al. 2011, "A comprehensive
theory of volumetric radiance estimation using photon points and beams"):

    L = Σ  Φ/N · σ_s · f(−ω·d) · Tr(0 → t) · W(s) · k(u) / sin θ,      k(u) = 1/(2R) or 3/(4R) · (1 − u²/R²)

over the beams with u < R. W is 1 for short beams, and the transmittance from the beginning of long ones. The sum is one
call of `Tree.gather`, which lists no hits, and leaves out those at the ends of beams and rays: these ends would add the
light of half a capsule each.

The *point × beam* estimate takes points at random on each ray, and the beams around each within the radius, by
`Tree.within`: a two-dimensional kernel, 1/(πR²) or 2/(πR²) · (1 − u²/R²), and the mean of the points times the length.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import LEAST, FloatArray, choice, count, number
from ..builder import build
from ..errors import InputError
from ..geometry.lines import Lines
from ..progress import ProgressCallback, staged
from ..support.counter_random import Float64Array, UInt64Array, random_bits, uniform
from ..support.phase_function import phase_function
from ..support.vectors import dot
from ..tree import Tree
from .camera_paths import Legs, camera_legs
from .coefficients import unit_rays
from .photons import Beams
from .scene import BeamScene, check_scene

#: The tree over the beams of a pass, which serves a single gather.
METHOD = "beams"
#: The kernels of the blur.
BLURS = ("box", "epanechnikov")
#: The estimators.
ESTIMATORS = ("beam", "point")
#: How many other beams are within a beam's own radius, and by what factor that may differ from the radius asked for.
NEIGHBOURS, WIDEST = 16, 4.0
#: How many points the point × beam estimate takes on each leg of a ray.
POINTS = 16
#: How many depths of rays in a medium on a grid are tabled at a time, each in three channels.
DEPTHS_AT_A_TIME = 1 << 22
#: How many points are looked up at a time.
POINTS_AT_A_TIME = 1 << 17


class BeamMap:
    """A tree over beams, and the light that each scatters: all that an estimate of radiance reads.

    Parameters
    ----------
    scene : BeamScene
    beams : Beams
        Of `trace_photons`.
    method : str
        The tree to build; see `fastlines.METHODS`.
    own_radius : float, optional
        Give each beam a radius that suits how dense beams are around it, from a quarter of this to four times this: the
        geometric mean, over its ends, of the distance to the nearest 16 others, times `scale`.
    scale : float

    Attributes
    ----------
    tree : Tree
        Over the beams, which are cut into pieces in a medium on a grid.
    values : (n, 3) float32
        Φ/N · σ_s of each, and 1/4π if the medium scatters evenly.
    decay : (3,) float64
        The extinction along them.

    Examples
    --------
    >>> import fastlines as fl
    >>> fog = fl.beams.HomogeneousMedium(absorption=0.5, scattering=0.5)
    >>> light = fl.beams.PointLight((0, 0, 0), power=100)
    >>> scene = fl.beams.BeamScene(fog, [light], box=[[-1, -1, -1], [1, 1, 1]])
    >>> beam_map = BeamMap(scene, fl.beams.trace_photons(scene, 10_000))
    >>> beam_map.radiance([[0.2, 0.1, -3]], [[0, 0, 1]], radius=0.05).shape
    (1, 3)
    """

    tree: Tree
    values: FloatArray
    decay: Float64Array

    def __init__(
        self,
        scene: BeamScene,
        beams: Beams,
        method: str = METHOD,
        *,
        own_radius: float | None = None,
        scale: float = 1.0,
    ) -> None:
        check_scene(scene)
        self.scene = scene
        sources = scene.medium.sources(beams.lines.segments, beams.decay)
        self.lines = beams.lines if sources.beam is None else Lines.from_segments(sources.segments)
        power = beams.power if sources.beam is None else beams.power[sources.beam]
        self.tree = build(self.lines, method)
        self.is_adapted = own_radius is not None
        if own_radius is not None:
            check_radius("own_radius", own_radius)
            number("scale", scale, "a number above 0", LEAST)
            widest = own_radius * WIDEST
            near_ends = np.clip(self._distances(widest / scale) * scale, own_radius / WIDEST, widest)
            # One radius for both ends: the kernel of a cone would lose light.
            self.lines = self.lines.with_radius(np.sqrt(near_ends.prod(axis=1)))
            self.tree = build(self.lines, method)
        self.g = scene.medium.g or None
        of_power = sources.scattered / beams.n_paths * (1.0 if self.g else 0.25 / np.pi)
        with np.errstate(over="ignore"):
            self.values = (power * of_power).astype(np.float32)
        if not np.isfinite(self.values).all():
            raise InputError(
                f"the power of the lights, {scene.power.tolist()}, times the scattering of the medium, "
                f"{list(scene.medium.scattering)}, is beyond float32; give one of them in a larger unit"
            )
        self.decay = sources.decay

    def _distances(self, farthest: float) -> FloatArray:
        """Return how far from its ends the last of a beam's nearest others is, (n, 2); inf beyond `farthest`."""
        # Many beams start at one point, where a light or a collision is.
        ends = np.ascontiguousarray(self.lines.segments).reshape(-1, 3)
        _, first, of_ends = np.unique(ends.view("V12"), return_index=True, return_inverse=True)
        k = min(NEIGHBOURS + 1, len(self.lines))  # the beam itself is the nearest
        found = self.tree.nearest(ends[first], k, max_distance=farthest)
        return found.distance[:, -1][of_ends.reshape(-1)].reshape(-1, 2)

    def radiance(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: float | None = None,
        *,
        keys: UInt64Array | None = None,
        blur: str = "box",
        estimator: str = "beam",
        points: int = POINTS,
        progress: ProgressCallback | None = None,
    ) -> Float64Array:
        """Estimate the radiance that arrives along rays, through mirrors and glass.

        Parameters
        ----------
        origins, directions : (n, 3) array
            Outside of glass.
        radius : float, optional
            Of the blur, in the unit of the coordinates. That of beams with a radius of their own is added to it.
        keys : (n,) uint64, optional
            Of the random numbers of each ray; by default their numbers.
        blur : {"box", "epanechnikov"}
        estimator : {"beam", "point"}
            Beam × beam, with a kernel of one dimension, or point × beam, with one of two.
        points : int
            How many points the latter takes on each leg of a ray.
        progress : callable, optional
            Is called with the fraction that is done.

        Returns
        -------
        (n, 3) float64
            In power per area and solid angle: W/(m²·sr) if the light has watts, and coordinates are in metres.

        Raises
        ------
        InputError
            If there is no radius above 0, a word is not a choice, or points are to take beams with a radius of their
            own.
        """
        if radius is not None or not self.is_adapted:
            check_radius("radius", radius)
        check_estimate(blur, estimator, points, self.is_adapted)
        starts, ways = unit_rays(origins, directions)
        keys = random_bits(0, np.arange(len(starts))) if keys is None else keys
        light = np.zeros((len(starts), 3))
        for i, legs in enumerate(camera_legs(self.scene, starts, ways, keys)):
            # The number of legs is unknown: each takes half of what is left of the progress.
            step = staged(progress, 1 - 0.5**i, 1 - 0.5 ** (i + 1))
            if radius is None or estimator == "beam":
                found = self.light_along(legs, radius, blur, step)
            else:
                found = self._around(legs, radius, blur, keys[legs.rays], points, step)
            arriving = legs.throughput * found
            for channel in range(3):
                light[:, channel] += np.bincount(legs.rays, arriving[:, channel], len(light))
        if progress is not None:
            progress(1.0)
        return light

    def light_along(
        self, legs: Legs, radius: float | None, blur: str, progress: ProgressCallback | None = None
    ) -> Float64Array:
        """Return the light of the beams that legs cross, (n, 3), at the origin of each: beam × beam."""
        light = np.empty((len(legs.rays), 3))
        at_a_time = max(DEPTHS_AT_A_TIME // self.scene.medium.n_steps, 1)
        for begin in range(0, len(light), at_a_time):
            rows = slice(begin, begin + at_a_time)
            part = legs.some(rows)
            end = min(begin + at_a_time, len(light))
            found = self.tree.gather(
                part.origins,
                part.directions,
                radius,
                self.values,
                t_max=part.lengths,
                blur=blur,
                phase=self.g,
                line_sigma=self.decay,
                progress=staged(progress, begin / len(light), end / len(light)) or False,
                **self.scene.medium.gather_options(part.origins, part.directions, part.lengths),
            )
            light[rows] = found.sum
        return light

    def _around(
        self,
        legs: Legs,
        radius: float,
        blur: str,
        keys: UInt64Array,
        points: int,
        progress: ProgressCallback | None,
    ) -> Float64Array:
        """Return the light of the beams around random points of legs, one in each equal part: point × beam."""
        light = np.zeros((len(legs.rays), 3))
        at_a_time = max(POINTS_AT_A_TIME // points, 1)
        for begin in range(0, len(light), at_a_time):
            rows = slice(begin, begin + at_a_time)
            part = legs.some(rows)
            places = uniform(keys[rows, None], 2 + np.arange(points)) + np.arange(points)
            leg = np.repeat(np.arange(len(part.rays)), points)
            t = (places / points * part.lengths[:, None]).reshape(-1)
            ways = part.directions[leg]
            starts = part.origins[leg]
            passed = self.scene.medium.transmittance(starts, ways, t) * (part.lengths / points)[leg, None]
            scattered = self._scattered_at(starts + t[:, None] * ways, ways, radius, blur)
            light[rows] = (passed * scattered).reshape(-1, points, 3).sum(axis=1)
            if progress is not None:
                progress(min(begin + at_a_time, len(light)) / len(light))
        return light

    def _scattered_at(self, places: Float64Array, ways: Float64Array, radius: float, blur: str) -> Float64Array:
        """Return what points (n, 3) scatter against directions, per unit of length."""
        near = self.tree.within(places, radius)
        # Leave out ends, as gathers do.
        kept = (near.u > 0) & (near.u < 1)
        point, prim, u = near.point[kept], near.prim[kept], near.u[kept].astype(np.float64)
        kernel = np.full(len(prim), 1 / (np.pi * radius**2))
        if blur == "epanechnikov":
            kernel *= 2 * (1 - (near.distance[kept] / radius) ** 2)
        segments = self.lines.segments[prim].astype(np.float64)
        along = segments[:, 1] - segments[:, 0]
        length = np.sqrt(dot(along, along))
        if self.g:
            kernel *= phase_function(self.g, -dot(ways[point], along) / length)
        light = self.values[prim] * np.exp(-(u * length)[:, None] * self.decay) * kernel[:, None]
        return np.stack([np.bincount(point, light[:, i], len(places)) for i in range(3)], axis=1)


def check_radius(name: str, radius: object) -> None:
    """Refuse a radius of the blur that is not a finite number above 0."""
    number(name, radius, "the radius of the blur, a finite number above 0", 1e-30)


def check_estimate(blur: str, estimator: str, points: int, is_adapted: bool = False) -> None:
    """Refuse settings of an estimate that cannot be used."""
    choice("blur", blur, BLURS), choice("estimator", estimator, ESTIMATORS), count("points", points, 1)
    if estimator == "point" and is_adapted:
        raise InputError("estimator='point' takes beams without a radius of their own; use estimator='beam'")
