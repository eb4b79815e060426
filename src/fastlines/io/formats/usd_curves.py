"""Reads the curves of one USD prim: points, widths and primvars, as arrays with a row per segment."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...arrays import AnyArray, IntArray, list_rows
from ...geometry.curve_input import bad_radius, outside
from .usd_time import time_of
from .usd_values import Float64Array, Layout, Remarks, cubic_layout, linear_layout, numbers

_BASES = {"bezier": "bezier", "bspline": "bspline", "catmullRom": "catmull-rom"}
_WRAPS = ("nonperiodic", "periodic", "pinned")
#: Attributes of USD curves that `Lines` and `Curves` cannot hold.
_NOT_READ = ("normals", "velocities", "accelerations")
#: If the scales of a transform differ by more than this factor, its curves are no longer round.
_UNIFORM = 1.001


@dataclass(frozen=True)
class Strokes:
    """The segments of a prim, linear or cubic.

    Attributes
    ----------
    control : (n, 2, 3) or (n, 4, 3) array
        Both ends of each linear segment, or Bezier control points.
    radius : (n, 2) or (n, 4) array, or None
    strands : (n,) int64
    n_strands : int
    prim : (n,) int64
        The prim, or the copy of a prim, of each segment.
    n_prims : int
    attributes, end_attributes : dict of str to array
        As in `Lines` and `Curves`.
    """

    control: AnyArray
    radius: AnyArray | None
    strands: IntArray
    n_strands: int
    prim: IntArray
    n_prims: int = 1
    attributes: dict[str, AnyArray] = field(default_factory=dict)
    end_attributes: dict[str, AnyArray] = field(default_factory=dict)

    def without_rows(self) -> Strokes:
        """Return what has the same types and shapes, but no rows."""
        return replace(
            self,
            control=self.control[:0].copy(),
            radius=None if self.radius is None else self.radius[:0].copy(),
            strands=self.strands[:0].copy(),
            prim=self.prim[:0].copy(),
            attributes={name: values[:0].copy() for name, values in self.attributes.items()},
            end_attributes={name: values[:0].copy() for name, values in self.end_attributes.items()},
        )


def strokes_of(prim: Any, time: Any, remarks: Remarks) -> Strokes | None:
    """Return the segments of a prim in its own space; None if it has none that can be read."""
    from pxr import UsdGeom

    path = prim.GetPath()
    is_hermite = prim.IsA(UsdGeom.HermiteCurves)
    curves = (UsdGeom.HermiteCurves if is_hermite else UsdGeom.BasisCurves)(prim)
    points = numbers(curves.GetPointsAttr().Get(time))
    counts = numbers(curves.GetCurveVertexCountsAttr().Get(time))
    if points is None or counts is None or points.ndim != 2 or points.shape[1] != 3 or counts.dtype.kind != "i":
        if points is not None or counts is not None:
            remarks.add("left out, as it has either no points or no curveVertexCounts", path)
        return None
    tangents = numbers(curves.GetTangentsAttr().Get(time)) if is_hermite else None
    if is_hermite and (tangents is None or tangents.shape != points.shape):
        remarks.add("left out, as it does not have one tangent for each point", path)
        return None
    layout = _layout(curves, time, counts.astype(np.int64), len(points), is_hermite, path, remarks)
    if layout is None:
        return None

    attributes, end_attributes = _primvars(prim, time, layout, remarks)
    for name in _NOT_READ:
        if prim.GetAttribute(name).HasAuthoredValue():
            remarks.add(f"{name} are not read", path)
    return Strokes(
        layout.control(points, tangents),
        _radius(prim, curves, time, layout, remarks),
        layout.strands,
        len(counts),
        np.zeros(len(layout.strands), np.int64),
        attributes=attributes,
        end_attributes=end_attributes,
    )


def placed(strokes: Strokes, matrices: Float64Array, path: object, remarks: Remarks) -> Strokes:
    """Return copies of segments, transformed by matrices (k, 4, 4) that row vectors are multiplied with: p · matrix."""
    n_copies, n = len(matrices), len(strokes.strands)
    if n_copies == 1 and np.array_equal(matrices[0], np.eye(4)):
        return strokes
    if (matrices[:, :3, 3] != 0).any() or (matrices[:, 3, 3] != 1).any():
        remarks.add("its transform has a perspective, which is not used", path)
    linear = matrices[:, :3, :3]
    with np.errstate(invalid="ignore", over="ignore"):  # NaN and Inf are reported with their rows
        flat = strokes.control.reshape(-1, 3).astype(np.float64) @ linear + matrices[:, 3:, :3]
    radius = strokes.radius
    if radius is not None:
        scale = np.cbrt(np.abs(np.linalg.det(linear)))
        finite = np.asarray(np.isfinite(linear).all(axis=(1, 2)), np.bool_)
        singular = np.linalg.svd(linear[finite], compute_uv=False)
        if (singular[:, 0] > _UNIFORM * singular[:, 2]).any():
            remarks.add(
                "is scaled by different factors along its axes; its radius is scaled by their geometric mean", path
            )
        radius = (scale[:, None, None] * radius).reshape(-1, radius.shape[1])
    copy = np.repeat(np.arange(n_copies), n)
    return replace(
        strokes,
        control=flat.reshape(-1, *strokes.control.shape[1:]),
        radius=radius,
        strands=np.tile(strokes.strands, n_copies) + copy * strokes.n_strands,
        n_strands=strokes.n_strands * n_copies,
        prim=copy,
        n_prims=n_copies,
        attributes={name: np.concatenate([values] * n_copies) for name, values in strokes.attributes.items()},
        end_attributes={name: np.concatenate([values] * n_copies) for name, values in strokes.end_attributes.items()},
    )


def _layout(
    curves: Any, time: Any, counts: IntArray, n_points: int, is_hermite: bool, path: object, remarks: Remarks
) -> Layout | None:
    """Return which points make which segments; curves with a wrong number of points are left out."""
    # Leave out all curves from the first one that needs more points than there are.
    n_curves = len(counts)
    with np.errstate(over="ignore"):
        beyond = (counts < 0) | (counts > n_points) | (np.cumsum(counts) > n_points)
    if beyond.any():
        counts = counts[: int(beyond.argmax())]
        remarks.add("some curves are left out: curveVertexCounts announce more points than there are", path)
    elif counts.sum() < n_points:
        remarks.add("some points are left out: curveVertexCounts announce fewer than there are", path)

    if is_hermite:
        basis, wrap, kind = "hermite", "nonperiodic", "cubic"
    else:
        tokens = (curves.GetBasisAttr().Get(time), curves.GetWrapAttr().Get(time), curves.GetTypeAttr().Get(time))
        basis, wrap, kind = (str(token) for token in tokens)
    if wrap not in _WRAPS or kind not in ("linear", "cubic") or (kind == "cubic" and basis not in (*_BASES, "hermite")):
        remarks.add(f"left out, as USD has no curves of type {kind!r}, basis {basis!r} and wrap {wrap!r}", path)
        return None
    if kind == "linear":
        return linear_layout(counts, n_curves, n_points, closed=wrap == "periodic")
    if basis == "hermite" and not is_hermite:
        remarks.add("left out, as BasisCurves no longer have the basis 'hermite'; make them HermiteCurves", path)
        return None
    layout = cubic_layout(counts, n_curves, n_points, _BASES.get(basis, basis), wrap)
    if layout.n_left_out:
        remarks.add(f"some curves are left out: their numbers of points fit no {wrap} {basis} curve", path)
    return layout


def _radius(prim: Any, curves: Any, time: Any, layout: Layout, remarks: Remarks) -> AnyArray | None:
    """Return half the widths along each segment; None if there are none."""
    from pxr import UsdGeom

    path = prim.GetPath()
    widths, stated = curves.GetWidthsAttr().Get(time), curves.GetWidthsInterpolation()
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("widths")
    if primvar and primvar.HasAuthoredValue():  # it overrides the attribute, by the schema
        widths, stated = _flat(primvar, time), primvar.GetInterpolation()
    values = numbers(widths)
    if values is None or values.size == 0:
        return None
    interpolation = layout.interpolation_of(len(values), stated) if values.ndim == 1 else None
    if interpolation is None:
        remarks.add(f"its widths are not read: their number does not fit the interpolation {stated!r}", path)
        return None
    if interpolation != stated:
        remarks.add(f"its widths are {interpolation} by their number, though called {stated}", path)
    radius = layout.coefficients(values / np.float32(2), interpolation)
    bad = bad_radius(radius) if radius.shape[1] == 4 else outside(radius)
    if bad.any():
        what = f"the widths of {path} must be finite and not negative (see {list_rows(bad)} of its segments)"
        raise remarks.source.error(f"{what}; fix the file")
    return radius


def _primvars(
    prim: Any, time: Any, layout: Layout, remarks: Remarks
) -> tuple[dict[str, AnyArray], dict[str, AnyArray]]:
    """Return the numeric primvars per segment, and those at both ends of each segment."""
    from pxr import UsdGeom

    attributes: dict[str, AnyArray] = {}
    end_attributes: dict[str, AnyArray] = {}
    for primvar in UsdGeom.PrimvarsAPI(prim).FindPrimvarsWithInheritance():
        name, stated = str(primvar.GetPrimvarName()), str(primvar.GetInterpolation())
        if name == "widths":
            continue
        values = numbers(_flat(primvar, time))
        if values is None:
            if primvar.HasValue():
                remarks.add(
                    f"primvar {name!r} is not read: it is not made of numbers, or its indices are wrong", prim.GetPath()
                )
            continue
        if not primvar.GetTypeName().isArray:
            values = values[None]
        interpolation = layout.interpolation_of(len(values), "varying" if stated == "faceVarying" else stated)
        if interpolation is None:
            remarks.add(f"primvar {name!r} is not read: its number of values does not fit {stated!r}", prim.GetPath())
        elif interpolation in ("constant", "uniform"):
            attributes[name] = layout.per_segment(values, interpolation)
        else:
            end_attributes[name] = layout.at_ends(values, interpolation)
    return attributes, end_attributes


def _flat(primvar: Any, time: Any) -> Any:
    """Return the values of a primvar with its indices resolved; None if an index has no value."""
    values = primvar.Get(time_of(primvar.GetAttr(), time))
    array = numbers(values)
    if array is None or not primvar.GetTypeName().isArray:
        return array
    size = primvar.GetElementSize()
    if size > 1:
        if len(array) % size:
            return None
        array = array.reshape(-1, size, *array.shape[1:])
    if not primvar.IsIndexed():
        return array
    indices = numbers(primvar.GetIndices(time))
    if indices is None or indices.ndim != 1 or (indices < 0).any() or (indices >= len(array)).any():
        return None
    return array[indices]
