"""Heat maps: the numbers of nodes visited and of primitives tested for the ray of each pixel."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fastlines import Camera, Tree

from ..harness.arrays import Float64Array
from ..harness.rays import camera_rays
from ..harness.visits import visits_of_rays

#: The colours of counts from 1 to MAX_COUNT on a logarithmic scale; 0 is black.
COLOURS = np.array(
    [(22, 11, 57), (66, 10, 104), (147, 38, 103), (221, 81, 58), (252, 165, 10), (252, 255, 164)], np.float64
)
MAX_COUNT = 10_000
#: The number of rays that are traced at a time, which limits the memory.
BATCH = 1024


def visit_maps(tree: Tree, camera: Camera, size: int, radius: float) -> tuple[Float64Array, Float64Array]:
    """Return the numbers of nodes whose boxes the ray of each pixel hits, and of references in the leaves among them.

    These are the steps of a traversal of the binary tree for all hits.

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
    """Return the colours of counts (h, w): (h, w, 3)."""
    place = np.log(np.clip(counts, 1, MAX_COUNT)) / np.log(MAX_COUNT)
    stops = np.linspace(0, 1, len(COLOURS))
    picture = np.stack([np.interp(place, stops, COLOURS[:, k]) for k in range(3)], axis=-1)
    picture[counts < 1] = 0
    rounded: npt.NDArray[np.uint8] = (picture + 0.5).astype(np.uint8)
    return rounded
