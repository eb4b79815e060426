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
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...geometry.collection import Geometry
from ...geometry.lines import Lines
from ...support.optional import optional
from ...support.units import unit_of
from ..cut_lines import regroup
from ..format import AnyLines
from ..rounding import Rounding
from ..segment_collector import offset_for
from ..source import Source
from .usd_curves import Strokes
from .usd_join import Columns, joined
from .usd_scene import Scene, reason_of, short, text_of
from .usd_values import Remarks
from .usd_write import write

__all__ = ["read", "read_chunks", "write"]

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
    _check_options(time, prim)
    with _told(source), source.file(_extension(source)) as path, _readable(source, path):
        scene = Scene(source, path, time, prim)
        parts: dict[int, list[Strokes]] = {2: [], 4: []}
        for strokes in scene.strokes():
            parts[strokes.control.shape[1]].append(strokes)
        every = [strokes for some in parts.values() for strokes in some]
        # Lines and curves have the same offset.
        offset = offset_for(source.offset, (strokes.control.reshape(-1, 3) for strokes in every))
        number_prims, rounding = sum(strokes.n_prims for strokes in every) > 1, Rounding()
        facts, found = _facts(source, scene.stage), []
        for some in filter(None, parts.values()):
            columns = Columns(some, scene.remarks, number_prims=number_prims)
            found.append(joined(some, columns, invalid, rounding, offset))
        scene.remarks.warn()
        rounding.warn()
        made = [replace(part, **facts) for part in found] or [replace(_no_lines(), **facts)]
        return Geometry(made) if len(made) > 1 else made[0]


def read_chunks(
    source: Source, max_segments: int, invalid: str, *, time: float | None = None, prim: str | None = None
) -> Iterator[Lines] | None:
    """Read linear curves prim by prim; not those of a file that has cubic ones."""
    _check_options(time, prim)
    n_oddities, lines = len(source.oddities), _linear(source, invalid, time, prim)
    if next(lines):
        return regroup(lines, max_segments)
    del source.oddities[n_oddities:]
    return None


def _linear(source: Source, invalid: str, time: float | None, prim: str | None) -> Iterator[Any]:
    """Yield whether all curves are linear, and then the lines of each prim."""
    with source.file(_extension(source)) as path, _readable(source, path):
        # Look at all prims first: what one of them has, all have.
        with _told(source):
            scene = Scene(source, path, time, prim)
            like = []
            for strokes in scene.strokes(0.5):
                if strokes.control.shape[1] == 4:
                    yield False
                    return
                like.append(strokes.without_rows())
            facts = _facts(source, scene.stage)
            if like:
                columns = Columns(like, scene.remarks, number_prims=sum(strokes.n_prims for strokes in like) > 1)
            scene.remarks.warn()
        silent = Source(b"", source.name)
        scene.remarks = Remarks(silent)
        with _told(silent):
            offset = offset_for(source.offset, (strokes.control.reshape(-1, 3) for strokes in scene.strokes(0)))
        yield True
        if not like:
            yield replace(_no_lines(), **facts)
        rounding, again = Rounding(), scene.strokes(0.5)
        while True:
            with _told(silent):
                part = next(again, None)
            if part is None:
                break
            yield replace(joined([part], columns, invalid, rounding, offset), **facts)
            del part
        rounding.warn()


def _check_options(time: float | None, prim: str | None) -> None:
    """Check the options of a reader, and that the library is there."""
    if time is not None and (isinstance(time, bool) or not isinstance(time, int | float) or not math.isfinite(time)):
        raise InputError(f"time={time!r}; expected a time code of the file, a number, or None for the earliest")
    if prim is not None and not isinstance(prim, str):
        raise InputError(f"prim={prim!r}; expected the path of a prim, such as '/World/Hair'")
    optional("pxr", "reading USD files", "usd")


@contextmanager
def _readable(source: Source, path: Path) -> Iterator[None]:
    """Turn what the library raises into errors about the file."""
    from pxr import Tf

    try:
        yield
    except (Tf.ErrorException, RuntimeError, UnicodeDecodeError, MemoryError) as error:
        why = reason_of(error).replace(str(path.absolute()), "")
        raise source.error(f"USD cannot read it ({why}); fix it, or get a fresh copy") from None


def _no_lines() -> Lines:
    return Lines(np.empty((0, 2, 3), np.float32))


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
        told = dict.fromkeys(text_of(found, "commentary") for found in delegate.TakeUncoalescedDiagnostics())
        del delegate
    for text in list(told)[:_N_WARNINGS]:
        source.warn(f"USD says: {short(text)}")
    if len(told) > _N_WARNINGS:
        source.warn(f"USD says {len(told) - _N_WARNINGS} other things")
