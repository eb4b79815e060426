"""Checks of what curves are made of, and its conversion to Bezier coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import (
    COORDINATE_LIMIT,
    INVALID,
    FloatArray,
    IntArray,
    check_strands,
    choice,
    column,
    kind_of,
    list_rows,
    own_float32,
    refuse_rows,
    to_float32,
    to_integers,
    to_strands,
    unusable,
    warn_of_rounding,
)
from ..errors import InputError
from ..support.immutable import own
from .bezier import Float64Array
from .offsets import reduced
from .spline_bases import find_spans

BoolArray = npt.NDArray[np.bool_]


class Converted(NamedTuple):
    """Curves that may still hold invalid rows.

    Attributes
    ----------
    control : (n, 4, 3) array of numbers
        Bezier control points, in the precision in which they were given or computed.
    radius : None or (n, 4) float64
        Bezier coefficients.
    bad : (n,) bool
        Which curves are known to be invalid.
    strands : (n,) int64
    attributes, end_attributes : mapping of str to array
        Per curve, and at both ends of each curve.
    """

    control: npt.ArrayLike
    radius: Float64Array | None
    bad: BoolArray
    strands: IntArray
    attributes: Mapping[str, npt.NDArray[Any]]
    end_attributes: Mapping[str, npt.NDArray[Any]]


def check_columns(control: FloatArray, radius: FloatArray | None, strands: IntArray, skipped: IntArray) -> None:
    """Refuse columns that do not fit the control points."""
    n = len(control)
    columns: list[tuple[str, Any, type[Any], tuple[int, ...]]] = [
        ("strands", strands, np.int64, (n,)),
        ("skipped", skipped, np.int64, np.shape(skipped)[:1]),
        *([] if radius is None else [("radius", radius, np.float32, (n, 4))]),
    ]
    for name, values, dtype, shape in columns:
        if not isinstance(values, np.ndarray) or values.dtype != dtype or values.shape != shape:
            raise InputError(
                f"{name}: {kind_of(values)}; Curves of {n} take {np.dtype(dtype)} of shape {shape}, and "
                "Curves.from_bezier converts other arrays"
            )
    check_strands(strands)
    if radius is not None and (bad := bad_radius(radius)).any():
        raise InputError(
            f"radius: {int(bad.sum())} of {n} curves ({list_rows(bad)}) have coefficients that are not numbers up to "
            f"{COORDINATE_LIMIT:g}, or that are below 0 at an end"
        )
    if len(skipped) and (skipped[0] < 0 or skipped[-1] >= n + len(skipped) or (np.diff(skipped) <= 0).any()):
        raise InputError(f"skipped are not rising rows of the {n + len(skipped)} that were given")


def check_attributes(attributes: object, end_attributes: object, n: int) -> None:
    """Refuse attributes that do not have a row for each of n curves."""
    for kind, values_of, shape in (("attributes", attributes, (n,)), ("end_attributes", end_attributes, (n, 2))):
        for name, values in mapping(kind, values_of).items():
            if not isinstance(values, np.ndarray) or values.shape[: len(shape)] != shape:
                raise InputError(
                    f"{name}: {kind_of(values)}; expected an array of shape ({', '.join(map(str, shape))}, …), a value "
                    f"for each {'curve' if len(shape) == 1 else 'end of each curve'}"
                )


def convert_bezier(
    control: npt.ArrayLike,
    radius: npt.ArrayLike | None,
    strands: npt.ArrayLike | None,
    attributes: Mapping[str, npt.ArrayLike] | None,
    end_attributes: Mapping[str, npt.ArrayLike] | None,
    invalid: str,
) -> Converted:
    """Check the arguments of `Curves.from_bezier`, and make one row of each for each curve."""
    choice("invalid", invalid, INVALID)
    given = to_float32(control, "control")
    if given.shape == (0,):
        control = given = given.reshape(0, 4, 3)
    if given.ndim != 3 or given.shape[1:] != (4, 3):
        raise InputError(
            f"control has shape {given.shape}; expected (n, 4, 3): n curves, 4 control points, x y z; "
            "Curves.from_strands takes points of splines"
        )
    n = len(given)
    radii = None if radius is None else radius_coefficients(radius, n)
    bad = np.zeros(n, np.bool_) if radii is None else outside(radii)
    if invalid == "error":
        refuse_radius(bad, "curves")
    per_curve, per_end = (
        {name: column(values, name, n, "curves") for name, values in mapping(kind, given_values).items()}
        for kind, given_values in (("attributes", attributes), ("end_attributes", end_attributes))
    )
    if both := per_curve.keys() & per_end.keys():
        raise InputError(f"{min(both)!r} is in attributes and in end_attributes; give it once")
    numbers = np.full(n, -1) if strands is None else to_strands(strands)
    if numbers.shape != (n,):
        raise InputError(f"strands have shape {numbers.shape}; expected ({n},), one for each curve")
    return Converted(control, radii, bad, numbers, per_curve, per_end)


def convert_strands(
    points: npt.ArrayLike,
    counts: npt.ArrayLike,
    basis: str,
    wrap: str,
    radius: npt.ArrayLike | None,
    tangents: npt.ArrayLike | None,
    attributes: Mapping[str, npt.ArrayLike] | None,
    invalid: str,
) -> Converted:
    """Check the arguments of `Curves.from_strands`, and convert them to Bezier curves.

    Returns
    -------
    Converted
        Without attributes per curve. Curves that depend on an invalid point are bad; with ``invalid="error"``, the
        point is an error.
    """
    choice("invalid", invalid, INVALID)
    places = _vectors(points, "points")
    n = len(places)
    per_strand = to_integers(counts, "counts")
    if per_strand.ndim != 1 or (per_strand < 0).any() or (per_strand > n).any() or per_strand.sum() != n:
        raise InputError(
            f"the counts of the strands do not add up to the {n} points that were given; expected one count, 0 or "
            "more, for each strand"
        )
    spans = find_spans(per_strand, basis, wrap)
    if (tangents is None) == (basis == "hermite"):
        what = "needs tangents, one for each point" if tangents is None else "takes no tangents; they are for 'hermite'"
        raise InputError(f"basis={basis!r} {what}")
    along = None if tangents is None else column(_vectors(tangents, "tangents"), "tangents", n, "points")
    radii = None if radius is None else np.asarray(to_float32(radius, "radius"), np.float64)
    if radii is not None:
        radii = column(np.full(n, radii) if radii.ndim == 0 else radii, "radius", n, "points")
        if radii.ndim != 1:
            raise InputError(f"radius has shape {radii.shape}; expected ({n},), one for each point, or one number")

    # Refuse what is invalid while its rows are those of the input.
    bad = np.zeros(n, np.bool_) if radii is None else outside(radii[:, None])
    if invalid == "error":
        refuse_radius(bad, "points")
    for name, vectors in (("points", places), ("tangents", along)):
        if vectors is not None:
            wrong = unusable(to_float32(vectors, name)[:, None])
            if invalid == "error":
                refuse_rows(wrong, name, "; fix them, or leave out their curves with invalid='skip'")
            bad |= wrong
    per_point = {name: column(values, name, n, "points") for name, values in mapping("attributes", attributes).items()}
    with np.errstate(invalid="ignore", over="ignore"):
        return Converted(
            spans.bezier(places, along),
            None if radii is None else spans.bezier(radii),
            np.asarray(bad[spans.points].any(axis=1)),
            spans.strands,
            {},
            {name: spans.at_ends(values) for name, values in per_point.items()},
        )


def valid(made: Converted, invalid: str, offset: Any = None) -> dict[str, Any]:
    """Round to float32, less the offset, and leave out or refuse what is invalid; return the fields of `Curves`."""
    given, facts = reduced(made.control, offset)
    control = own_float32(given, "control")
    warn_of_rounding(given, control)
    radius = None if made.radius is None else own_float32(made.radius, "radius")
    bad = made.bad | unusable(control)
    if radius is not None:
        bad |= bad_radius(radius)
    if invalid == "error":
        refuse_rows(bad, "curves", "; fix them, or leave them out with invalid='skip'")
    columns = made._asdict() | {"control": control, "radius": radius}
    del columns["bad"]
    kept = {name: _without(bad, values) for name, values in columns.items()}
    return kept | {"skipped": np.flatnonzero(bad), "metadata": facts}


def _without(bad: BoolArray, values: Any) -> Any:
    """Return an array, or a mapping of arrays, without some rows."""
    if values is None or not bad.any():
        return values
    if isinstance(values, Mapping):
        return {name: _without(bad, array) for name, array in values.items()}
    return own(values[~bad])


def radius_coefficients(radius: npt.ArrayLike, n: int) -> Float64Array:
    """Return the Bezier coefficients, (n, 4), of one radius for all, one a curve, one an end, or four a curve."""
    given = np.asarray(to_float32(radius, "radius"), np.float64)
    shape: tuple[int, ...] = given.shape
    if shape not in ((), (n,), (n, 2), (n, 4)):
        raise InputError(
            f"radius has shape {shape}; expected one number, or ({n},), ({n}, 2) or ({n}, 4): one for each "
            "curve, for each end, or Bezier coefficients"
        )
    if len(shape) == 2 and shape[1] == 2:
        r0, r3 = given[..., 0], given[..., 1]
        return np.stack([r0, (2 * r0 + r3) / 3, (r0 + 2 * r3) / 3, r3], axis=1)
    return np.array(np.broadcast_to(given[:, None] if len(shape) == 1 else given, (n, 4)))


def outside(radius: npt.NDArray[Any]) -> BoolArray:
    """Return in which rows (n, k) of radii there is one that cannot be used."""
    rounded = to_float32(radius, "radius")
    return ~np.asarray(((rounded >= 0) & (rounded <= COORDINATE_LIMIT)).all(axis=1), np.bool_)


def bad_radius(coefficients: npt.NDArray[Any]) -> BoolArray:
    """Return in which rows (n, 4) Bezier coefficients of a radius cannot be used; the inner two may be negative."""
    return outside(np.concatenate([coefficients[:, [0, 3]], np.abs(coefficients[:, 1:3])], axis=1))


def refuse_radius(bad: BoolArray, of: str) -> None:
    """Refuse curves or points whose radius cannot be used."""
    if bad.any():
        raise InputError(
            f"radius: {int(bad.sum())} of {len(bad)} {of} have one that is not from 0 to {COORDINATE_LIMIT:g} "
            f"({list_rows(bad)}); fix them, or leave their curves out with invalid='skip'"
        )


def mapping(name: str, values: object) -> Mapping[str, Any]:
    """Check a mapping of names to arrays; None is an empty one."""
    if not isinstance(values, Mapping | None):
        raise InputError(f"{name} are {kind_of(values)}; expected a mapping of names to arrays")
    return values or {}


def _vectors(values: npt.ArrayLike, name: str) -> Float64Array:
    array = to_float32(values, name)
    if array.shape == (0,):
        return np.empty((0, 3))
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{name}: the shape is {array.shape}; expected (m, 3): x y z of each point")
    return np.asarray(values, np.float64)
