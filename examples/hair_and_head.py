"""Hair, a head and pearls in one tree, with shadows: `python examples/hair_and_head.py head.png 500`."""

import sys
from typing import Any

import numpy as np
from PIL import Image

import fastlines as fl

#: Half the width, height and depth of the skull.
SKULL = np.array([0.74, 1.0, 0.86])
#: Hair, skin, pearls and the whites of eyes, irises.
COLOURS = np.array([[0.50, 0.25, 0.10], [0.93, 0.70, 0.58], [0.97, 0.95, 0.92], [0.10, 0.25, 0.35]])
#: Bumps of the face: where from the centre, for x > 0 and its mirror image; width, and height outwards.
FACE = [
    ((0.00, 0.02, 1.00), 0.08, 0.07),  # the bridge and the tip of the nose
    ((0.00, -0.17, 0.98), 0.09, 0.17),
    ((0.33, 0.10, 0.93), 0.15, -0.09),  # sockets of the eyes, brows
    ((0.32, 0.34, 0.88), 0.15, 0.04),
    ((0.06, -0.45, 0.89), 0.09, 0.05),  # lips and chin
    ((0.00, -0.80, 0.60), 0.20, 0.13),
    ((1.00, -0.08, 0.00), 0.13, 0.10),  # ears
]


def unit(vectors: Any) -> Any:
    """Return vectors of length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def triangles(x: Any, y: Any, z: Any) -> Any:
    """Return the triangles of a grid of points."""
    grid = np.stack(np.broadcast_arrays(x, y, z), axis=2)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.concatenate([np.stack(corners, axis=2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))])


def skin(n: int) -> fl.Triangles:
    """Return a head, and a neck with shoulders."""
    around, up = np.linspace(-np.pi, np.pi, 2 * n)[:, None], np.linspace(-np.pi / 2, np.pi / 2, n)
    x, y, z = np.sin(around) * np.cos(up), np.sin(up), np.cos(around) * np.cos(up)
    size = 1 + sum(
        height * np.exp(-((np.abs(x) - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) / width**2)
        for (a, b, c), width, height in FACE
    )
    head = triangles(SKULL[0] * x * size * (1 + 0.25 * np.minimum(y, 0)), SKULL[1] * y * size, SKULL[2] * z * size)
    down = np.linspace(0, 1, n)
    wide = 0.36 + 1.6 * np.maximum(down - 0.4, 0) ** 1.3
    neck = triangles(1.2 * wide * np.sin(around), -0.5 - 1.4 * down, 0.9 * np.sqrt(wide / 2) * np.cos(around) - 0.2)
    return fl.Triangles(np.concatenate([head, neck]))


def hair(n: int, n_points: int = 28) -> fl.Lines:
    """Comb n strands from a parting to the sides and back; they fall, stay out of the head, and get thinner."""
    rng = np.random.default_rng(3)
    root = unit(rng.normal(size=(6 * n, 3)))
    root = root[root[:, 1] > 0.16 + 0.52 * root[:, 2]][:n]
    side = np.where(root[:, 0] > 0.12, 1.0, -1.0)
    comb = np.stack([0.55 * side, np.full(len(root), 0.25), -0.5 - 0.3 * root[:, 2]], axis=1)
    at, going = root * SKULL, unit(0.3 * root + comb)
    curl, length = rng.normal(0, 0.12, (len(root), 3)), rng.uniform(1.8, 2.3, (len(root), 1)) / n_points
    clearance = rng.uniform(1.03, 1.16, (len(root), 1))
    points = [at]
    for i in range(1, n_points):
        pull = comb / i - [0, 0.3 + 0.04 * i, 0] + curl * np.sin(0.7 * i + 9 * curl)
        going, at = unit(going + 0.35 * pull), at + length * going
        inside = np.maximum(clearance ** min(1, i / 6) / np.linalg.norm(at / SKULL, axis=1, keepdims=True), 1)
        points.append(at := at * inside)
    radius = np.tile(np.linspace(0.006, 0.0015, n_points), len(root))
    return fl.Lines.from_points(np.stack(points, axis=1).reshape(-1, 3), [n_points] * len(root), radius=radius)


def main(path: str = "head.png", width: int = 500, n_strands: int = 20_000) -> None:
    """Write a picture that is width pixels wide and high, with 2 × 2 rays a pixel."""
    angle = np.linspace(-1.25, 1.25, 25)
    necklace = np.stack([0.56 * np.sin(angle), -1.28 - 0.12 * np.cos(angle), 0.3 * np.cos(angle) + 0.12], axis=1)
    eyes, ears = [[x, 0.09, 0.655] for x in (-0.24, 0.24)], [[x, -0.32, 0.05] for x in (-0.80, 0.80)]
    pearls = fl.Spheres.from_centres([*eyes, *ears, *necklace], radius=[0.11] * 2 + [0.07] * 2 + [0.036] * 25)
    irises = fl.Spheres.from_centres(np.add(eyes, [0, 0, 0.07]), radius=0.052)
    tree = fl.build(fl.Geometry([hair(n_strands), skin(160), pearls, irises]))
    camera = fl.Camera(origin=(1.9, 0.15, 6.2), target=(0, -0.28, 0), fov_degrees=28)
    light, picture = unit(np.array([0.3, 0.8, 0.75])), np.zeros((width * width, 3))
    shade = np.random.default_rng(4).uniform(0.65, 1.25, n_strands + 1)
    for at in ((0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)):
        directions = camera.directions(width, width, at=at).reshape(-1, 3)
        hits = tree.first_hit(np.array(camera.origin), directions, at="surface")
        is_hit, normals = hits.hit, hits.normals()[hits.hit]
        lit = np.maximum(normals @ light, 0) * ~tree.any_hit(hits.points(outside=True)[is_hit], light)
        gloss = np.maximum((normals * unit(light - directions[is_hit])).sum(axis=1), 0) ** 60 * (lit > 0)
        colour = COLOURS[hits.part[is_hit]] * np.where(hits.part == 0, shade[hits.strand], 1)[is_hit, None]
        picture[is_hit] += colour * (0.32 + 0.12 * normals[:, 1] + 0.75 * lit)[:, None] + 0.35 * gloss[:, None]
        picture[~is_hit] += [0.80, 0.86, 0.92]
    Image.fromarray(np.uint8(255 * np.clip(picture / 4, 0, 1) ** 0.8).reshape(width, width, 3)).save(path)
    print(f"{path}: {tree.n_prims:,} pieces of hair, triangles and spheres cover {is_hit.mean():.0%} of the picture")


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:]))
