"""``fastlines info`` and ``fastlines validate``: what a file holds, and whether a tree satisfies the axioms."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer
from typer import Option

import fastlines as fl

from ..errors import FastlinesError, InputError
from ..geometry.collection import AnyGeometry, core_data, core_of, needs_radius, parts_of, points_of, unit_of, up_of
from ..geometry.curves import Curves
from ..geometry.lines import Lines
from ..geometry.triangles_boxes import Boxes, Triangles
from ..query.hit_places import names
from ..settings.settings import limit_notes
from ..support.texts import bytes_text
from ..tree import Tree
from .files import Source
from .options import FormatName, FormatOptions, Input, Json, TreeFile

#: The most characters a line of a picture.
COLUMNS = 80


def info(
    source: Input,
    picture: Annotated[bool, Option("--picture", "-p", help="Draw it, small, in the terminal.")] = False,
    format: FormatName = None,
    option: FormatOptions = None,
    as_json: Json = False,
) -> None:
    """Describe a file: the number and size of its lines, their attributes, and their oddities.

    Segments that hold NaN or Inf are left out and counted. The radius for pictures is the least of 1, 2, 5, 10 … with
    which dense lines look closed; lines with a radius of their own need none.

    [bold]Examples[/]

    [cyan]fastlines info hair.tfx[/]

    [cyan]fastlines info hair.flt --json[/]

    [cyan]fastlines info tracts.trk.gz --picture[/]

    [cyan]fastlines info protein.pdb --option model=2[/]

    [cyan]fastlines info scene:photon-beams:10000[/]
    """
    from .files import open_input

    if picture and as_json:
        raise InputError("--picture does not apply to --json; give one of them")
    opened = open_input(source, True, format, option)
    is_lines = isinstance(opened.geometry, Lines)
    tree = opened.tree
    if tree is None and len(opened.geometry) and (picture or needs_radius(opened.geometry)):
        tree = fl.build(opened.geometry, effort=0)
    suits = _suitable(opened, tree)
    facts: dict[str, Any] = {"name": opened.name, "format": opened.format and opened.format.description}
    facts["lines" if is_lines else "shapes"] = {**describe(opened.geometry), "radius_for_pictures": suits}
    if opened.tree is not None:
        facts["tree"] = opened.tree.stats()
    if as_json:
        typer.echo(json.dumps(facts, indent=2))
        return
    typer.echo(opened.name + (f": {opened.format.description}" if opened.format else ""))
    for part in ("lines", "shapes", "tree"):
        for key, value in facts.get(part, {}).items():
            if key == "radius_for_pictures" and value is None:
                continue  # they have their own radius, or there is nothing to draw
            name = key.removeprefix("n_").removesuffix("_bytes").replace("_", " ")
            typer.echo(f"{part:>7}  {name:<19} {_text(key, value)}")
    if picture and tree is not None:
        typer.echo(draw(opened, tree, suits or 0.0))


def _suitable(opened: Source, tree: Tree | None) -> float | None:
    """Return a radius with which a picture of the lines is not almost empty, if they have none."""
    from ..rendering.plan import PictureOptions, choose_camera
    from ..rendering.suitable_radius import suitable_radius

    if tree is None or not needs_radius(opened.geometry) or not len(opened.geometry):
        return None
    return suitable_radius(tree, choose_camera(PictureOptions(), tree.geometry)[0])


def draw(opened: Source, tree: Tree, radius: float) -> str:
    """Draw lines as text that fits the terminal, by the default camera."""
    from ..rendering.shading.depth_tone import grey
    from .terminal import has_colours, picture_text

    columns = max(16, min(COLUMNS, shutil.get_terminal_size((COLUMNS, 24)).columns))
    rows = columns // 2
    size: dict[str, Any] = {"width": columns, "height": 2 * rows}
    image = grey(fl.render(tree, opened.camera(), look="depth", radius=radius, samples=4, **size))
    lit = np.flatnonzero(image.any(axis=1)) // 2
    return picture_text(image[2 * lit.min(initial=rows) : 2 * lit.max(initial=0) + 2], has_colours())


def validate(tree_file: TreeFile, as_json: Json = False) -> None:
    """Check a tree: axioms 1 to 5, the axiom of its kind, Theorem 4, and that f = g (Theorem 1).

    If a node breaks an axiom, the command names both and exits with code 1.

    [bold]Examples[/]

    [cyan]fastlines validate hair.flt[/]

    [cyan]fastlines validate hair.flt --json[/]
    """
    from .files import open_tree

    tree = open_tree(tree_file)
    tree.validate()
    f, g = tree.cost(by="f"), tree.cost(by="g")
    difference = abs(f - g) / max(abs(f), abs(g), 1e-300)
    if not difference <= 1e-9:
        raise FastlinesError(f"{tree_file}: f = {f!r} and g = {g!r} differ, against Theorem 1; build the tree again")
    kind = "KD" if tree.settings.boxes == "cut" else "BVH"
    if as_json:
        typer.echo(json.dumps({"valid": True, "kind": kind, "n_nodes": tree.n_nodes, "cost_f": f, "cost_g": g}))
        return
    typer.echo(
        f"{tree_file}: valid: axioms 1 to 5, the {kind} axiom and Theorem 4 hold at all {tree.n_nodes:,} nodes; "
        f"f = g = {f:.9g} (they differ by {difference:.0e})"
    )


def describe(geometry: AnyGeometry) -> dict[str, Any]:
    """Return counts and sizes of lines, or of what else a tree is over, ready for JSON."""
    if isinstance(geometry, Lines):
        return _describe_lines(geometry)
    points, radii = points_of(geometry)
    parts = parts_of(geometry)
    lines = [core_of(part) if isinstance(part, Curves) else part for part in parts if isinstance(part, Lines | Curves)]
    facts: dict[str, Any] = {f"n_{type(part).__name__.lower()}": 0 for part in parts}
    for part in parts:
        facts[f"n_{type(part).__name__.lower()}"] += len(part)
    some = len(points) > 0
    bounds = np.stack([points.min(axis=0), points.max(axis=0)]) if some else None
    sums = np.concatenate([np.empty(0), *(strand_sums(part) for part in lines if isinstance(part, Lines))])
    return {
        **facts,
        "n_strands": sum(part.n_strands for part in parts if isinstance(part, Lines | Curves)),
        "bounds": None if bounds is None else bounds.tolist(),
        "size": None if bounds is None else (bounds[1] - bounds[0]).tolist(),
        "total_length": float(sum(segment_lengths(part).sum() for part in lines if isinstance(part, Lines))),
        "strand_lengths": extremes(sums),
        "n_zero_length": sum(_n_points(part) for part in parts),
        "n_duplicates": sum(map(_n_repeats, parts)),
        "radius": [float(radii.min()), float(radii.max())] if radii.any() else None,
        "attributes": _attributes(parts),
        "up": up_of(geometry),
        "unit": unit_of(geometry),
        "n_skipped": sum(len(part.skipped) for part in parts if isinstance(part, Lines | Curves)),
        "memory_bytes": core_data(geometry)[1].nbytes,
    }


def _n_points(part: AnyGeometry) -> int:
    """Count the segments and the curves that are one point."""
    if not isinstance(part, Lines | Curves):
        return 0
    points = part.control if isinstance(part, Curves) else part.segments
    return int((points == points[:, :1]).all(axis=(1, 2)).sum())


def _n_repeats(part: AnyGeometry) -> int:
    """Count the segments, or the curves, that are the same as an earlier one, in either direction."""
    if isinstance(part, Curves):
        points = part.control.reshape(-1, 12) + np.float32(0)
        backwards = part.control[:, ::-1].reshape(-1, 12) + np.float32(0)
        first = (points != backwards).argmax(axis=1)
        rows = np.arange(len(points))
        turned = points[rows, first] > backwards[rows, first]
        return len(points) - len(np.unique(np.where(turned[:, None], backwards, points), axis=0))
    return count_duplicates(part) if isinstance(part, Lines) else 0


def _describe_lines(lines: Lines) -> dict[str, Any]:
    ends = lines.segments
    lengths = segment_lengths(lines)
    arrays = [values for name, values in lines.attributes.items() if name not in lines.end_attributes]
    arrays += [ends, lines.strands, *lines.end_attributes.values()]
    some = len(lines) > 0
    return {
        "n_segments": len(lines),
        "n_strands": lines.n_strands,
        "bounds": lines.bounds.tolist() if some else None,
        "size": (lines.bounds[1] - lines.bounds[0]).tolist() if some else None,
        "total_length": float(lengths.sum()),
        "median_length": float(np.median(lengths)) if some else None,
        "strand_lengths": extremes(strand_sums(lines)),
        "n_zero_length": int((ends[:, 0] == ends[:, 1]).all(axis=1).sum()),
        "n_duplicates": count_duplicates(lines),
        "radius": None if lines.radius is None or not some else [float(lines.radius.min()), float(lines.radius.max())],
        "attributes": _attributes([lines]),
        "up": lines.up,
        "unit": lines.unit,
        "n_skipped": len(lines.skipped),
        "memory_bytes": sum(values.nbytes for values in arrays) + (0 if lines.radius is None else lines.radius.nbytes),
    }


def _attributes(parts: Sequence[AnyGeometry]) -> dict[str, str]:
    """Return the type of each attribute and what it has values for, by name; of several parts if these differ."""
    kinds: dict[str, dict[str, None]] = {}
    for part in parts:
        for name in names(part):
            if isinstance(part, Lines | Curves) and name in part.attributes:
                values = part.attributes[name]
                kind = f"{values.dtype}{_shape(values.shape[1:])} per {_place(part, name)}"
            elif isinstance(part, Triangles | Boxes):
                is_corner = name in part.corner_attributes
                values = (part.corner_attributes if is_corner else part.attributes)[name]
                of = "corner" if is_corner else "box" if isinstance(part, Boxes) else "triangle"
                kind = f"{values.dtype}{_shape(values.shape[1 + is_corner :])} per {of}"
            else:
                continue  # the radius, which is reported by itself
            kinds.setdefault(name, {})[kind] = None
    return {name: " or ".join(kinds[name]) for name in sorted(kinds)}


def _place(part: Lines | Curves, name: str) -> str:
    """Return what an attribute has values for: points, strands, or segments or curves."""
    if name in part.end_attributes:
        return "point" if isinstance(part, Lines) else "end of a curve"
    values, strands = part.attributes[name], part.strands
    if 0 < part.n_strands < len(part) and (strands >= 0).all():
        _, first, strand = np.unique(strands, return_index=True, return_inverse=True)
        if np.array_equal(values, values[first][strand], equal_nan=values.dtype.kind in "fc"):
            return "strand"
    return "segment" if isinstance(part, Lines) else "curve"


def segment_lengths(lines: Lines) -> npt.NDArray[np.float64]:
    """Return the length of each segment, (n,)."""
    return np.asarray(np.sqrt((np.diff(lines.segments.astype(np.float64), axis=1)[:, 0] ** 2).sum(axis=1)))


def strand_sums(lines: Lines) -> npt.NDArray[np.float64]:
    """Return the length of each strand."""
    has = lines.strands >= 0
    strand = np.unique(lines.strands[has], return_inverse=True)[1]
    return np.asarray(np.bincount(strand, segment_lengths(lines)[has]))


def extremes(lengths: npt.NDArray[np.float64]) -> list[float] | None:
    """Return the least, the median and the greatest length; None if there are none."""
    if not len(lengths):
        return None
    return [float(lengths.min()), float(np.median(lengths)), float(lengths.max())]


def _shape(shape: tuple[int, ...]) -> str:
    return " × ".join(["", *map(str, shape)])


def count_duplicates(lines: Lines) -> int:
    """Count the segments that join the same two points as an earlier one, in either direction."""
    ends = lines.segments + np.float32(0)  # no negative zeros
    first, last = ends[:, 0], ends[:, 1]
    differs = first != last
    axis = differs.argmax(axis=1)
    rows = np.arange(len(ends))
    turned = first[rows, axis] > last[rows, axis]
    ends[turned] = ends[turned][:, ::-1]
    return len(ends) - len(np.unique(ends.reshape(-1, 6), axis=0))


def _text(key: str, value: Any) -> str:
    """Write a value of `describe` or of `Tree.stats`."""
    if key == "bounds" and value:
        return " to ".join(_text("", corner) for corner in value)
    if key == "attributes" and isinstance(value, dict):
        return ", ".join(f"{name} ({kind})" for name, kind in value.items()) or "none"
    if key == "memory_bytes":
        return bytes_text(value)
    if isinstance(value, list):
        return "(" + ", ".join(_text("", item) for item in value) + ")" if value else "none"
    if isinstance(value, dict):
        return ", ".join(limit_notes(value)) or "none"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, int):
        return f"{value:,}"
    return "none" if value is None else str(value)
