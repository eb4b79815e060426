"""What gives lines their colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import AnyArray, FloatArray, did_you_mean
from ...errors import FileWarning, InputError
from ...geometry.any_geometry import AnyGeometry
from ...support.warn_caller import warn_caller
from ..color.legend import ColorBar, Legend, Triad
from ..color.palette import light_of, of_directions, of_neurites, of_numbers
from ..color.tone import linear
from ..shading.fragments import Fragments
from ..shading.shading_context import ShadingContext
from .variation import shade_of_strands

#: The attribute that holds the colour of lines in USD.
DISPLAY_COLOR = "displayColor"
#: The attribute of SWC that holds the types of neurites, and the radius of lines, which is in the unit of coordinates.
TYPE, RADIUS = "type", "radius"
#: How bright red, green and blue look (Rec. 709).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
#: The words that are colours of lines, and what begins the name of an attribute that could be taken for one of them.
WORDS, ATTRIBUTE = ("direction", "strand"), "attribute:"


@dataclass(frozen=True)
class Color:
    """Colours of fragments.

    Parameters
    ----------
    by : {"direction", "strand", "plain", "attribute", "neurite"}
        What colours depend on.
    map : str
        The colour map for the numbers of an attribute.
    plain : (3,) numbers
        The colour of all lines, linear.
    range : pair of numbers, optional
        The values at both ends of the map; by default those of all lines, without the outer hundredths.
    attribute : str
        The name of the attribute.
    variation : float
        How much brighter or darker than that a strand is, from 0 to 1.
    """

    by: str = "direction"
    map: str = "viridis"
    plain: tuple[float, float, float] = (0.72, 0.64, 0.52)
    range: tuple[float, float] | None = None
    attribute: str = ""
    variation: float = 0.0

    def of(self, fragments: Fragments, context: ShadingContext) -> FloatArray:
        """Return the colour of each fragment, (n, 3) linear."""
        colors = self._of(fragments, context)
        return colors * shade_of_strands(fragments.strand, self.variation)[:, None] if self.variation else colors

    def _of(self, fragments: Fragments, context: ShadingContext) -> FloatArray:
        if self.by == "plain":
            return np.broadcast_to(np.asarray(self.plain, np.float32), (len(fragments), 3))
        if self.by == "direction":
            return of_directions(fragments.smooth_tangents)
        if self.by == "strand":
            return of_numbers(fragments.strand)
        if self.by == "neurite":
            return of_neurites(fragments.hits.sample(TYPE))
        values = fragments.hits.sample(self.attribute)
        if values.ndim == 2 and values.shape[1] == 3:
            return _colors(np.nan_to_num(values), context.tree.geometry, self.attribute)
        if values.ndim != 1:
            raise InputError(
                f"attribute {self.attribute!r} has {values.shape[1:]} numbers a line; a colour needs one or three"
            )
        return self._bar(context.tree.geometry).colors(values)

    def legend(self, context: ShadingContext) -> Legend | None:
        """Return a colour bar for numbers or a triad for directions; None for other colours."""
        if self.by == "direction":
            return Triad(context.camera.axes())
        return self._bar(context.tree.geometry) if self.has_bar(context.tree.geometry) else None

    def has_bar(self, geometry: AnyGeometry) -> bool:
        """Return whether these are the colours of numbers, which a colour bar explains."""
        return self.by == "attribute" and is_number(geometry, self.attribute)

    def depends_on(self, geometry: AnyGeometry) -> str:
        """Return what these colours depend on, as `options.PictureRequest` names it."""
        if self.by in ("attribute", "neurite"):
            return "number" if self.has_bar(geometry) else "other"
        return self.by

    def lightness(self, geometry: AnyGeometry) -> float:
        """Return the mean luminance of lines of one colour, or with colours in the file; of others that of grey."""
        colors = np.full((1, 3), 0.2)
        if self.by == "plain":
            colors = np.array([self.plain])
        elif self.by == "attribute":
            arrays = (
                array for array, n in geometry.arrays_of(self.attribute) if array.shape[n:] == (3,) and len(array)
            )
            found = [_colors(np.nan_to_num(array.reshape(-1, 3)), geometry, self.attribute) for array in arrays]
            colors = np.concatenate(found) if found else colors
        return float((colors @ LUMINANCE).mean(dtype=np.float64))

    def _bar(self, geometry: AnyGeometry) -> ColorBar:
        has_unit = self.attribute == RADIUS and geometry.unit is not None
        title = f"{self.attribute} in {geometry.unit}" if has_unit else self.attribute
        return ColorBar(title, *(self.range or value_range(geometry, self.attribute)), self.map)


def _colors(values: AnyArray, geometry: AnyGeometry, name: str) -> FloatArray:
    """Return the linear light of colours: of bytes, as files of meshes have them, or of numbers from 0 to 1."""
    if any(array.dtype == np.uint8 for array, _ in geometry.arrays_of(name)):
        return linear(values / 255)
    return np.asarray(np.clip(values, 0, 1), np.float32)


def make_color(by: str | Sequence[float], color_map: str, geometry: AnyGeometry) -> Color:
    """Return the colour that a text or three numbers describe; refuse an attribute that no part of the geometry has.

    The words "direction" and "strand" keep their meaning, and so does "#" before digits, whatever attributes there are.
    "attribute:" names an attribute in any case.
    """
    plain = light_of(by)
    if plain is not None:
        return Color("plain", color_map, plain)
    assert isinstance(by, str)
    known = geometry.sample_names
    if by in WORDS:
        if by in known:
            text = f"color={by!r} is the {by} of lines; color={ATTRIBUTE + by!r} is their attribute of this name"
            warn_caller(text, FileWarning)
        return Color(by, color_map)
    name = by.removeprefix(ATTRIBUTE)
    if name not in known:
        choices = known if by.startswith(ATTRIBUTE) else (*WORDS, "#rrggbb", *known)
        raise InputError(f"lines have no attribute {name!r} to be coloured by{did_you_mean(name, choices)}")
    for array, _ in geometry.arrays_of(name):
        is_vector = array.dtype.kind == "f" and array.shape[-1] == 3 and not is_number(geometry, name)
        if name != DISPLAY_COLOR and is_vector and np.nanmax(array, initial=0) > 1:
            raise InputError(
                f"attribute {name!r} holds numbers above 1; a colour is bytes, or three numbers from 0 to 1"
            )
    return Color("attribute", color_map, attribute=name)


def is_number(geometry: AnyGeometry, name: str) -> bool:
    """Return whether an attribute is one number at each place, not a colour or a vector."""
    return name in geometry.sample_names and all(array.ndim == n for array, n in geometry.arrays_of(name))


def value_range(geometry: AnyGeometry, name: str) -> tuple[float, float]:
    """Return the range of an attribute, without the outer hundredths of its values."""
    arrays = (values for values, _ in geometry.arrays_of(name) if values.dtype.kind in "biuf")
    found = [np.asarray(values, np.float64).ravel() for values in arrays]
    values = np.concatenate([np.zeros(0), *found])
    values = values[np.isfinite(values)]
    if not len(values):
        return 0.0, 1.0
    low, high = np.quantile(values, [0.01, 0.99])
    return float(low), float(high)
