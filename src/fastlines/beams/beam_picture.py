"""A picture of the light in a medium: its radiance, its variance, and its files."""

from __future__ import annotations

import io
import math
import os
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, number
from ..errors import InputError
from ..rendering.pictures.images import check_image_path, save_png, write_channels
from ..rendering.pictures.picture import Picture
from ..support.texts import counted

#: What fraction of the pixels is darker than the light that `WHITE` is for, in a picture whose exposure is not given.
BRIGHT = 0.98
#: What a filmic curve gets of that light.
WHITE = 1.0
#: The largest exposure, and the smallest with a minus: 2 to this power is a float32.
MAX_EXPOSURE = 100.0


@dataclass(frozen=True, eq=False, repr=False)
class BeamPicture:
    """The light of the pixels of a picture.

    Attributes
    ----------
    radiance : (height, width, 3) float32
        Red, green and blue, in power per area and solid angle.
    variance : (height, width, 3) float32
        Of the radiance: the square of its standard error, from the differences of passes; NaN of a single pass.
    n_passes : int
        How many passes are averaged; each is one ray a pixel.
    n_paths : int
        How many photons were emitted.
    radius : float
        Of the blur in the last pass.
    """

    radiance: FloatArray
    variance: FloatArray
    n_passes: int
    n_paths: int
    radius: float

    def __repr__(self) -> str:
        height, width = self.radiance.shape[:2]
        return f"<BeamPicture: {width} × {height} pixels, {counted(self.n_passes, 'passes')}>"

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        save_png(file, self.for_screen().to_bytes())
        return file.getvalue()

    @property
    def exposure(self) -> float:
        """The exposure with which 2 % of the pixels are brighter than white."""
        bright = float(np.quantile(self.radiance.max(axis=2), BRIGHT))
        return math.log2(WHITE / bright) if bright > 0 else 0.0

    def for_screen(self, exposure: float | None = None) -> Picture:
        """Return a picture for the eye.

        Parameters
        ----------
        exposure : float, optional
            The light is multiplied by 2 to this power, from -100 to 100; by default by that of `exposure`.
        """
        exposure = self.exposure if exposure is None else check_exposure(exposure)
        shape = self.radiance.shape
        backdrop = np.zeros(shape, np.float32)
        return Picture(self.radiance, np.ones(shape[:2], np.float32), backdrop, self.n_passes, exposure=exposure)

    def save(self, path: str | os.PathLike[str], exposure: float | None = None) -> None:
        """Write the picture as a .png for the eye, or its numbers as an .exr.

        An .exr has the radiance as the channels R, G and B, its variance as ``variance.R``, ``variance.G`` and
        ``variance.B``, and the number of passes as ``samples``.

        Raises
        ------
        InputError
            If the extension is unknown, or an .exr is given an exposure, or one is not from -100 to 100.
        MissingExtraError
            If an .exr is to be written, and OpenEXR is not installed.
        """
        if check_picture_file(path, exposure) == ".png":
            self.for_screen(exposure).save(path)
            return
        samples = np.full(self.radiance.shape[:2], self.n_passes, np.uint32)
        of_channels = zip("RGB", np.moveaxis(self.radiance, 2, 0), strict=True)
        variances = zip(("variance.R", "variance.G", "variance.B"), np.moveaxis(self.variance, 2, 0), strict=True)
        write_channels(path, {**dict(of_channels), **dict(variances), "samples": samples})


def check_exposure(exposure: float) -> float:
    """Check the power of 2 by which light is multiplied."""
    return number("exposure", exposure, "a power of 2, from -100 to 100", -MAX_EXPOSURE, MAX_EXPOSURE)


def check_picture_file(path: str | os.PathLike[str], exposure: float | None) -> str:
    """Return the extension of a picture's file; refuse an unknown one, and an exposure that it does not take."""
    extension = check_image_path(path)
    if exposure is not None and extension != ".png":
        raise InputError(
            f"exposure={exposure} does not apply: an {extension} holds the radiance itself; leave it out, or write "
            "a .png"
        )
    if exposure is not None:
        check_exposure(exposure)
    return extension
