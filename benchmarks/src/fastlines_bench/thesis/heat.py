"""Heat maps: the numbers of nodes visited and of primitives tested for the ray of each pixel.

These are the steps of a traversal of the binary tree for all hits, whatever the order of children (thesis §3.3).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fastlines import Camera, Tree

from ..harness.arrays import Float64Array, IntArray
from ..harness.rays import RayBatch, camera_rays

#: The colours of counts from 1 to MAX_COUNT on a logarithmic scale; 0 is black.
COLOURS = np.array(
    [(22, 11, 57), (66, 10, 104), (147, 38, 103), (221, 81, 58), (252, 165, 10), (252, 255, 164)], np.float64
)
MAX_COUNT = 10_000
#: The number of rays that are traced at a time, which limits the memory.
BATCH = 1024


def visit_maps(tree: Tree, camera: Camera, size: int, radius: float) -> tuple[Float64Array, Float64Array]:
    """Return the numbers of nodes whose boxes the ray of each pixel hits, and of references in the leaves among them.

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


def visits_of_rays(tree: Tree, rays: RayBatch, radius: float) -> tuple[IntArray, IntArray]:
    """Return for each ray the number of nodes hit, with leaves, and of references in those leaves: (n,) int64 each."""
    right, n_refs = (tree.nodes[name].astype(np.int64) for name in ("right", "n_refs"))
    visited, tests = np.zeros(len(rays), np.int64), np.zeros(len(rays), np.int64)
    # Traverse the tree level by level with all rays at once.
    items, nodes = np.arange(len(rays)), np.zeros(len(rays), np.int64)
    while len(items):
        hit = _hit_boxes(tree, rays, radius, items, nodes)
        items, nodes = items[hit], nodes[hit]
        inner = right[nodes] > 0
        visited += np.bincount(items, minlength=len(rays))
        tests += np.bincount(items, np.where(inner, 0, n_refs[nodes]), len(rays)).astype(np.int64)
        items, nodes = np.tile(items[inner], 2), np.concatenate([nodes[inner] + 1, right[nodes[inner]]])
    return visited, tests


def _hit_boxes(tree: Tree, rays: RayBatch, radius: float, items: IntArray, nodes: IntArray) -> npt.NDArray[np.bool_]:
    """Return whether rays hit the boxes of nodes, enlarged by the radius, pair by pair."""
    box = tree.nodes["box"][nodes].astype(np.float64)
    origins, directions = (a[items].astype(np.float64) for a in (rays.origins, rays.directions))
    # A ray in the plane of a face gives 0/0 = NaN and hits it: fmax and fmin skip NaN.
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = ((corner - origins) / directions for corner in (box[:, 0] - radius, box[:, 1] + radius))
    enter, leave = np.full(len(items), rays.t_min), np.full(len(items), rays.t_max)
    for axis in range(3):
        enter = np.fmax(enter, np.minimum(low[:, axis], high[:, axis]))
        leave = np.fmin(leave, np.maximum(low[:, axis], high[:, axis]))
    hit: npt.NDArray[np.bool_] = enter <= leave
    return hit


def colour(counts: Float64Array) -> npt.NDArray[np.uint8]:
    """Return the colours of counts (h, w): (h, w, 3)."""
    place = np.log(np.clip(counts, 1, MAX_COUNT)) / np.log(MAX_COUNT)
    stops = np.linspace(0, 1, len(COLOURS))
    picture = np.stack([np.interp(place, stops, COLOURS[:, k]) for k in range(3)], axis=-1)
    picture[counts < 1] = 0
    rounded: npt.NDArray[np.uint8] = (picture + 0.5).astype(np.uint8)
    return rounded
