"""How bright pictures of hair are with ``quality="normal"``, beside those of ``quality="high"``."""

from __future__ import annotations

import numpy as np

import fastlines as fl

from ..harness.internals import open_lines


def print_brightness(sources: tuple[str, ...], color: str, side: int, samples: int) -> None:
    """Print a table of mean luminances: of files or scenes, in pictures of side² pixels."""
    print("| picture | normal | high | normal less high |\n|---|--:|--:|--:|")
    for source in sources:
        tree = fl.build(open_lines(source).lines)
        normal, high = (
            _luminance(fl.render(tree, width=side, height=side, look="hair", color=color, quality=quality, samples=n))
            for quality, n in (("normal", None), ("high", samples))
        )
        print(f"| `{source.rpartition('/')[2]}`, {color} | {normal:.4f} | {high:.4f} | {normal / high - 1:+.0%} |")


def _luminance(picture: fl.Picture) -> float:
    """Return the mean luminance of the light of a picture (Rec. 709)."""
    return float((picture.light.reshape(-1, 3) @ np.array([0.2126, 0.7152, 0.0722])).mean())
