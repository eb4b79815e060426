"""A radius that suits a picture: the least round number with which it is not almost empty."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ..camera import Camera
from ..forest.forest import AnyTree
from ..support.distinct import distinct
from ..support.vectors import is_point
from .shading.depth_tone import pixel_size

#: A radius suits a query if at least this fraction of the rays that cross the box of the lines hit.
MANY = 0.25
#: The bounds of the radius of a picture, and one with which lines look closed, as fractions of the longest side.
THINNEST, THICKEST, COARSE = 1 / 1500, 1 / 400, 1 / 100
#: The largest radius of hair in a picture, about that of a pixel: thicker hairs look like noodles.
THICKEST_HAIR = 1 / 1000
#: At least this fraction of the rays hit that hit with the coarse radius.
CLOSED = 0.8
#: The least radius of the sticks of a molecule, in Å.
STICK = 0.25
#: The radius of what is a single point, as a fraction of the height of the picture.
DOT = 1 / 20
#: How many rays are tried, spread evenly over all; they say nothing if fewer than `LEAST` of them cross the box.
TRIED, LEAST = 4096, 100


def suitable_radius(tree: AnyTree, camera: Camera, thickest: float = THICKEST) -> float:
    """Return the least of the radii 1, 2, 5, 10 … with which lines look closed where they are dense.

    With it, `CLOSED` of the rays of a picture hit that hit with the radius `COARSE`. It is not less than `THINNEST` and
    not more than `thickest`, all of them times the longest side of the box. Flat lines have the least radius. Lines
    that are nowhere dense have the largest, such as a single one. Points may be as thick as `COARSE`, and so may lines
    that are shorter than that altogether. What is a single point has the radius `DOT`. Sticks of molecules have the
    radius `STICK` at least.

    Parameters
    ----------
    tree : Tree
        Over at least one primitive.
    camera : Camera
    thickest : float
        `THICKEST_HAIR` for hair.

    Examples
    --------
    >>> import fastlines as fl
    >>> scene = fl.scenes.make("spaghetti")
    >>> suitable_radius(fl.build(scene.lines), scene.camera)
    0.002
    >>> line = fl.lines([[[0, 0, 0], [0, 0, 1]]])
    >>> suitable_radius(fl.build(line), fl.Camera.framing(line))
    0.002
    """
    low, high = tree.box.astype(np.float64)
    if is_point(low, high):
        return round_number(DOT * pixel_size(tree.geometry, camera, 1))
    extent = high - low
    size = float(extent.max())
    least, most, coarse = (round_number(part * size) for part in (THINNEST, thickest, COARSE))
    if tree.geometry.unit == "Å":
        least = max(least, STICK)
        most = max(most, least)
    are_dots = tree.geometry.total_length <= coarse and all(part.has_axes for part in tree.geometry.each_part())
    if are_dots:
        most = coarse
    side = round(TRIED**0.5)
    rays = some_rays(tree, *camera.rays(side, side))
    enough = 0.0 if rays is None else CLOSED * tree.any_hit(rays[0], rays[1], coarse).sum()
    if rays is None or enough == 0:
        return most
    if extent.min() == 0 and not are_dots:
        return least  # flat lines, such as a map, have gaps
    tried = [least, *round_numbers(least, most)]
    return next((radius for radius in tried if tree.any_hit(rays[0], rays[1], radius).sum() >= enough), most)


def round_number(number: float) -> float:
    """Return the nearest of the numbers 1, 2 and 5 times a power of ten.

    Examples
    --------
    >>> round_number(0.0018), round_number(4.2)
    (0.002, 5.0)
    """
    return min(round_numbers(number / 10, number * 10), key=lambda other: abs(math.log(other / number)))


def some_rays(tree: AnyTree, origins: npt.ArrayLike, directions: npt.ArrayLike, **bounds: Any) -> Any:
    """Return some of the rays that cross the box of the lines; None if they are too few."""
    origins, directions = (np.reshape(a, (-1, 3)) for a in np.broadcast_arrays(origins, directions))
    if len(origins) < LEAST or tree.n_prims == 0:
        return None
    # Spread the tried rays evenly, also over the rows and columns of a picture, by multiples of the golden ratio.
    tried = distinct((np.arange(TRIED) * ((5**0.5 - 1) / 2) % 1 * len(origins)).astype(np.int64))
    origins, directions = origins[tried], directions[tried]
    crossing = cross(tree.box, origins - np.array(tree.geometry.offset), directions, **bounds)
    return (origins[crossing], directions[crossing]) if crossing.sum() >= LEAST else None


def least_radius(tree: AnyTree, rays: Any, radius: float, **asked: Any) -> tuple[float | None, float]:
    """Return the least round radius above a given one with which enough of the rays hit, and which share does."""
    size = float(np.ptp(tree.box, axis=0).max())
    for larger in round_numbers(max(radius, 1e-6 * size), size):
        suits = float(tree.any_hit(rays[0], rays[1], larger, **asked).mean())
        if suits >= MANY:
            return larger, suits
    return None, 0.0


def small(width: int, height: int) -> tuple[int, int]:
    """Return the size of a picture of the same shape with about `TRIED` pixels."""
    shrink = max(1.0, (width * height / TRIED) ** 0.5)
    return max(1, round(width / shrink)), max(1, round(height / shrink))


def round_numbers(low: float, high: float) -> list[float]:
    """Return the numbers 1, 2 and 5 times a power of ten that are above `low` and up to `high`."""
    if not 0 < low < high:
        return []
    tens = range(math.floor(math.log10(low)), math.floor(math.log10(high)) + 1)
    return [number for ten in tens for digit in (1, 2, 5) if low < (number := float(f"{digit}e{ten}")) <= high]


def cross(
    box: npt.NDArray[np.float32],
    origins: npt.NDArray[Any],
    directions: npt.NDArray[Any],
    t_min: float = 0.0,
    t_max: float = float("inf"),
) -> npt.NDArray[np.bool_]:
    """Return which rays cross a box."""
    low, high = box.astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        sides = [(side - origins) / directions.astype(np.float64) for side in (low, high)]
    # A ray parallel to two sides is always or never between them.
    still, between = directions == 0, (low <= origins) & (origins <= high)
    enter = np.where(still, np.where(between, -np.inf, np.inf), np.minimum(*sides))
    leave = np.where(still, np.inf, np.maximum(*sides))
    return np.asarray(enter.max(axis=1, initial=t_min) <= leave.min(axis=1, initial=t_max))
