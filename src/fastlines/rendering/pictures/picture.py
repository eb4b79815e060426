"""A picture: the light of its pixels, and what can be made of it."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray, choice
from ...camera import Camera
from ...support.texts import counted
from ..color.legend import CORNERS, Legend, draw_legend, emptiest_corner
from ..color.tone import bleed, dithered, filmic, srgb, to_bytes
from .images import check_image_path, save_png, write_light, write_picture
from .notebook import is_in_cell
from .options import PictureRequest, check_options


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
        How many samples of each pixel are averaged; 0 of a draft.
    shadow : (height, width) float32, optional
        How much darker the backdrop is, from 0 to 1: the shadow on the ground, weighted by what no line covers.
    exposure : float
        The light is multiplied by 2 to this power.
    is_light : bool
        Whether a filmic curve brings the light to the screen.
    aovs : dict of str to array
        What one ray through the centre of each pixel hits; `AOVS` describes them. Empty unless they were asked for.
    legend : ColorBar or Triad, optional
        What the colours mean.
    shows_legend : bool
        Whether the legend is drawn.
    corner : str, optional
        The corner of the legend; by default where it hides least.
    camera : Camera, optional
        The camera, for picking: `Camera.ray` returns the ray of a pixel, and `Camera.project` the pixel of a point.
    radius : float, optional
        What was added to the radius of the lines.
    look : Look or Measure, optional
        What shaded the lines. Hair has its `material`.
    rig : Rig, optional
        The lights; None where the look shows no light.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1, 0]]])
    >>> picture = fl.render(tree, width=64, height=64, samples=1)
    >>> pixels, _ = picture.camera.project([[0.5, 1, 0]], 64, 64)   # a point on the upper line
    >>> origin, direction, _ = picture.camera.ray(*pixels[0], 64, 64)
    >>> tree.first_hit(origin, direction, picture.radius).prim
    array(1)
    """

    light: FloatArray
    alpha: FloatArray
    backdrop: FloatArray
    samples: int
    shadow: FloatArray | None = None
    exposure: float = 0.0
    is_light: bool = True
    aovs: dict[str, AnyArray] = field(default_factory=dict)
    legend: Legend | None = None
    shows_legend: bool = False
    corner: str | None = None
    camera: Camera | None = None
    radius: float | None = None
    look: Any = None
    rig: Any = None

    def __repr__(self) -> str:
        height, width = self.alpha.shape
        return f"<Picture: {width} × {height} pixels, {counted(self.samples, 'samples')}>"

    def _ipython_display_(self) -> None:
        """Show nothing if the cell of a notebook shows this picture already; else leave it to `_repr_png_`."""
        if not is_in_cell(self):
            raise NotImplementedError

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        save_png(file, self.to_bytes())
        return file.getvalue()

    def to_bytes(self, transparent: bool = False) -> npt.NDArray[np.uint8]:
        """Return what a screen shows, (height, width, 3) uint8 sRGB; (…, 4) if the backdrop is transparent.

        Colours of transparent pixels are not multiplied by alpha, as PNG wants them.
        """
        alpha = np.clip(self.alpha, 0, 1)[..., None]
        own: AnyArray = self.light / np.maximum(alpha, 1e-6)
        own = filmic(bleed(own * np.float32(2.0**self.exposure))) if self.is_light else np.clip(own, 0, 1)
        shadow = np.zeros_like(alpha) if self.shadow is None else self.shadow[..., None]
        if transparent:
            # A shadow is black that covers what no line does.
            whole = alpha + shadow
            pixels = to_bytes(
                np.concatenate([srgb(own * alpha / np.maximum(whole, 1e-6)), np.clip(whole, 0, 1)], axis=2)
            )
        else:
            pixels = dithered(srgb(own * alpha + (1 - alpha - shadow) * self.backdrop))
        if not (self.shows_legend and self.legend):
            return pixels
        return draw_legend(pixels, self.legend, self.corner or emptiest_corner(self.alpha, self.legend))

    def with_legend(self, corner: str | None = None) -> Picture:
        """Return the picture with its legend drawn.

        That is a colour bar for the numbers of an attribute, hits or nodes, and three axes for directions. Other
        pictures have no legend, and stay the same.

        Parameters
        ----------
        corner : str, optional
            "lower left", "lower right", "upper left" or "upper right"; by default the first one that is empty, or else
            the emptiest.

        Examples
        --------
        >>> import fastlines as fl
        >>> lines = fl.Lines.from_segments([[[0, 0, 0], [1, 1, 1]]], attributes={"fa": [0.5]})
        >>> picture = fl.render(lines, width=64, height=64, radius=0.1, samples=1, look="tube", color="fa")
        >>> picture.with_legend().legend
        ColorBar(title='fa', low=0.5, high=0.5, map='viridis')
        """
        return replace(self, shows_legend=True, corner=None if corner is None else choice("corner", corner, CORNERS))

    def save(self, path: str | os.PathLike[str], transparent: bool = False) -> None:
        """Write the picture as a .png for the eye, or its numbers as an .exr.

        An .exr has the channels R, G and B: linear light, multiplied by alpha and by the exposure, without backdrop and
        filmic curve, and without legend. A is alpha, without the shadow on the ground. AOVs follow: Z is the depth, N.X
        to N.Z the normal, P.X to P.Z the position. The others keep their names.

        Raises
        ------
        InputError
            If the extension is unknown, or a transparent picture is not written as .png.
        MissingExtraError
            If an .exr is to be written, and OpenEXR is not installed.
        """
        if check_image_path(path) == ".exr":
            check_options({"transparent": transparent}, PictureRequest(file=".exr"))
            exposure = np.float32(2.0**self.exposure if self.is_light else 1.0)
            write_light(path, self.light * exposure, self.alpha, self.aovs)
        else:
            write_picture(path, self.to_bytes(transparent))
