"""Tapered blades near and far, without and with a spread: `python examples/taper.py taper.png` draws them side by side.

Near ones are round cones that rays enter `at="surface"`. Far ones are thinner than a pixel: a ray through its centre
mostly misses them, and hits others as a whole. With `spread=camera.spread(height)` it hits all that its pixel
covers. At depth t the pixel reaches w = spread·t to both sides of the ray. A blade of radius r at a distance d covers
what is of [−w, w] in [d − r, d + r].
"""

import sys
from typing import Any

import numpy as np
from PIL import Image

import fastlines as fl

LIGHT, SKY, GROUND = np.array([[-0.48, 0.6, 0.64], [0.86, 0.92, 0.98], [0.55, 0.60, 0.38]])


def blades(n: int, width: float, z: tuple[float, float], height: float) -> fl.Lines:
    """Return n blades on the ground, from far to near; each is twelve round cones, from a thick root to a tip."""
    rng, s = np.random.default_rng(5), np.linspace(0, 1, 13)[:, None]
    root = np.stack([rng.uniform(-width, width, n), np.zeros(n), np.linspace(*z, n)], axis=1)[:, None]
    lean, tall = rng.normal(0, 0.3, (n, 1, 3)) * [1, 0, 1], height * rng.uniform(0.5, 1, (n, 1, 1))
    points = root + tall * (s * [0, 1, 0] + s**2 * lean)
    return fl.Lines.from_points(points.reshape(-1, 3), [13] * n, radius=np.tile(0.05 * (1 - s[:, 0]), n))


def shade(normals: Any) -> Any:
    """Return the colours of surfaces by their normals."""
    return (0.35 + 0.65 * np.maximum(normals @ LIGHT, 0))[:, None] * [0.50, 0.80, 0.25]


def surfaces(tree: fl.Tree, camera: fl.Camera, width: int, height: int) -> tuple[Any, Any]:
    """Return the colour of the first surface at the centre of each pixel, and how much of the pixel it covers, all."""
    hits = tree.first_hit(*camera.rays(width, height), at="surface")
    colours = np.zeros((width * height, 3))
    colours[hits.hit] = shade(hits.normals()[hits.hit])
    return colours, hits.hit[:, None].astype(float)


def coverage(tree: fl.Tree, camera: fl.Camera, width: int, height: int) -> tuple[Any, Any]:
    """Return the blend of all blades in each pixel, weighted by what they cover, and how much that is."""
    spread, (origins, directions) = camera.spread(height), camera.rays(width, height)
    hits = tree.all_hits(origins, directions, spread=spread)
    # Keep one hit of each blade in a pixel, the nearest to the ray; then all from front to back.
    order = np.lexsort([hits.distance, hits.strand, hits.ray])
    ray, strand = hits.ray[order], hits.strand[order]
    kept = order[np.diff(ray, prepend=-1) + np.abs(np.diff(strand, prepend=-1)) > 0]
    kept = kept[np.lexsort([hits.t[kept], hits.ray[kept]])]
    ray, d, r, w = hits.ray[kept], hits.distance[kept], hits.sample("radius")[kept], spread * hits.t[kept]
    covers = np.clip((np.minimum(d + r, w) - np.maximum(d - r, -w)) / (2 * w), 0, 0.999)
    passes = np.cumsum(np.log1p(-covers)) - np.log1p(-covers)  # what those in front let pass, as a logarithm
    weight = covers * np.exp(passes - passes[np.searchsorted(ray, ray)])
    # Light a blade by the normal in its middle, towards the camera.
    along = hits.tangents()[kept]
    facing = -directions[ray] + (directions[ray] * along).sum(axis=1, keepdims=True) * along
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    blended = np.zeros((len(origins), 4))
    np.add.at(blended, ray, weight[:, None] * np.column_stack([shade(facing), np.ones(len(ray))]))
    return blended[:, :3], blended[:, 3:]


def main(path: str = "taper.png", width: int = 480, n: int = 1500) -> None:
    """Write both pictures, each width pixels wide and half as high, side by side."""
    height = width // 2
    camera = fl.Camera(origin=(0, 1.5, 6), target=(0, 1.2, 0), fov_degrees=32)
    near, far = fl.build(blades(18, 3, (-1.5, 1.5), 1.5)), fl.build(blades(n, 45, (-90, -40), 9))
    front, is_front = surfaces(near, camera, width, height)
    behind = np.where(camera.rays(width, height)[1][:, 1:2] < -0.016, GROUND, SKY)
    pictures = []
    for colours, covered in (surfaces(far, camera, width, height), coverage(far, camera, width, height)):
        pictures.append((front + (1 - is_front) * (colours + (1 - covered) * behind)).reshape(height, width, 3))
    Image.fromarray(np.uint8(255 * np.clip(np.hstack(pictures), 0, 1) ** 0.8)).save(path)
    print(f"{path}: far blades without a spread (left) and with it (right)")


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:]))
