"""Distances of points: the definition bit for bit in NumPy, and the same in float64 within a band."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import cases
from support.builds import ALL_KINDS
from support.points import points_of

import fastlines as fl
from fastlines.geometry.collection import as_geometry

#: Half an ulp of 1 in float32.
EPS = 2.0**-24


def frame_of(corners: Any) -> tuple[Any, float]:
    """Return the centre and the scale of the frame of a scene with these corners, (n, 3) float32."""
    view = fl.build(fl.Lines.from_segments(np.stack([corners.min(axis=0), corners.max(axis=0)])[None])).layout.view
    centre, scale, _ = view.frame
    return np.float32(centre), scale


def dot(a: Any, b: Any) -> Any:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def by_definition(ends: Any, radii: Any, points: Any, surface: bool, frame: tuple[Any, float]) -> tuple[Any, Any]:
    """Return s and the distance of each point from each segment, in float32, as docs/answers.md defines them."""
    (centre, scale), f = frame, np.float32
    p = ((points - centre.astype(np.float64)) * scale).astype(f)[:, None]
    start, end = ((ends[:, i] - centre) * f(scale) for i in (0, 1))
    r0, r1 = (radii * f(scale)).T
    e, w = end - start, p - start
    ee, we, slope = dot(e, e), dot(w, e), r1 - r0
    zero, one = f(0), f(1)
    with np.errstate(all="ignore"):
        s = np.where(ee > 0, np.minimum(np.maximum(we / ee, zero), one), zero)
        if surface:
            c = np.stack(
                np.broadcast_arrays(
                    *(w[..., i] * e[..., j] - w[..., j] * e[..., i] for i, j in ((1, 2), (2, 0), (0, 1)))
                ),
                -1,
            )
            rest2 = ee - slope * slope
            tilted = we / ee + np.sqrt(dot(c, c)) * slope / (ee * np.sqrt(np.maximum(rest2, zero)))
            larger = np.where(slope > 0, one, zero)
            s = np.where(rest2 > 0, np.minimum(np.maximum(tilted, zero), one), larger)
    r = np.where((s >= 1)[..., None], p - end, w - s[..., None] * e)
    distance = np.sqrt(dot(r, r))
    if surface:
        distance = distance - np.where(s >= 1, r1, r0 + s * slope)
    return s, distance / f(scale)


@pytest.mark.parametrize("name", [name for name in nasty.SCENES if name != "empty"])
@pytest.mark.parametrize("kind", ["segments", "round cones", "spheres"])
def test_bits_are_those_of_the_definition(kind: str, name: str) -> None:
    case = cases(0)[name]
    lines, points = ALL_KINDS[kind](case.segments), points_of(case, 0)
    frame = frame_of(lines.segments.reshape(-1, 3))
    for to in ("axis", "surface"):
        surface = to == "surface" and kind != "segments"
        s, distance = by_definition(lines.segments, lines.end_radii, points, surface, frame)
        order = np.argsort(distance, axis=1, kind="stable")
        found = fl.build(lines).nearest(points, len(lines) if len(lines) > 1 else 1, to=to)
        prim = found.prim.reshape(len(points), -1)
        assert np.array_equal(prim, order)
        assert np.array_equal(found.distance.reshape(prim.shape), np.take_along_axis(distance, order, axis=1))
        assert np.array_equal(found.u.reshape(prim.shape), np.take_along_axis(s, order, axis=1))


def segment_distance(p: Any, ends: Any) -> Any:
    """Return the distance of each point from each segment, in float64."""
    start, e = ends[:, 0], ends[:, 1] - ends[:, 0]
    w, ee = p[:, None] - start, dot(e, e)
    s = np.clip(dot(w, e) / np.where(ee > 0, ee, 1), 0, 1)
    return np.linalg.norm(w - s[..., None] * e, axis=2)


def cone_distance(p: Any, ends: Any, radii: Any) -> Any:
    """Return the least distance less radius over many places of each axis, refined by thirds: it is convex."""
    low, high = np.zeros((len(p), len(ends))), np.ones((len(p), len(ends)))

    def at(s: Any) -> Any:
        axis = ends[:, 0] + s[..., None] * (ends[:, 1] - ends[:, 0])
        return np.linalg.norm(p[:, None] - axis, axis=2) - (radii[:, 0] + s * (radii[:, 1] - radii[:, 0]))

    for _ in range(80):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        is_left = at(a) < at(b)
        low, high = np.where(is_left, low, a), np.where(is_left, b, high)
    return np.minimum(at(low), np.minimum(at(np.zeros_like(low)), at(np.ones_like(low))))


def triangle_distance(p: Any, corners: Any) -> Any:
    """Return the distance of each point from each triangle: of its edges, or from its plane over its inside."""
    edges = [segment_distance(p, corners[:, [i, (i + 1) % 3]]) for i in range(3)]
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    w, uu, uv, vv = p[:, None] - a, dot(u, u), dot(u, v), dot(v, v)
    det = uu * vv - uv * uv
    with np.errstate(all="ignore"):
        beta, gamma = (vv * dot(w, u) - uv * dot(w, v)) / det, (uu * dot(w, v) - uv * dot(w, u)) / det
        over = np.linalg.norm(w - beta[..., None] * u - gamma[..., None] * v, axis=2)
        is_over = (beta >= 0) & (gamma >= 0) & (beta + gamma <= 1) & (det > 0)
    return np.minimum(np.minimum.reduce(edges), np.where(is_over, over, np.inf))


def box_distance(p: Any, corners: Any) -> Any:
    return np.linalg.norm(np.maximum(np.maximum(corners[:, 0] - p[:, None], p[:, None] - corners[:, 1]), 0), axis=2)


def in_float64(kind: str, made: Any, points: Any, to: str) -> Any:
    if kind in ("segments", "round cones", "spheres"):
        ends = made.segments.astype(np.float64)
        if to == "surface" and kind != "segments":
            return cone_distance(points, ends, made.end_radii.astype(np.float64))
        return segment_distance(points, ends)
    if kind == "curves":
        pieces, owner = made.pieces.lines, made.owner
        found = in_float64("round cones", pieces, points, to)
        return np.stack([found[:, owner == i].min(axis=1) for i in range(len(made))], axis=1)
    if kind == "a mixture":
        parts = zip(("triangles", "round cones", "boxes", "curves"), made.parts, strict=True)
        return np.concatenate([in_float64(name, part, points, to) for name, part in parts if len(part)], axis=1)
    if kind == "one's own":
        return np.linalg.norm(points[:, None] - made.source.centre, axis=2) - made.source.own
    corners = made.corners.astype(np.float64)
    return (triangle_distance if kind == "triangles" else box_distance)(points, corners)


@pytest.mark.parametrize(
    "name", [name for name in nasty.SCENES if name not in ("empty", "moved 1e4", "hair moved 1e5")]
)
@pytest.mark.parametrize("kind", ALL_KINDS)
def test_distances_are_those_of_float64_within_a_band(kind: str, name: str) -> None:
    """These scenes reach 0.8 of half the band, which is 2⁻²¹ of the scene's size, with radii, and of the distance."""
    case = cases(0)[name]
    made = as_geometry(ALL_KINDS[kind](case.segments))
    size = float(np.ptp(made.bounds, axis=0).max()) + 2 * made.max_radius or 1.0
    # Pieces of curves differ from them by a tolerance.
    off = max(getattr(part, "tolerance", None) or 0.0 for part in made.each_part())
    points = points_of(case, 0)
    points = points[np.abs(points).max(axis=1) < 1e5 * size]
    for to in ("axis", "surface"):
        exact = in_float64(kind, made, points, to)
        rows = np.arange(len(points))
        band = 4 * EPS * (size + np.abs(exact).min(axis=1))
        nearest = fl.build(made).nearest(points, to=to)
        assert (np.abs(nearest.distance - exact.min(axis=1)) <= band).all()
        assert (np.abs(exact[rows, nearest.prim_number] - exact.min(axis=1)) <= 2 * band).all()
        radius = 0.3 * size
        within = fl.build(made).within(points, radius, to=to)
        inside = np.zeros(exact.shape, bool)
        inside[within.point, within.prim_number] = True
        clear = np.abs(exact - radius) > band[:, None]
        assert ((inside == (exact <= radius)) | ~clear).all()
        # The point that is named is as near.
        away = np.linalg.norm(nearest.points() - points, axis=1)
        is_thick = to == "surface" and kind != "segments"
        expected = np.abs(nearest.distance) if is_thick or kind == "one's own" else nearest.distance
        assert (np.abs(away - expected) <= 2 * (band + off)).all()


@pytest.mark.parametrize("is_thick", [False, True])
def test_distances_of_points_far_away(is_thick: bool) -> None:
    """There six roundings add up, and a few of many points are off by more than half the band."""
    rng, n = np.random.default_rng(0), 20_000
    ends = rng.uniform(-1, 1, (8, 2, 3)).astype(np.float32)
    radius = 0.05 * rng.random((8, 2)) if is_thick else None
    lines = fl.Lines.from_segments(ends, radius=radius)
    away = rng.normal(0, 1, (n, 3))
    points = away / np.linalg.norm(away, axis=1, keepdims=True) * 10 ** rng.uniform(1, 5, (n, 1))
    exact = in_float64("round cones" if is_thick else "segments", lines, points, "surface").min(axis=1)
    size = float(np.ptp(lines.bounds, axis=0).max()) + 2 * lines.max_radius
    off = np.abs(fl.build(lines).nearest(points).distance - exact) / (size + exact)
    assert 0.6 * 2.0**-22 < off.max() <= 2.0**-21
