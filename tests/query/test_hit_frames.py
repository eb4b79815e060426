"""Compiled frames of hits: points, normals, tangents and radii have the bits of their definition in NumPy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from support.curves import SHAPES, curves_of
from support.hit_reference import bits, frames
from support.nasty import RAYS, SCENES, mixed, size_of, windows_for

import fastlines as fl
from fastlines.query.hits import AllHits, FirstHits
from fastlines.threads import num_threads


@pytest.fixture(params=fl.available_simd())
def simd(request: pytest.FixtureRequest) -> Iterator[str]:
    fl.set_simd(request.param)
    yield request.param
    fl.set_simd(None)


def check(hits: FirstHits | AllHits) -> int:
    """Compare the frames of hits at surfaces with the definition, and return how many there are."""
    expected = frames(hits)
    found = hits.points(), hits.normals(), hits.tangents(), hits.sample("radius")
    for name, got, values in zip(expected._fields, found, expected, strict=True):
        assert got.dtype == np.float64
        assert got.shape == (*hits.prim.shape, *values.shape[1:])
        assert np.array_equal(bits(got.reshape(values.shape)), bits(values)), name
    return int((hits.prim >= 0).sum())


@pytest.mark.parametrize("scene", SCENES)
def test_lines_of_all_radii(simd: str, scene: str) -> None:
    rng = np.random.default_rng(len(scene))
    segments = SCENES[scene](rng, 60).astype(np.float32)
    size, n = size_of(segments), len(segments)
    origins, directions = (array.astype(np.float32) for array in mixed(rng, segments, 12 * len(RAYS), size))
    length = np.linalg.norm(segments[:, 1].astype(np.float64) - segments[:, 0], axis=1)
    radii = {
        "capsules": 0.02 * size * rng.random(n),
        "tapered": 0.05 * size * rng.random((n, 2)),
        "to a tip": 0.1 * size * rng.random((n, 1)) * [1, 0],
        "one end in the other": (2 * length + 1e-3 * size)[:, None] * [1, 0.25],
        "as steep as the ray": length[:, None] * [0, 1],
    }
    windows = [(0.0, np.inf), *windows_for(rng, segments, origins, directions).values()]
    n_hits = 0
    for i, radius in enumerate(radii.values()):
        tree = fl.build(fl.Lines.from_segments(segments, radius=radius))
        for query in (tree.first_hit, tree.all_hits):
            for of_query in (0.0, 0.02 * size, 0.02 * size * rng.random(len(origins))):
                t_min, t_max = windows[(i := i + 1) % len(windows)]
                n_hits += check(query(origins, directions, of_query, t_min=t_min, t_max=t_max, at="surface"))
    assert n_hits > (100 if n else -1)


@pytest.mark.parametrize("shape", SHAPES)
def test_curves(simd: str, shape: str) -> None:
    curves = curves_of(shape, tolerance=0.01 if shape == "thicker than long" else None)
    rng = np.random.default_rng(1)
    ends = curves.ends
    origins, directions = (array.astype(np.float32) for array in mixed(rng, ends, 120, size_of(ends)))
    tree, n_hits = fl.build(curves), 0
    for t_min in (0.0, -np.inf):
        for query in (tree.first_hit, tree.all_hits):
            radius = 0.0 if curves.radius is not None and curves.max_radius else 0.1
            hits = query(origins, directions, radius, t_min=t_min, at="surface")
            expected = frames(hits)
            found = hits.points(), hits.normals(), hits.tangents()
            for got, values in zip(found, expected[:3], strict=True):
                assert np.array_equal(bits(got.reshape(values.shape)), bits(values))
            if curves.radius is not None:
                assert np.array_equal(bits(hits.sample("radius").reshape(-1)), bits(expected.radius))
            n_hits += int((hits.prim >= 0).sum())
    assert n_hits > 30


@pytest.mark.parametrize("n_threads", [1, 3])
def test_many_hits_with_an_offset(n_threads: int) -> None:
    rng = np.random.default_rng(2)
    ends = rng.random((50, 2, 3)) + np.array([1e6, 0, 0])
    lines = fl.Lines.from_segments(ends, radius=np.full(50, 0.05), offset=[1e6, 0, 0])
    origins = rng.random((70_001, 3)) + np.array([1e6, 0, -2])
    with num_threads(n_threads):
        hits = fl.build(lines).first_hit(origins, [0, 0, 1], at="surface")
        assert check(hits) > 10_000


@pytest.mark.parametrize("tapers", [False, True])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_points_outside_are_moved_along_the_normals(simd: str, scale: float, tapers: bool) -> None:
    rng = np.random.default_rng(5)
    segments = (rng.random((50, 2, 3)) * scale).astype(np.float32)
    lines = fl.Lines.from_segments(segments, radius=0.05 * scale * rng.random((50, 2) if tapers else 50))
    directions = rng.normal(size=(400, 3)).astype(np.float32)
    origins = (scale * (rng.random((400, 3)) - 3 * directions)).astype(np.float32)
    ray_radius = (0.01 * scale * rng.random(400)).astype(np.float32)
    hits = fl.build(lines).first_hit(origins, directions, ray_radius, at="surface")
    bounds = lines.bounds.astype(np.float64)
    size = float((bounds[1] - bounds[0]).max() + np.abs(bounds).max())
    own = lines.end_radii[hits.prim].max(axis=1).astype(np.float64)
    expected = hits.points() + (2.0**-20 * (size + own + ray_radius))[:, None] * hits.normals()
    assert np.array_equal(bits(hits.points(outside=True)), bits(expected))
    assert 50 < hits.hit.sum() < 400


def test_parts_have_the_frames_of_their_own() -> None:
    rng = np.random.default_rng(3)
    segments = rng.random((40, 2, 3)).astype(np.float32)
    lines = fl.Lines.from_segments(segments, radius=np.full((40, 2), [0.01, 0.05]))
    floor = fl.Triangles([[[-9, -9, 3], [9, -9, 3], [0, 9, 3]]])
    tree = fl.build(fl.Geometry([floor, lines]))
    origins = (rng.random((600, 3)) * [1, 1, 0] - [0, 0, 2]).astype(np.float32)
    hits = tree.first_hit(origins, [0, 0, 1], at="surface")
    of_lines = np.flatnonzero(hits.part == 1)
    alone = fl.build(lines).first_hit(origins[of_lines], [0, 0, 1], at="surface")
    assert np.array_equal(alone.prim, hits.prim[of_lines])
    for name in ("points", "normals", "tangents"):
        assert np.array_equal(getattr(hits, name)()[of_lines], getattr(alone, name)())
    assert (hits.normals()[hits.part == 0] == [0, 0, -1]).all()
    found, of_alone = hits.frames(of_lines, lift=0.5), alone.frames(lift=0.5)
    for name in ("points", "normals", "tangents", "to_eye"):
        assert np.array_equal(getattr(found, name), getattr(of_alone, name))
    assert np.array_equal(found.radius, hits.sample("radius")[of_lines].astype(np.float32))
    of_floor = hits.frames(np.flatnonzero(hits.part == 0))
    assert (of_floor.normals == [0, 0, -1]).all()
    assert (of_floor.points[:, 2] == 3).all()
    assert not of_floor.tangents.any()
    assert not of_floor.radius.any()


def test_frames_for_shading_are_the_same_in_float32(simd: str) -> None:
    rng = np.random.default_rng(4)
    segments = rng.random((50, 2, 3)).astype(np.float32)
    segments[:5, 1] = segments[:5, 0]  # balls have no tangent
    tree = fl.build(fl.Lines.from_segments(segments, radius=0.1 * rng.random((50, 2))))
    directions = rng.normal(size=(500, 3)).astype(np.float32)
    origins = rng.random((500, 3)).astype(np.float32) - 3 * directions
    for hits in (
        tree.first_hit(origins, directions, 0.01, at="surface"),
        tree.all_hits(origins, directions, at="surface"),
    ):
        expected = frames(hits)
        is_hit = np.flatnonzero(hits.prim >= 0)
        ray = is_hit if isinstance(hits, FirstHits) else hits.ray
        some = rng.permutation(len(is_hit))[:77]
        for rows, at in ((None, np.arange(len(is_hit))), (is_hit[some], some)):
            found, of = hits.frames(rows, lift=0.25), is_hit[at]
            points = expected.points[of] + 0.25 * expected.normals[of]
            radius = expected.radius[of] + np.float32(0.01 if isinstance(hits, FirstHits) else 0.0)
            tangents = np.nan_to_num(expected.tangents[of])
            columns = points, expected.normals[of], tangents, -directions[ray[at]], radius
            for got, values in zip(found, columns, strict=True):
                assert got.dtype == np.float32
                assert np.array_equal(got, values.astype(np.float32))
    with pytest.raises(fl.InputError, match="query again with at='surface'"):
        tree.first_hit(origins, directions).frames()


@pytest.mark.parametrize("n_rays", [1, 3, 8, 13])
def test_misses_of_no_axis_at_all(n_rays: int) -> None:
    """There is no memory to read, as of an axis."""
    no_curves = fl.Curves(np.empty((0, 4, 3), np.float32), radius=np.empty((0, 4), np.float32))
    for geometry in (no_curves, fl.Lines.from_segments(np.empty((0, 2, 3)), radius=np.empty(0))):
        hits = fl.build(geometry).first_hit(np.zeros((n_rays, 3)), [0, 0, 1], at="surface")
        for found in (hits.points(), hits.normals(), hits.tangents()):
            assert found.shape == (n_rays, 3)
            assert np.isnan(found).all()
        assert np.isnan(hits.sample("radius")).all()


def test_hits_of_no_primitive_are_refused() -> None:
    hits = fl.build([[[-1, 0, 0], [1, 0, 0]]]).first_hit([0, 0, -5], [0, 0, 1], 0.5, at="surface")
    hits.prim[...] = 1
    for ask in (hits.points, hits.normals, hits.tangents, lambda: hits.sample("radius")):
        with pytest.raises((IndexError, fl.InputError)):
            ask()
