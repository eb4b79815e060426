"""Files of many pictures: numbered PNGs, a GIF or an MP4. Each file appears whole or not at all."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ...arrays import number
from ...errors import InputError
from ...support.atomic_write import atomic_write, check_target
from ...support.optional import optional
from .images import IMAGE_FORMATS, check_image_path, known_extension
from .options import PictureRequest, check_options
from .picture import Picture

if TYPE_CHECKING:
    from PIL import Image

#: The extensions of many pictures, and what each becomes.
FRAME_FORMATS = {
    ".png": "a file for each picture, such as x_0001.png",
    ".exr": "the same, of numbers (needs the extra 'exr')",
    ".gif": "an animation of 256 colours a picture, which repeats",
    ".mp4": "a film, H.264 (needs the extra 'video')",
}
#: How long each picture of an animation is shown, unless another time is given.
SECONDS = 0.04
#: The least seconds of a picture of a GIF; viewers slow down shorter ones.
SHORTEST = 0.02


def check_frames_path(path: str | os.PathLike[str]) -> str:
    """Return the extension of a file of many pictures; refuse an unknown one, or .mp4 without its library."""
    extension = known_extension(path, FRAME_FORMATS, "many pictures")
    if extension == ".mp4":
        optional("imageio_ffmpeg", "writing .mp4", "video")
    elif extension in IMAGE_FORMATS:
        check_image_path(path)
    return extension


def write_frames(
    path: str | os.PathLike[str],
    pictures: Iterable[Picture],
    *,
    seconds: float | None = None,
    repeats: bool = True,
    transparent: bool = False,
) -> list[Path]:
    """Write pictures as numbered files or as an animation.

    Pictures are written as they come, so that any number of them takes the memory of a few.

    Parameters
    ----------
    path : str or path
        A .png or .exr, for files that are numbered from 1 on: frames/x.png names frames/x_0001.png and so on. A .gif,
        or an .mp4 with the extra "video".
    pictures : iterable of Picture
        All of the same size. An .mp4 has an even number of rows and columns; the last ones are repeated.
    seconds : float, optional
        How long each picture of an animation is shown, 0.04 by default; in a .gif it is rounded to hundredths, and at
        least two.
    repeats : bool
        Whether a .gif starts again after its end.
    transparent : bool
        Whether .png files have no backdrop.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        If the extension is unknown, an option has no effect on such files, or there are no pictures.
    MissingExtraError
        If an .mp4 is to be written, and imageio-ffmpeg is not installed.

    Examples
    --------
    >>> import tempfile
    >>> import fastlines as fl
    >>> from fastlines.rendering import turntable
    >>> pictures = turntable(fl.scenes.make("spaghetti", 50).lines, 2, width=16, height=16, samples=1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [file.name for file in write_frames(f"{folder}/x.png", pictures)]
    ['x_0001.png', 'x_0002.png']
    """
    extension = check_frames_path(path)
    given = {"seconds": seconds, "repeats": repeats, "transparent": transparent}
    check_options(given, PictureRequest(file=extension))
    seconds = number("seconds", SECONDS if seconds is None else seconds, "a number from 0.001 to 60", 1e-3, 60.0)
    check_target(numbered(path, 1) if extension in IMAGE_FORMATS else path)
    if extension in IMAGE_FORMATS:
        written: list[Path] = []
        for picture in pictures:
            written.append(numbered(path, len(written) + 1))
            picture.save(written[-1], transparent)
        if not written:
            raise InputError(f"{path}: there are no pictures to write")
        return written
    frames = iter(pictures)
    first = next(frames, None)
    if first is None:
        raise InputError(f"{path}: there are no pictures to write")
    pixels = _of_one_size(path, itertools.chain([first], frames))
    with atomic_write(path) as partial:
        if extension == ".gif":
            _write_gif(partial, pixels, seconds, repeats)
        else:
            _write_film(partial, pixels, seconds)
    return [Path(path)]


def numbered(path: str | os.PathLike[str], index: int) -> Path:
    """Return the path of one of several files.

    Examples
    --------
    >>> numbered("frames/x.png", 7).as_posix()
    'frames/x_0007.png'
    """
    named = Path(path)
    return named.with_name(f"{named.stem}_{index:04}{named.suffix}")


def _of_one_size(path: str | os.PathLike[str], pictures: Iterable[Picture]) -> Iterator[npt.NDArray[np.uint8]]:
    shape = None
    for picture in pictures:
        pixels = picture.to_bytes()
        if shape is not None and pixels.shape != shape:
            raise InputError(f"{path}: pictures have the sizes {shape[1::-1]} and {pixels.shape[1::-1]}; use one size")
        shape = pixels.shape
        yield pixels


def _write_gif(partial: Path, pixels: Iterator[npt.NDArray[np.uint8]], seconds: float, repeats: bool) -> None:
    milliseconds = 10 * round(100 * max(seconds, SHORTEST))
    frames = map(_with_palette, pixels)
    options = {"loop": 0} if repeats else {}
    with partial.open("wb") as file:
        next(frames).save(file, "GIF", save_all=True, append_images=frames, duration=milliseconds, **options)


def _with_palette(pixels: npt.NDArray[np.uint8]) -> Image.Image:
    """Return a picture of the 256 colours that suit it, mixed from dots where others are needed."""
    from PIL import Image

    picture = Image.fromarray(pixels)
    palette = picture.quantize(256, Image.Quantize.MEDIANCUT)
    return picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)


def _write_film(partial: Path, pixels: Iterator[npt.NDArray[np.uint8]], seconds: float) -> None:
    """Encode as H.264 with colours of half the resolution, which every player shows."""
    ffmpeg = optional("imageio_ffmpeg", "writing .mp4", "video")
    first = _even(next(pixels))
    film = ffmpeg.write_frames(
        str(partial),
        first.shape[1::-1],
        fps=1 / seconds,
        codec="libx264",
        pix_fmt_out="yuv420p",
        macro_block_size=1,
        output_params=["-crf", "16", "-movflags", "+faststart", "-f", "mp4"],
    )
    film.send(None)
    try:
        for frame in itertools.chain([first], map(_even, pixels)):
            film.send(np.ascontiguousarray(frame))
    finally:
        film.close()


def _even(pixels: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Repeat the last row and column where their number is odd."""
    height, width = pixels.shape[:2]
    return np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), "edge")
