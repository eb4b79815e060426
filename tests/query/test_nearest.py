"""The nearest hits, and where rays enter capsules: each hit once, even if several pieces of a segment are hit."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same, cases, question

import fastlines as fl
from fastlines.query.backend import KERNELS

WIDE = [kernel for kernel in KERNELS if kernel != "binary"]


def test_next_hits_are_the_first_of_all_hits() -> None:
    case = cases(3)["crossing"]
    asked, _ = question(case)
    tree = fl.build(case.segments)
    for at in ("closest", "surface"):
        every = tree.all_hits(**asked, at=at)
        assert every.counts.max() > 33
        for k, kernel in product((0, 1, 2, 7, 16, 33, 10_000), WIDE):
            few = tree.next_hits(**asked, k=k, at=at, kernel=kernel)
            assert (few.counts == np.minimum(every.counts, k)).all()
            chosen = np.concatenate([np.arange(a, a + n) for a, n in zip(every.offsets, few.counts, strict=False)])
            for name in ("t", "prim", "u", "distance") + ("t_out",) * (at == "surface"):
                assert (getattr(few, name) == getattr(every, name)[chosen.astype(int)]).all(), name
    for kernel in ("binary", *WIDE):
        assert len(tree.next_hits(**asked, k=0, kernel=kernel).t) == 0
    assert len(fl.brute_force(case.segments, **asked, query="next_hits", k=0).t) == 0
    for k in (-1, 1.5, None, "3"):
        with pytest.raises(fl.InputError, match="k="):
            tree.next_hits(**asked, k=k)


@pytest.mark.parametrize("radius", [1e-6, 1e-3, 0.1])
def test_rays_that_graze_capsules(radius: float) -> None:
    """The piece at whose point a ray enters reports the hit, though rounding moves the entry along the ray."""
    rng = np.random.default_rng(5)
    lines = fl.scenes.make("spaghetti", n_segments=300).lines
    tree = fl.build(lines)
    assert len(tree.refs) > 3 * len(lines)
    n = 3000
    start, end = lines.segments[rng.integers(0, len(lines), n)].astype(float).transpose(1, 0, 2)
    along = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    across = np.cross(along, rng.normal(size=(n, 3)))
    across /= np.linalg.norm(across, axis=1)[:, None]
    beside = start + rng.random((n, 1)) * (end - start) + across * radius * (1 - 10 ** rng.uniform(-8, -1, (n, 1)))
    d = along + np.cross(along, across) * 10 ** rng.uniform(-7, 1, (n, 1))
    rays = {"origins": beside - d * rng.uniform(0, 2, (n, 1)), "directions": d, "radius": radius, "at": "surface"}
    expected = fl.brute_force(lines, **rays, query="next_hits", k=2)
    assert expected.counts.sum() > 0.5 * n
    for kernel in WIDE:
        assert_same(tree.next_hits(**rays, k=2, kernel=kernel), expected)
        assert_same(tree.first_hit(**rays, kernel=kernel), fl.brute_force(lines, **rays, query="first_hit"))


def everything(kind: str) -> Any:
    rng = np.random.default_rng(8)
    ends = (rng.uniform(-1, 1, (400, 1, 3)) ** 3 + rng.normal(0, 0.1, (400, 2, 3))).astype(np.float32)
    ends[50:60] = ends[40:50]  # ties
    lines = fl.Lines.from_segments(ends, radius=rng.uniform(0, 0.1, (400, 2)), strands=np.arange(400) // 8)
    control = np.einsum("ij,njk->nik", [[1, 0], [0.6, 0.5], [0.3, 0.6], [0, 1]], ends[:60])
    curves = fl.Curves.from_bezier(control, rng.uniform(0, 0.05, (60, 4)))
    triangles = fl.Triangles.from_mesh(ends[:30, 0] * 3, np.arange(30).reshape(10, 3))
    return {
        "lines": fl.Lines.from_segments(ends),
        "round cones": lines,
        "curves": curves,
        "geometry": fl.Geometry([triangles, lines, curves]),
        "one point": fl.Lines.from_segments(np.ones((3, 2, 3))),
    }[kind]


@pytest.mark.parametrize("how", ["rays", "points", "spread", "ignore", "surface"])
@pytest.mark.parametrize("kind", ["lines", "round cones", "curves", "geometry", "one point"])
def test_the_nearest_by_distance_are_those_of_brute_force(kind: str, how: str) -> None:
    """Whatever the radius is, though rays look for them within smaller ones."""
    if kind == "geometry" and how == "spread":
        return
    geometry, rng, n = everything(kind), np.random.default_rng(2), 60
    # From within and from far away, past and through the scene, for bounds of every kind.
    origins = rng.normal(size=(n, 3)) * 10 ** rng.uniform(-1, 2, (n, 1))
    directions = rng.normal(0, 1, (n, 3)) - origins
    t_min, t_max = np.where(rng.random(n) < 0.2, -np.inf, 0), np.where(rng.random(n) < 0.5, np.inf, rng.random(n))
    rays: dict[str, Any] = {"origins": origins, "directions": directions, "t_min": t_min, "t_max": t_max}
    rays["radius"] = 10.0 ** rng.integers(-2, 4, n)
    if how == "points":
        rays |= {"t_min": 0, "t_max": 0}
    elif how == "spread":
        rays["spread"] = np.where(rng.random(n) < 0.8, rng.random(n), 0)
    elif how == "ignore":
        rays["ignore"] = rng.integers(-1, len(geometry), (n, 3))
    elif how == "surface":
        rays["at"] = "surface"
    tree = fl.build(geometry)
    for k in (0, 1, 3, 10_000):
        asked = rays | {"k": k, "rank": "distance"}
        expected = fl.brute_force(geometry, **asked, query="next_hits")
        for kernel in KERNELS:
            assert_same(tree.next_hits(**asked, kernel=kernel), expected)
    all_of_each = fl.brute_force(geometry, **rays)
    assert np.array_equal(expected.counts, all_of_each.counts)
    for ray in np.flatnonzero(expected.counts):
        of_ray = all_of_each.of(ray)
        order = np.argsort(all_of_each.distance[of_ray], kind="stable")
        assert np.array_equal(expected.prim_number[expected.of(ray)], all_of_each.prim_number[of_ray][order])
