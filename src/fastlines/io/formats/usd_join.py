"""Joins the segments of several USD prims to lines or to curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...arrays import AnyArray
from ...geometry.curve_input import Converted, valid
from ...geometry.curves import Curves
from ...geometry.lines import Lines
from ...geometry.offsets import NO_OFFSET, OFFSET, Offset
from ...support.immutable import own
from ..rounding import Rounding
from .usd_curves import Strokes
from .usd_values import Remarks


class Columns:
    """What is known of the segments of all prims, which some of the prims may lack.

    Parameters
    ----------
    parts : sequence of Strokes
        All prims; their rows do not matter.
    remarks : Remarks
        Takes what prims lack.
    number_prims : bool
        Whether the attribute ``prim`` counts the prims.
    """

    def __init__(self, parts: Sequence[Strokes], remarks: Remarks, *, number_prims: bool) -> None:
        self.dtype = np.result_type(*(part.control for part in parts))
        self.has_radius = any(part.radius is not None for part in parts)
        if self.has_radius and (n_bare := sum(part.n_prims for part in parts if part.radius is None)):
            remarks.source.warn(f"prims without widths have the radius 0 beside those with widths: {n_bare:,}")
        #: Of each attribute, whether it has values at both ends of segments, its type, and its shape per row.
        self.values: dict[str, tuple[bool, np.dtype[Any], tuple[int, ...]]] = {}
        for name in dict.fromkeys(name for part in parts for name in (*part.attributes, *part.end_attributes)):
            has_ends = any(name in part.end_attributes for part in parts)
            given = [values for part in parts if (values := _values(part, name, has_ends)) is not None]
            shape = given[0].shape[1:]
            if any(values.shape[1:] != shape for values in given):
                remarks.source.warn(
                    f"primvar {name!r} is not read: its values have different shapes on different prims"
                )
                continue
            dtype = np.result_type(*given)
            if len(given) < len(parts):
                # NaN stands for a value that is not there; it needs floating-point numbers.
                dtype = np.result_type(dtype, *([] if given[0].dtype.kind == "f" else [np.float64]))
                missing = len(parts) - len(given)
                remarks.source.warn(f"primvar {name!r} is NaN on the prims that do not have it: {missing:,}")
            self.values[name] = has_ends, dtype, shape
        self.has_numbers = number_prims and "prim" not in self.values


def joined(
    parts: Sequence[Strokes], columns: Columns, invalid: str, rounding: Rounding, offset: Offset
) -> Lines | Curves:
    """Return lines of linear segments, or curves of cubic ones, in their order."""
    control = _together([part.control for part in parts]).astype(columns.dtype, copy=False)
    strands = own(_together([part.strands for part in parts]))
    radius = None
    if columns.has_radius:
        radii = [np.zeros(part.control.shape[:2]) if part.radius is None else part.radius for part in parts]
        radius = own(_together(radii))
    attributes: dict[str, AnyArray] = {}
    end_attributes: dict[str, AnyArray] = {}
    for name, (has_ends, dtype, shape) in columns.values.items():
        known = [_values(part, name, has_ends) for part in parts]
        values = [
            np.full((len(part.strands), *shape), np.nan, dtype) if of_part is None else of_part
            for part, of_part in zip(parts, known, strict=True)
        ]
        (end_attributes if has_ends else attributes)[name] = own(_together(values).astype(dtype, copy=False))
    if columns.has_numbers:
        attributes["prim"] = np.concatenate([part.prim for part in parts])
    if control.shape[1] == 2:
        lines = Lines.from_segments(
            rounding.to_float32(control.reshape(-1, 3), offset).reshape(-1, 2, 3),
            strands=strands,
            radius=radius,
            attributes=attributes,
            end_attributes=end_attributes,
            invalid=invalid,
        )
        return lines if offset == NO_OFFSET else replace(lines, metadata={OFFSET: offset})
    bad = np.zeros(len(control), np.bool_)
    return Curves(**valid(Converted(control, radius, bad, strands, attributes, end_attributes), invalid, offset))


def _together(arrays: Sequence[AnyArray]) -> AnyArray:
    """Return arrays one after the other, and one alone as it is."""
    return np.concatenate(arrays) if len(arrays) > 1 else arrays[0]


def _values(part: Strokes, name: str, has_ends: bool) -> AnyArray | None:
    """Return an attribute of a prim per segment, or at both ends of each; None if it has none."""
    if name in part.end_attributes:
        return part.end_attributes[name]
    values = part.attributes.get(name)
    return np.stack([values, values], axis=1) if values is not None and has_ends else values
