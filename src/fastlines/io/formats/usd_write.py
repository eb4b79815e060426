"""Writes lines and curves as USD BasisCurves."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import AnyArray, IntArray
from ...errors import InputError
from ...geometry.collection import Geometry
from ...geometry.curves import Curves
from ...geometry.lines import Lines
from ...geometry.offsets import NO_OFFSET
from ...support.optional import optional
from ...support.units import meters_of
from ..losses import is_encodable, strand_numbers
from ..polylines import Polylines, attributes_of_runs, equal, polylines_of

#: USD's types of arrays by NumPy's, and whether there are vectors of them.
_TYPES: dict[str, tuple[str, bool]] = {
    "f2": ("Half", True),
    "f4": ("Float", True),
    "f8": ("Double", True),
    "i4": ("Int", True),
    "i8": ("Int64", False),
    "u1": ("UChar", False),
    "u4": ("UInt", False),
    "u8": ("UInt64", False),
    "b1": ("Bool", False),
}
#: What is converted to a wider type, as USD has none of its own.
_WIDER = {"i1": "i4", "i2": "i4", "u2": "i4"}


def write(geometry: Lines | Curves | Geometry, path: Path) -> list[str]:
    """Write a prim of BasisCurves for lines and one for curves; return what they cannot hold.

    Lines are linear curves, and curves cubic Bezier ones; segments that follow each other along a strand share a
    point. Widths are diameters. Attributes are primvars: vertex or varying, if they are at both ends of segments, or
    else uniform.
    """
    optional("pxr", "writing USD files", "usd")
    from pxr import Sdf, Tf, Usd, UsdGeom, UsdUtils

    parts = geometry.each_part()
    kept = [part for part in parts if isinstance(part, Lines | Curves) and part.is_plain]
    lost = [f"part {i}, {type(part).__name__}" for i, part in enumerate(parts) if not part.is_plain]
    if not kept:
        raise InputError("USD curves hold lines and curves, and there are none; write something else")
    plain = path.with_suffix(".usdc") if path.suffix == ".usdz" else path
    try:
        layer = Sdf.Layer.CreateNew(str(plain.absolute()))
        stage = Usd.Stage.Open(layer)
        lost += _facts(stage, kept)
        root = "" if len(kept) == 1 else "/geometry"
        if root:
            UsdGeom.Xform.Define(stage, root)
        n_strands = 0
        for i, part in enumerate(kept):
            name = "curves" if isinstance(part, Curves) else "lines"
            strips = splines_of(part) if isinstance(part, Curves) else polylines_of(part)
            lost += _curves(stage, f"{root}/{name}{i if root else ''}", part, strips, n_strands)
            n_strands += len(strips.counts)
        stage.SetDefaultPrim(stage.GetPrimAtPath(root or f"/{name}"))
        layer.Save()
        del stage, layer
        if plain != path and not (
            UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(plain)), str(path)) and _is_whole(path)
        ):
            raise OSError("USD could not write the package; is there enough space on the disk?")
    except Tf.ErrorException as error:
        raise OSError(f"USD could not write it: {' '.join(str(error).split())}") from None
    return lost


def _is_whole(package: Path) -> bool:
    """Return whether a package agrees with its checksums: USD does not report all errors of writing one."""
    try:
        with zipfile.ZipFile(package) as archive:
            return archive.testzip() is None
    except (OSError, EOFError, zipfile.BadZipFile):
        return False


def _facts(stage: Any, parts: list[Any]) -> list[str]:
    """Write the axis that points upwards and the unit, of the first part that has them."""
    from pxr import UsdGeom

    lost = []
    ups, units = ([getattr(part, name) for part in parts] for name in ("up", "unit"))
    up, unit = (next(filter(None, values), None) for values in (ups, units))
    if up == "x":
        lost.append("the axis that points upwards, which is neither y nor z")
    elif up:
        UsdGeom.SetStageUpAxis(stage, up.upper())
    meters = meters_of(unit) if unit else None
    if meters:
        UsdGeom.SetStageMetersPerUnit(stage, meters)
    elif unit:
        lost.append(f"the unit {unit!r}, which is not a known length")
    for what, values, held in (("axes", ups, up if up != "x" else "y"), ("units", units, unit if meters else None)):
        if len({*values}) > 1:
            of_parts = ", ".join(f"{value or 'none'} of part {i}" for i, value in enumerate(values))
            lost.append(f"that parts have different {what} ({of_parts}), and the file says {held or 'none'} for all")
    return lost


def _curves(stage: Any, path: str, part: Lines | Curves, strips: Polylines, first: int) -> list[str]:
    """Write one prim, whose first strand will be read as the number `first`."""
    from pxr import Gf, Sdf, UsdGeom, Vt

    is_cubic = isinstance(part, Curves)
    prim = UsdGeom.BasisCurves.Define(stage, path)
    prim.CreateTypeAttr("cubic" if is_cubic else "linear")
    if is_cubic:
        prim.CreateBasisAttr("bezier")
    prim.CreateWrapAttr("nonperiodic")
    # Points are float32 and the transform is float64.
    points = strips.points if is_cubic else strips.points - np.array(part.offset)
    prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(points, np.float32, order="C")))
    if part.offset != NO_OFFSET:
        prim.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*part.offset))
    prim.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(strips.counts.astype(np.int32)))
    if strips.radius is not None:
        prim.CreateWidthsAttr(Vt.FloatArray.FromNumpy(np.ascontiguousarray(2 * strips.radius)))
        prim.SetWidthsInterpolation("vertex")
    if len(part):
        extent = part.bounds + np.array([[-1], [1]]) * part.max_radius
        prim.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(extent.astype(np.float32)))

    lost = strips.lost + strand_numbers(strips.strand, first)
    if isinstance(part, Curves) and part.tolerance is not None:
        lost.append("the tolerance")
    api = UsdGeom.PrimvarsAPI(prim)
    names: set[str] = set()
    at_points = "varying" if is_cubic else "vertex"
    for interpolation, columns in ((at_points, strips.point_attributes), ("uniform", strips.attributes)):
        for given, values in columns.items():
            made = _value(values) if is_encodable(given) else None
            if made is None:
                lost.append(f"{given!r} ({values.dtype}, {values.ndim}-d)")
                continue
            name = _name(given, names)
            if name != given:
                lost.append(f"the name {given!r}, which is written as {name!r}")
            type_name, array, size = made
            primvar = api.CreatePrimvar(name, getattr(Sdf.ValueTypeNames, type_name), interpolation, size)
            primvar.Set(array)
    return lost


def _value(values: AnyArray) -> tuple[str, Any, int] | None:
    """Return the name of USD's type, the array, and how many numbers of it are one value; None if there is no type."""
    from pxr import Vt

    wider = _WIDER.get(values.dtype.str[1:], values.dtype.str[1:])
    if values.ndim > 2 or values.shape[1:] in ((0,), (1,)) or wider not in _TYPES:
        return None
    array = np.ascontiguousarray(values, np.dtype(wider))
    name, has_vectors = _TYPES[wider]
    width = 1 if array.ndim == 1 else array.shape[1]
    if has_vectors and width in (2, 3, 4):
        kind = getattr(Vt, f"Vec{width}{name[0].lower()}Array")
        return f"{name}{width}Array", kind.FromNumpy(array), 1
    return f"{name}Array", getattr(Vt, f"{name}Array").FromNumpy(array.reshape(-1)), width


