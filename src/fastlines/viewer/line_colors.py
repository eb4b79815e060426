"""The colours of lines on the page, and the legend that explains them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, did_you_mean, is_text
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.hit_places import Float64Array, unit
from ..inspection.outline import Outline
from ..rendering.color.legend import ColorBar
from ..rendering.color.palette import of_directions, of_numbers
from ..rendering.looks.color import ATTRIBUTE, value_range
from ..support.distinct import distinct
from ..support.texts import counted
from .strokes import Strokes
from .tree_values import TREE_VALUES, tree_values

#: Colours of spheres and other strokes without a direction, linear.
PLAIN = (0.45, 0.55, 0.7)
#: The colour map of numbers.
MAP = "viridis"


@dataclass(frozen=True, eq=False)
class LineLegend:
    """What colours mean.

    Attributes
    ----------
    title : str
    bar : ColorBar or None
        The colour map and the numbers at its ends; None if colours are not those of numbers.
    notes : tuple of str
        What else there is to know.
    """

    title: str
    bar: ColorBar | None = None
    notes: tuple[str, ...] = ()


def color_names(geometry: AnyGeometry) -> tuple[str, ...]:
    """Return the names of what lines can be coloured by.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.Lines.from_segments([[[0, 0, 0], [1, 2, 3]]], attributes={"speed": [3.0]})
    >>> color_names(lines)
    ('direction', 'depth', 'leaf size', 'cost', 'attribute:speed')
    """
    names = ["direction", *["strand"] * (geometry.n_strands > 0), *TREE_VALUES]
    names += ["radius"] * (geometry.radius_range is not None or geometry.max_radius > 0)
    return (*names, *(ATTRIBUTE + name for name in numeric_attributes(geometry)))


def numeric_attributes(geometry: AnyGeometry) -> tuple[str, ...]:
    """Return the names of attributes that hold numbers: one, or the components of a vector."""
    return tuple(name for name in _attributes(geometry) if all(map(_is_numeric, _arrays(geometry, name))))


def check_color(name: str, geometry: AnyGeometry) -> str:
    """Return the name of a colouring; that of an attribute may be given alone.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    known = color_names(geometry)
    found = name if name in known else f"{ATTRIBUTE}{name}"
    if found not in known:
        raise InputError(f"lines cannot be coloured by {name!r}{did_you_mean(name, known)}")
    return found


def line_colors(name: str, strokes: Strokes, geometry: AnyGeometry, outline: Outline) -> tuple[FloatArray, LineLegend]:
    """Return the colours of both ends of each stroke, (n, 2, 3) linear, and what they mean.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.inspection import outline_of
    >>> from fastlines.viewer.strokes import strokes_of
    >>> tree = fl.build(fl.scenes.make("spaghetti", 100).lines)
    >>> colors, legend = line_colors("leaf size", strokes_of(tree.geometry), tree.geometry, outline_of(tree))
    >>> colors.shape, legend.title
    ((100, 2, 3), 'leaf size: references in the leaf; the mean over all references')
    """
    check_color(name, geometry)
    if name == "direction":
        return _by_direction(strokes)
    if name == "strand":
        return _by_strand(strokes, geometry)
    values, title, limits = _values(name, strokes, geometry, outline)
    known = values[np.isfinite(values)]
    low, high = limits or ((float(known.min()), float(known.max())) if len(known) else (0.0, 1.0))
    bar = ColorBar(title, low, high, MAP)
    notes = ["values beyond the outer hundredths have the colours of the ends"] * (limits is not None)
    if n_missing := len(distinct(strokes.prims[np.isnan(values).any(axis=1)])):
        notes.append(f"grey: {counted(n_missing, strokes.noun)} shown without a value (NaN)")
    return bar.colors(values), LineLegend(title, bar, tuple(notes))


