"""Former names of this package: they work for one more release, with a DeprecationWarning."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from ..camera import Camera
from ..progress import ProgressOption
from ..tree import Tree
from .depth import check_radius
from .depth_tone import grey
from .renderer import render


def former(name: str) -> Any:
    """Return what a former name refers to, with a warning; None for other names."""
    if name != "depth_picture":
        return None
    text = 'fastlines.rendering.depth_picture is now fl.render(tree, camera, look="depth").to_bytes()'
    warnings.warn(text, DeprecationWarning, stacklevel=3)
    return _depth_picture


def _depth_picture(
    tree: Tree,
    camera: Camera,
    width: int,
    height: int,
    radius: float | None = None,
    samples: int = 3,
    progress: ProgressOption = False,
) -> npt.NDArray[np.uint8]:
    """Draw the lines, lighter where they are nearer, on black, with `samples`² samples a pixel."""
    size: dict[str, Any] = {"width": width, "height": height, "radius": check_radius(tree, radius)}
    return grey(render(tree, camera, look="depth", samples=samples**2, progress=progress, **size))
