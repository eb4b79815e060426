"""Pictures of work: how many nodes are visited, and primitives tested, for the ray of each pixel."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fastlines import Camera, Tree

from ..harness.arrays import Float64Array
from ..harness.rays import camera_rays
from ..harness.visits import visits_of_rays

#: The colour of a count, from 1 to MOST on a logarithmic scale; 0 is black.
COLOURS = np.array(
    [(22, 11, 57), (66, 10, 104), (147, 38, 103), (221, 81, 58), (252, 165, 10), (252, 255, 164)], np.float64
)
MOST = 10_000
#: Rays are followed so many at a time, which bounds the memory.
BATCH = 1024


def visit_maps(tree: Tree, camera: Camera, size: int, radius: float) -> tuple[Float64Array, Float64Array]:
    """Count the nodes whose boxes the ray of each pixel meets, and the references in the leaves among them.

    These are the steps of a search for all hits in the tree as it was built.

    Returns
    -------
    nodes, tests : (size, size) float64
    """
    rays = camera_rays(camera, size * size)
    found = [visits_of_rays(tree, rays.take(slice(i, i + BATCH)), radius) for i in range(0, len(rays), BATCH)]
    nodes, tests = (
        np.concatenate(counts).astype(np.float64).reshape(size, size) for counts in zip(*found, strict=True)
    )
    return nodes, tests


def colour(counts: Float64Array) -> npt.NDArray[np.uint8]:
    """Give counts (h, w) the colours of the scale: (h, w, 3)."""
    place = np.log(np.clip(counts, 1, MOST)) / np.log(MOST)
    stops = np.linspace(0, 1, len(COLOURS))
    picture = np.stack([np.interp(place, stops, COLOURS[:, k]) for k in range(3)], axis=-1)
    picture[counts < 1] = 0
    rounded: npt.NDArray[np.uint8] = (picture + 0.5).astype(np.uint8)
    return rounded
