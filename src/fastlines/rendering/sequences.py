"""Pictures one after another from one tree: a turn around the lines, and lines that grow thicker."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import count, number
from ..camera import Camera
from ..errors import InputError
from ..progress import ProgressOption
from .color.legend import ColorBar, emptiest_corner
from .default_view import ViewOptions
from .measures import Measure
from .pictures.picture import Picture
from .plan import PictureOptions, PicturePlan, plan_picture
from .renderer import draw

#: The most pictures of a sequence.
MAX_PICTURES = 100_000


def turntable(
    tree: Any,
    n_pictures: int,
    camera: Camera | None = None,
    *,
    degrees: float = 360.0,
    progress: ProgressOption = False,
    **options: Any,
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
    progress : bool or callable
        Of each picture.
    **options
        The others of `render`. A radius that is not given is chosen once, and so is the range of the colours of a
        measure.

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
    plan = plan_picture(tree, PictureOptions(camera=camera or ViewOptions(turns=True), **options))
    return turned(plan, n_pictures, degrees, progress)


def radius_sweep(
    tree: Any,
    radii: Sequence[float],
    camera: Camera | None = None,
    *,
    progress: ProgressOption = False,
    **options: Any,
) -> Iterator[Picture]:
    """Render pictures of the same lines with other radii, all from one tree.

    Parameters
    ----------
    tree : Tree, or what `build` takes
    radii : sequence of numbers
        `spaced_radii` makes them.
    camera : Camera, optional
        By default one that frames the geometry.
    progress : bool or callable
        Of each picture.
    **options
        The others of `render`, without the radius. The colours of a measure have a range of their own in each picture,
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
    return swept(plan_picture(tree, PictureOptions(camera=camera, **options), radii=radii), radii, progress)


def turned(
    plan: PicturePlan, n_pictures: int, degrees: float = 360.0, progress: ProgressOption = False
) -> Iterator[Picture]:
    """Draw a plan from each camera of a turn; keep the range of a measure of the first picture."""
    return _with_steady_legend(_turned(plan, n_pictures, degrees, progress))


def _turned(plan: PicturePlan, n_pictures: int, degrees: float, progress: ProgressOption) -> Iterator[Picture]:
    for i in range(n_pictures):
        picture = draw(replace(plan, camera=plan.camera.orbit(degrees * i / n_pictures)), progress)
        look = plan.look
        if isinstance(look, Measure) and look.range is None and isinstance(picture.legend, ColorBar):
            plan = replace(plan, look=replace(look, range=(picture.legend.low, picture.legend.high)))
        yield picture


def swept(plan: PicturePlan, radii: Sequence[float], progress: ProgressOption = False) -> Iterator[Picture]:
    """Draw a plan with each radius."""
    return _with_steady_legend(draw(replace(plan, radius=radius), progress) for radius in radii)


def _with_steady_legend(pictures: Iterator[Picture]) -> Iterator[Picture]:
    """Put the legend of all pictures into the corner of the first."""
    corner = None
    for picture in pictures:
        if picture.shows_legend and picture.legend is not None:
            corner = corner or emptiest_corner(picture.alpha, picture.legend)
        yield replace(picture, corner=corner)


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
