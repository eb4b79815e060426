"""What the rays of a picture hit: fragments of lines, each with the fraction of a pixel that it covers.

Lines thinner than about a pixel are found by cones: all lines that come within the radius R of a spot around the ray.
Such a line covers the fraction K((d + r)/R) − K((d − r)/R) of the spot. Here r is its radius, d its distance from the
ray, and K the integral of the kernel of Epanechnikov across the line. So a line is neither missed nor drawn too thick,
however thin it is. A strand counts once where it comes near: a hit at the end of a segment is left out if the strand
goes on and comes nearer.

Thicker lines, and all other shapes, are hit by rays at their surface, and cover the whole sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray
from ...engines import engine
from ...query.hit_geometry import outside_distance
from ...query.hit_lists import offsets_of
from ...query.hits import AllHits, FirstHits
from ...support.computed_once import computed_once
from ...tree import Tree
from .control_points import control_points

#: The radius of the spot around a ray, in pixels.
SPOT = 0.75
#: Fragments behind this opacity are not drawn.
OPAQUE = 0.995
#: Fragments of a smaller weight are drawn by chance.
FAINT = 0.08
#: The most fragments of a ray.
MAX_FRAGMENTS = 128


@dataclass(frozen=True)
class Fragments:
    """Parts of lines as some rays see them, in the order of the rays and, for each ray, from the front to the back.

    Attributes
    ----------
    hits : AllHits
        One hit for each fragment.
    ray : (n,) int64
        The ray that sees each fragment.
    weight : (n,) float32
        The fraction of the ray's light that comes from the fragment: what it covers and nothing nearer hides.
    to_eye : (n, 3) float32
        Unit vectors from the fragments to the origins of the rays.
    points : (n, 3) float32
        Of cones: the point of the ray that is nearest to the line. Else the point of the surface.
    opacity : (n_rays,) float32
        The fraction of each ray that lines cover.
    normals : (n, 3) float32 or None
        Outwards, at a surface; None for cones.
    axes : (n, 3) float32, optional
        The tangents, if they are known.
    """

    hits: AllHits
    ray: IntArray
    weight: FloatArray
    to_eye: FloatArray
    points: FloatArray
    opacity: FloatArray
    normals: FloatArray | None = None
    axes: FloatArray | None = None

    def __len__(self) -> int:
        return len(self.ray)

    @computed_once
    def tangents(self) -> FloatArray:
        """The unit direction of the line of each fragment, (n, 3); zero where there is none."""
        return np.nan_to_num(self.hits.tangents()).astype(np.float32, "C") if self.axes is None else self.axes

    @computed_once
    def smooth_tangents(self) -> FloatArray:
        """The same without steps from segment to segment, for highlights."""
        geometry, hits = self.hits.geometry, self.hits
        assert geometry is not None
        return geometry.smooth_tangents_at(hits.prim_number, hits.u, self.tangents)

    @property
    def strand(self) -> IntArray:
        """The strand of each fragment; for what has none, its primitive."""
        return np.where(self.hits.strand >= 0, self.hits.strand, self.hits.prim)


class Cones:
    """Finds fragments of lines that are thinner than a pixel."""

    def __init__(self, tree: Tree, radius: float, spread: float, opacity: float) -> None:
        """Take the spread of half a pixel, and about the opacity of a line in the middle of a spot."""
        self.tree, self.radius = tree, radius
        self.spread = 2 * SPOT * spread
        self.k = int(np.clip(np.ceil(6 / max(opacity, 1e-3)), 8, MAX_FRAGMENTS))

    def find(self, origins: FloatArray, directions: FloatArray, offsets: FloatArray | float) -> Fragments:
        """Return the fragments in the cones of rays with unit directions; offsets in [0, 1) choose among faint ones."""
        geometry = self.tree.geometry
        hits = self.tree.next_hits(origins, directions, self.radius, self.k, spread=self.spread)
        own = hits.sample("radius").astype(np.float32) if geometry.radius_beyond > 0 else None
        axis, axes = control_points(geometry, hits.prim)
        rows, ray, weight, opacity = engine.cone_fragments(
            (hits.offsets, axis, hits.t, hits.u, hits.distance, own),
            np.ascontiguousarray(origins, np.float32),
            np.ascontiguousarray(directions, np.float32),
            axes,
            (self.radius, self.spread, OPAQUE, FAINT),
            np.asarray(offsets, np.float32).reshape(-1),
        )
        points = np.asarray(origins[ray] + hits.t[rows, None] * directions[ray], np.float32)
        return Fragments(some_hits(hits, rows, ray), ray, weight, -directions[ray], points, opacity)


class Surfaces:
    """Finds the nearest surfaces."""

    def __init__(self, tree: Tree, radius: float) -> None:
        self.tree, self.radius = tree, radius
        self._lift = float(outside_distance(tree.geometry, tree.geometry.max_radius, radius))

    def find(self, origins: FloatArray, directions: FloatArray, offsets: FloatArray | float) -> Fragments:
        """Return where rays with unit directions enter surfaces: one fragment for each ray that hits."""
        hits = self.tree.first_surface(origins, directions, self.radius)
        ray = np.flatnonzero(hits.hit)
        frames = hits.frames(lift=self._lift)
        ones, opacity = np.ones(len(ray), np.float32), hits.hit.astype(np.float32)
        surface = frames.to_eye, frames.points, opacity, frames.normals, frames.tangents
        return Fragments(some_hits(hits, ray, ray), ray, ones, *surface)


def some_hits(hits: AllHits | FirstHits, rows: IntArray, ray: IntArray) -> AllHits:
    """Return some of the hits, in their order, and the ray of each."""
    assert hits.rays is not None
    part = None if hits.part is None else hits.part[rows]
    offsets = offsets_of(ray, len(hits.rays))
    columns = hits.t[rows], hits.prim[rows], hits.u[rows], hits.distance[rows]
    t_out = None if hits.t_out is None else hits.t_out[rows]
    return AllHits(offsets, *columns, t_out, hits.skipped, hits.geometry, hits.rays, part)
