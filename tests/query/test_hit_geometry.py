"""Where hits are: points, normals, tangents and attributes, against closed forms and the definition in float64."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Callable

import numpy as np
import pytest

import fastlines as fl
from fastlines.theory.hits import capsule_interval

#: Queries whose hits have a place, and their arguments.
QUERIES: dict[str, dict[str, int]] = {"first_hit": {}, "all_hits": {}, "next_hits": {"k": 2}}


def tapered(n: int = 300, seed: int = 0) -> fl.Lines:
    """Return segments in the unit cube that are thicker at one end."""
    rng = np.random.default_rng(seed)
    start = rng.random((n, 3))
    ends = np.stack([start, start + rng.normal(size=(n, 3)) * 0.1], axis=1)
    return fl.Lines.from_segments(ends, radius=rng.random((n, 2)) * 0.02 + 1e-4, strands=np.arange(n) // 3)


def rays(n: int = 4000, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return rays from outside, whose directions are not of unit length."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(n, 3))
    directions *= 2 / np.sqrt((directions**2).sum(axis=1, keepdims=True))
    return (rng.random((n, 3)) - 2 * directions).astype(np.float32), directions.astype(np.float32)


def distance_from_surface(lines: fl.Lines, prim: np.ndarray, points: np.ndarray, radius: float) -> np.ndarray:
    """Return how far points are from the surfaces of round cones, by a search for the nearest ball; negative inside."""
    start, end = np.moveaxis(lines.segments[prim].astype(np.float64), 1, 0)
    radius0, radius1 = lines.end_radii[prim].astype(np.float64).T + radius
    low, high = np.zeros(len(prim)), np.ones(len(prim))

    def gap(s: np.ndarray) -> np.ndarray:
        centre = start + s[:, None] * (end - start)
        return np.sqrt(((points - centre) ** 2).sum(axis=1)) - (radius0 + s * (radius1 - radius0))

    for _ in range(120):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        left = gap(a) < gap(b)
        low, high = np.where(left, low, a), np.where(left, b, high)
    return gap((low + high) / 2)


@pytest.mark.parametrize("radius", [0.0, 0.01])
@pytest.mark.parametrize("query", QUERIES)
def test_points_lie_on_the_surface_and_normals_are_its_gradient(query: str, radius: float) -> None:
    lines = tapered()
    hits = getattr(fl.build(lines), query)(*rays(), radius, at="surface", **QUERIES[query])
    hit = hits.prim >= 0
    assert hit.sum() > 500
    points, normals, prim = hits.points()[hit], hits.normals()[hit], hits.prim[hit]
    assert np.abs(distance_from_surface(lines, prim, points, radius)).max() < 1e-6
    # The distance from the surface grows by one per unit along the normal, and first not at all across it.
    step = 1e-5
    outside = distance_from_surface(lines, prim, points + step * normals, radius)
    assert np.abs(outside / step - 1).max() < 0.02
    gradient = np.stack(
        [
            distance_from_surface(lines, prim, points + step * axis, radius)
            - distance_from_surface(lines, prim, points - step * axis, radius)
            for axis in np.eye(3)
        ],
        axis=1,
    ) / (2 * step)
    cosines = (gradient * normals).sum(axis=1) / np.sqrt((gradient**2).sum(axis=1))
    assert np.degrees(np.arccos(np.clip(cosines, -1, 1))).max() < 0.2


@pytest.mark.parametrize("query", QUERIES)
def test_misses_have_nan(query: str) -> None:
    origins, directions = rays(500)
    hits = getattr(fl.build(tapered()), query)(
        origins.reshape(5, 100, 3), directions.reshape(5, 100, 3), at="surface", **QUERIES[query]
    )
    shape = hits.prim.shape
    for found in (hits.points(), hits.normals(), hits.tangents()):
        assert found.shape == (*shape, 3)
        assert found.dtype == np.float64
        assert (np.isnan(found).all(axis=-1) == (hits.prim < 0)).all()
    assert (np.isnan(hits.sample("radius")) == (hits.prim < 0)).all()


def test_points_of_the_closest_approach_are_those_of_t() -> None:
    origins, directions = rays()
    hits = fl.build(tapered()).first_hit(origins, directions)
    expected = origins + hits.t[:, None].astype(np.float64) * directions
    assert np.array_equal(hits.points()[hits.hit], expected[hits.hit])
    with pytest.raises(fl.InputError, match="query again with at='surface'"):
        hits.normals()


def test_rays_from_outside_do_not_hit_their_own_surface() -> None:
    lines = tapered()
    tree = fl.build(lines)
    hits = tree.first_hit(*rays(20_000), at="surface")
    origins, normals = hits.points(outside=True)[hits.hit], hits.normals()[hits.hit]
    rng = np.random.default_rng(5)
    directions = rng.normal(size=origins.shape)
    away = directions - np.minimum((directions * normals).sum(axis=1), 0)[:, None] * normals  # some along the surface
    again = tree.all_hits(origins, away)
    own = hits.prim[hits.hit][again.ray]
    assert len(again) > 1000
    assert (again.prim != own).all()


def test_the_normal_at_the_centre_is_opposite_to_the_ray() -> None:
    tree = fl.build(fl.Spheres.from_centres([[0, 0, 0]], 1))
    assert tree.first_hit([0, 0, 0], [0, 2, 0], at="surface").normals().tolist() == [0, -1, 0]


def test_a_name_is_given_once() -> None:
    ends = tapered(4).segments
    with pytest.raises(fl.InputError, match="'fa' is in attributes and in end_attributes"):
        fl.Lines.from_segments(ends, attributes={"fa": np.ones(4)}, end_attributes={"fa": np.ones((4, 2))})
    lines = fl.Lines.from_segments(ends, end_attributes={"fa": np.zeros((4, 2))})
    changed = dataclasses.replace(lines, end_attributes={"fa": np.ones((4, 2))})
    assert changed.attributes["fa"].tolist() == [1, 1, 1, 1]


def test_a_ray_that_starts_inside_has_its_origin() -> None:
    tree = fl.build(fl.Lines.from_segments([[[-1, 0, 0], [1, 0, 0]]], radius=[0.5]))
    hits = tree.first_hit([0, 0, 0.25], [0, 0, 1], at="surface")
    assert hits.t == 0
    assert hits.points().tolist() == [0, 0, 0.25]
    assert hits.normals().tolist() == [0, 0, 1]


def test_capsules_are_entered_where_the_definition_says() -> None:
    segments = tapered().segments
    origins, directions = rays(300)
    hits = fl.build(segments).all_hits(origins, directions, 0.02, at="surface")
    t_in, _ = capsule_interval(segments, origins, directions, np.float32(0.02))
    exact = origins[hits.ray] + t_in[hits.ray, hits.prim, None] * directions[hits.ray].astype(np.float64)
    kept = np.isfinite(exact).all(axis=1)
    assert np.abs(hits.points()[kept] - exact[kept]).max() < 1e-9


def test_sample_interpolates_what_is_known_at_both_ends() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 5, 0], [1, 5, 0]], np.float32)
    lines = fl.Lines.from_points(
        points,
        [3, 2],
        radius=[0.1, 0.2, 0.1, 0.3, 0.3],
        attributes={
            "fa": np.array([0, 1, 3, 5, 7.0]),
            "rgb": np.eye(5, 3),
            "label": np.array([1, 2, 3, 4, 5]),
        },
    )
    hits = fl.build(lines).first_hit([[0.25, 0, -9], [1.75, 0, -9], [0.5, 5, -9], [9, 9, -9]], [0, 0, 1])
    assert hits.prim.tolist() == [0, 1, 2, -1]
    assert np.allclose(hits.sample("fa"), [0.25, 2.5, 6, np.nan], equal_nan=True)
    assert np.allclose(hits.sample("radius"), [0.125, 0.125, 0.3, np.nan], equal_nan=True)
    assert np.allclose(hits.sample("rgb")[0], [0.75, 0.25, 0])
    assert np.array_equal(hits.sample("label"), [1, 3, 5, np.nan], equal_nan=True)  # of the nearer end
    with pytest.raises(fl.InputError, match="did you mean 'label'"):
        hits.sample("lable")
    # Attributes of segments are constant along each.
    assert lines.attributes["fa"].tolist() == [0, 1, 5]
    whole = fl.Lines.from_segments(lines.segments, attributes={"bundle": [7, 8, 9], "name": np.array(["a", "b", "c"])})
    hits = fl.build(whole).first_hit([[0.25, 0, -9], [9, 9, -9]], [0, 0, 1], 0.1)
    assert np.array_equal(hits.sample("bundle"), [7, np.nan], equal_nan=True)
    with pytest.raises(fl.InputError, match="expected numbers"):
        hits.sample("name")


def negate(array: np.ndarray) -> None:
    array *= -1


def add(array: np.ndarray) -> None:
    array += 1


def clear(array: np.ndarray) -> None:
    array[:] = 0


def reverse(array: np.ndarray) -> None:
    array[:] = array[::-1].copy()


def swap(array: np.ndarray) -> None:
    array[[0, -1]] = array[[-1, 0]]


def flip_a_bit(array: np.ndarray) -> None:
    array.view(np.uint32).reshape(-1)[len(array) // 2] ^= np.uint32(1)


def flip_a_bit_of_all(array: np.ndarray) -> None:
    array.view(np.uint32)[:] ^= np.uint32(1 << 30)


CHANGES = [negate, add, clear, reverse, swap, flip_a_bit, flip_a_bit_of_all]


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
@pytest.mark.parametrize("n", [1, 2, 3, 700, 40_000])
def test_rays_that_were_changed_are_noticed(n: int, change: Callable[[np.ndarray], None]) -> None:
    tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    for seed in range(10 if n < 10 else 1):
        rng = np.random.default_rng(seed)
        arrays = {name: rng.normal(size=(n, 3)).astype(np.float32) for name in ("origins", "directions")}
        arrays |= {name: rng.random(n).astype(np.float32) for name in ("radius", "t_max")}
        arrays["t_min"] = -arrays["t_max"][::-1] - 9
        for array in arrays.values():
            hits, before = tree.first_hit(**arrays), array.copy()
            hits.points()
            change(array)
            if not np.array_equal(array, before):
                with pytest.raises(fl.InputError, match="rays have changed since the query"):
                    hits.points()
            array[:] = before
            hits.points()


def test_arrays_of_rays_that_change_together_are_noticed() -> None:
    origins, directions = rays(50)
    radius = np.array(0.1, np.float32)  # one for all
    hits = fl.build(tapered()).first_hit(origins, directions, radius, at="surface")
    before = [array.copy() for array in (origins, directions, radius)]
    for changed in ([before[1], before[0], before[2]], [before[0], before[1], before[2] * 2]):
        for array, values in zip((origins, directions, radius), changed, strict=True):
            array[...] = values
        for ask in (hits.points, hits.normals):
            with pytest.raises(fl.InputError, match="rays have changed since the query"):
                ask()
        assert np.isfinite(hits.tangents()[hits.hit]).all()  # which need no rays


@pytest.mark.parametrize("n", [1, 3, 40_000])
def test_the_checksum_is_that_of_every_instruction_set(n: int) -> None:
    given = fl.query.rays.RayArguments(*rays(n), np.arange(n))
    digests = set()
    for name in fl.available_simd():
        fl.set_simd(name)
        digests.add(fl.query.rays.check_rays(given, np.float32([[0, 0, 0], [1, 1, 1]])).digest)
    fl.set_simd(None)
    assert len(digests) == 1


def test_pickled_hits_have_no_points() -> None:
    hits = pickle.loads(pickle.dumps(fl.build(tapered()).first_hit(*rays(), at="surface")))
    for ask in (hits.points, hits.normals, hits.tangents, lambda: hits.sample("radius")):
        with pytest.raises(fl.InputError, match="query again"):
            ask()
