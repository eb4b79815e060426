"""Files of pictures: PNG for the eye, EXR for the depths themselves."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray
from ..atomic_write import atomic_write
from ..errors import InputError
from ..optional import optional

#: The extensions of pictures, and the content of each.
IMAGE_FORMATS = {
    ".png": "the picture: lighter = nearer, 8 bits",
    ".exr": "the depths: channel Z, float32, inf where nothing is hit (needs fastlines[exr])",
}


def check_image_path(path: str | os.PathLike[str]) -> str:
    """Return the extension of a picture's file; refuse an unknown one, or .exr without OpenEXR."""
    extension = Path(path).suffix.lower()
    if extension not in IMAGE_FORMATS:
        known = ", ".join(IMAGE_FORMATS)
        raise InputError(f"{path}: unknown extension {extension or '(none)'!r} for a picture; known: {known}")
    if extension == ".exr":
        optional("OpenEXR", "writing .exr", "exr")
    return extension


def write_picture(path: str | os.PathLike[str], picture: npt.NDArray[np.uint8]) -> None:
    """Write a picture, (h, w) or (h, w, 3) uint8, as PNG; the file appears whole or not at all."""
    from PIL import Image

    if check_image_path(path) != ".png":
        raise InputError(f"{path}: a picture of 8 bits is written as .png")
    with atomic_write(path) as partial:
        Image.fromarray(picture).save(partial, "PNG")


def write_depth(path: str | os.PathLike[str], depth: FloatArray) -> None:
    """Write depths, (h, w) float32, as EXR with the channel Z; the file appears whole or not at all.

    Raises
    ------
    MissingExtraError
        If OpenEXR is not installed.
    """
    if check_image_path(path) != ".exr":
        raise InputError(f"{path}: depths are written as .exr")
    exr = optional("OpenEXR", "writing .exr", "exr")
    header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
    channels = {"Z": np.ascontiguousarray(depth, np.float32)}
    with atomic_write(path) as partial:
        exr.File(header, channels).write(str(partial))
