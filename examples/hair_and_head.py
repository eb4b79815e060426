"""Hair, a head of triangles and pearls in one tree: `python examples/hair_and_head.py head.png` makes a picture."""

import sys
from typing import Any

import numpy as np
from PIL import Image

import fastlines as fl

#: Colours of the parts of the geometry: skin, hair, pearls.
SKIN, HAIR, PEARLS = np.array([[0.85, 0.6, 0.48], [0.42, 0.22, 0.1], [0.92, 0.9, 0.86]])
LIGHT = np.array([0.45, 0.65, 0.6])


def head(n: int) -> fl.Triangles:
    """Return a sphere that is drawn out to a face, as a grid of triangles: z is to the front, y up."""
    polar, azimuth = np.meshgrid(np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, 2 * n), indexing="ij")
    x, y, z = np.sin(polar) * np.sin(azimuth), np.cos(polar), np.sin(polar) * np.cos(azimuth)

    def bump(at: Any, width: float, height: float) -> Any:
        return height * np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2 + (z - at[2]) ** 2) / width**2)

    out = 1 + bump([0, -0.1, 1], 0.2, 0.22) + bump([0, -0.75, 0.65], 0.4, 0.16) + bump([0, -0.42, 0.9], 0.16, 0.06)
    out += sum(bump([side, 0.16, 0.93], 0.2, -0.1) for side in (-0.36, 0.36))
    out += sum(bump([side, -0.1, 0], 0.22, 0.12) for side in (-1, 1))
    vertices = np.stack([0.8 * x * out, y * out * 1.1, 0.95 * z * out], axis=-1).reshape(-1, 3)
    row = np.arange(2 * n * n).reshape(n, 2 * n)
    a, b, c, d = row[:-1, :-1], row[:-1, 1:], row[1:, 1:], row[1:, :-1]
    return fl.Triangles.from_mesh(
        vertices, np.concatenate([np.stack([a, d, c], -1), np.stack([a, c, b], -1)]).reshape(-1, 3)
    )


def hair(n_strands: int, rng: np.random.Generator) -> fl.Curves:
    """Return strands from the crown that fall to the sides and the back, and taper."""
    root = rng.normal(size=(4 * n_strands, 3))
    root /= np.linalg.norm(root, axis=1)[:, None]
    root = root[(root[:, 1] > 0.15 + 0.55 * np.maximum(root[:, 2], -0.9)) & (root[:, 1] > -0.3)][:n_strands]
    side = np.stack(
        [np.sign(root[:, 0]) * 0.5 + root[:, 0], np.zeros(len(root)), np.minimum(root[:, 2], 0.15) - 0.2], 1
    )
    side /= np.linalg.norm(side, axis=1)[:, None]
    scale = np.array([0.82, 1.12, 0.97])
    jitter = rng.normal(0, 0.03, (3, len(root), 3))
    length = rng.uniform(0.9, 1.25, len(root))[:, None]
    first, second = root * scale, root * scale * 1.12 + 0.16 * side + jitter[0]
    third = side * [0.95, 0, 1.05] + [0, 0.1, -0.1] + jitter[1] + root * [0, 0.35, 0]
    last = side * [0.9, 0, 1.0] + [0, -1.15, -0.1] * length + jitter[2]
    control = np.stack([first, second, third, last], axis=1)
    return fl.Curves.from_bezier(control, np.tile([0.006, 0.007, 0.006, 0.002], (len(root), 1)), tolerance=0.001)


def main(path: str = "head.png", size: str = "600", n_strands: str = "12000") -> None:
    """Write a picture, size pixels wide and high."""
    rng = np.random.default_rng(1)
    around = np.linspace(-1.1, 1.1, 25)
    pearls = np.stack([0.98 * np.sin(around), 0.62 + 0.1 * np.cos(around), 0.98 * np.cos(around)], axis=1)
    scene = fl.Geometry([head(150), hair(int(n_strands), rng), fl.Spheres.from_centres(pearls, radius=0.055)])
    tree = fl.build(scene)
    camera = fl.Camera.framing(scene, direction=(-0.35, -0.12, -1), fov_degrees=24)
    n, light = int(size), LIGHT / np.linalg.norm(LIGHT)
    picture = np.zeros((n * n, 3))
    for at in ((0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)):
        directions = camera.directions(n, n, at=at).reshape(-1, 3)
        hits = tree.first_hit(camera.origin, directions, at="surface")
        hit = hits.hit
        normals, tangents = hits.normals()[hit], hits.tangents()[hit]
        points = hits.points(outside=True)[hit]
        lit = ~tree.any_hit(points, light, ignore=hits.prim_number[hit, None])
        # Diffuse and specular light on surfaces; on hair, that of a thin cylinder (Kajiya and Kay 1989).
        half = light - directions[hit] / np.linalg.norm(directions[hit], axis=1)[:, None]
        half /= np.linalg.norm(half, axis=1)[:, None]
        is_hair = (hits.part[hit] == 1)[:, None]
        along = [(tangents * towards).sum(axis=1, keepdims=True) for towards in (light, half)]
        facing = [(normals * towards).sum(axis=1, keepdims=True).clip(0) for towards in (light, half)]
        diffuse, shine = np.where(is_hair, [np.sqrt(1 - np.minimum(x * x, 1)) for x in along], facing)
        gloss = np.array([[0.06], [0.35], [0.7]])[hits.part[hit]]
        colour = np.stack([SKIN, HAIR, PEARLS])[hits.part[hit]] * (0.28 + 0.8 * lit[:, None] * diffuse)
        picture[hit] += colour + gloss * lit[:, None] * shine**40
        picture[~hit] += [0.93, 0.94, 0.96]
    Image.fromarray(np.uint8(255 * (picture / 4).clip(0, 1) ** (1 / 1.6)).reshape(n, n, 3)).save(path)
    print(f"{path}: {len(scene):,} primitives in one tree")


if __name__ == "__main__":
    main(*sys.argv[1:])
