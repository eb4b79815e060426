"""Pictures one after another from one tree: a turn around the lines, and lines that grow thicker."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import count, number
from ..builder import build
from ..camera import Camera, Vector
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..tree import Tree
from .color.legend import ColorBar
from .default_view import complete_size, default_camera, default_size, default_view
from .measures import MEASURES, Measure
from .pictures.picture import Picture
from .renderer import render
from .shading.depth import SIZE, check_size
from .suitable_radius import suitable_radius

#: The most pictures of a sequence.
MAX_PICTURES = 100_000


def turntable(
    tree: Any, n_pictures: int, camera: Camera | None = None, *, degrees: float = 360.0, **options: Any
) -> Iterator[Picture]:
    """Render pictures from a camera that turns around the lines.

    Parameters
    ----------
    tree : Tree, or what `build` takes
    n_pictures : int
        How many pictures make the turn. The next one would be the first again.
    camera : Camera, optional
        The first view; it turns about its upward axis through its target. By default `turntable_camera`.
    degrees : float
        The whole turn, seen from above counter-clockwise.
    **options
        Those of `render`. A radius that is not given is chosen once, and so is the range of the colours of a measure.

    Yields
    ------
    Picture

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 50).lines)
    >>> [picture.alpha.any() for picture in turntable(tree, 3, width=16, height=16, samples=1)]
    [np.True_, np.True_, np.True_]
    """
    count("n_pictures", n_pictures, 1, MAX_PICTURES)
    made = tree if isinstance(tree, Tree) else build(tree)
    width, height = _size(options, (SIZE, SIZE))
    first = camera or turntable_camera(made.geometry, aspect=width / height)
    if options.get("radius") is None and made.geometry.needs_radius:
        options["radius"] = suitable_radius(made, first)
    cameras = (first.orbit(degrees * i / n_pictures) for i in range(n_pictures))
    return _turned(made, cameras, options)


def radius_sweep(tree: Any, radii: Sequence[float], camera: Camera | None = None, **options: Any) -> Iterator[Picture]:
    """Render pictures of the same lines with other radii, all from one tree.

    Parameters
    ----------
    tree : Tree, or what `build` takes
    radii : sequence of numbers
        `spaced_radii` makes them.
    camera : Camera, optional
        By default one that frames the geometry.
    **options
        Those of `render`, without the radius. The colours of a measure have a range of their own in each picture,
        unless the measure has one.

    Yields
    ------
    Picture

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 50).lines)
    >>> pictures = radius_sweep(tree, spaced_radii(0.001, 0.1, 3), width=16, height=16, samples=1)
    >>> covered = [picture.alpha.mean() for picture in pictures]
    >>> covered == sorted(covered)
    True
    """
    if "radius" in options:
        raise InputError("radius_sweep takes the radii, one for each picture; leave out radius=")
    for radius in radii:
        number("radius", radius, "a finite number that is not negative", 0.0)
    made = tree if isinstance(tree, Tree) else build(tree)
    suitable = (SIZE, SIZE) if camera is not None else default_size(made.geometry, SIZE)
    options["width"], options["height"] = _size(options, suitable)
    view = camera or default_camera(made.geometry, aspect=options["width"] / options["height"])
    return (render(made, view, radius=radius, **options) for radius in radii)


def _size(options: dict[str, Any], suitable: tuple[int, int]) -> tuple[int, int]:
    """Return the size of pictures; what is not given follows from a suitable one."""
    given = options.get("width"), options.get("height")
    check_size(*(SIZE if side is None else side for side in given))
    return complete_size(*given, suitable)


def spaced_radii(first: float, last: float, n_radii: int) -> list[float]:
    """Return radii from the first to the last: each is the same factor larger, or from 0 on the same step.

    Examples
    --------
    >>> spaced_radii(0.01, 1, 3), spaced_radii(0, 1, 3)
    ([0.01, 0.1, 1.0], [0.0, 0.5, 1.0])
    """
    count("n_radii", n_radii, 1, MAX_PICTURES)
    for radius in (first, last):
        number("radius", radius, "a finite number that is not negative", 0.0)
    spaced = np.geomspace if first > 0 and last > 0 else np.linspace
    return [float(f"{radius:.12g}") for radius in spaced(first, last, n_radii)]


def turntable_camera(
    geometry: AnyGeometry,
    *,
    direction: Vector | None = None,
    up: Vector | None = None,
    fov_degrees: float = 30.0,
    aspect: float = 1.0,
) -> Camera:
    """Return a camera that shows all lines at every angle of a turn; `default_view` chooses what is not given.

    It frames the upright cylinder around the lines. Its target is on the cylinder's axis.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.lines([[[0, 0, 0], [4, 0, 0]], [[2, -1, -2], [2, 1, 2]]])
    >>> camera = turntable_camera(lines, direction=(0, 0, -1), up=(0, 1, 0))
    >>> [round(x, 6) for x in camera.target]
    [2.0, 0.0, 0.0]
    """
    default_direction, default_up = default_view(geometry)
    direction, up = direction or default_direction, up or default_up
    points, radii = (values.astype(np.float64) for values in geometry.span())
    if len(points) == 0:
        return default_camera(geometry, direction=direction, up=up, fov_degrees=fov_degrees, aspect=aspect)
    # Find the cylinder about the upward axis.
    axis = np.asarray(up, np.float64) / math.sqrt(sum(x * x for x in up))
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    height = ((points - centre) * axis).sum(axis=1)
    away = points - centre - height[:, None] * axis
    wide = float((np.sqrt((away**2).sum(axis=1)) + radii).max())
    low, high = float((height - radii).min()), float((height + radii).max())
    # Frame two of its circles.
    one = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    one /= math.sqrt(float((one**2).sum()))
    turns = np.linspace(0, 2 * np.pi, 64, endpoint=False)[:, None]
    circle = wide * (np.cos(turns) * one + np.sin(turns) * np.cross(axis, one))
    rims = np.concatenate([centre + low * axis + circle, centre + high * axis + circle])
    camera = Camera.framing(rims, direction, up, fov_degrees=fov_degrees, aspect=aspect)
    # Move the target along the view to the axis.
    forward, start = camera.axes()[2], np.subtract(camera.origin, centre)
    across = forward - (forward * axis).sum() * axis
    level = float((across**2).sum())
    if level < 1e-12:
        return camera
    distance = -float((start * across).sum()) / level
    x, y, z = (camera.origin + distance * forward).tolist()
    return replace(camera, target=(x, y, z))


def _turned(tree: Tree, cameras: Iterator[Camera], options: dict[str, Any]) -> Iterator[Picture]:
    """Render from each camera; keep the range of a measure of the first picture."""
    for camera in cameras:
        picture = render(tree, camera, **options)
        look = options.get("look")
        measure = MEASURES.get(look) if isinstance(look, str) else look
        if isinstance(measure, Measure) and measure.range is None and isinstance(picture.legend, ColorBar):
            options["look"] = replace(measure, range=(picture.legend.low, picture.legend.high))
        yield picture
