"""What a gather of photon beams sums, and the sums by our two ways: one query, or lists of hits and NumPy.

Source: Jarosz, Nowrouzezahrai, Thomas, Sloan, Zwicker, "Progressive Photon Beams", ACM Trans. Graph. 30 (6), 2011.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fastlines import Lines, Tree

from ..harness.arrays import Float64Array, FloatArray
from ..harness.rays import RayBatch

#: sin θ below which a pair of a ray and a beam counts as parallel.
PARALLEL = 2.0**-20


@dataclass(frozen=True)
class Gathering:
    """What a gather sums: the arguments of ``tree.gather`` that all sides share. The kernel is that of Epanechnikov.

    Parameters
    ----------
    radius : float
    sigma : float
        The extinction along the ray, per unit of length.
    line_sigma : float
        The extinction along the beam.
    g : float
        The mean cosine of the phase function.
    """

    radius: float
    sigma: float
    line_sigma: float
    g: float

    def ours(self, tree: Tree, rays: RayBatch, powers: FloatArray) -> Float64Array:
        """Return the sums by ``tree.gather``, (n_rays, 3)."""
        found = tree.gather(
            rays.origins,
            rays.directions,
            self.radius,
            powers,
            blur="epanechnikov",
            sigma=self.sigma,
            line_sigma=self.line_sigma,
            phase=self.g,
            t_min=rays.t_min,
            t_max=rays.t_max,
        )
        return np.asarray(found.sum)

    def listed(self, tree: Tree, lines: Lines, rays: RayBatch, powers: FloatArray, max_bytes: int) -> Float64Array:
        """Return the sums by NumPy over lists of all hits, of which each takes up to `max_bytes`."""
        sums = np.zeros((len(rays), powers.shape[1]))
        edges = lines.segments[:, 1] - lines.segments[:, 0]
        lengths = np.sqrt((edges * edges).sum(axis=1))
        towards = edges / lengths[:, None]
        parts = tree.iter_all_hits(
            rays.origins, rays.directions, self.radius, max_bytes=max_bytes, t_min=rays.t_min, t_max=rays.t_max
        )
        for hits in parts:
            inner = (hits.t > rays.t_min) & (hits.t < rays.t_max) & (hits.u > 0) & (hits.u < 1)
            ray, prim, t, u, distance = (
                column[inner] for column in (hits.ray, hits.prim, hits.t, hits.u, hits.distance)
            )
            ray = ray + hits.first_ray
            direction, along = rays.directions[ray], towards[prim]
            cosine = -(direction * along).sum(axis=1)
            normal = np.cross(direction, along)
            sine = np.sqrt((normal * normal).sum(axis=1))
            weight = 0.75 / self.radius * (1 - (distance / self.radius) ** 2) / np.maximum(sine, PARALLEL)
            weight *= np.exp(-self.sigma * t - self.line_sigma * u * lengths[prim])
            turn = 1 + self.g**2 - 2 * self.g * cosine
            weight *= (1 - self.g**2) / (4 * np.pi) / (turn * np.sqrt(turn))
            weight *= sine >= PARALLEL
            for colour in range(powers.shape[1]):
                sums[:, colour] += np.bincount(ray, weight * powers[prim, colour], len(rays))
        return sums
