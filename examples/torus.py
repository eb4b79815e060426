"""A primitive of your own, the torus: `python examples/torus.py torus.png` draws a thousand of them."""

import sys
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

import fastlines as fl


class Tori(NamedTuple):
    """Solid tori: centres and unit axes (n, 3); radii of the rings, and of the tubes around these (n,)."""

    centre: Any
    axis: Any
    ring: Any
    tube: Any

    def bounds(self) -> Any:
        """Return the box of each torus."""
        half = self.ring[:, None] * np.sqrt(np.maximum(1 - self.axis**2, 0)) + self.tube[:, None]
        return np.stack([self.centre - half, self.centre + half], axis=1)

    def hit(self, ids: Any, rays: Any, radius: Any) -> Any:
        """Return where rays enter: p + s·d, with p nearest to the centre, is in the torus where quartic(s) ≤ 0."""
        length, ring, tube = np.linalg.norm(rays.directions, axis=1), self.ring[ids], self.tube[ids] + radius
        d, p = rays.directions / length[:, None], rays.origins - self.centre[ids]
        nearest = -(p * d).sum(axis=1)
        p += nearest[:, None] * d
        a, b, pp = ((x * y).sum(axis=1) for x, y in ((p, self.axis[ids]), (d, self.axis[ids]), (p, p)))
        k = pp + ring**2 - tube**2
        c2, c1, c0 = 2 * k - 4 * ring**2 * (1 - b * b), 8 * ring**2 * a * b, k * k - 4 * ring**2 * (pp - a * a)
        half = np.sqrt(np.maximum((ring + tube) ** 2 - pp, 0))
        low, high = np.maximum(rays.t_min * length - nearest, -half), np.minimum(rays.t_max * length - nearest, half)
        # The roots of the second derivative isolate those of the first, and these those of the quartic.
        bend = np.sqrt(np.maximum(-c2 / 6, 0))
        turns = np.clip([low, -bend, bend, high], low, np.maximum(low, high))
        turns = np.stack([low, *bisect(lambda s: (4 * s * s + 2 * c2) * s + c1 > 0, turns[:-1], turns[1:]), high])
        inside = ((turns**2 + c2) * turns + c1) * turns + c0 <= 0
        first, row = inside.argmax(axis=0), np.arange(len(ids))
        ends = turns[np.maximum(first - 1, 0), row], turns[first, row]
        s = bisect(lambda s: ((s * s + c2) * s + c1) * s + c0 <= 0, *ends)
        hit = inside.any(axis=0) & (low <= high) & (pp <= (ring + tube) ** 2)
        return np.where(hit, (s + nearest) / length, np.nan)

    def normals(self, ids: Any, points: Any) -> Any:
        """Return the direction from the nearest point of the ring."""
        away, axis = points - self.centre[ids], self.axis[ids]
        return unit(away - self.ring[ids, None] * unit(away - (away * axis).sum(axis=1, keepdims=True) * axis))


def unit(vectors: Any) -> Any:
    """Return vectors of length 1."""
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def bisect(holds: Any, low: Any, high: Any) -> Any:
    """Return where a condition begins or ceases to hold; the upper ends if it does not change."""
    at_low = holds(low)
    for _ in range(52):
        same = holds(middle := (low + high) / 2) == at_low
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return high


def main(path: str = "torus.png", width: int = 600, n: int = 1000) -> None:
    """Write a picture of n tori, width pixels wide and high."""
    rng = np.random.default_rng(1)
    centre, axis, ring = rng.uniform(-4, 4, (n, 3)), unit(rng.normal(size=(n, 3))), rng.uniform(0.2, 0.7, n)
    tree = fl.build(Tori(centre, axis, ring, tube=ring * rng.uniform(0.1, 0.4, n)))
    hits = tree.first_hit(*fl.Camera.framing(tree.geometry, direction=(-1, -0.6, -2)).rays(width, width))
    colours = np.where(hits.hit[:, None], 0.5 + 0.5 * hits.normals(), 1)
    Image.fromarray(np.uint8(255 * colours).reshape(width, width, 3)).save(path)
    print(f"{path}: {hits.hit.mean():.0%} of {hits.hit.size:,} rays hit one of {n:,} tori")


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:]))