def _name(given: str, taken: set[str]) -> str:
    """Return a name that USD takes, and that no other primvar of the prim has."""
    from pxr import Sdf, Tf

    name = given
    if name in ("widths", "indices") or name.endswith(":indices") or not Sdf.Path.IsValidNamespacedIdentifier(name):
        name = Tf.MakeValidIdentifier(name) + ("_" if name in ("widths", "indices") else "")
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def splines_of(curves: Curves) -> Polylines:
    """Join Bezier curves to splines where the next one of a strand begins as the last one ended.

    The splines have 4, 7, 10, … points. Values at the ends of curves are one more than a spline has curves.
    """
    n, begins = len(curves), curves.begins()
    first: IntArray = np.flatnonzero(begins)
    ends = np.append(begins[1:], True)[:n]
    is_point, is_end = np.ones((n, 4), np.bool_), np.ones((n, 2), np.bool_)
    is_point[:, 3] = is_end[:, 1] = ends
    lost: list[str] = []
    at_points = {}
    for name, values in curves.end_attributes.items():
        if not equal(values[1:, 0][~begins[1:]], values[:-1, 1][~begins[1:]]):
            lost.append(f"{name!r} on both sides of a point, where curves of a strand differ")
        at_points[name] = values[is_end]
    attributes = attributes_of_runs(curves, begins, lost)
    radius = None if curves.radius is None else curves.radius[is_point]
    counts = 3 * np.diff(np.append(first, n)) + 1
    return Polylines(curves.control[is_point], counts, curves.strands[first], radius, at_points, attributes, lost)
