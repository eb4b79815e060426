"""Progressive passes: new photons and a smaller radius in each, so that both noise and blur vanish.

The radius of pass i + 1 is R · (i + α) / (i + 1), where R is that of pass i; with a kernel of two dimensions the square
of the radius shrinks so (Knaus and Zwicker 2011; Jarosz et al. 2011, "Progressive photon beams"). A small α shrinks
fast: less blur and more noise. The picture is the mean of the passes, and its variance is that of their means.
"""

from __future__ import annotations

import hashlib
import math
import os
import time
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..arrays import check_fields, choice, count, did_you_mean, number
from ..errors import InputError
from ..progress import ProgressCallback, staged
from ..rendering.state import describe, read_state, write_state
from ..settings.methods import method_settings
from ..support.counter_random import Float64Array, random_bits, uniform
from ..support.warn_caller import warn_caller
from .beam_picture import BeamPicture
from .camera_paths import camera_legs
from .estimate import METHOD, POINTS, BeamMap, check_estimate, check_radius
from .photons import KINDS, trace_photons
from .scene import BeamScene, check_scene

#: The width and the height of a picture in pixels.
SIZE = 512
#: The radius of the first pass, as a fraction of the longest side of the box.
RADIUS = 0.005
#: The least and the largest such fraction; float32 cannot tell a smaller radius from 0 at all places of the box.
LEAST_RADIUS, LARGEST_RADIUS = 1e-7, 1e6
#: What fraction of a pass the photons are, for progress.
TRACING = 0.3
#: The number of the stream of random numbers of pixels; those of photons are numbered by pass.
PIXELS = 2**63


@dataclass(frozen=True, kw_only=True)
class PassSettings:
    """What passes depend on, besides the scene.

    Parameters
    ----------
    width, height : int, optional
        Of the picture, in pixels. Each is the other one by default, and 512 if neither is given.
    n_paths : int
        How many photons each pass emits.
    radius : float, optional
        Of the blur in the first pass, in the unit of the coordinates; by default 1/200 of the box's longest side.
    alpha : float
        How slowly the radius shrinks: above 0, and 1 keeps it.
    kind : {"short", "long"}
        Of beams; see `trace_photons`.
    adapt : bool
        Give each beam a radius that suits how dense beams are around it, near that of the pass.
    blur : {"box", "epanechnikov"}
    estimator : {"beam", "point"}
    points : int
        See `BeamMap.radiance`.
    max_scatterings : int, optional
        See `trace_photons`.
    seed : int
        Another one gives other photons and rays.
    method : str
        The tree to build; see `fastlines.METHODS`.
    """

    width: int | None = None
    height: int | None = None
    n_paths: int = 50_000
    radius: float | None = None
    alpha: float = 0.7
    kind: str = "short"
    adapt: bool = False
    blur: str = "box"
    estimator: str = "beam"
    points: int = POINTS
    max_scatterings: int | None = None
    seed: int = 0
    method: str = METHOD

    def __post_init__(self) -> None:
        count("n_paths", self.n_paths, 1)
        check_fields(self, ("width", "height"), count, 1)
        if self.radius is not None:
            check_radius("radius", self.radius)
        check_estimate(self.blur, self.estimator, self.points, self.adapt)
        number("alpha", self.alpha, "a number above 0 and at most 1", 1e-6, 1.0)
        count("seed", self.seed, 0)
        choice("kind", self.kind, KINDS)
        method_settings(self.method)

    @property
    def size(self) -> tuple[int, int]:
        """The width and the height of the picture.

        Examples
        --------
        >>> PassSettings(width=64).size, PassSettings().size
        ((64, 64), (512, 512))
        """
        return self.width or self.height or SIZE, self.height or self.width or SIZE

    def radius_of(self, scene: BeamScene, pass_number: int) -> float:
        """Return the radius of a pass; the first is number 0.

        Examples
        --------
        >>> import fastlines as fl
        >>> scene, settings = fl.beams.example("point-light"), PassSettings(radius=1.0, alpha=0.5)
        >>> [settings.radius_of(scene, i) for i in range(3)]
        [1.0, 0.75, 0.625]
        """
        first = RADIUS * _side(scene) if self.radius is None else self.radius
        shrinking = math.prod((i + self.alpha) / (i + 1) for i in range(1, pass_number + 1))
        return first * (shrinking if self.estimator == "beam" else math.sqrt(shrinking))


