"""What the rays of a picture see: fragments of lines, each with the fraction of a pixel that it covers.

Lines thinner than about a pixel are found by cones: all lines that come within the radius R of a spot around the ray.
Such a line covers the fraction K((d + r)/R) − K((d − r)/R) of the spot. Here r is its radius, d its distance from the
ray, and K the integral of the kernel of Epanechnikov across the line. So a line is neither missed nor drawn too thick,
however thin it is. A strand counts once where it comes near: a hit at the end of a segment is left out if the strand
goes on and comes nearer.

Thicker lines, and all other shapes, are hit by rays at their surface, and cover the whole sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ...query.hit_lists import offsets_of
from ...query.hits import AllHits, FirstHits
from ...support.computed_once import computed_once
from ...support.vectors import dot
from ...tree import Tree
from .following import AxisEnds, Following

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
    """

    hits: AllHits
    ray: IntArray
    weight: FloatArray
    to_eye: FloatArray
    points: FloatArray
    opacity: FloatArray
    normals: FloatArray | None = None

    def __len__(self) -> int:
        return len(self.ray)

    @computed_once
    def tangents(self) -> FloatArray:
        """The unit direction of the line of each fragment, (n, 3); zero where there is none."""
        return np.nan_to_num(self.hits.tangents()).astype(np.float32)

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
        self._following = Following(cast(AxisEnds, tree.geometry))

    def find(self, origins: FloatArray, directions: FloatArray, offsets: FloatArray | float) -> Fragments:
        """Return the fragments that rays with unit directions see; offsets in [0, 1) choose among faint ones."""
        hits = self.tree.next_hits(origins, directions, self.radius, self.k, spread=self.spread)
        ray = np.asarray(hits.ray)
        kept = self._kept(hits, directions[ray])
        own = hits.sample("radius") if self.tree.geometry.radius_beyond > 0 else 0.0
        width, spot = np.float32(self.radius) + own, np.float32(self.spread) * hits.t
        cover = np.where(kept, _share(hits.distance, width, np.maximum(spot, np.float32(1e-45))), 0).astype(np.float32)
        # The light of a fragment passes what lies before it.
        passed = np.concatenate([[0.0], np.cumsum(np.log1p(-np.minimum(cover, np.float32(0.9999)), dtype=np.float64))])
        before = passed[:-1] - passed[hits.offsets[ray]]
        weight = np.where(before > np.log1p(-OPAQUE), cover * np.exp(before), 0).astype(np.float32)
        opacity = np.bincount(ray, weight, minlength=len(directions)).astype(np.float32)
        # Keep some of the faint fragments, each for several: one for each full step of the sum of a ray's weights.
        sums = np.concatenate([[0.0], np.cumsum(np.minimum(weight, FAINT), dtype=np.float64)]) / FAINT
        first = sums[hits.offsets[ray]] - np.broadcast_to(offsets, len(directions))[ray]
        steps = np.floor(sums[1:] - first) > np.floor(sums[:-1] - first)
        rows = np.flatnonzero((weight >= FAINT) | steps)
        ray, weight = ray[rows], np.maximum(weight[rows], np.float32(FAINT))
        points = origins[ray] + hits.t[rows, None] * directions[ray]
        return Fragments(some_hits(hits, rows, ray), ray, weight, -directions[ray], points, opacity)

    def _kept(self, hits: AllHits, directions: FloatArray) -> npt.NDArray[np.bool_]:
        """Return the hits where a strand comes nearest: not at the end of a segment that leads on to a nearer point."""
        prim, u, following = hits.prim, hits.u, self._following
        kept = np.ones(len(prim), np.bool_)
        starts, ends = np.flatnonzero(u <= 0), np.flatnonzero(u >= 1)
        kept[starts] = ~following.continues(prim[starts])
        ends = ends[following.continues(prim[ends] + 1)]
        # The vector from the ray to the end of the segment, against the direction in which the strand goes on.
        rays = hits.rays
        assert rays is not None
        point = following.lines.ends_of(prim[ends])[:, 1] - rays.origins[hits.ray[ends]]
        along = directions[ends]
        away = point - dot(point, along)[:, None] * along
        onward = following.lines.first_directions_of(prim[ends] + 1).astype(np.float64)  # else huge products overflow
        kept[ends[dot(away, onward) < 0]] = False
        return kept


class Surfaces:
    """Finds the nearest surfaces."""

    def __init__(self, tree: Tree, radius: float) -> None:
        self.tree, self.radius = tree, radius

    def find(self, origins: FloatArray, directions: FloatArray, offsets: FloatArray | float) -> Fragments:
        """Return the fragments that rays with unit directions see: one for each ray that hits."""
        hits = self.tree.first_hit(origins, directions, self.radius, at="surface")
        ray = np.flatnonzero(hits.hit)
        found = some_hits(hits, ray, ray)
        points, normals = found.points(outside=True).astype(np.float32), found.normals().astype(np.float32)
        ones, opacity = np.ones(len(ray), np.float32), hits.hit.astype(np.float32)
        return Fragments(found, ray, ones, -directions[ray], points, opacity, normals)


def some_hits(hits: AllHits | FirstHits, rows: IntArray, ray: IntArray) -> AllHits:
    """Return some of the hits, in their order, and the ray of each."""
    assert hits.rays is not None
    part = None if hits.part is None else hits.part[rows]
    offsets = offsets_of(ray, len(hits.rays))
    columns = hits.t[rows], hits.prim[rows], hits.u[rows], hits.distance[rows]
    t_out = None if hits.t_out is None else hits.t_out[rows]
    return AllHits(offsets, *columns, t_out, hits.skipped, hits.geometry, hits.rays, part)


def _share(distance: npt.NDArray[Any], width: npt.NDArray[Any] | Any, spot: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the fraction of a spot that lines of some half width cover.

    Examples
    --------
    >>> _share(np.array([0.0, 0.0, 2.0]), np.array([0.5, 2.0, 0.5]), np.ones(3)).tolist()
    [0.6875, 1.0, 0.0]
    """
    return np.asarray(_integral((distance + width) / spot) - _integral((distance - width) / spot))


def _integral(x: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Integrate the kernel of Epanechnikov, 3/4·(1 − x²) in [−1, 1]."""
    x = np.clip(x, -1, 1)
    return 0.5 + 0.75 * (x - x**3 / 3)
