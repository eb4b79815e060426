"""Hair in three colours, with one tree and one camera: `python examples/hair_colours.py hair-colours.png`."""

import sys

import numpy as np
from PIL import Image

import fastlines as fl


def main(path: str, size: int = 512, n_segments: int = 82_250) -> None:
    """Render the pictures side by side."""
    tree = fl.build(fl.scenes.make("bun-hair", n_segments).lines)
    pictures = [
        fl.render(tree, width=size, height=2 * size // 3, look="hair", color=color)
        for color in ("blond", "red", "#3060c0")
    ]
    Image.fromarray(np.concatenate([picture.to_bytes() for picture in pictures], axis=1)).save(path)
    print(f"{path}: blond, red and blue hair")


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:]))
