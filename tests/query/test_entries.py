"""Hits at="entry" are those of rays that come in from outside. (test_against_brute_force compares trees.)"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import assert_same, cases, question
from support.builds import ALL_KINDS

import fastlines as fl
from fastlines.query.backend import KERNELS
from fastlines.theory.hits import deepest_approach

#: Rounding decides closer to the surface than this fraction of the scene's size.
BAND = 3e-7


def crowd(kind: str, rng: np.random.Generator) -> tuple[fl.Lines, Any, Any]:
    """Return 80 thick lines that overlap, and 400 rays that start within the crowd, in any of them or in none."""
    start = rng.uniform(-1, 1, (80, 3))
    edge = rng.normal(size=(80, 3)) * (0 if kind == "balls" else 0.5)
    radii = rng.uniform(0.05, 0.4, (80, 2))
    if kind == "capsules":
        radii[:, 1] = radii[:, 0]
    lines = fl.Lines.from_segments(np.stack([start, start + edge], axis=1), radius=radii)
    origins, directions = rng.uniform(-1, 1, (400, 3)), rng.normal(size=(400, 3))
    return lines, origins.astype(np.float32), directions.astype(np.float32)


@pytest.mark.parametrize("t_min", [0.0, 0.25, -0.5])
@pytest.mark.parametrize("kind", ["capsules", "tapering", "balls"])
def test_entries_are_those_of_the_definition(kind: str, t_min: float) -> None:
    """In float64: the ray hits, and its first point lies outside."""
    lines, origins, directions = crowd(kind, np.random.default_rng(len(kind)))
    rays = lines.segments, lines.end_radii, origins, directions
    of_ray = deepest_approach(*rays, 0.02, t_min=t_min)[0]
    of_start = deepest_approach(*rays, 0.02, t_min=t_min, t_max=t_min)[0]
    size = float(np.ptp(lines.bounds, axis=0).max()) + lines.max_radius
    is_clear = (np.abs(of_ray) > BAND * size) & (np.abs(of_start) > BAND * size)
    expected = (of_ray <= 0) & (of_start > 0)
    assert np.count_nonzero(np.count_nonzero(of_start <= 0, axis=1) > 1) > 20, "rays start inside several"
    for kernel in KERNELS:
        hits = fl.build(lines).all_hits(origins, directions, 0.02, t_min=t_min, at="entry", kernel=kernel)
        found = np.zeros(expected.shape, bool)
        found[hits.ray, hits.prim] = True
        assert (found == expected)[is_clear].all()
        assert (hits.t >= np.float32(t_min)).all()
        assert (hits.t_out > hits.t).all()


@pytest.mark.parametrize("name", nasty.NAMES)
@pytest.mark.parametrize("kind", ALL_KINDS)
def test_entries_are_hits_at_the_surface_after_the_start(kind: str, name: str) -> None:
    case = cases(1, n_rays=40)[name]
    asked, _ = question(case)
    starts_at_0 = (np.arange(len(asked["origins"])) % 2 > 0) & (np.asarray(asked["t_max"]) >= 0)
    asked["t_min"] = np.where(starts_at_0, 0, asked["t_min"]).astype(np.float32)
    geometry = ALL_KINDS[kind](case.segments)
    every = fl.brute_force(geometry, **asked, at="surface")
    entries = fl.brute_force(geometry, **asked, at="entry")
    columns = ("ray", "t", "prim_number", "u", "distance", "t_out")
    at_surface, entered = (
        list(zip(*(getattr(hits, name).tolist() for name in columns), strict=True)) for hits in (every, entries)
    )
    assert set(entered) <= set(at_surface)
    if kind in ("triangles", "a mixture"):  # triangles have no inside
        return
    is_after = every.t > asked["t_min"][every.ray]
    after = {row for row, is_later in zip(at_surface, is_after, strict=True) if is_later}
    assert after <= set(entered)
    # Where t_min is 0, this is exact. Elsewhere, t of an entry may round to t_min.
    assert all(asked["t_min"][ray] != 0 for ray, *_ in set(entered) - after)


def test_a_ray_that_starts_on_a_surface_does_not_enter() -> None:
    tree = fl.build([[[-4, 0, 0], [4, 0, 0]]])
    ways: list[Any] = [
        ([0, 0, -0.5], [0, 0, 1]),
        ([0, 0, 0.5], [0, 0, 1]),
        ([0, 0, 0], [0, 0, 1]),
        ([0, 0, -1], [0, 0, 1]),
    ]
    origins, directions = zip(*ways, strict=True)
    assert tree.first_hit(origins, directions, 0.5, at="surface").t.tolist() == [0, 0, 0, 0.5]
    assert tree.first_hit(origins, directions, 0.5, at="entry").t.tolist() == [np.inf, np.inf, np.inf, 0.5]
    assert tree.any_hit(origins, directions, 0.5, at="entry").tolist() == [False, False, False, True]
    assert tree.count_hits(origins, directions, 0.5, at="entry").tolist() == [0, 0, 0, 1]
    # From before their start, they enter.
    assert tree.any_hit(origins, directions, 0.5, t_min=-2, at="entry").all()


def test_a_ray_leaves_what_it_starts_in_and_hits_what_is_behind() -> None:
    """A chain of balls that overlap: a ray that starts in the second and third enters the fourth first."""
    chain = fl.Spheres.from_centres([[x, 0, 0] for x in range(5)], radius=0.75)
    hits = fl.build(chain).all_hits([1.5, 0, 0], [1, 0, 0], at="entry")
    assert hits.prim.tolist() == [3, 4]
    assert hits.t.tolist() == [0.75, 1.75]
    assert hits.t_out.tolist() == [2.25, 3.25]


def test_triangles_have_no_inside_and_boxes_have() -> None:
    square = fl.Triangles([[[-1, -1, 0], [3, -1, 0], [-1, 3, 0]]])
    box = fl.Boxes([[[-1, -1, 1], [1, 1, 2]]])
    tree = fl.build(fl.Geometry([square, box]))
    for z, expected in ((-1, [0, 1]), (0, [0, 1]), (1, []), (1.5, [])):
        hits = tree.all_hits([0, 0, z], [0, 0, 1], at="entry")
        assert hits.part.tolist() == expected, z


def test_a_curve_is_entered_once_a_crossing() -> None:
    """An arch in thick pieces: from inside its leg, a ray enters other pieces of the leg, which begin no crossing."""
    arch = fl.Curves.from_bezier([[[0, 0, 0], [0, 4, 0], [4, 4, 0], [4, 0, 0]]], 0.5, tolerance=1e-3)
    tree = fl.build(arch)
    inside, outside = tree.all_hits([[0, 0.5, 0], [-2, 0.5, 0]], [1, 0, 0], at="entry").counts
    assert (inside, outside) == (1, 2)
    up = tree.all_hits([0, 0, 0], [0, 1, 0], at="surface")
    assert len(up) > 0
    for kernel in KERNELS:
        assert not tree.any_hit([0, 0.1, 0], [0, 1, 0], t_max=1, at="entry", kernel=kernel)
        first = tree.first_hit([[0, 0.5, 0], [-2, 0.5, 0]], [1, 0, 0], at="entry", kernel=kernel)
        assert first.t.round(1).tolist() == [3.5, 1.5]


@pytest.mark.parametrize("kind", ALL_KINDS)
def test_without_t_the_surface_is_the_closest_approach(kind: str) -> None:
    case = cases(0, n_rays=60)["hair"]
    asked, _ = question(case)
    tree = fl.build(ALL_KINDS[kind](case.segments))
    for query, kernel in product(("any_hit", "count_hits"), KERNELS):
        if kind in ("curves", "a mixture") and query == "count_hits":
            continue  # crossings
        expected = getattr(tree, query)(**asked)
        assert_same(getattr(tree, query)(**asked, at="surface", kernel=kernel), expected)


def test_entries_are_left_out_and_ranked_as_other_hits() -> None:
    lines, origins, directions = crowd("tapering", np.random.default_rng(7))
    tree = fl.build(lines)
    entries = tree.all_hits(origins, directions, at="entry")
    ignored = tree.all_hits(origins, directions, at="entry", ignore=np.arange(0, 80, 2))
    assert np.array_equal(ignored.prim, entries.prim[entries.prim % 2 == 1])
    nearest = tree.next_hits(origins, directions, k=2, rank="distance", at="entry")
    for ray in range(0, 400, 7):
        of_ray = entries.distance[entries.offsets[ray] : entries.offsets[ray + 1]]
        got = nearest.distance[nearest.offsets[ray] : nearest.offsets[ray + 1]]
        assert got.tolist() == sorted(of_ray)[:2]


def test_entries_need_a_surface() -> None:
    tree = fl.build([[[0, 0, 0], [1, 0, 0]]])
    ray: Any = [0.5, 0, -5], [0, 0, 1]
    for query in ("first_hit", "any_hit", "count_hits", "all_hits"):
        with pytest.raises(fl.InputError, match="at='entry' has no meaning with a spread"):
            getattr(tree, query)(*ray, spread=0.1, at="entry")
        with pytest.raises(fl.InputError, match="at='inside' is not a choice"):
            getattr(tree, query)(*ray, 0.1, at="inside")
    with pytest.raises(fl.InputError, match="it needs at='surface'"):
        tree.all_hits(*ray, 0.1, at="entry", merge="strand")
