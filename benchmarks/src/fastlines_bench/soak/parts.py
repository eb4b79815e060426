"""The geometry of a case as plain arrays, of which rows can be left out: parts, their containers, and their text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

import fastlines as fl

from .balls import Balls
from .scenes import Array, Random, random_axes, random_radii, size_of

#: The bases of curves.
BASES = ("bezier", "bspline", "catmull-rom", "hermite")


@dataclass(frozen=True)
class Part:
    """A container of primitives: its kind, arrays with a row for each primitive, and other arguments."""

    kind: str
    rows: dict[str, Array]
    options: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(next(iter(self.rows.values())))

    @property
    def label(self) -> str:
        """What tables call it."""
        return str(self.options.get("label", self.kind))

    def some(self, keep: Array) -> Part:
        """Return the part with these rows alone."""
        return replace(self, rows={name: values[keep] for name, values in self.rows.items()})

    def made(self, offset: tuple[float, ...] | None = None, spoiled: tuple[int, ...] = ()) -> Any:
        """Return the container, moved by an offset that it subtracts again; spoiled rows are given, and skipped."""
        rows, options = self.rows, self.options
        if spoiled:
            rows = {name: np.insert(values, spoiled, _nothing(values), axis=0) for name, values in rows.items()}
            options = {**options, "invalid": "skip"}
        return MAKERS[self.kind](rows, options, offset)

    def with_corners(self, low: Array, high: Array) -> Part:
        """Return the part with more rows at its end, whose box has these corners."""
        ends = np.stack([low, high])[None].astype(np.float32)
        match self.kind:
            case "lines" | "cones":
                more = {"ends": ends, "moved": ends}
            case "spheres" | "own class":
                more = {"centres": ends[0]}
            case "curves":
                more = {"control": ends[:, [0, 0, 1, 1]]}
            case kind:
                more = {"corners": ends[:, [0, 0, 1]] if kind == "triangles" else ends}
        n = len(next(iter(more.values())))
        rows = {}
        for name, values in self.rows.items():
            nothing = np.zeros((n, *values.shape[1:])) + (values.max(initial=-1) + 1 if name == "strands" else 0)
            rows[name] = np.concatenate([values, more.get(name, nothing)]).astype(values.dtype)
        return replace(self, rows=rows)

    def corners(self) -> Array:
        """Return the points of all primitives, (n, …, 3)."""
        name = next(name for name in ("ends", "control", "corners", "centres") if name in self.rows)
        return self.rows[name]


def _placed(points: Array, offset: tuple[float, ...] | None) -> Array:
    """Return points moved by an offset, in float64."""
    return points if offset is None else points.astype(np.float64) + np.array(offset)


def _nothing(values: Array) -> Any:
    """Return what no row of a container may hold."""
    return np.nan if values.dtype.kind == "f" else 0


def _lines(rows: dict[str, Array], options: dict[str, Any], offset: tuple[float, ...] | None) -> fl.Lines:
    more: Any = {name: rows[name] for name in ("radius", "strands") if name in rows}
    more["invalid"] = options.get("invalid", "error")
    return fl.Lines.from_segments(_placed(rows["ends"], offset), offset=offset, **more)


def _spheres(rows: dict[str, Array], options: dict[str, Any], offset: tuple[float, ...] | None) -> fl.Spheres:
    invalid = options.get("invalid", "error")
    return fl.Spheres.from_centres(_placed(rows["centres"], offset), rows["radius"], offset=offset, invalid=invalid)


def _curves(rows: dict[str, Array], options: dict[str, Any], offset: tuple[float, ...] | None) -> fl.Curves:
    given = _placed(rows["control"], offset)
    strands, tolerance = rows.get("strands"), options["tolerance"]
    more: Any = {"strands": strands, "tolerance": tolerance, "invalid": options.get("invalid", "error")}
    return fl.Curves.from_bezier(given, rows["radius"], **more, offset=offset)


#: What makes a container of a kind, from rows, options and an offset.
MAKERS: dict[str, Callable[[dict[str, Array], dict[str, Any], Any], Any]] = {
    "lines": _lines,
    "cones": _lines,
    "spheres": _spheres,
    "curves": _curves,
    "triangles": lambda rows, options, offset: fl.Triangles(rows["corners"]),
    "boxes": lambda rows, options, offset: fl.Boxes(rows["corners"]),
    "own class": lambda rows, options, offset: Balls(rows["centres"], rows["radius"]),
}
#: The kinds that can be parts of a `Geometry`.
PARTS = tuple(kind for kind in MAKERS if kind != "own class")
#: The kinds that are lines to a refit and a forest, and those that have axes and so an offset.
LINES = ("lines", "cones")
AXES = ("lines", "cones", "spheres", "curves")


def random_part(rng: Random, kind: str, n: int, shape: str | None = None) -> tuple[str, Part]:
    """Return the shape of a scene, and a part of this kind over it."""
    name, ends = random_axes(rng, n, shape)
    return name, part_over(rng, kind, ends)


def part_over(rng: Random, kind: str, ends: Array) -> Part:
    """Return a part of a kind over axes, (n, 2, 3) float32."""
    n, size = len(ends), size_of(ends)
    match kind:
        case "lines" | "cones":
            rows = {"ends": ends, "moved": ends + rng.normal(0, 0.1 * size, (n, 1, 3)).astype(np.float32)}
            if kind == "cones":
                rows["radius"] = random_radii(rng, ends)
            if rng.random() < 0.5:
                rows["strands"] = np.arange(n) // 8
            return Part(kind, rows)
        case "spheres":
            return Part(kind, {"centres": ends[:, 0], "radius": random_radii(rng, ends)[:, 0]})
        case "curves":
            return _random_curves(rng, ends, size)
        case "triangles":
            third = ends[:, :1] + rng.normal(0, 0.3 * size, (n, 1, 3))
            return Part(kind, {"corners": np.concatenate([ends, third], axis=1).astype(np.float32)})
        case "boxes":
            return Part(kind, {"corners": np.stack([ends.min(axis=1), ends.max(axis=1)], axis=1)})
        case _:
            return Part(kind, {"centres": ends.mean(axis=1), "radius": 0.5 * random_radii(rng, ends)[:, 0]})


def _random_curves(rng: Random, ends: Array, size: float) -> Part:
    """Return curves of a random basis, as Bezier curves."""
    basis = str(rng.choice(BASES))
    tolerance, n = 0.01 * size, len(ends)
    if basis == "bezier" or n < 4:
        weights = np.array([[1, 0], [2 / 3, 1 / 3], [1 / 3, 2 / 3], [0, 1]])
        control = np.einsum("ij,njk->nik", weights, ends.astype(np.float64))
        control[:, 1:3] += rng.normal(0, 0.05 * size, (n, 2, 3))
        rows = {"control": control.astype(np.float32), "radius": 0.3 * random_radii(rng, ends)}
        return Part("curves", rows, {"tolerance": tolerance, "label": "curves, bezier"})
    points, radii = ends[:, 0], 0.3 * random_radii(rng, ends)[:, 0]
    tangents = rng.normal(0, 0.3 * size, (n, 3)) if basis == "hermite" else None
    half = n // 2 if n >= 8 else n
    counts = [half, n - half] if half < n else [n]
    made = fl.Curves.from_strands(points, counts, basis=basis, radius=radii, tangents=tangents, tolerance=tolerance)
    assert made.radius is not None
    rows = {"control": made.control, "radius": np.maximum(made.radius, np.float32(0)), "strands": made.strands}
    return Part("curves", rows, {"tolerance": tolerance, "label": f"curves, {basis}"})
