"""Depth images: the distance of the nearest line in each pixel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, count, number
from ...camera import Camera
from ...errors import InputError
from ...progress import ProgressOption, reporting
from ...query.rays import require_radius
from ...tree import Tree
from .own_frame import in_own_frame

#: The most pixels of a picture: an 8K screen has fewer.
MAX_PIXELS = 1 << 25
#: The most rays traced at a time, which bounds the memory of a large picture.
MAX_BATCH = 1 << 20
#: The same where each ray is shaded or measured; what that needs stays in the cache.
MAX_RAYS = 1 << 16
#: The fewest that are worth a call, unless a picture has fewer.
MIN_RAYS = 1 << 14
#: How many such batches are traced at a time, in threads of their own.
MAX_BANDS = 16
#: The width and the height of a picture, unless others are given.
SIZE = 1024
#: The expected value of a radius, for error messages.
RADIUS = "a finite number that is not negative"


def depth_image(
    tree: Tree, camera: Camera, width: int, height: int, radius: float | None = None, progress: ProgressOption = False
) -> FloatArray:
    """Find the depth of the nearest line through the centre of each pixel.

    Parameters
    ----------
    tree : Tree
        Over lines.
    camera : Camera
    width, height : int
        The size of the image in pixels; at most `MAX_PIXELS` in all.
    radius : float, optional
        Half the thickness of the lines, in the unit of the coordinates. It is added to the radius of the lines, and is
        needed if they have none.
    progress : bool or callable
        Show a bar, or call back with the fraction that is done.

    Returns
    -------
    (height, width) float32
        The distance from the camera's origin along the ray of the pixel; inf where it hits nothing.

    Raises
    ------
    InputError
        If the size or the radius cannot be used.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    >>> depth_image(tree, fl.Camera(origin=(0, 0, 4), target=(0, 0, 0)), 1, 3, radius=0.1).ravel().tolist()
    [inf, 4.0, inf]
    """
    check_size(width, height)
    tree, camera = in_own_frame(tree, camera)
    view = View(tree, camera, width, height)
    radius = check_radius(tree, radius)
    depth = np.empty((height, width), np.float32)
    with reporting(progress, "render") as callback:
        for rows in bands(width, height):
            depth[rows] = view.depth(radius, rows)
            if callback is not None:
                callback(rows.stop / height)
    return depth


def check_radius(tree: Tree, radius: float | None) -> float:
    """Check the radius of a picture."""
    require_radius(tree.geometry, radius)
    return number("radius", 0.0 if radius is None else radius, RADIUS, 0.0)


@dataclass(frozen=True)
class View:
    """A tree as a camera shows it in a picture of some size."""

    tree: Tree
    camera: Camera
    width: int
    height: int

    def rays(self, rows: slice, at: tuple[float, float] = (0.5, 0.5)) -> tuple[FloatArray, FloatArray]:
        """Return the origin and the directions of rays through one point of each pixel in some rows."""
        directions = self.camera.directions(self.width, self.height, rows, at)
        return np.asarray(self.camera.origin, np.float32), directions

    def depth(self, radius: float, rows: slice, at: tuple[float, float] = (0.5, 0.5)) -> FloatArray:
        """Return the distance at which each of these rays hits, at the surface if there is one; inf for a miss."""
        find = self.tree.first_hit if self.tree.geometry.needs_radius else self.tree.first_surface
        return find(*self.rays(rows, at), radius).t


def bands(width: int, height: int, max_rays: int = MAX_BATCH) -> Iterator[slice]:
    """Divide a picture into bands of rows, each of at most `max_rays` pixels or one row."""
    n_rows = max(1, max_rays // width)
    for top in range(0, height, n_rows):
        yield slice(top, min(top + n_rows, height))


def check_size(width: int, height: int) -> None:
    """Refuse a picture without pixels or with too many."""
    if count("width", width, 1, MAX_PIXELS) * count("height", height, 1, MAX_PIXELS) > MAX_PIXELS:
        raise InputError(f"a picture of {width} × {height} pixels has more than {MAX_PIXELS:,}; choose a smaller one")
