"""USD scenes (``.usd``, ``.usda``, ``.usdc``, ``.usdz``): BasisCurves and HermiteCurves.

Schemas: https://openusd.org/release/api/class_usd_geom_basis_curves.html and class_usd_geom_hermite_curves.html there.
The library usd-core opens the files, and with them whatever they refer to.

- Linear curves become `Lines`, closed if they are periodic. Cubic ones become `Curves`. A file with both is a
  `Geometry` of lines and curves.
- Points and widths are taken to the world: transforms, instances and PointInstancers are resolved. Widths are
  diameters, in the space of the prim. Where a transform scales by different factors along its axes, the radius is
  scaled by their geometric mean, with a warning.
- Numeric primvars become attributes by their names. Vertex and varying ones have values at both ends of segments;
  uniform and constant ones are repeated. They are not transformed.
- A strand is a curve of the file, also a copy. With several prims, the attribute ``prim`` counts them and their copies,
  unless the prims have a primvar of this name: files that are written from several prims have one.
- Invisible prims, inactive ones, NurbsCurves, other shapes, normals and velocities are not read. Prims for guides and
  proxies are read, with a warning.
- The unit is metersPerUnit, if the file has it; USD's default of centimetres is not assumed.

The library does not check all of a binary file before it uses it: a damaged ``.usdc`` may end the program.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...geometry.collection import Geometry
from ...geometry.lines import Lines
from ...geometry.offsets import AUTO, middle_of
from ...support.optional import optional
from ...support.texts import kinds_text
from ..format import AnyLines
from ..source import UNPACK_BYTES, UNPACK_FACTOR, Source
from ..units import unit_of
from .usd_curves import Strokes, placed, strokes_of
from .usd_join import joined
from .usd_values import Remarks
from .usd_walk import Walk
from .usd_write import write

__all__ = ["read", "write"]

_EXTENSIONS = (".usd", ".usda", ".usdc", ".usdz")
#: How many of the library's own warnings are passed on.
_N_WARNINGS = 5


def read(source: Source, invalid: str, *, time: float | None = None, prim: str | None = None) -> AnyLines:
    """Read the curves of a USD file.

    Parameters
    ----------
    time : number, optional
        The time code at which everything is read. Without it, each value is the earliest one: its first sample, the
        first knot of its spline, or its default if it has neither; nothing moves by its velocity.
    prim : str, optional
        The path of a prim, such as ``"/World/Hair"``: only what is below it is read, at its place in the world.
    """
    if time is not None and (isinstance(time, bool) or not isinstance(time, int | float) or not math.isfinite(time)):
        raise InputError(f"time={time!r}; expected a time code of the file, a number, or None for the earliest")
    if prim is not None and not isinstance(prim, str):
        raise InputError(f"prim={prim!r}; expected the path of a prim, such as '/World/Hair'")
    optional("pxr", "reading USD files", "usd")
    from pxr import Tf

    with _told(source), source.file(_extension(source)) as path:
        try:
            return _read(source, path, invalid, time, prim)
        except (Tf.ErrorException, RuntimeError, UnicodeDecodeError, MemoryError) as error:
            why = _reason(error).replace(str(path.absolute()), "")
            raise source.error(f"USD cannot read it ({why}); fix it, or get a fresh copy") from None


def _read(source: Source, path: Path, invalid: str, time: float | None, prim: str | None) -> AnyLines:
    from pxr import Sdf, Tf, Usd

    if path != source.path:
        _find_assets(path, Path(source.name).absolute().parent)
    stage = Usd.Stage.Open(str(path.absolute()))
    for layer in stage.GetUsedLayers():
        # USD shares layers that this program has open elsewhere, even if their file has changed since.
        if layer.dirty:
            source.warn(f"this program has changed {layer.identifier} without saving it; it is read as changed")
        elif not layer.anonymous:
            layer.Reload()
    root = stage.GetPseudoRoot()
    if prim is not None:
        root = stage.GetPrimAtPath(prim) if Sdf.Path.IsValidPathString(prim) and prim.startswith("/") else None
        if not root:
            top = ", ".join(str(child.GetPath()) for child in stage.GetPseudoRoot().GetChildren()[:5]) or "nothing"
            raise InputError(f"there is no prim {prim!r}; at the top of the file there is {top}")
    layers = [Path(layer.realPath) for layer in stage.GetUsedLayers() if layer.realPath]
    n_bytes = sum(layer.stat().st_size for layer in layers if layer.is_file())
    limit = UNPACK_FACTOR * max(n_bytes, source.size) + UNPACK_BYTES

    # Read each prim once, and copy it to its places.
    remarks = Remarks(source)
    when = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(float(time))
    walk = Walk(source, when, remarks, limit)
    parts: dict[int, list[Strokes]] = {2: [], 4: []}
    n_strands = n_prims = 0
    for curves, places in walk.curves(root):
        try:
            strokes = strokes_of(curves, when, remarks)
        except (Tf.ErrorException, TypeError, AttributeError, UnicodeDecodeError) as error:  # values of a wrong type
            remarks.add(f"left out, as USD cannot read it: {_reason(error)}", curves.GetPath())
            continue
        if strokes is None:
            continue
        source.advance(strokes.control.nbytes)  # about twice what the file has of them: read, and parsed
        values = [*strokes.attributes.values(), *strokes.end_attributes.values()]
        walk.spend((strokes.control.nbytes + sum(array.nbytes for array in values)) * len(places))
        made = placed(strokes, places, curves.GetPath(), remarks)
        if n_prims:
            made = replace(made, strands=made.strands + n_strands, prim=made.prim + n_prims)
        parts[made.control.shape[1]].append(made)
        n_strands += made.n_strands
        n_prims += made.n_prims
    _tell_of_others(walk, remarks)

    if source.offset == AUTO:  # the same one for lines and curves
        every = [strokes.control.reshape(-1, 3) for some in parts.values() for strokes in some]
        source.offset = middle_of(np.concatenate([np.empty((0, 3)), *every]))
    facts = _facts(source, stage)
    found = [joined(some, remarks, invalid, number_prims=n_prims > 1) for some in parts.values() if some]
    remarks.warn()
    made_parts = [replace(part, **facts) for part in found] or [replace(_no_lines(), **facts)]
    return Geometry(made_parts) if len(made_parts) > 1 else made_parts[0]


def _find_assets(copy: Path, folder: Path) -> None:
    """Let a copy of a file, such as one that was packed, refer to what is beside the file itself."""
    from pxr import Sdf, UsdUtils

    if copy.suffix.lower() == ".usdz":  # which holds what it refers to
        return
    layer = Sdf.Layer.FindOrOpen(str(copy.absolute()))
    UsdUtils.ModifyAssetPaths(layer, lambda asset: str(folder / asset) if (folder / asset).is_file() else asset)
    if layer.dirty:
        layer.Save()


def _no_lines() -> Lines:
    return Lines(np.empty((0, 2, 3), np.float32))


def _tell_of_others(walk: Walk, remarks: Remarks) -> None:
    if walk.other:
        remarks.source.warn(f"prims that are not BasisCurves or HermiteCurves are not read: {kinds_text(walk.other)}")


def _facts(source: Source, stage: Any) -> dict[str, Any]:
    """Return the axis that points upwards and the unit, where the file says so."""
    # Ask the layer: the stage refuses values of another type than its schema's, which older writers used.
    facts: dict[str, Any] = {}
    layer = stage.GetRootLayer().pseudoRoot
    if layer.HasInfo("upAxis"):
        up = str(layer.GetInfo("upAxis")).lower()
        if up in ("y", "z"):
            facts["up"] = up
        else:
            source.warn(f"its upAxis {up!r} is neither Y nor Z, and is not used")
    if layer.HasInfo("metersPerUnit"):
        meters = layer.GetInfo("metersPerUnit")
        if isinstance(meters, int | float) and 0 < meters < math.inf:
            facts["unit"] = unit_of(float(meters))
        else:
            source.warn(f"its metersPerUnit, {meters!r}, is not a length, and is not used")
    return facts


def _extension(source: Source) -> str:
    """Return the extension by which USD opens the file."""
    extension = source.path.suffix.lower() if source.path else ""
    if extension in _EXTENSIONS:
        return extension
    starts = {b"#usda": ".usda", b"PXR-USDC": ".usdc", b"PK": ".usdz"}
    return next((found for start, found in starts.items() if source.data.startswith(start)), ".usd")


@contextmanager
def _told(source: Source) -> Iterator[None]:
    """Turn what USD would print into warnings about the file."""
    from pxr import UsdUtils

    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        told = dict.fromkeys(_text(found, "commentary") for found in delegate.TakeUncoalescedDiagnostics())
        del delegate
    for text in list(told)[:_N_WARNINGS]:
        source.warn(f"USD says: {_short(text)}")
    if len(told) > _N_WARNINGS:
        source.warn(f"USD says {len(told) - _N_WARNINGS} other things")


def _reason(error: Exception) -> str:
    """Return what USD says in an error, without its functions and lines."""
    text = _text(error)
    said = re.findall(r": '(.*?)'\s*(?:Error in|$)", text)
    return _short(said[0] if said else text) or type(error).__name__


def _text(said: object, attribute: str = "") -> str:
    """Return a text of USD in one line; it may hold bytes of the file that are not text."""
    try:
        return " ".join(str(getattr(said, attribute) if attribute else said).split())
    except UnicodeDecodeError:
        return "it holds bytes that are not UTF-8"


def _short(words: str) -> str:
    return words if len(words) <= 200 else f"{words[:200]} …"
