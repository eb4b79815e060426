"""Files of pictures: PNG for the eye, EXR for the numbers behind it."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import IO

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray
from ...errors import InputError
from ...support.atomic_write import atomic_write
from ...support.optional import optional

#: The extensions of pictures, and the content of each.
IMAGE_FORMATS = {
    ".png": "the picture, of 8 bits a channel",
    ".exr": "linear light, alpha, and depths as channel Z, inf where nothing is hit (needs the extra 'exr')",
}
#: What renderers call the channels of some AOVs; others keep their names.
CHANNELS = {"depth": "Z", "normal": "N", "position": "P"}
#: The rendering intent of sRGB in a PNG: that for pictures.
PERCEPTUAL = 0
#: The largest float16, and the number of nothing in a channel of whole numbers.
HALF_MAX, NOTHING = 65504.0, 2**32 - 1


def check_image_path(path: str | os.PathLike[str]) -> str:
    """Return the extension of a picture's file; refuse an unknown one, or .exr without OpenEXR."""
    extension = known_extension(path, IMAGE_FORMATS, "a picture")
    if extension == ".exr":
        optional("OpenEXR", "writing .exr", "exr")
    return extension


def known_extension(path: str | os.PathLike[str], formats: Collection[str], what: str) -> str:
    """Return the extension of a path in lower case; refuse one that is not among some formats."""
    extension = Path(path).suffix.lower()
    if extension not in formats:
        known = ", ".join(formats)
        raise InputError(f"{path}: unknown extension {extension or '(none)'!r} for {what}; known: {known}")
    return extension


def write_picture(path: str | os.PathLike[str], picture: npt.NDArray[np.uint8], *, is_final: bool = True) -> None:
    """Write a picture, (h, w) or (h, w, 3) uint8, as PNG; the file appears whole or not at all.

    One that is not final is compressed less, and may be lost at a power failure.
    """
    if check_image_path(path) != ".png":
        raise InputError(f"{path}: a picture of 8 bits is written as .png")
    with atomic_write(path, durable=is_final) as partial:
        save_png(partial, picture, 6 if is_final else 1)


def save_png(file: Path | IO[bytes], picture: npt.NDArray[np.uint8], compress_level: int = 6) -> None:
    """Write a picture as PNG, and say that its values are those of sRGB."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    info = PngInfo()
    info.add(b"sRGB", bytes([PERCEPTUAL]))
    Image.fromarray(picture).save(file, "PNG", pnginfo=info, compress_level=compress_level)


def write_depth(path: str | os.PathLike[str], depth: FloatArray) -> None:
    """Write depths, (h, w) float32, as EXR with the channel Z; the file appears whole or not at all.

    Raises
    ------
    MissingExtraError
        If OpenEXR is not installed.
    """
    if check_image_path(path) != ".exr":
        raise InputError(f"{path}: depths are written as .exr")
    write_channels(path, channels_of({"depth": depth}))


def write_light(
    path: str | os.PathLike[str], light: FloatArray, alpha: FloatArray, aovs: Mapping[str, AnyArray]
) -> None:
    """Write light, alpha and AOVs as one EXR; the file appears whole or not at all.

    Parameters
    ----------
    path : str or path
    light : (height, width, 3) array
        Linear and multiplied by alpha, as EXR wants it; written as the channels R, G and B, of 16 bits.
    alpha : (height, width) array
        Written as the channel A, of 16 bits.
    aovs : mapping of str to array
        Written as `channels_of` names them.

    Raises
    ------
    MissingExtraError
        If OpenEXR is not installed.
    """
    if check_image_path(path) != ".exr":
        raise InputError(f"{path}: light and AOVs are written as .exr")
    colors = np.clip(np.concatenate([light, alpha[..., None]], axis=2), 0, HALF_MAX).astype(np.float16)
    write_channels(path, dict(zip("RGBA", np.moveaxis(colors, 2, 0), strict=True)) | channels_of(aovs))


def channels_of(aovs: Mapping[str, AnyArray]) -> dict[str, AnyArray]:
    """Return the channels of AOVs, as renderers name them.

    Vectors have three channels, such as N.X, N.Y and N.Z. Numbers are float32, and whole numbers uint32. There -1
    becomes 4294967295, the largest.

    Examples
    --------
    >>> aovs = {"depth": np.ones((1, 1)), "normal": np.ones((1, 1, 3)), "id": np.full((1, 1), -1)}
    >>> {name: values.tolist() for name, values in channels_of(aovs).items()}
    {'Z': [[1.0]], 'N.X': [[1.0]], 'N.Y': [[1.0]], 'N.Z': [[1.0]], 'id': [[4294967295]]}
    """
    channels: dict[str, AnyArray] = {}
    for name, values in aovs.items():
        whole = values.dtype.kind in "iub"
        kept = np.where(values < 0, NOTHING, values).astype(np.uint32) if whole else values.astype(np.float32)
        if values.ndim == 3:
            channels |= {f"{CHANNELS.get(name, name)}.{axis}": kept[..., i] for i, axis in enumerate("XYZ")}
        else:
            channels[CHANNELS.get(name, name)] = kept
    return channels


def write_channels(path: str | os.PathLike[str], channels: Mapping[str, AnyArray]) -> None:
    """Write channels, (height, width) each, as one EXR; the file appears whole or not at all."""
    exr = optional("OpenEXR", "writing .exr", "exr")
    header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
    with atomic_write(path) as partial:
        exr.File(header, {name: np.ascontiguousarray(c) for name, c in channels.items()}).write(str(partial))
