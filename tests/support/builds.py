"""How trees are built, by name: all that answers must not depend on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from support.nasty import boxes_of, triangles_on

import fastlines as fl
from fastlines.geometry.collection import as_geometry

#: Keeps trees over copies of long lines small, so that the tests are quick; enough for most others.
BUDGET = 3000

G = fl.PlaneGrid
#: Settings off the beaten track.
OFF_THE_TRACK: dict[str, dict[str, Any]] = {
    "events tight": {"splits": fl.PlaneEvents()},
    "median tight": {"splits": fl.Median(), "cost": fl.Cost(0.01)},
    "median cut": {"splits": fl.Median(), "boxes": "cut", "cost": fl.Cost(0.01)},
    "middle tight": {"splits": fl.Midpoint(), "cost": fl.Cost(0.01)},
    "middle cut": {"splits": fl.Midpoint(), "boxes": "cut", "cost": fl.Cost(0.01)},
    "all tight": {"splits": (fl.ObjectSweep(max_refs=32), G(3), fl.PlaneEvents(max_refs=8), fl.Median())},
    "all cut": {"splits": (G(4), fl.PlaneEvents(max_refs=16), fl.Median(), fl.Midpoint()), "boxes": "cut"},
    "sweep ahead 2": {"splits": fl.ObjectSweep(max_refs=12), "lookahead": 2},
    "grid ahead 3": {"splits": G(1), "lookahead": [1, 2, 3]},
    "cut ahead 2": {"splits": G(2), "lookahead": 2, "boxes": "cut", "cost": fl.Cost(0.1)},
    "no lookahead": {"lookahead": 0},
    "one plane": {"splits": G(1), "cost": fl.Cost(1e-3)},
    "many planes": {"splits": G(300), "cost": fl.Cost(0.3), "limits": fl.Limits(max_refs=300)},
    "depth 0": {"limits": fl.Limits(max_depth=0)},
    "depth 3": {"limits": fl.Limits(max_depth=3, max_refs=BUDGET), "cost": fl.Cost(0.01)},
    "leaves of 1": {"splits": fl.ObjectSweep(), "limits": fl.Limits(max_leaf_refs=1)},
    "leaves of 3": {"splits": G(2), "limits": fl.Limits(max_leaf_refs=3, max_refs=BUDGET)},
    "no duplicates": {"splits": G(16), "limits": fl.Limits(max_refs=40), "cost": fl.Cost(0.01)},
    "few duplicates": {"boxes": "cut", "limits": fl.Limits(max_refs=55), "cost": fl.Cost(0.01)},
    "leaf_refs 0": {"splits": fl.PlaneEvents(), "boxes": "cut", "limits": fl.Limits(leaf_refs=0, max_refs=BUDGET)},
    "leaf_size": {"limits": fl.Limits(leaf_size=0.3, max_refs=BUDGET), "cost": fl.Cost(0.01)},
}

#: Trees that reinsertion has to do with.
TO_REINSERT: dict[str, dict[str, Any]] = {
    "whole": {"splits": fl.ObjectSweep(), "cost": fl.Cost(0.3)},
    "pieces": {"splits": fl.PlaneGrid(4), "cost": fl.Cost(0.3), "limits": fl.Limits(max_refs=2000)},
    "best": {"method": "best", "limits": fl.Limits(max_refs=2000, max_leaf_refs=4)},
    "presplit": {"method": "bvh-cl", "presplit": fl.Presplit(refs=5), "cost": fl.Cost(0.3)},
    "median": {"splits": fl.Median(), "cost": fl.Cost(0.01)},
}
#: Bounds on early split clipping.
PRESPLITS = [fl.Presplit(area=1e-3), fl.Presplit(area=1.0), fl.Presplit(refs=1), fl.Presplit(refs=7.5), fl.Presplit()]

#: The kinds of primitive that queries run on: what makes each of an array of segments, the same every time.
KINDS: dict[str, Callable[[Any], fl.Lines]] = {
    "segments": fl.Lines.from_segments,
    "round cones": lambda segments: fl.Lines.from_segments(segments, radius=_radii(segments)),
    "spheres": lambda segments: fl.Spheres.from_centres(np.reshape(segments, (-1, 2, 3))[:, 0], _radii(segments)[:, 0]),
}


def _curves(segments: Any) -> fl.Curves:
    """Bend each segment, and give it a radius that tapers; few pieces a curve."""
    ends = np.asarray(segments, np.float64).reshape(-1, 2, 3)
    size = float(np.ptp(ends)) if ends.size else 0.0
    weights = np.array([[1, 0], [2 / 3, 1 / 3], [1 / 3, 2 / 3], [0, 1]])
    control = np.einsum("ij,njk->nik", weights, ends)
    control[:, 1:3] += np.random.default_rng(3).normal(0, 0.02 * size, (len(ends), 2, 3))
    return fl.Curves.from_bezier(control.astype(np.float32), _radii(segments) * 0.2, tolerance=0.01 * size or None)


class Balls:
    """Balls as a class of one's own would have them: solid, and larger by the radius of a query."""

    def __init__(self, segments: Any) -> None:
        ends = np.asarray(segments, np.float64).reshape(-1, 2, 3)
        self.centre, self.own = ends.mean(axis=1), _radii(segments)[:, 0] * 0.5

    def bounds(self) -> Any:
        """See `fl.Primitives`."""
        return np.stack([self.centre - self.own[:, None], self.centre + self.own[:, None]], axis=1)

    def hit(self, ids: Any, rays: Any, radius: Any) -> Any:
        """See `fl.Primitives`."""
        d2 = (rays.directions**2).sum(axis=1)
        from_centre = rays.origins - self.centre[ids]
        middle = -(from_centre * rays.directions).sum(axis=1) / d2
        nearest = from_centre + middle[:, None] * rays.directions
        half2 = ((self.own[ids] + radius) ** 2 - (nearest**2).sum(axis=1)) / d2
        half = np.sqrt(np.maximum(half2, 0))
        t, t_out = np.maximum(middle - half, rays.t_min), np.minimum(middle + half, rays.t_max)
        return {"t": np.where((half2 >= 0) & (t <= t_out), t, np.inf), "t_out": t_out}

    def nearest(self, ids: Any, points: Any) -> Any:
        """See `fl.Primitives`; negative inside."""
        away = points - self.centre[ids]
        length = np.sqrt((away**2).sum(axis=1))
        towards = np.where(length > 0, away.T / np.where(length > 0, length, 1), [[0], [0], [1]]).T
        return {"distance": length - self.own[ids], "point": self.centre[ids] + self.own[ids, None] * towards}


