"""The shapes, and the least ratio to Embree that is wanted of each."""

from __future__ import annotations

from dataclasses import dataclass

#: A kind of rays and a query.
Question = tuple[str, str]


@dataclass(frozen=True)
class Shape:
    """A kind of primitive.

    Attributes
    ----------
    title : str
        Both sides, for the heading of its table.
    note : str
        Why answers differ.
    scenes, quick_scenes : tuple of str
        The scenes by default, and those of a quick run.
    floors : dict of (str, str) to float
        The least mean ratio that is wanted, for kinds of rays and queries.
    """

    title: str
    note: str
    scenes: tuple[str, ...]
    quick_scenes: tuple[str, ...]
    floors: dict[Question, float]


def _floors(camera_first: float, random_first: float, random_all: float) -> dict[Question, float]:
    return {("camera", "first"): camera_first, ("random", "first"): random_first, ("random", "all"): random_all}


SHAPES = {
    "cones": Shape(
        "round cones beside Embree's round linear curves",
        "Embree's segments share no vertices, so each has both its balls, as ours have; pieces of a segment share.",
        ("bun-hair", "straight-hair", "spaghetti", "spaghetti-2", "photon-beams"),
        ("spaghetti:1000", "straight-hair:10000"),
        _floors(1.8, 1.8, 3.0),
    ),
    "hair": Shape(
        "cubic curves beside Embree's round Bezier curves",
        "Embree sweeps discs and has no ends; ours are balls, so a ray near a joint hits both curves. Each has its "
        "own tolerance.",
        ("bun-hair", "straight-hair"),
        ("bun-hair:5000",),
        _floors(1.2, 1.2, 2.0),
    ),
    "spheres": Shape(
        "spheres beside Embree's sphere points",
        "",
        ("balls", "beads"),
        ("balls:5000",),
        _floors(0.8, 0.8, 0.8),
    ),
    "triangles": Shape(
        "triangles beside Embree's",
        "A ray through an edge may hit either triangle.",
        ("icosphere", "knot", "terrain"),
        ("knot:10000",),
        _floors(0.4, 0.4, 0.4),
    ),
}

#: How many times the time of lines of the same radius cones may take at most.
MOST_OF_LINES = 1.25
