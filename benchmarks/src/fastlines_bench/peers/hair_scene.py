"""The scene that both sides render: hair, a camera, one distant light and an even sky."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl
from fastlines import Camera, Curves, Lines

from ..harness.arrays import FloatArray
from ..harness.internals import HairMaterial, Light, Sky

#: The shapes of hairs, and how far both sides agree on them.
SHAPES = {
    "bspline": "cubic B-splines through the points of the lines",
    "linear": "lines; Mitsuba's have no tangents, so its hairs scatter light in arbitrary directions",
}

#: The longest side of the scene.
SIDE = 100.0


@dataclass(frozen=True, eq=False)
class HairScene:
    """What is rendered.

    Attributes
    ----------
    geometry : Lines or Curves
        What we render. Curves have their radius.
    path : path
        The file of curves that Mitsuba renders.
    shape : str
        One of `SHAPES`.
    radius : float
        That of all hairs.
    camera : Camera
    material : HairMaterial
    light : Light
        Its angle is 0.
    sky : Sky
        The same radiance everywhere.
    size : int
        The width and the height of the picture in pixels.
    max_bounces : int
    """

    geometry: Lines | Curves
    path: Path
    shape: str
    radius: float
    camera: Camera
    material: HairMaterial
    light: Light
    sky: Sky
    size: int
    max_bounces: int

    @cached_property
    def towards(self) -> FloatArray:
        """The unit vector towards the light, (3,)."""
        zero = np.zeros(1, np.float32)
        return np.asarray(self.light.sample(self.camera, zero, zero)[0])

    @property
    def query_radius(self) -> float:
        """The radius of our queries."""
        return 0.0 if self.shape == "bspline" else self.radius


def normalised(lines: Lines, radius: float, camera: Camera) -> tuple[Lines, float, Camera]:
    """Move the middle of lines to the coordinate origin, and scale their longest side to `SIDE`.

    Mitsuba starts rays 9e-5·(1 + the largest coordinate) away from surfaces. Of hair in metres that is about a radius.
    """
    low, high = lines.bounds.astype(np.float64)
    middle, scale = (low + high) / 2, SIDE / float((high - low).max())

    def moved(points: Any) -> Any:
        return (np.asarray(points, np.float64) - middle) * scale

    origin, target = (tuple(moved(point).tolist()) for point in (camera.origin, camera.target))
    segments = moved(lines.segments).astype(np.float32)
    return replace(lines, segments=segments), radius * scale, replace(camera, origin=origin, target=target)


def geometry_of(lines: Lines, radius: float, shape: str, path: Path, tolerance: float | None = None) -> Lines | Curves:
    """Write hairs to a file of Mitsuba, and return what we render: the same lines, or the curves of the file.

    The tolerance of curves is a fraction of the radius; None stands for the default of `fl.Curves`.
    """
    ends = np.full(lines.segments.shape[:2], radius, np.float32)
    fl.write(path, replace(lines, radius=ends, up=None, attributes={}, end_attributes={}))
    if shape == "linear":
        return lines
    curves = fl.read(path, basis="bspline")
    assert isinstance(curves, Curves)
    return curves if tolerance is None else replace(curves, tolerance=tolerance * radius)
