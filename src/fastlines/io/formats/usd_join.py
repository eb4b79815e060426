"""Joins the segments of several USD prims to lines or to curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import AnyArray
from ...geometry.curve_input import Converted, valid
from ...geometry.curves import Curves
from ...geometry.lines import Lines
from ...support.immutable import own
from .usd_curves import Strokes
from .usd_values import Remarks


def joined(parts: Sequence[Strokes], remarks: Remarks, invalid: str, *, number_prims: bool) -> Lines | Curves:
    """Return lines of linear segments, or curves of cubic ones, in their order."""
    control, strands = _together([part.control for part in parts]), _together([part.strands for part in parts])
    radius = None
    if any(part.radius is not None for part in parts):
        n_bare = sum(part.n_prims for part in parts if part.radius is None)
        if n_bare:
            remarks.source.warn(f"prims without widths have the radius 0 beside those with widths: {n_bare:,}")
        radii = [np.zeros(part.control.shape[:2]) if part.radius is None else part.radius for part in parts]
        radius = _together(radii)
    attributes, end_attributes = _attributes(parts, remarks)
    end_attributes = {name: own(values) for name, values in end_attributes.items()}
    if number_prims and "prim" not in (*attributes, *end_attributes):
        attributes["prim"] = np.concatenate([part.prim for part in parts])
    if control.shape[1] == 2:
        return Lines.from_segments(
            own(control),
            strands=own(strands),
            radius=None if radius is None else own(radius),
            attributes=attributes,
            end_attributes=end_attributes,
            offset=remarks.source.offset,
            invalid=invalid,
        )
    bad = np.zeros(len(control), np.bool_)
    return Curves(
        **valid(Converted(control, radius, bad, strands, attributes, end_attributes), invalid, remarks.source.offset)
    )


def _together(arrays: Sequence[AnyArray]) -> AnyArray:
    """Return arrays one after the other, and one alone as it is."""
    return np.concatenate(arrays) if len(arrays) > 1 else arrays[0]


def _attributes(parts: Sequence[Strokes], remarks: Remarks) -> tuple[dict[str, AnyArray], dict[str, AnyArray]]:
    """Join attributes by their names: per segment, or at both ends if some prim has them there."""
    names = dict.fromkeys(name for part in parts for name in (*part.attributes, *part.end_attributes))
    attributes: dict[str, AnyArray] = {}
    end_attributes: dict[str, AnyArray] = {}
    for name in names:
        has_ends = any(name in part.end_attributes for part in parts)
        known = [_values(part, name, has_ends) for part in parts]
        given = [values for values in known if values is not None]
        shape = given[0].shape[1:]
        if any(values.shape[1:] != shape for values in given):
            remarks.source.warn(f"primvar {name!r} is not read: its values have different shapes on different prims")
            continue
        if len(given) < len(parts):
            # NaN stands for a value that is not there; it needs floating-point numbers.
            dtype = np.result_type(*given, *([] if given[0].dtype.kind == "f" else [np.float64]))
            missing = len(parts) - len(given)
            remarks.source.warn(f"primvar {name!r} is NaN on the prims that do not have it: {missing:,}")
            known = [
                np.full((len(part.strands), *shape), np.nan, dtype) if values is None else values
                for part, values in zip(parts, known, strict=True)
            ]
        (end_attributes if has_ends else attributes)[name] = _together([v for v in known if v is not None])
    return attributes, end_attributes


def _values(part: Strokes, name: str, has_ends: bool) -> AnyArray | None:
    """Return an attribute of a prim per segment, or at both ends of each; None if it has none."""
    if name in part.end_attributes:
        return part.end_attributes[name]
    values = part.attributes.get(name)
    return np.stack([values, values], axis=1) if values is not None and has_ends else values