def _mixture(segments: Any) -> fl.Geometry:
    ends = np.asarray(segments, np.float32).reshape(-1, 2, 3)
    thirds = [ends[i::3] for i in range(3)]
    lines = fl.Lines.from_segments(thirds[0], radius=_radii(thirds[0]))
    return fl.Geometry([triangles_on(thirds[1]), lines, boxes_of(thirds[2]), _curves(thirds[1])])


#: Shapes that queries run on, besides lines: what makes each of an array of segments, the same every time.
SHAPES: dict[str, Callable[[Any], Any]] = {
    "triangles": triangles_on,
    "boxes": boxes_of,
    "curves": _curves,
    "a mixture": _mixture,
    "one's own": Balls,
}


def _radii(segments: Any) -> Any:
    """Return a radius for each end: from none to larger than the lines, and some that let one ball hold the other."""
    ends = np.asarray(segments, np.float64).reshape(-1, 6)
    size = float(np.ptp(ends)) if ends.size else 0.0
    radii = np.random.default_rng(7).random((len(ends), 2)) ** 8 * 0.3 * size
    radii[::7] = 0
    radii[1::7, 1] = radii[1::7, 0]
    return radii.astype(np.float32)


#: All kinds of primitive.
ALL_KINDS: dict[str, Callable[[Any], Any]] = {**KINDS, **SHAPES}

METHODS: dict[str, dict[str, Any]] = {method: {"method": method} for method in fl.METHODS}

#: All of them.
BUILDS: dict[str, dict[str, Any]] = {
    **METHODS,
    **OFF_THE_TRACK,
    **{f"{name}, reinserted": {**given, "reinsertion": 3} for name, given in TO_REINSERT.items()},
    **{
        f"{method}, {presplit}": {"method": method, "presplit": presplit, "limits": fl.Limits(max_refs=2000)}
        for method, presplit in zip(("bvh-cl", "bvh-ss", "best", "bvh-cl", "bvh-ss"), PRESPLITS, strict=True)
    },
}


def build(segments: Any, **given: Any) -> fl.Tree:
    """Build a tree that is small enough to be asked much."""
    limits = fl.Limits(max_refs=max(BUDGET, len(as_geometry(segments).build_data()[1])))
    return fl.build(segments, **{"limits": limits, **given})
