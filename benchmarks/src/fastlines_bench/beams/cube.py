"""The thesis's scene of photon beams: a mirrored cube, with a power for each beam."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import fastlines as fl

from ..harness.arrays import FloatArray
from ..harness.internals import CUBE_EXTINCTION, CUBE_G
from ..harness.rays import RayBatch, camera_rays
from ..peers.gathering import Gathering


@dataclass(frozen=True, eq=False)
class Cube:
    """Beams in the cube, and the rays that gather them.

    Attributes
    ----------
    lines : Lines
        A beam for each flight of a photon. Its length was drawn, so it is a short beam.
    powers : (n, 3) float32
        Every photon has its own colour, of one photon's share of a power of 1.
    rays : RayBatch
        A square picture.
    """

    lines: fl.Lines
    powers: FloatArray
    rays: RayBatch

    def gathering(self, radius: float) -> Gathering:
        """Return what a gather sums: the scene's extinction and its phase function."""
        return Gathering(radius, CUBE_EXTINCTION, 0.0, CUBE_G)


def radius_of(n_beams: int) -> float:
    """Return the radius for so many beams: a ray crosses some tens or hundreds of them."""
    return 0.005 if n_beams < 100_000 else 0.001


def make_cube(n_beams: int, size: int, seed: int = 0) -> Cube:
    """Trace photons until there are `n_beams`, for a picture of size² pixels."""
    scene = fl.scenes.make("photon-beams", n_beams, seed)
    photons = scene.lines.strands
    hues = np.arange(int(photons.max()) + 1) * 0.618034 % 1.0  # neighbours differ: multiples of the golden ratio
    colours = np.clip(np.abs((hues[:, None] * 6 + [3, 1, 5]) % 6 - 3) - 1, 0, 1)
    powers = (colours[photons] / len(hues)).astype(np.float32)
    return Cube(scene.lines, powers, camera_rays(scene.camera, size * size))
