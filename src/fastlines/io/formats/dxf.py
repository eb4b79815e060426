"""DXF (``.dxf``): the lines of drawings, text or binary, by the library ezdxf (the extra "cad").

Format: https://help.autodesk.com/view/OARX/2024/ENU/?guid=GUID-235B22E0-A567-4CF6-92D3-38A2306D73F3.

Of the model space are read LINE, LWPOLYLINE and POLYLINE (2D and 3D) with their bulges, ARC, CIRCLE, ELLIPSE, SPLINE
and HELIX, also in blocks, as each INSERT places them. Each entity is a strand. Curves, splines too, become polylines
within a tolerance. The unit is that of
``$INSUNITS``. Other entities are dropped with a warning, and so are layouts, and entities that break the
rules of the format. Colours and line weights are dropped.

The attribute ``feature`` counts the entities of the model space, of all types: ``list(drawing.modelspace())[feature]``
is the entity in ezdxf; of lines in blocks, it is the INSERT. ``handle`` is the entity's own handle, and ``layer_name``
the name of its layer. ``layer`` counts the layers in the order of the file's table.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from io import BytesIO
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import LEAST, number
from ...geometry.lines import Lines
from ...geometry.making import OF_SIZE
from ...geometry.strand_attributes import NO_TEXT, objects
from ...support.optional import optional
from ...support.texts import kinds_text
from ..source import BAD_COPY, Source, reason
from .columns import with_features
from .dxf_records import Record, text_of, without_bad

Float64Array = npt.NDArray[np.float64]

_LINES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "HELIX")
#: The units of $INSUNITS, by number.
_UNITS = {
    1: "in", 2: "ft", 3: "mi", 4: "mm", 5: "cm", 6: "m", 7: "km", 8: "µin", 9: "mil", 10: "yd", 11: "Å", 12: "nm",
    13: "µm", 14: "dm", 15: "dam", 16: "hm", 17: "Gm", 18: "au", 19: "ly", 20: "pc",
}  # fmt: skip
_BINARY = b"AutoCAD Binary DXF"
#: What may follow the end.
_BLANK = b" \t\r\n\0\x1a"
#: An arc of a polyline is so many cubic Bezier curves, which are off by less than 1e-7 of its radius.
_BEZIERS = 16
#: Blocks in blocks, at most.
_MAX_DEPTH = 64
#: A drawing may have this many entities, those in blocks counted each time, and one more for each byte.
_MAX_ENTITIES = 100_000


def read(source: Source, invalid: str, *, tolerance: float | None = None) -> Lines:
    """Read the lines of a drawing.

    Parameters
    ----------
    tolerance : float, optional
        How far polylines may be from their curves, in the unit of the drawing; by default 1e-5 of the longest side of
        the box of each curve, which makes about 500 segments of a circle. A larger one reads drawings of many curves
        faster.
    """
    if tolerance is not None:
        tolerance = number("tolerance", tolerance, "a length above 0", LEAST)
    if b"ENTITIES" not in source.data:
        raise source.error("is not a DXF drawing: it has no section ENTITIES; check the extension, or save it again")
    if not source.data[-1024:].rstrip(_BLANK).endswith(b"EOF"):
        raise source.error(f"does not end with EOF; {BAD_COPY}")
    ezdxf = optional("ezdxf", "reading .dxf", "cad")
    path = optional("ezdxf.path", "reading .dxf", "cad")
    drawing = _open(source, ezdxf)
    layers = {str(layer.dxf.name).lower(): i for i, layer in enumerate(drawing.layers)}
    others: dict[str, int] = {}
    bad: dict[str, int] = {}
    strands: list[Float64Array] = []
    numbers: list[int] = []
    features: list[int] = []
    texts: dict[str, list[str]] = {"layer_name": [], "handle": []}
    n_points = 0
    why = "it has no size"
    for feature, entity, matrices in _lines_of(source, drawing.modelspace(), others, bad):
        try:
            points = _points(entity, path.make_path(entity, segments=_BEZIERS), matrices, tolerance)
            layer, handle = str(entity.dxf.layer), str(entity.dxf.get("handle") or NO_TEXT)
        except Exception as error:  # whatever the library raises for values that make no sense
            points, why = np.empty((0, 3)), reason(error)
        if not len(points):
            bad[entity.dxftype()] = bad.get(entity.dxftype(), 0) + 1
            continue
        n_points += len(points)
        if 12 * n_points > source.unpack_limit:
            raise source.error("its curves become far more points than a drawing has; raise tolerance=")
        strands.append(points)
        numbers.append(layers.setdefault(layer.lower(), len(layers)))
        features.append(feature)
        texts["layer_name"].append(layer)
        texts["handle"].append(handle)
    if bad:
        source.warn(f"entities that cannot be read are left out: {kinds_text(bad)} ({why.rstrip('.')})")
    n_elsewhere = sum(entity.dxftype() in _LINES for name in drawing.layouts.names() if name != "Model"
                      for entity in drawing.layouts.get(name))  # fmt: skip
    if n_elsewhere:
        others["lines of layouts"] = n_elsewhere
    if others:
        source.warn(f"entities other than lines of the model space are not read: {kinds_text(others)}")
    points = np.concatenate([np.empty((0, 3)), *strands])
    lines = Lines.from_points(points, [len(part) for part in strands], offset=source.offset, invalid=invalid)
    unit = _UNITS.get(drawing.header.get("$INSUNITS", 0))
    named = {name: objects(column) for name, column in texts.items()}
    return with_features(lines, features, {"layer": np.array(numbers, np.int64), **named}, unit)


def _open(source: Source, ezdxf: Any) -> Any:
    """Open the drawing; one that breaks the rules of the format is repaired as far as the library can.

    Where it cannot, the entities, variables and sections that it refuses are left out.
    """
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())  # or the library prints to stderr
    recover = optional("ezdxf.recover", "reading .dxf", "cad")
    with source.file(".dxf") as file:
        try:
            return ezdxf.readfile(file)
        except Exception as error:  # the library raises many types for damaged files
            why = reason(error).rstrip(".")

    def load(data: bytes) -> Any:
        try:
            return recover.read(BytesIO(data))
        except Exception:
            return None

    loaded = load(source.data)
    bad: list[Record] = []
    if loaded is None:
        rest, bad = without_bad(_text(source), lambda data: load(data) is not None)
        loaded = load(rest) if bad else None
    if loaded is None:
        if b"SECTION" in source.data:
            raise source.error(f"cannot be read as a DXF drawing: {why}; audit the drawing, and save it again")
        raise source.error(f"is not a DXF drawing: {why}; check the extension, or save it again")
    drawing, audit = loaded
    if bad:
        kinds = [record.kind for record in bad]
        numbers = kinds_text({kind: kinds.count(kind) for kind in dict.fromkeys(kinds)})
        source.warn(f"parts that break the rules of the format are left out: {numbers} ({why})")
    else:
        source.warn(f"breaks the rules of the format ({why}); {len(audit.fixes)} mistakes were repaired to read it")
    return drawing


def _text(source: Source) -> bytes:
    """Return the drawing as text, if it is binary."""
    if not source.data.startswith(_BINARY):
        return source.data
    tagger = optional("ezdxf.lldxf.tagger", "reading .dxf", "cad")
    try:
        return text_of(tagger.binary_tags_loader(source.data))
    except Exception:  # whatever the library raises for values that make no sense
        return b""


def _lines_of(
    source: Source, entities: Iterable[Any], others: dict[str, int], bad: dict[str, int]
) -> Iterator[tuple[int, Any, tuple[Any, ...]]]:
    """Yield the entities that are lines, with the number of the one they are in and the matrices of the blocks."""
    n_left = [_MAX_ENTITIES + source.size]
    for feature, entity in enumerate(entities):
        for part, matrices in _exploded(source, [entity], others, bad, n_left):
            yield feature, part, matrices


def _exploded(
    source: Source,
    entities: Iterable[Any],
    others: dict[str, int],
    bad: dict[str, int],
    n_left: list[int],
    matrices: tuple[Any, ...] = (),
) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """Yield the entities that are lines, with the matrices of the blocks around them; count others and bad ones."""
    if len(matrices) > _MAX_DEPTH:
        raise source.error(f"its blocks are nested more than {_MAX_DEPTH} deep, perhaps in themselves; fix them")
    for entity in entities:
        n_left[0] -= 1
        if n_left[0] < 0:
            raise source.error("its blocks are inserted so often that they hold far more entities than a drawing has")
        kind = entity.dxftype()
        block = entity.block() if kind == "INSERT" else None
        if block is not None:
            try:
                places = [one.matrix44() for one in (entity.multi_insert() if entity.mcount > 1 else [entity])]
            except Exception:  # whatever the library raises for values that make no sense
                bad[kind] = bad.get(kind, 0) + 1
                continue
            for place in places:
                yield from _exploded(source, block, others, bad, n_left, (place, *matrices))
        elif kind in _LINES and not (kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)):
            yield entity, matrices
        else:
            others[kind] = others.get(kind, 0) + 1


def _points(entity: Any, path: Any, matrices: Sequence[Any], tolerance: float | None) -> Float64Array:
    """Return an entity as a polyline, in the world."""
    points = list(path.control_vertices())
    if path.has_curves:
        size = float(np.ptp(_array(points), axis=0).max())
        within = OF_SIZE * size
        if tolerance is not None:
            # The tolerance is in the world, and the polyline is in its block.
            linear = [np.array(matrix).reshape(4, 4)[:3, :3] for matrix in matrices]
            within = tolerance / max(float(np.prod([np.linalg.norm(part, 2) for part in linear])), LEAST)
        within = min(within, size / 4)
        # A path has the arcs of polylines exactly enough, but not rational splines: take all other entities themselves.
        exact = path if entity.dxftype() in ("LWPOLYLINE", "POLYLINE") else entity
        points = list(exact.flattening(within)) if within > 0 else points[:1]
    for matrix in matrices:
        points = list(matrix.transform_vertices(points))
    return _array(points)


def _array(points: Iterable[Any]) -> Float64Array:
    return np.array([tuple(point) for point in points], np.float64).reshape(-1, 3)
