"""What a format cannot hold, in words, as writers return it."""

from __future__ import annotations

import math
from collections.abc import Container

import numpy as np

from ..arrays import AnyArray, IntArray
from ..geometry.lines import Lines
from ..support.units import factor_between
from .polylines import Polylines


def is_encodable(name: str) -> bool:
    """Return whether a name can be written as UTF-8, which halves of surrogate pairs cannot."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def not_held(
    lines: Lines,
    polylines: Polylines,
    *,
    radius: bool = False,
    needs_radius: bool = False,
    attributes: Container[str] = (),
    strands: bool = False,
    unit: str | None = None,
) -> list[str]:
    """Return what is lost when lines are written as polylines.

    Parameters
    ----------
    radius : bool
        Whether the format has a radius at each point.
    needs_radius : bool
        Whether it has one in any case, so that 0 stands for none.
    attributes : container of str
        The attributes that are written.
    strands : bool
        Whether the numbers of strands are written.
    unit : str, optional
        The unit by the format's convention.
    """
    lost = []
    if lines.radius is not None and not radius:
        lost.append("radius")
    if lines.radius is None and needs_radius:
        lost.append("that there is no radius, which is written as 0")
    if not strands:
        lost += strand_numbers(polylines.strand)
    names = [repr(name) for name in (*polylines.point_attributes, *polylines.attributes) if name not in attributes]
    lost += names
    said = tuple(f"{name} on " for name in ("radius",) * (not radius) + tuple(names))
    lost += [text for text in polylines.lost if not text.startswith(said)]
    return lost + conventions(lines, unit)


def conventions(lines: Lines, unit: str | None = None, up: str | None = None) -> list[str]:
    """Return what is lost of the unit and the upward axis in a format that has these by convention, or none.

    Examples
    --------
    >>> lines = Lines(np.zeros((1, 2, 3), np.float32), unit="mm")
    >>> conventions(lines, "mm", "z"), conventions(lines)
    ([], ["the unit 'mm'"])
    """
    lost = []
    if lines.unit is None and unit and len(lines):
        lost.append(f"that the unit is not known (coordinates will be read as {unit})")
    factor = factor_between(lines.unit or "", unit or "")
    if lines.unit not in (None, unit) and not (factor and math.isclose(factor, 1)):
        first = f": to keep lengths, multiply them and the radius by {factor:g} first" if factor else ""
        instead = f" (coordinates are written as they are, and will be read as {unit}{first})" if unit else ""
        lost.append(f"the unit {lines.unit!r}{instead}")
    if lines.up not in (None, up):
        lost.append(f"the upward axis {lines.up!r}" + (f" ({up} will be up)" if up else ""))
    return lost


def strand_numbers(strand: IntArray, first: int = 0) -> list[str]:
    """Return what is lost of the strands of polylines when these are counted first, first + 1, … in the file.

    Examples
    --------
    >>> strand_numbers(np.array([0, 1, -1])), strand_numbers(np.array([0, 0]))
    (['that segments have no strand'], ['the numbers of strands, which are counted from 0'])
    """
    lost = []
    if (strand < 0).any():
        lost.append("that segments have no strand")
    if ((strand >= 0) & (strand != first + np.arange(len(strand)))).any():
        lost.append("the numbers of strands, which are counted from 0")
    return lost


def free_name(name: str, clean: str, taken: set[str], lost: list[str]) -> str:
    """Return the name that is written: `clean`, with ``_`` appended while another attribute has that name.

    Parameters
    ----------
    clean : str
        The name as the format can hold it.
    taken : set of str
        The names of all attributes, and those written so far; the name is added.
    lost : list of str
        Where it is recorded that the name is another one.
    """
    written = clean
    if written != name:
        while written in taken:
            written += "_"
        lost.append(f"the name {name!r} ({written!r} is written)")
    taken.add(written)
    return written


def keeps_values(values: AnyArray, written: AnyArray) -> bool:
    """Return whether numbers that are written as floats can be converted back exactly."""
    with np.errstate(invalid="ignore", over="ignore"):
        back = written.astype(values.dtype)
    if values.dtype.kind == "f":
        return np.array_equal(back, values, equal_nan=True)
    # The largest whole numbers may be rounded to one that their type does not have.
    n_bits = 8 * values.dtype.itemsize - (values.dtype.kind == "i")
    return bool((written < 2.0**n_bits).all()) and np.array_equal(back, values)
