"""Lines and curves as named arrays, which is what ``.npz`` and ``.safetensors`` files hold.

| names                                     | what they are                                                |
|-------------------------------------------|--------------------------------------------------------------|
| ``segments`` (n, 2, 3) or (n, 6)          | lines; with or without integer ``strands`` (n,)              |
| ``points`` (m, 3) and ``counts`` (k,)     | lines: the points of k strands, and how many each has        |
| ``control`` (n, 4, 3)                     | cubic Bezier curves; with or without integer ``strands`` (n,) |
| ``radius``                                | (n,) or (n, 2) of segments; (m,) of points; also (n, 4) of curves |
| ``end_attributes/NAME`` (n, 2, …)         | values at both ends of each segment or curve                 |
| ``attributes/NAME``, or any other name    | attributes: one row for each segment, point or curve         |
| ``texts/`` and the name of an attribute   | the different texts of an attribute that has the number of each text |

Facts are texts beside the arrays: ``up`` ("x", "y" or "z"), ``unit`` ("mm" or another), ``metadata`` (JSON) and, of
curves, ``tolerance``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...arrays import AnyArray, is_text, list_rows
from ...errors import InputError
from ...geometry.curve_input import bad_radius
from ...geometry.curves import Curves
from ...geometry.lines import AXES, Lines
from ...geometry.offsets import in_file, with_metadata
from ...support.metadata import from_json, to_json
from ...support.text_columns import TEXTS, numbered, texts_of
from ..source import Source

#: What begins the name of an attribute that could be taken for something else.
ENDS, ATTRIBUTES = "end_attributes/", "attributes/"
#: The texts beside the arrays.
FACTS = ("up", "unit", "tolerance", "metadata")
_PREFIXES = (ENDS, ATTRIBUTES, TEXTS)
_RESERVED = {"segments", "points", "counts", "control", "strands", "radius", *FACTS}


def from_arrays(source: Source, arrays: dict[str, AnyArray], facts: Mapping[str, str], invalid: str) -> Lines | Curves:
    """Return what the arrays of a file hold."""
    arrays = dict(arrays)
    name: str
    match sorted(arrays.keys() & {"segments", "points", "counts", "control", "strands"}):
        case [("segments" | "control") as found] | [("segments" | "control") as found, "strands"]:
            name = found
        case ["counts", "points"]:
            name = "points"
        case _:
            raise source.error(
                f"holds the arrays {', '.join(arrays) or '(none)'}; expected 'segments' or 'control', with or without "
                "'strands', or 'points' and 'counts'"
            )
    given, radius = arrays.pop(name), arrays.pop("radius", None)
    n_rows = len(given) if given.ndim else 0
    strands, counts = arrays.pop("strands", np.full(n_rows, -1)), arrays.pop("counts", np.zeros(0, np.int64))
    _check(source, "strands", strands, (n_rows,), integer=True)
    if name != "segments":
        _check(source, name, given, (n_rows, 3) if name == "points" else (n_rows, 4, 3))
    _check(source, "counts", counts, counts.shape[:1], integer=True)
    if np.any(counts < 0) or np.any(counts > n_rows):  # before they are added: the sum could wrap around
        raise source.error(f"'counts' are from {counts.min()} to {counts.max()}; there are {n_rows} points")
    if radius is not None:
        widest = {"segments": (2,), "points": (), "control": (2, 4)}[name]
        per_row = radius.shape[1:] if radius.ndim == 2 and radius.shape[1] in widest else ()
        _check(source, "radius", radius, (n_rows, *per_row))
    attributes, end_attributes = _attributes(source, arrays, n_rows, ends=name != "points")
    known = _facts(source, facts, is_curves=name == "control")
    offset = source.offset_or(known.get("metadata", {}))
    made: Lines | Curves
    if name == "control":
        more: dict[str, Any] = {"attributes": attributes, "end_attributes": end_attributes, "invalid": invalid}
        more["offset"] = offset
        made = _curves(source, given, radius, strands=strands, **more)
    else:
        radius = None if radius is None else source.radius("radius", radius)
        made = (
            Lines.from_points(given, counts, radius=radius, attributes=attributes, offset=offset, invalid=invalid)
            if name == "points"
            else Lines.from_segments(
                given,
                strands=strands,
                radius=radius,
                attributes=attributes,
                end_attributes=end_attributes,
                offset=offset,
                invalid=invalid,
            )
        )
    if "metadata" in known:
        known["metadata"] = with_metadata(made, known["metadata"])
    return replace(made, **known) if known else made


def to_arrays(geometry: Lines | Curves) -> tuple[dict[str, AnyArray], dict[str, str], list[str]]:
    """Return the arrays and the facts of lines or curves, and what has no place in them."""
    name = next(iter(geometry.sections))
    points = getattr(geometry, name)
    arrays: dict[str, AnyArray] = {name: in_file(geometry, points), "strands": geometry.strands}
    if geometry.radius is not None:
        arrays["radius"] = geometry.radius
    lost = []
    per_row = {name: values for name, values in geometry.attributes.items() if name not in geometry.end_attributes}
    for prefix, columns in ((ATTRIBUTES, per_row), (ENDS, geometry.end_attributes)):
        for column, values in columns.items():
            has_texts = is_text(values)
            if not (has_texts or values.dtype.kind in "fiub") or not column.isprintable():
                lost.append(f"{column!r} ({values.dtype})")
                continue
            plain = prefix == ATTRIBUTES and column not in _RESERVED and not column.startswith(_PREFIXES)
            key = column if plain else prefix + column
            arrays[key] = values
            if has_texts:
                arrays[key], arrays[TEXTS + key] = numbered(values)
    tolerance = getattr(geometry, "tolerance", None)
    facts = {
        "up": geometry.up,
        "unit": geometry.unit,
        "tolerance": None if tolerance is None else repr(tolerance),
        "metadata": to_json(geometry.metadata) if geometry.metadata else None,
    }
    return arrays, {name: text for name, text in facts.items() if text is not None}, lost


def _curves(source: Source, control: AnyArray, radius: AnyArray | None, **more: Any) -> Curves:
    """Make curves; Bezier coefficients of the radius may be negative inside."""
    if radius is None or radius.ndim == 1 or radius.shape[1] == 2:
        return Curves.from_bezier(control, None if radius is None else source.radius("radius", radius), **more)
    with np.errstate(over="ignore"):
        coefficients = radius.astype(np.float32)
    bad = bad_radius(coefficients)
    if bad.any():
        raise source.error(
            f"the radius must be finite, and not negative at both ends of a curve (see {list_rows(bad)}); fix the file"
        )
    curves = Curves.from_bezier(control, **more)
    return replace(curves, radius=coefficients[curves.rows] if len(curves.skipped) else coefficients)


def _attributes(
    source: Source, arrays: dict[str, AnyArray], n_rows: int, *, ends: bool
) -> tuple[dict[str, AnyArray], dict[str, AnyArray]]:
    """Separate the attributes per row from those at both ends, and check their shapes."""
    per_row: dict[str, AnyArray] = {}
    per_end: dict[str, AnyArray] = {}
    for name in [name for name in arrays if TEXTS + name in arrays]:
        try:
            arrays[name] = texts_of(arrays[name], arrays.pop(TEXTS + name))
        except (TypeError, ValueError):
            raise source.error(f"the texts of {name!r} do not fit its numbers; the file is damaged") from None
    for name, values in arrays.items():
        if ends and name.startswith(ENDS):
            _check(source, name, values, (n_rows, 2, *values.shape[2:]))
            per_end[name.removeprefix(ENDS)] = values
            continue
        _check(source, name, values, (n_rows, *values.shape[1:]))
        if (column := name.removeprefix(ATTRIBUTES)) in per_row:
            raise source.error(f"the attribute {column!r} is in it twice; write one of them by another name")
        per_row[column] = values
    return per_row, per_end


def _facts(source: Source, given: Mapping[str, str], *, is_curves: bool) -> dict[str, Any]:
    """Return the facts, checked."""
    facts: dict[str, Any] = {name: given[name] for name in FACTS if name in given}
    if "up" in facts and facts["up"] not in AXES:
        raise source.error(f"'up' is {facts['up']!r}; expected 'x', 'y' or 'z'")
    if "unit" in facts and not (facts["unit"] and facts["unit"].isprintable()):
        raise source.error(f"'unit' is {facts['unit']!r}; expected the name of a unit, such as 'mm'")
    if "tolerance" in facts:
        try:
            facts["tolerance"] = float(facts["tolerance"])
        except ValueError:
            facts["tolerance"] = np.nan
        if not is_curves or not 0 < facts["tolerance"] < np.inf:
            raise source.error(f"'tolerance' is {given['tolerance']!r}; expected a length above 0, and of curves only")
    if "metadata" in facts:
        try:
            facts["metadata"] = from_json(facts["metadata"])
        except InputError as error:
            source.warn(f"its 'metadata' are left out: {error}")
            del facts["metadata"]
    return facts


def _check(source: Source, name: str, array: AnyArray, shape: tuple[int, ...], *, integer: bool = False) -> None:
    """Refuse an array of another shape, or one that must hold integers and is not convertible to int64."""
    if array.ndim == 0 or array.shape != shape:
        raise source.error(f"{name!r} has shape {array.shape}; expected {shape}, to go with the other arrays")
    if integer and not np.can_cast(array.dtype, np.int64):
        raise source.error(f"{name!r} is of type {array.dtype}; expected integers, int64 or smaller")
