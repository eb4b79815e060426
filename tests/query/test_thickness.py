"""Lines with a radius of their own, spheres, and hits ranked by their distance from the ray."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.answers import assert_same

import fastlines as fl
from fastlines.query.backend import KERNELS

N_RAYS = 3000


def segments(n: int = 200, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    start = rng.random((n, 3))
    return np.stack([start, start + rng.normal(size=(n, 3)) * 0.2], axis=1).astype(np.float32)


def rays(n: int = N_RAYS, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(n, 3)).astype(np.float32)
    return (rng.random((n, 3)) - 2 * directions).astype(np.float32), directions


def test_lines_without_a_radius_need_one() -> None:
    lines = fl.Lines.from_segments(segments())
    for ask in (fl.build(lines).first_hit, lambda *rays: fl.brute_force(lines, *rays)):
        with pytest.raises(fl.InputError, match=r"these lines have no radius of their own, so a query needs one"):
            ask(*rays())


@pytest.mark.parametrize("shape", [(), (2,)], ids=["a segment", "an end"])
def test_a_radius_for_all_is_that_of_a_query(shape: tuple[int, ...]) -> None:
    ends = segments()
    thick = fl.Lines.from_segments(ends, radius=np.full((len(ends), *shape), 0.02))
    for at in ("closest", "surface"):
        own = fl.build(thick).all_hits(*rays(), 0.01, at=at)
        plain = fl.build(ends).all_hits(*rays(), 0.03, at=at)
        same = np.intersect1d(own.ray << 32 | own.prim, plain.ray << 32 | plain.prim)
        assert len(own) > 1000
        assert len(same) >= 0.999 * max(len(own), len(plain))  # up to rounding
    assert np.allclose(np.sort(own.t), np.sort(plain.t), atol=1e-4)


def test_a_radius_of_zero_gives_the_bits_of_segments() -> None:
    ends = segments()
    thick = fl.Lines.from_segments(ends, radius=np.zeros(len(ends)))
    for query in ("first_hit", "all_hits", "any_hit", "count_hits"):
        assert_same(getattr(fl.build(thick), query)(*rays(), 0.03), getattr(fl.build(ends), query)(*rays(), 0.03))


def test_own_radius_can_be_left_out() -> None:
    ends = segments()
    lines = fl.Lines.from_segments(ends, radius=np.full(len(ends), 0.1), attributes={"a": np.arange(len(ends))})
    tree = fl.build(lines, own_radius=False)
    assert tree.geometry.radius is None
    assert tree.geometry.attributes["a"] is lines.attributes["a"]
    assert_same(tree.all_hits(*rays(), 0.03), fl.build(ends).all_hits(*rays(), 0.03))
    with pytest.raises(fl.InputError, match="have no radius of their own"):
        tree.first_hit(*rays())
    assert fl.build(fl.Spheres.from_centres([[0, 0, 0]], 1), own_radius=False).geometry.radius is None


def test_what_has_no_own_radius_to_leave_out_says_what_to_do() -> None:
    mesh = fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    curves = fl.Curves.from_bezier(np.eye(4, 3)[None], radius=0.1)
    for given, words in (
        (
            fl.Geometry([mesh, curves]),
            r"this is a Geometry; leave it out, or drop the radius of part 1 \(1 curve\) first",
        ),
        (
            curves,
            r"these are Curves; leave it out, or drop the radius first: dataclasses\.replace\(part, radius=None\)",
        ),
        (mesh, "these are Triangles; leave it out$"),
    ):
        with pytest.raises(fl.InputError, match=f"own_radius=False is for lines, {words}"):
            fl.build(given, own_radius=False)
    assert replace(curves, radius=None).radius is None


def test_radii_move_with_a_refit_and_stay_in_files(tmp_path: Path) -> None:
    ends = segments()
    tree = fl.build(fl.Lines.from_segments(ends, radius=np.full(len(ends), 0.01)))
    tree.layout  # noqa: B018  (so that it is refitted too)
    thicker = fl.Lines.from_segments(ends, radius=np.linspace(0, 0.1, len(ends)))
    for refitted in (tree.refit(thicker), fl.build(ends).refit(thicker)):
        assert_same(refitted.all_hits(*rays()), fl.brute_force(thicker, *rays()))
    assert_same(tree.refit(ends + 1).all_hits(*rays()), fl.brute_force(tree.refit(ends + 1).geometry, *rays()))
    fl.build(thicker).save(tmp_path / "a.flt")
    assert_same(fl.load(tmp_path / "a.flt").all_hits(*rays()), fl.brute_force(thicker, *rays()))


def test_radii_of_every_size_are_exact() -> None:
    """Balls from nothing to more than the scene, in one tree."""
    rng = np.random.default_rng(2)
    spheres = fl.Spheres.from_centres(rng.random((100, 3)), 10.0 ** rng.uniform(-8, 1, 100))
    origins, directions = rays()
    hits = fl.build(spheres).all_hits(origins - 30 * directions, directions, at="surface")
    o, d = (origins - 30 * directions).astype(np.float32).astype(np.float64), directions.astype(np.float64)
    centres, radius = spheres.centres.astype(np.float64), spheres.radius.astype(np.float64)
    offset = centres - o[:, None]
    along = (offset * d[:, None]).sum(-1) / (d**2).sum(-1)[:, None]
    gap = np.sqrt(((offset - along[..., None] * d[:, None]) ** 2).sum(-1)) - radius
    found = np.zeros(gap.shape, bool)
    found[hits.ray, hits.prim] = True
    assert (found == (gap <= 0))[np.abs(gap) > 1e-5].all()
    assert found.sum() == len(hits) > 1000


@pytest.mark.parametrize("at", ["closest", "surface"])
@pytest.mark.parametrize("size", [10, 1000])
def test_coherent_rays_hit_balls_far_larger_than_the_scene_of_their_centres(size: float, at: str) -> None:
    rng = np.random.default_rng(0)
    spheres = fl.Spheres.from_centres(rng.uniform(-1, 1, (100, 3)), size * rng.uniform(0.9, 1.1, 100))
    y, x = np.meshgrid(*[np.linspace(-0.5, 0.5, 16)] * 2)
    origins = np.stack([x, y, np.full_like(x, -5 * size)], axis=-1).reshape(-1, 3)
    tree = fl.build(spheres)
    for bounds in ({}, {"t_max": 4.3 * size}, {"t_min": 5.6 * size}, {"t_min": 4.5 * size, "t_max": 4.6 * size}):
        for query in ("first_hit", "all_hits"):
            expected = fl.brute_force(spheres, origins, [0, 0, 1], query=query, at=at, **bounds)
            assert (expected.prim >= 0).sum() >= 256
            for kernel in KERNELS:
                got = getattr(tree, query)(origins, [0, 0, 1], at=at, kernel=kernel, **bounds)
                assert_same(got, expected, f"{kernel}, {bounds}, {query}")


@pytest.mark.parametrize("radius", [1e31, np.inf, np.nan, -1.0])
def test_radii_that_no_query_can_use_are_refused(radius: float) -> None:
    with pytest.raises(fl.InputError, match=r"radius: 1 of 1 are not numbers from 0 to 1e\+30 \(row 0\)"):
        fl.Lines.from_segments(segments(1), radius=[radius])


def test_segments_with_such_radii_can_be_skipped() -> None:
    lines = fl.Lines.from_segments(segments(3), radius=[1, np.nan, 2], invalid="skip")
    assert lines.radius.tolist() == [1, 2]
    assert lines.skipped.tolist() == [1]


def test_a_radius_far_larger_than_the_scene_is_refused_by_queries() -> None:
    tree = fl.build(fl.Lines.from_segments(segments(3), radius=[1e20, 1, 1]))
    with pytest.raises(fl.InputError, match=r"the largest radius of the lines, 1e\+20, is more than 1e\+12 times"):
        tree.first_hit(*rays())


def test_spheres_are_checked() -> None:
    assert len(fl.Spheres.from_centres([], 1)) == 0
    with pytest.raises(fl.InputError, match=r"centres have shape \(2, 2\); expected \(n, 3\)"):
        fl.Spheres.from_centres([[0, 0], [1, 1]], 1)
    with pytest.raises(fl.InputError, match="spheres have segments of length zero"):
        fl.Spheres(segments(1), radius=np.ones(1, np.float32))
    skipped = fl.Spheres.from_centres([[0, 0, np.nan], [1, 1, 1]], [1, 2], invalid="skip")
    assert skipped.centres.tolist() == [[1, 1, 1]]
    assert skipped.radius.tolist() == [2]


def test_the_nearest_to_the_ray_of_six_lines() -> None:
    heights = np.array([0.5, 0.3, 0.1, 0.2, 0.4, 0.1])
    ends = np.array([[[-1, y, z], [1, y, z]] for z, y in enumerate(heights)])
    tree = fl.build(ends)
    ray = [0, 0, -5], [0, 0, 1], 1.0
    assert tree.next_hits(*ray, k=1, rank="distance").prim.tolist() == [2]  # of two equally near, the lower t
    hits = tree.next_hits(*ray, k=9, rank="distance")
    assert hits.prim.tolist() == [2, 5, 3, 1, 4, 0]
    assert np.allclose(hits.distance, np.sort(heights))
    assert tree.next_hits(*ray, k=0, rank="distance").prim.tolist() == []
    assert tree.next_hits(*ray, k=1).prim.tolist() == [0]
    with pytest.raises(fl.InputError, match="next_hits needs k="):
        tree.next_hits(*ray)
    with pytest.raises(fl.InputError, match="rank='near' is not a choice"):
        tree.next_hits(*ray, k=1, rank="near")
    with pytest.raises(fl.InputError, match="rank='distance' is for query='next_hits'"):
        fl.brute_force(ends, *ray, query="all_hits", rank="distance")


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("at", ["closest", "surface"])
def test_ranked_hits_are_the_nearest_of_all(at: str, kernel: str) -> None:
    ends = segments()
    tree = fl.build(fl.Lines.from_segments(ends, radius=np.linspace(0, 0.05, len(ends))))
    every = tree.all_hits(*rays(), 0.02, at=at)
    order = np.lexsort((every.prim, every.t, every.distance, every.ray))
    rank = np.arange(len(every)) - np.repeat(every.offsets[:-1], every.counts)
    expected = order[rank < 4]
    ranked = tree.next_hits(*rays(), 0.02, 4, rank="distance", at=at, kernel=kernel)
    assert np.array_equal(ranked.counts, np.minimum(every.counts, 4))
    for column in ("prim", "t", "u", "distance", *(["t_out"] if at == "surface" else [])):
        assert np.array_equal(getattr(ranked, column), getattr(every, column)[expected]), column