def _side(scene: BeamScene) -> float:
    """Return the longest side of the box."""
    return float((scene.box[1] - scene.box[0]).max())


def _check_first_radius(radius: float | None, scene: BeamScene) -> None:
    side = _side(scene)
    if radius is not None and not LEAST_RADIUS * side <= radius <= LARGEST_RADIUS * side:
        raise InputError(
            f"radius={radius!r}; expected the radius of the blur in the unit of the scene, whose box is {side:g} long: "
            f"from {LEAST_RADIUS * side:g} to {LARGEST_RADIUS * side:g}"
        )


def map_pass(
    scene: BeamScene, settings: PassSettings, pass_number: int, progress: ProgressCallback | None = None
) -> tuple[BeamMap, float | None]:
    """Trace the photons of a pass; return their beams in a tree, and the radius of the blur.

    The radius is None if beams have a radius of their own.
    """
    beams = trace_photons(
        scene,
        settings.n_paths,
        kind=settings.kind,
        seed=settings.seed,
        pass_number=pass_number,
        max_scatterings=settings.max_scatterings,
        progress=progress or False,
    )
    radius = settings.radius_of(scene, pass_number)
    if not settings.adapt:
        return BeamMap(scene, beams, settings.method), radius
    scale = radius / settings.radius_of(scene, 0)
    return BeamMap(scene, beams, settings.method, own_radius=radius, scale=scale), None


