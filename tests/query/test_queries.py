"""What queries promise: relations between answers, tight radii, and shapes that follow those of the question."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import assert_same, cases, options, question
from support.builds import build
from support.slow import few_of

import fastlines as fl
from fastlines.query.backend import KERNELS
from fastlines.query.queries import QUERIES, Query
from fastlines.query.ray_arguments import RayArguments
from fastlines.query.rays import check_rays

SEEDS = range(8)


def check_relations(all_hits: fl.AllHits, first: fl.FirstHits, n_rays: int) -> None:
    """Sorted by (ray, t, prim), no segment twice, the first is the first."""
    ray, t, prim = all_hits.ray, all_hits.t, all_hits.prim
    assert (np.lexsort((prim, t, ray)) == np.arange(len(ray))).all()
    assert len(np.unique(np.stack([ray, prim]), axis=1).T) == len(ray)
    some = all_hits.counts > 0
    assert (first.hit == some).all()
    at = all_hits.offsets[:-1][some]
    for name in ("t", "prim", "u", "distance", "t_out"):
        one, many = getattr(first, name), getattr(all_hits, name)
        assert one is None or (one[some] == many[at]).all(), name
    assert np.isinf(first.t[~some]).all()
    assert (first.prim[~some] == -1).all()
    assert np.isinf(first.distance[~some]).all()


@pytest.mark.parametrize("name", nasty.NAMES)
@pytest.mark.parametrize("seed", few_of(SEEDS))
def test_relations_that_must_hold(seed: int, name: str) -> None:
    case = cases(seed)[name]
    asked, n_rays = question(case)
    answers = {
        (query, at): fl.brute_force(case.segments, **asked, query=query, at=at)
        for query in ("first_hit", "all_hits")
        for at in ("closest", "surface")
    }
    closest, surface = answers["all_hits", "closest"], answers["all_hits", "surface"]
    check_relations(closest, answers["first_hit", "closest"], n_rays)
    check_relations(surface, answers["first_hit", "surface"], n_rays)
    assert (fl.brute_force(case.segments, **asked, query="count_hits") == closest.counts).all()
    assert (fl.brute_force(case.segments, **asked, query="any_hit") == (closest.counts > 0)).all()

    # Both kinds of t tell of the same hits; the capsule is entered first.
    order = [np.lexsort((hits.prim, hits.ray)) for hits in (closest, surface)]
    for column in ("prim", "ray", "distance"):
        assert (getattr(closest, column)[order[0]] == getattr(surface, column)[order[1]]).all()
    t_in, t, t_out = surface.t[order[1]], closest.t[order[0]], surface.t_out[order[1]]
    slack = 1e-4 * nasty.size_of(case.segments) / np.linalg.norm(asked["directions"].astype(float), axis=1)
    slack = slack[closest.ray[order[0]]] * (1 + asked["radius"].max() / nasty.size_of(case.segments))
    assert (t_in <= t + slack).all()
    assert (t_in <= t_out).all()
    assert (t_in >= np.broadcast_to(asked["t_min"], n_rays * 5)[surface.ray[order[1]]]).all()
    assert (t_out <= np.broadcast_to(asked["t_max"], n_rays * 5)[surface.ray[order[1]]]).all()

    # Hits at a smaller radius are hits at a larger one: zero ⊆ small ⊆ medium ⊆ large.
    hit = np.zeros((5 * n_rays, len(case.segments)), bool)
    hit[closest.ray, closest.prim] = True
    hit = hit.reshape(5, n_rays, -1)
    for smaller in range(3):
        assert not (hit[smaller] & ~hit[smaller + 1]).any()


@pytest.mark.parametrize("name", nasty.NAMES)
@pytest.mark.parametrize("seed", few_of(range(3), n=1))
def test_radius_of_exactly_the_distance(seed: int, name: str) -> None:
    """The boxes can not be tighter: each ray asks with its own distance to a segment, and the next float."""
    case = cases(seed, 40, 720)[name]
    rng = np.random.default_rng(seed)
    hits = fl.brute_force(case.segments, *case[1:3], case.radii["medium"], t_min=case.t_min, t_max=case.t_max)
    some = hits.counts > 0
    chosen = hits.offsets[:-1][some] + rng.integers(0, 1 << 40, some.sum()) % hits.counts[some]
    bounds = {
        name: bound if np.ndim(bound) == 0 else bound[some]
        for name, bound in (("t_min", case.t_min), ("t_max", case.t_max))
    }
    trees = [build(case.segments, method=method) for method in fl.METHODS]
    for radius in (hits.distance[chosen], np.nextafter(hits.distance[chosen], np.float32(np.inf))):
        asked = {"origins": case.origins[some], "directions": case.directions[some], "radius": radius, **bounds}
        for at in ("closest", "surface"):
            for query in ("first_hit", "all_hits"):
                expected = fl.brute_force(case.segments, **asked, query=query, at=at)
                for tree in trees:
                    assert_same(getattr(tree, query)(**asked, at=at), expected)


@pytest.mark.parametrize("method", fl.METHODS)
@pytest.mark.parametrize("distance", few_of([0, 1e3, 1e4, 1e5], n=1))
def test_nothing_is_lost_far_from_the_origin(distance: float, method: str) -> None:
    """Cut points are rounded to the grid of the coordinates, which is coarse there."""
    rng = np.random.default_rng(int(distance) + 1)
    segments = (nasty.hair(rng, 80) + distance * np.array([1, -1, 0.3])).astype(np.float32)
    size = nasty.size_of(segments)
    rays = nasty.from_distance(1)(rng, segments.astype(float), 20_000, size)
    tree = build(segments, method=method)
    for radius in (1e-4 * size, 1e-3 * size):
        counts = fl.brute_force(segments, *rays, radius, query="count_hits")
        assert np.abs(tree.count_hits(*rays, radius) - counts).sum() == 0, f"{counts.sum()} hits in all"


@pytest.mark.parametrize(
    "where", ["nowhere", "at the first", "at the last", "at some", "but seldom where looked first"]
)
@pytest.mark.parametrize("query", ["all_hits", "next_hits"])
def test_lists_of_which_rays_does_not_matter(where: str, query: str) -> None:
    """How many hits there will be is guessed from a fourth of the rays, and may be far off."""
    n_rays, n_lines = 9000, 40
    i = np.arange(n_rays)
    hit = {
        "nowhere": i < 0,
        "at the first": i == 0,
        "at the last": i == n_rays - 1,
        "at some": i % 700 < 30,
        "but seldom where looked first": (i // 64 % 4 != 0) & (i // 256 % 4 != 0) & (i // 1024 % 4 != 0),
    }[where]
    x = np.linspace(-1, 1, n_lines)
    segments = np.stack([np.stack([x, -(x**0), x], 1), np.stack([-x, x**0, x], 1)], axis=1).astype(np.float32)
    origins = np.where(hit[:, None], [0, 0, -2], [5, 0, -2]) + np.random.default_rng(2).normal(0, 1e-3, (n_rays, 3))
    tree = fl.build(segments)
    asked = {"radius": 0.1, "at": "surface"} | options(query)
    expected = fl.brute_force(segments, origins, [0, 0, 1], query=query, **asked)
    assert len(expected) == hit.sum() * (n_lines if query == "all_hits" else asked["k"])
    try:
        for n_threads in (1, 3):
            fl.set_num_threads(n_threads)
            for kernel in KERNELS:
                assert_same(getattr(tree, query)(origins, [0, 0, 1], **asked, kernel=kernel), expected)
    finally:
        fl.set_num_threads(None)


@pytest.mark.parametrize("query", QUERIES)
def test_one_number_for_all_rays_is_that_number_for_each(query: str) -> None:
    case = cases(2)["window per ray"]
    tree = build(case.segments, method="bvh-d2")

    def ask(directions: Any, radius: Any, **bounds: Any) -> Any:
        return getattr(tree, query)(case.origins, directions, radius, **options(query), **bounds)

    each = np.full(len(case.origins), 0.05, np.float32)
    expected = ask(case.directions, each, t_min=0 * each + 0.5, t_max=each * 60)
    assert_same(ask(case.directions, 0.05, t_min=0.5, t_max=np.float32(0.05) * 60), expected)
    tiled = np.tile(case.directions[0], (len(case.origins), 1))
    assert_same(ask(case.directions[0], 0.05), ask(tiled, 0.05))


SHAPES = [
    ((3,), (3,), ()),
    ((1, 3), (1, 3), (1,)),
    ((7, 3), (7, 3), (7,)),
    ((4, 5, 3), (4, 5, 3), (4, 5)),
    ((3,), (4, 5, 3), (4, 5)),
    ((7, 3), (3,), (7,)),
    ((4, 1, 3), (5, 3), (4, 5)),
    ((2, 1, 3, 3), (1, 4, 1, 3), (2, 4, 3)),
    ((0, 3), (0, 3), (0,)),
    ((0, 3), (3,), (0,)),
    ((4, 0, 3), (4, 0, 3), (4, 0)),
    ((300, 0, 3), (3,), (300, 0)),
]


@pytest.mark.parametrize(("origins", "directions", "shape"), SHAPES)
def test_shape_of_the_answer_follows_the_question(
    origins: tuple[int, ...], directions: tuple[int, ...], shape: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(0)
    segments = nasty.crossing(rng, 30).astype(np.float32)
    tree = build(segments, method="bvh-d2")
    o, d = rng.uniform(-1, 1, origins), rng.normal(0, 1, directions)
    per_ray = rng.uniform(0, 0.3, shape)
    for radius in (0.2, per_ray):
        first = tree.first_hit(o, d, radius, at="surface")
        for name, dtype in {
            "t": np.float32,
            "prim": np.int64,
            "u": np.float32,
            "distance": np.float32,
            "t_out": np.float32,
        }.items():
            column = getattr(first, name)
            assert isinstance(column, np.ndarray)
            assert (column.shape, column.dtype) == (shape, dtype)
        assert first.hit.shape == shape
        found, counts, every = (
            tree.any_hit(o, d, radius),
            tree.count_hits(o, d, radius),
            tree.all_hits(o, d, radius),
        )
        assert (found.shape, found.dtype) == (shape, np.bool_)
        assert (counts.shape, counts.dtype) == (shape, np.int64)
        assert every.offsets.shape == (found.size + 1,)
        assert (every.counts.reshape(shape) == counts).all()
        assert first.t_out is not None
        assert tree.first_hit(o, d, radius).t_out is None
        # Row by row it is the same as all at once.
        flat_o = np.broadcast_to(o, (*shape, 3)).reshape(-1, 3)
        flat_d = np.broadcast_to(d, (*shape, 3)).reshape(-1, 3)
        for i, r in enumerate(np.broadcast_to(radius, shape).reshape(-1)):
            one = tree.first_hit(flat_o[i], flat_d[i], r, at="surface")
            assert (one.t, one.prim) == (first.t.reshape(-1)[i], first.prim.reshape(-1)[i])
            assert (every.prim[every.of(i)] == tree.all_hits(flat_o[i], flat_d[i], r).prim).all()


@pytest.mark.parametrize("ray", [-1, 3, 99])
def test_hits_of_no_ray(ray: int) -> None:
    tree = fl.build(np.array([[[0, 0, 0], [1, 0, 0]]], np.float32))
    hits = tree.all_hits(np.zeros((3, 3)), [0, 0, 1], 0.5)
    assert [hits.of(i) for i in range(3)] == [slice(i, i + 1) for i in range(3)]
    with pytest.raises(fl.InputError, match=f"ray={ray}; expected a whole number from 0 to below 3"):
        hits.of(ray)


class NoRoom:
    """A backend that finds no memory for any answer."""

    def first_hit(self, *_: object) -> Any:
        raise MemoryError("std::bad_alloc")

    any_hit = count_hits = list_hits = first_hit


def test_lists_that_do_not_fit_into_memory_say_what_to_do() -> None:
    lines = fl.Lines.from_segments([[[0, 0, 0], [1, 1, 1]]])
    query = Query(NoRoom(), check_rays(RayArguments(np.zeros((3, 3)), [0, 0, 1], 0.5), lines.bounds), lines)
    with pytest.raises(MemoryError, match=r"hits of 3 rays.*next_hits.*count_hits"):
        query.all_hits()
    with pytest.raises(MemoryError, match=r"hits of 3 rays.*a smaller k"):
        query.next_hits(5)
    with pytest.raises(MemoryError, match="bad_alloc"):
        query.count_hits()


def test_answers_are_shown_in_a_line():
    tree = fl.build([[[0, 0, 0], [1, 1, 1]]])
    rays = np.tile([0.5, 0.5, -5], (1000, 1)), [0, 0, 1]
    assert repr(tree.first_hit(*rays, 0.1)) == "<FirstHits: 1,000 rays, 1,000 hit>"
    assert repr(tree.all_hits(*rays, 0.1)) == "<AllHits: 1,000 rays, 1,000 hits>"
    assert re.fullmatch(r"<Layout: 1 node, 1 leaf, \d+ references?, [\d,]+ bytes with primitives>", repr(tree.layout))
