"""A million strands between guides: `python examples/million_strands.py head.png 1024 1000000 64 hair.tfx`.

The numbers are the width in pixels, the strands, and the samples of a pixel. All guides of the file have the same
number of points. Without a file, the guides are those of a scene.
"""

import sys
from time import perf_counter

import numpy as np
from PIL import Image

import fastlines as fl


def guides_of(lines: fl.Lines) -> np.ndarray:
    """Return the points of strands that are equally long, (n_strands, n_points, 3)."""
    ends = lines.segments.reshape(lines.n_strands, -1, 2, 3)
    return np.concatenate([ends[:, :, 0], ends[:, -1:, 1]], axis=1)


def main(path: str = "head.png", width: int = 512, n_strands: int = 10**6, samples: int = 32, file: str = "") -> None:
    """Write a picture of strands between those of a file."""
    guides = fl.read(file) if file else fl.scenes.make("straight-hair", 20_000).lines
    start = perf_counter()
    hair = fl.scenes.dense_hair(guides_of(guides), n_strands)
    tree = fl.build(hair)
    built = perf_counter()
    camera = fl.rendering.default_camera(guides)
    radius = float(np.ptp(guides.bounds, axis=0).max()) / 7000
    quality = {"look": "hair", "quality": "high", "samples": samples, "radius": radius}
    picture = fl.render(tree, camera, width=width, height=width, progress=True, **quality)
    Image.fromarray(picture.to_bytes()).save(path)
    print(f"{path}: {len(hair):,} segments, built in {built - start:.1f} s, drawn in {perf_counter() - built:.1f} s")


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:5]), *sys.argv[5:6])