class Passes:
    """A picture of a scene, pass after pass.

    Parameters
    ----------
    scene : BeamScene
        With a camera.
    settings : PassSettings, optional
    **more
        Fields of `PassSettings`, in place of those of `settings`.

    Attributes
    ----------
    width, height : int
        Of the picture, in pixels.
    done : int
        How many passes there are.

    Examples
    --------
    >>> import fastlines as fl
    >>> passes = Passes(fl.beams.example("point-light"), width=16, height=16, n_paths=1000)
    >>> for _ in range(3):
    ...     passes.add()
    >>> passes.picture()
    <BeamPicture: 16 × 16 pixels, 3 passes>
    """

    def __init__(self, scene: BeamScene, settings: PassSettings | None = None, **more: Any) -> None:
        known = [field.name for field in fields(PassSettings)]
        if unknown := [name for name in more if name not in known]:
            raise InputError(f"there is no setting {unknown[0]!r}{did_you_mean(unknown[0], known)}")
        check_scene(scene)
        if scene.camera is None:
            raise InputError("the scene has no camera; give it one, as BeamScene(…, camera=fl.Camera(…))")
        chosen = replace(settings or PassSettings(), **more)
        self.width, self.height = chosen.size
        self.scene, self.settings = scene, replace(chosen, width=self.width, height=self.height)
        _check_first_radius(self.settings.radius, scene)
        shape = (self.height, self.width, 3)
        # One tuple, so that what interrupts a pass leaves the passes before whole.
        self._state: tuple[int, Float64Array, Float64Array] = 0, np.zeros(shape), np.zeros(shape)
        self.seconds_a_pass: float | None = None

    @property
    def done(self) -> int:
        """How many passes there are."""
        return self._state[0]

    @property
    def radius(self) -> float:
        """The radius of the last pass, or of the first one if there is none yet."""
        return self.settings.radius_of(self.scene, max(self.done - 1, 0))

    def add(self, progress: ProgressCallback | None = None) -> None:
        """Trace the photons of one more pass, build a tree over their beams, and gather their light."""
        start, settings = time.perf_counter(), self.settings
        beam_map, radius = map_pass(self.scene, settings, self.done, staged(progress, 0, TRACING))
        origins, directions, keys = self._rays()
        light = beam_map.radiance(
            origins,
            directions,
            radius,
            keys=keys,
            blur=settings.blur,
            estimator=settings.estimator,
            points=settings.points,
            progress=staged(progress, TRACING, 1),
        )
        if not self.done and not light.any() and next(camera_legs(self.scene, origins, directions, keys), None) is None:
            warn_caller(
                "no ray of the camera goes through the medium, so the picture is black; turn or move the camera"
            )
        light = light.reshape(self.height, self.width, 3)
        done, total, squares = self._state
        self._state = done + 1, total + light, squares + light**2
        self.seconds_a_pass = time.perf_counter() - start

    def _rays(self) -> tuple[Float64Array, Float64Array, Any]:
        """Return a ray through a random point of each pixel, and the keys of their random numbers."""
        camera, width, height = self.scene.camera, self.width, self.height
        assert camera is not None
        stream = random_bits(random_bits(self.settings.seed, PIXELS), self.done)
        keys = random_bits(stream, np.arange(width * height))
        row, column = np.divmod(np.arange(width * height), width)
        origins, directions, _ = camera.ray(column + uniform(keys, 0), row + uniform(keys, 1), width, height)
        return origins.astype(np.float64), directions.astype(np.float64), random_bits(keys, 2)

    def picture(self) -> BeamPicture:
        """Return the picture of all passes so far.

        Raises
        ------
        InputError
            If there is no pass yet.
        """
        done, total, squares = self._state
        if not done:
            raise InputError("there is no pass yet, so there is no picture; call add() first")
        mean = total / done
        spread = np.maximum(squares / done - mean**2, 0) / (done - 1) if done > 1 else np.full(mean.shape, np.nan)
        n_paths = done * self.settings.n_paths
        return BeamPicture(mean.astype(np.float32), spread.astype(np.float32), done, n_paths, self.radius)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the passes so far to a .npz file, from which `resume` goes on; it appears whole or not at all."""
        done, total, squares = self._state
        write_state(path, self._told, {"total": total, "squares": squares, "done": np.array(done)})

    def resume(self, path: str | os.PathLike[str]) -> None:
        """Take over the passes that `save` has written; those to come are the same as without a break.

        Raises
        ------
        InputError
            If the file is not the state of a picture, or is that of another scene or of other settings.
        OSError
            If it cannot be read.
        """
        done, total, squares = self._state
        found = read_state(path, self._told, {"total": total, "squares": squares, "done": np.array(done)})
        self._state = int(found["done"]), found["total"], found["squares"]

    @property
    def _told(self) -> dict[str, str]:
        """All that the passes depend on, as texts."""
        scene = self.scene
        parts = scene.medium, scene.lights, scene.surfaces, scene.camera, scene.box
        checksum = hashlib.blake2b("; ".join(map(_told, parts)).encode(), digest_size=20).hexdigest()
        settings = {field.name: describe(getattr(self.settings, field.name)) for field in fields(self.settings)}
        return {"scene": checksum, **settings}


def count_saved(path: str | os.PathLike[str]) -> int:
    """Return how many passes a file has that `Passes.save` has written; 0 if it is none."""
    try:
        return int(read_state(path, {}, {"done": np.array(0)})["done"])
    except (InputError, OSError):
        return 0


def _told(value: Any) -> str:
    """Write a part of a scene as text; of arrays, a checksum."""
    if hasattr(value, "fingerprint"):
        return str(value.fingerprint())
    if isinstance(value, np.ndarray):
        checksum = hashlib.blake2b(np.ascontiguousarray(value).tobytes(), digest_size=20).hexdigest()
        return f"{value.dtype} {value.shape} {checksum}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_told, value))})"
    if is_dataclass(value):
        parts = (f"{field.name}={_told(getattr(value, field.name))}" for field in fields(value))
        return f"{type(value).__name__}({', '.join(parts)})"
    return describe(value)
