"""A picture: the light of its pixels, and what can be made of it."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, FloatArray
from .images import write_picture
from .tone import bleed, filmic, srgb, to_bytes


@dataclass(frozen=True, eq=False, repr=False)
class Picture:
    """The light of the pixels of a picture.

    Attributes
    ----------
    light : (height, width, 3) float32
        Linear red, green and blue of the lines alone, weighted by what they cover.
    alpha : (height, width) float32
        The fraction of each pixel that the lines cover.
    backdrop : (height, width, 3) float32
        The light behind.
    samples : int
        How many samples of each pixel are averaged.
    exposure : float
        The light is multiplied by 2 to this power.
    is_light : bool
        Whether a filmic curve brings the light to the screen.
    """

    light: FloatArray
    alpha: FloatArray
    backdrop: FloatArray
    samples: int
    exposure: float = 0.0
    is_light: bool = True
    aovs: dict[str, FloatArray] = field(default_factory=dict)

    def __repr__(self) -> str:
        height, width = self.alpha.shape
        return f"<Picture: {width} × {height} pixels, {self.samples} samples>"

    def _repr_png_(self) -> bytes:
        from PIL import Image

        file = io.BytesIO()
        Image.fromarray(self.to_bytes()).save(file, "PNG")
        return file.getvalue()

    def to_bytes(self, transparent: bool = False) -> npt.NDArray[np.uint8]:
        """Return what a screen shows, (height, width, 3) uint8 sRGB; (…, 4) if the backdrop is transparent.

        Colours of transparent pixels are not multiplied by alpha, as PNG wants them.
        """
        alpha = np.clip(self.alpha, 0, 1)[..., None]
        own: AnyArray = self.light / np.maximum(alpha, 1e-6)
        own = filmic(bleed(own * np.float32(2.0**self.exposure))) if self.is_light else np.clip(own, 0, 1)
        if transparent:
            return to_bytes(np.concatenate([srgb(own), alpha], axis=2))
        return to_bytes(srgb(own * alpha + (1 - alpha) * self.backdrop))

    def save(self, path: str | os.PathLike[str], transparent: bool = False) -> None:
        """Write the picture as a PNG."""
        write_picture(path, self.to_bytes(transparent))