def _values(
    name: str, strokes: Strokes, geometry: AnyGeometry, outline: Outline
) -> tuple[Float64Array, str, tuple[float, float] | None]:
    """Return the value at both ends of each stroke, (n, 2), what it is, and the range of colours if it is clipped."""
    unit_text = f" in {geometry.unit}" if geometry.unit else ""
    if name in TREE_VALUES:
        of_prims = tree_values(outline, geometry, name)
        return np.stack([of_prims[strokes.prims]] * 2, axis=1), f"{name}: {TREE_VALUES[name]}", _hundredths(of_prims)
    if name == "radius":
        return strokes.radii.astype(np.float64), f"radius of the lines{unit_text}", None
    attribute = name.removeprefix(ATTRIBUTE)
    values = np.full((len(strokes.prims), 2), np.nan)
    first, is_vector, places = 0, False, dict[str, None]()
    for part in geometry.each_part():
        here = (first <= strokes.prims) & (strokes.prims < first + len(part))
        first += len(part)
        if attribute not in _attributes(part):
            continue
        array, has_places = _array(part, attribute)
        is_vector |= array.ndim > 1 + has_places
        values[here] = _at_ends(array, has_places, strokes.prims[here] - first + len(part), strokes.places[here])
        places[part.place_of(attribute) if attribute in part.sample_names else ""] = None
    what = f"{attribute}{', its length' if is_vector else ''}"
    per = ", ".join(filter(None, places))
    limits = _hundredths(values) if is_vector else value_range(geometry, attribute)
    return values, f"{what}{f' per {per}' if per else ''}", limits


def _at_ends(
    array: npt.NDArray[Any], has_places: bool, prims: npt.NDArray[np.int64], places: FloatArray
) -> Float64Array:
    """Return the values of an attribute at both ends of strokes, the length of vectors."""
    found = array[prims].astype(np.float64)
    if found.ndim > 1 + has_places:
        found = np.sqrt((found**2).sum(axis=-1))
    if not has_places:
        return np.stack([found, found], axis=1)
    if found.shape[1] == 2:
        return np.asarray(found[:, :1] * (1 - places) + found[:, 1:] * places)
    return np.take_along_axis(found, places.astype(np.int64), axis=1)


def _hundredths(values: Float64Array) -> tuple[float, float]:
    """Return the range of values without the outer hundredths."""
    known = values[np.isfinite(values)]
    low, high = np.quantile(known, [0.01, 0.99]) if len(known) else (0.0, 1.0)
    return float(low), float(high)


def _attributes(geometry: AnyGeometry) -> tuple[str, ...]:
    parts = geometry.each_part()
    return tuple(dict.fromkeys(name for part in parts for name in (*part.place_attributes, *part.attributes)))


def _arrays(geometry: AnyGeometry, name: str) -> list[tuple[npt.NDArray[Any], bool]]:
    return [_array(part, name) for part in geometry.each_part() if name in _attributes(part)]


def _array(part: AnyGeometry, name: str) -> tuple[npt.NDArray[Any], bool]:
    """Return the values of an attribute, and whether there is one for each end or corner."""
    return (part.place_attributes[name], True) if name in part.place_attributes else (part.attributes[name], False)


def _is_numeric(array: tuple[npt.NDArray[Any], bool]) -> bool:
    values, has_places = array
    return not is_text(values) and values.dtype.kind in "biuf" and values.ndim <= 2 + has_places


def _by_direction(strokes: Strokes) -> tuple[FloatArray, LineLegend]:
    along = strokes.ends[:, 1].astype(np.float64) - strokes.ends[:, 0]
    has_length = along.any(axis=1)
    colors = np.full((len(along), 3), PLAIN, np.float32)
    colors[has_length] = of_directions(unit(along[has_length]).astype(np.float32))
    return np.stack([colors, colors], axis=1), LineLegend("direction: x is red, y is green, z is blue")


def _by_strand(strokes: Strokes, geometry: AnyGeometry) -> tuple[FloatArray, LineLegend]:
    strands, first, begin = np.zeros(len(strokes.prims), np.int64), 0, 0
    for part in geometry.each_part():
        here = (first <= strokes.prims) & (strokes.prims < first + len(part))
        of_part = part.strands_of(strokes.prims[here] - first)
        strands[here] = np.where(of_part >= 0, of_part + begin, -1)
        first, begin = first + len(part), begin + part.end_of_strands
    colors = of_numbers(strands)
    colors[strands < 0] = PLAIN
    n = geometry.n_strands
    return np.stack([colors, colors], axis=1), LineLegend(f"strand: {n:,} strands, neighbours in different colours")
