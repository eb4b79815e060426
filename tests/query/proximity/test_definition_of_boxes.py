"""What is in a box, by its definition: in rational numbers, and by a search for the nearest point in float64."""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import cases
from support.boxes import boxes_on, matrix
from support.builds import ALL_KINDS

import fastlines as fl


def has_segment(segment: Any, low: Any, high: Any) -> bool:
    """Decide by rational numbers."""
    s0, s1 = Fraction(0), Fraction(1)
    for p, q, lo, hi in zip(*segment.tolist(), low.tolist(), high.tolist(), strict=True):
        start, along = Fraction(p), Fraction(q) - Fraction(p)
        for sign, side in ((1, lo), (-1, hi)):
            if np.isinf(side):
                continue
            # sign · (start + s · along - side) >= 0
            slope, rest = sign * along, sign * (Fraction(side) - start)
            if slope == 0:
                if rest > 0:
                    return False
            elif slope > 0:
                s0 = max(s0, rest / slope)
            else:
                s1 = min(s1, rest / slope)
    return s0 <= s1


def has_triangle(corners: Any, low: Any, high: Any) -> bool:
    """Cut the polygon by each side, in rational numbers."""
    polygon = [[Fraction(x) for x in corner] for corner in corners.tolist()]
    for k, sides in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        for sign, side in zip((1, -1), sides, strict=True):
            if np.isinf(side):
                continue
            plane, kept = Fraction(side), []
            for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
                da, db = sign * (a[k] - plane), sign * (b[k] - plane)
                if da >= 0:
                    kept.append(a)
                if da * db < 0:
                    kept.append([x + da / (da - db) * (y - x) for x, y in zip(a, b, strict=True)])
            polygon = kept
    return bool(polygon)


def band_of(segments: Any, low: Any, high: Any) -> float:
    corners = np.concatenate([low, high, np.asarray(segments, float).reshape(-1, 3)])
    return float(np.abs(corners[np.isfinite(corners)]).max(initial=0)) * 2.0**-48


@pytest.mark.parametrize("name", ["random", "hair", "axis parallel", "equal boxes", "some points", "flat", "moved 1e4"])
@pytest.mark.parametrize("kind", ["segments", "triangles"])
def test_rational_numbers_agree(kind: str, name: str) -> None:
    """Whatever is in a box that is smaller by rounding is in it, and nothing that is not in one that is larger."""
    segments = cases(1)[name].segments
    low, high = boxes_on(segments, 1, 24)
    geometry = ALL_KINDS[kind](segments)
    rows = geometry.core_rows[:, :9] if kind == "triangles" else geometry.core_rows
    decide = has_triangle if kind == "triangles" else has_segment
    found = matrix(fl.brute_force_in_box(geometry, low, high), len(geometry))
    band = band_of(segments, low, high)
    n_exact = 0
    for i, j in itertools.product(range(len(low)), range(len(rows))):
        points = rows[j].astype(np.float64).reshape(-1, 3)
        exact = decide(points, low[i], high[i])
        n_exact += exact == found[i, j]
        if exact != found[i, j]:
            grow = -band if exact else band
            assert decide(points, low[i] - grow, high[i] + grow) == found[i, j], (i, j)
    assert n_exact > 0.99 * found.size


@pytest.mark.parametrize("name", ["random", "hair", "duplicates", "points", "collinear"])
@pytest.mark.parametrize("kind", ["round cones", "spheres"])
def test_thick_lines_by_search(kind: str, name: str) -> None:
    """The least distance of the axis from a box, less the radius, decides; it is convex, and searched in float64."""
    segments = cases(2)[name].segments
    low, high = boxes_on(segments, 2)
    geometry = ALL_KINDS[kind](segments)
    found = matrix(fl.brute_force_in_box(geometry, low, high), len(geometry))
    rows = geometry.cone_rows.astype(np.float64)
    p, q, r0, r1 = rows[:, 0:3], rows[:, 3:6], rows[:, 6], rows[:, 7]

    def gap(s: Any) -> Any:
        x = p + s[..., None] * (q - p)
        outside = np.maximum(np.maximum(low[:, None] - x, x - high[:, None]), 0)
        return np.sqrt((outside**2).sum(axis=-1)) - (r0 + s * (r1 - r0))

    a, b = np.zeros(found.shape), np.ones(found.shape)
    for _ in range(120):
        third = (b - a) / 3
        left = gap(a + third) <= gap(b - third)
        a, b = np.where(left, a, a + third), np.where(left, b - third, b)
    least = np.minimum(gap((a + b) / 2), np.minimum(gap(np.zeros(found.shape)), gap(np.ones(found.shape))))
    band = 1e-12 * nasty.size_of(segments)
    assert found[least < -band].all()
    assert not found[least > band].any()
    axis = matrix(fl.brute_force_in_box(geometry, low, high, to="axis"), len(geometry))
    assert (axis <= found).all()
    assert 0 < axis.sum() < found.sum() < found.size


def test_a_larger_box_has_more() -> None:
    segments = cases(3)["random"].segments
    low, high = boxes_on(segments, 3)
    found = matrix(fl.brute_force_in_box(segments, low, high), len(segments))
    larger = matrix(fl.brute_force_in_box(segments, low - 1e-3, high), len(segments))
    assert (found <= larger).all()
