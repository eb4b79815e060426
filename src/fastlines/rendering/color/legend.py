"""Legends: what the colours of a picture mean, drawn into a corner of it.

Letters are light on dark pictures and dark on light ones, and have a halo of the opposite shade.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray
from ...camera import Float64Array
from .palette import mapped, of_directions
from .tone import srgb

if TYPE_CHECKING:
    from PIL import Image, ImageDraw, ImageFont

Bytes: TypeAlias = npt.NDArray[np.uint8]
Shade: TypeAlias = tuple[int, int, int]

#: Sizes as fractions of the shorter side of the picture: letters, the space around, the bar, the arms of the triad.
LETTERS, MARGIN, BAR, ARM = 0.026, 0.03, (0.34, 0.018), 0.06
#: The smallest letters, in pixels.
SMALLEST = 9
#: The corners, in the order in which they are tried: the first one with so few lines, or else the emptiest.
CORNERS, EMPTY = ("lower left", "lower right", "upper left", "upper right"), 0.01
#: Legends are drawn larger by this factor and scaled down, for smooth edges.
FINER = 4
LIGHT: Shade = (240, 240, 240)
DARK: Shade = (22, 22, 24)


@dataclass(frozen=True)
class ColorBar:
    """A colour map, the numbers at both of its ends, and what they are."""

    title: str
    low: float
    high: float
    map: str

    @property
    def is_constant(self) -> bool:
        """Whether all numbers are the same; they have the colour in the middle of the map."""
        return self.high - self.low <= 1e-6 * max(abs(self.low), abs(self.high))

    def colors(self, values: npt.NDArray[np.floating]) -> FloatArray:
        """Return the colours of numbers, linear, (…, 3)."""
        if self.is_constant:
            return mapped(np.full(np.shape(values), 0.5), self.map)
        return mapped((values - self.low) / (self.high - self.low), self.map)


@dataclass(frozen=True, eq=False)
class Triad:
    """The x, y and z axes as a camera sees them, each in the colour of its direction.

    Attributes
    ----------
    axes : (3, 3) array
        The unit vectors to the right, up and forward, as `Camera.axes` returns them.
    """

    axes: Float64Array


Legend: TypeAlias = ColorBar | Triad


def emptiest_corner(alpha: FloatArray, legend: Legend) -> str:
    """Return the corner of a picture where a legend hides least: the first without lines, or that with the fewest.

    Parameters
    ----------
    alpha : (height, width) array
        The fraction of each pixel that lines cover.
    legend : ColorBar or Triad

    Examples
    --------
    >>> alpha = np.zeros((100, 200))
    >>> alpha[50:] = 1  # lines in the lower half
    >>> emptiest_corner(alpha, ColorBar("fa", 0.0, 1.0, "viridis"))
    'upper left'
    """
    drawn = Pen(min(alpha.shape) * FINER, LIGHT, DARK).drawn(legend)
    covered = {corner: float(alpha[_within(alpha, corner, *drawn.size)].mean()) for corner in CORNERS}
    return next((corner for corner in CORNERS if covered[corner] < EMPTY), min(CORNERS, key=lambda at: covered[at]))


def draw_legend(pixels: Bytes, legend: Legend, corner: str = CORNERS[0]) -> Bytes:
    """Draw a legend into a corner of a picture.

    Parameters
    ----------
    pixels : (height, width, 3) or (height, width, 4) uint8
    legend : ColorBar or Triad
    corner : str
        One of `CORNERS`.

    Returns
    -------
    array of the same shape

    Examples
    --------
    >>> picture = np.zeros((100, 200, 3), np.uint8)
    >>> drawn = draw_legend(picture, ColorBar("fa", 0.0, 1.0, "viridis"))
    >>> bool(drawn[50:, :100].any()), bool(drawn[:50].any())
    (True, False)
    """
    from PIL import Image

    height, width = pixels.shape[:2]
    drawn = Pen.of(pixels, corner).drawn(legend)
    picture = Image.fromarray(pixels).convert("RGBA")
    rows, columns = _within(pixels, corner, *drawn.size)
    above = max(0, drawn.height - height)
    picture.alpha_composite(drawn.crop((0, above, min(width, drawn.width), drawn.height)), (columns.start, rows.start))
    return np.array(picture.convert("RGB" if pixels.shape[2] == 3 else "RGBA"))


def _within(pixels: AnyArray, corner: str, width: int, height: int) -> tuple[slice, slice]:
    """Return the rows and the columns of a part of a picture of some size in a corner, as far as it has them."""
    whole_height, whole_width = pixels.shape[:2]
    height, width = min(height, whole_height), min(width, whole_width)
    top = 0 if "upper" in corner else whole_height - height
    left = 0 if "left" in corner else whole_width - width
    return slice(top, top + height), slice(left, left + width)


@dataclass(frozen=True)
class Pen:
    """Sizes in fine pixels, and the shades of letters and halos."""

    side: float
    ink: Shade
    halo: Shade

    @classmethod
    def of(cls, pixels: Bytes, corner: str) -> Pen:
        """Choose light letters on a dark or transparent corner, and dark ones on a light corner."""
        side = min(pixels.shape[:2])
        near = pixels[_within(pixels, corner, max(1, side // 2), max(1, side // 4))]
        shown = near[..., :3] * (near[..., 3:] / 255 if pixels.shape[2] == 4 else 1)
        bright = shown.mean() > 128
        return cls(side * FINER, *((DARK, LIGHT) if bright else (LIGHT, DARK)))

    @property
    def margin(self) -> float:
        """The space around the legend."""
        return MARGIN * self.side

    @property
    def letters(self) -> float:
        """The height of letters."""
        return max(SMALLEST * FINER, LETTERS * self.side)

    def drawn(self, legend: Legend) -> Image.Image:
        """Draw a legend, in pixels of the picture."""
        return self.bar(legend) if isinstance(legend, ColorBar) else self.triad(legend)

    def bar(self, bar: ColorBar) -> Image.Image:
        """Draw a colour bar between its title and its numbers, in pixels of the picture."""
        long, high = BAR[0] * self.side, max(BAR[1] * self.side, 4 * FINER)
        gap = 0.35 * self.letters
        texts = bar.title, f"{bar.low:.3g}", "" if bar.is_constant else f"{bar.high:.3g}"
        wide = max(long, self._font().getlength(texts[0]), sum(map(self._font().getlength, texts[1:])) + 2 * gap)
        image, draw = self._canvas(wide, high + 2 * (1.2 * self.letters + gap))
        left, top = self.margin, self.margin + 1.2 * self.letters + gap
        right, bottom = left + long, top + high
        self._text(draw, (left, top - gap), texts[0], self.ink, "ls")
        edge = 0.12 * self.letters
        draw.rectangle((left - edge, top - edge, right + edge, bottom + edge), self.ink)
        columns = np.arange(int(left), int(right))
        colors = bar.colors(bar.low + (columns - left) / long * (bar.high - bar.low))
        for column, color in zip(columns.tolist(), colors, strict=True):
            draw.line((column, top, column, bottom), _color(color))
        self._text(draw, (left, bottom + gap + 0.9 * self.letters), texts[1], self.ink, "ls")
        self._text(draw, (max(right, left + wide), bottom + gap + 0.9 * self.letters), texts[2], self.ink, "rs")
        return image.reduce(FINER)

    def triad(self, triad: Triad) -> Image.Image:
        """Draw the three axes, the farthest first, in pixels of the picture."""
        arm = max(ARM * self.side, 1.5 * self.letters)
        reach = arm + self.letters
        image, draw = self._canvas(2 * reach, 2 * reach)
        middle = self.margin + reach
        thick = 0.2 * self.letters
        for axis in np.argsort(-triad.axes[2]):
            right, up = triad.axes[:2, axis]
            color = _color(of_directions(np.eye(3, dtype=np.float32)[[axis]])[0])
            end = middle + arm * right, middle - arm * up
            for shade, more in ((self.halo, 0.6 * thick), (color, 0.0)):
                draw.line((middle, middle, *end), shade, round(thick + 2 * more))
                for x, y in ((middle, middle), end):
                    half = thick / 2 + more
                    draw.ellipse((x - half, y - half, x + half, y + half), shade)
            label = middle + (arm + 0.6 * self.letters) * right, middle - (arm + 0.6 * self.letters) * up
            self._text(draw, label, "xyz"[axis], color, "mm")
        return image.reduce(FINER)

    def _canvas(self, width: float, height: float) -> tuple[Image.Image, ImageDraw.ImageDraw]:
        """Return an empty image with a margin around this size."""
        from PIL import Image, ImageDraw

        size = [FINER * int(-(-(length + 2 * self.margin) // FINER)) for length in (width, height)]
        image = Image.new("RGBA", (size[0], size[1]), (*self.halo, 0))
        return image, ImageDraw.Draw(image)

    def _font(self) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
        from PIL import ImageFont

        return ImageFont.load_default(self.letters)

    def _text(
        self, draw: ImageDraw.ImageDraw, place: tuple[float, float], text: str, shade: Shade, anchor: str
    ) -> None:
        halo = max(FINER, round(0.12 * self.letters))
        draw.text(place, text, shade, self._font(), anchor, stroke_width=halo, stroke_fill=self.halo)


def _color(linear: npt.NDArray[np.float32]) -> Shade:
    """Return the bytes of a colour in linear light."""
    red, green, blue = np.rint(255 * srgb(linear)).astype(int).tolist()
    return red, green, blue
