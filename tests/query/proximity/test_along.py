"""Primitives along a bent needle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support import nasty

import fastlines as fl

NEEDLE = np.array([[-1, 0, 0.1], [0, 0, 0], [0.5, 0.5, 0.2], [0.5, 2, 0.2]])


def hair() -> fl.Lines:
    ends = nasty.hair(np.random.default_rng(3), 2400).astype(np.float32)
    return fl.Lines(ends, np.arange(len(ends)) // 8)


@pytest.mark.parametrize("to", ["axis", "surface"])
def test_along_is_the_best_of_all_pairs(to: str) -> None:
    lines = hair().with_radius(0.02)
    found = fl.build(lines).along(NEEDLE, 0.1, to=to)
    needle = np.stack([NEEDLE[:-1], NEEDLE[1:]], axis=1)
    pairs = fl.brute_force_pairs(needle, 0.1, lines, to=to)
    order = np.lexsort((pairs.i, pairs.distance, pairs.j))
    prim, first = np.unique(pairs.j[order], return_index=True)
    best = order[first]
    assert len(found) > 20
    assert np.array_equal(found.prim, prim)
    assert np.array_equal(found.u, pairs.t[best])
    assert np.array_equal(found.distance, pairs.distance[best])
    assert np.array_equal(found.segment, pairs.i[best])
    assert np.array_equal(found.s, pairs.s[best])
    assert np.array_equal(found.position, found.segment + found.s.astype(np.float64))
    assert np.array_equal(found.strand, lines.strands[found.prim])


def test_along_knows_points_and_attributes() -> None:
    lines = fl.Lines.from_strands([[[5, 0, 0], [9, 0, 0]]], attributes={"a": [0.0, 1.0]}, offset=[5, 0, 0])
    found = fl.build(lines).along([[6, 1, 0], [6, 9, 0]], 1)
    assert (found.points().tolist(), found.distance.tolist()) == ([[6, 0, 0]], [1])
    assert (found.sample("a").tolist(), found.row.tolist(), repr(found)) == ([0.25], [0], "<Along: 1 primitive>")
    assert found.tangents().tolist() == [[1, 0, 0]]


def test_along_many_segments() -> None:
    lines = hair()
    angle = np.linspace(0, 20, 500)
    helix = np.stack([np.cos(angle), np.sin(angle), angle / 20], axis=1) * 0.8
    found = fl.build(lines).along(helix, 0.05)
    pairs = fl.brute_force_pairs(np.stack([helix[:-1], helix[1:]], axis=1), 0.05, lines)
    assert np.array_equal(found.prim, np.unique(pairs.j))
    assert len(found) > 20


def test_ends_far_away_do_not_make_distances_coarse() -> None:
    tree = fl.build(hair().with_radius(0.02))
    middle, step = np.array([0.1, 0.2, 0.1]), np.array([0.3, -0.5, 0.81])
    near = tree.along([middle - 4 * step, middle + 4 * step], 0.1)
    far = tree.along([[1e7, 9, 0], middle - 1e7 * step, middle + 1e7 * step, [0, 1e8, 0]], 0.1)
    assert len(near) > 20
    assert np.array_equal(far.prim, near.prim)
    assert np.allclose(far.distance, near.distance, rtol=0, atol=2.0**-20)
    assert np.allclose(far.u, near.u, rtol=0, atol=1e-4)
    assert (set(far.segment), set(far.s.round(5))) == ({1}, {0.5})
    # Both ends are in the scene's box, but for rounding; what misses it finds nothing.
    axis = fl.build([[[x, 0, 0], [x, 0, 1]] for x in range(3)]).along([[-1e9, 0, 0], [1e9, 0, 0]], 0)
    assert (axis.prim.tolist(), axis.distance.tolist()) == ([0, 1, 2], [0, 0, 0])
    assert len(tree.along([[9, -1e7, 0], [9, 1e7, 0], [1e9, 9, 9]], 0.1)) == 0


def test_curves_are_found_once() -> None:
    rng = np.random.default_rng(4)
    curves = fl.Curves.from_bezier(rng.uniform(-1, 1, (50, 4, 3)))
    spheres = fl.Spheres.from_centres(rng.uniform(-1, 1, (50, 3)), radius=0.1)
    found = fl.build(curves).along(NEEDLE, 0.2)
    assert (np.diff(found.prim) > 0).all()
    both = fl.build(fl.Geometry([spheres, curves])).along(NEEDLE, 0.2, to="axis")
    assert both.part is not None
    assert np.array_equal(both.prim[both.part == 1], found.prim)
    assert np.allclose(both.distance[both.part == 1], found.distance, atol=1e-6)


@pytest.mark.parametrize(
    ("polyline", "why"),
    [
        ([[0, 0, 0]], r"shape \(1, 3\); expected \(m, 3\), with two points or more"),
        ([0, 0, 0], r"shape \(3,\)"),
        ([[0, 0], [1, 1]], r"shape \(2, 2\)"),
        ([[0, 0, 0], [np.nan, 0, 0]], r"1 of 2 points of the polyline hold NaN, Inf or a coordinate beyond 1e\+30"),
        ([[0, 0, 0], [np.inf, 0, 0]], r"1 of 2 points of the polyline hold"),
        ("needle", r"polyline: a str cannot be read as an array of numbers"),
    ],
)
def test_polylines_are_checked(polyline: Any, why: str) -> None:
    for lines in (hair(), np.empty((0, 2, 3))):
        with pytest.raises(fl.InputError, match=why):
            fl.build(lines).along(polyline, 1)
