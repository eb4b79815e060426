"""The five scenes of the thesis (§6), made by seeded generators: any size, about the unit cube, y up.

The numbers of a scene come from ``numpy.random.default_rng([seed, crc32(name)])``. So each scene has its own stream,
and the same name, size and seed give the same lines. A smaller scene is the beginning of a larger one.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import count, did_you_mean
from ..camera import Camera, Vector
from ..errors import InputError
from ..geometry.lines import Lines
from . import beams, bun_hair, spaghetti, straight_hair
from .interpolated import dense_hair

__all__ = ["MAX_SEGMENTS", "NAMES", "RADII", "Scene", "dense_hair", "make"]

#: The most segments of a scene, which take some gigabytes of random numbers.
MAX_SEGMENTS = 100_000_000

#: The radii of the thesis's queries: wide, medium, narrow.
RADII = {"W": 0.005, "M": 0.001, "N": 0.0005}


@dataclass(frozen=True)
class Scene:
    """Lines and a camera that shows them.

    Attributes
    ----------
    name : str
        Its name for `make`.
    title : str
        Its name in the thesis.
    lines : Lines
    camera : Camera
        Fills the frame of a square picture.
    """

    name: str
    title: str
    lines: Lines
    camera: Camera


@dataclass(frozen=True)
class _Recipe:
    title: str
    n_segments: int  # as in the thesis
    generate: Callable[[int, np.random.Generator], Lines]
    direction: Vector  # of view


_RECIPES = {
    "bun-hair": _Recipe("Bun Hair", 82_250, bun_hair.generate, (-0.9, -0.25, 0.5)),
    "straight-hair": _Recipe("Straight Hair", 87_460, straight_hair.generate, (-0.9, -0.25, 1.0)),
    "spaghetti": _Recipe("Spaghetti", 2_000, spaghetti.generate, (-0.2, -0.15, -1.0)),
    "spaghetti-2": _Recipe("Spaghetti 2", 8_000, spaghetti.generate, (-0.2, -0.15, -1.0)),
    "photon-beams": _Recipe("Photon Beams", 36_294, beams.generate, (-0.2, -0.15, -1.0)),
}

NAMES = tuple(_RECIPES)


def make(name: str, n_segments: int | None = None, seed: int = 0) -> Scene:
    """Make one of the thesis's scenes.

    Parameters
    ----------
    name : str
        One of `NAMES`.
    n_segments : int, optional
        The exact number of segments, up to `MAX_SEGMENTS`; by default the thesis's. The last strand may be cut short.
    seed : int
        Another seed gives another scene of the same kind.

    Raises
    ------
    InputError
        If there is no such scene, or a number is not usable.

    Examples
    --------
    >>> scene = make("spaghetti")
    >>> scene.title, len(scene.lines)
    ('Spaghetti', 2000)
    """
    if not isinstance(name, str) or name not in _RECIPES:
        raise InputError(f"there is no scene {name!r}{did_you_mean(name, NAMES)}")
    recipe = _RECIPES[name]
    n_segments = count("n_segments", recipe.n_segments if n_segments is None else n_segments, 1, MAX_SEGMENTS)
    rng = np.random.default_rng([count("seed", seed, 0), zlib.crc32(name.encode())])
    lines = replace(recipe.generate(n_segments, rng), up="y")
    return Scene(name, recipe.title, lines, Camera.framing(lines, recipe.direction))
