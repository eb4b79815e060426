"""Embree's cubic curves, spheres and triangles, as the peer gives them to it, against ours and against NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from peers import needs_embree

import fastlines as fl
from fastlines_bench.harness.compare import compare_surfaces
from fastlines_bench.harness.rays import rays_through
from fastlines_bench.peers.embree import Build, Config, Scenes, configs

pytestmark = needs_embree

WIDTHS = [(1, False), (8, False), (8, True), (16, False), (16, True)]
CUBE = np.array([[0, 0, 0], [1, 1, 1]], np.float32)
RAYS = rays_through(CUBE, 3001)  # not a multiple of any width
TOLERANCE = 1e-5

#: Of each curve.
N_CONES = 48


@pytest.mark.parametrize("compact", [False, True])
@pytest.mark.parametrize(("width", "coherent"), WIDTHS)
def test_spheres_are_ours(width: int, coherent: bool, compact: bool) -> None:
    rng = np.random.default_rng(0)
    spheres = np.concatenate([rng.random((300, 3)), rng.uniform(0.005, 0.05, (300, 1))], axis=1).astype(np.float32)
    scenes = Scenes.of_shapes(spheres, 1)
    config = Config(Build("sphere", compact=compact), width, coherent)
    tree = fl.build(fl.Spheres.from_centres(spheres[:, :3], spheres[:, 3]))
    first = tree.first_hit(RAYS.origins, RAYS.directions, at="surface")
    assert first.hit.mean() > 0.3
    assert compare_surfaces("first", first, scenes.query(config, "first", RAYS), TOLERANCE).n_differ <= 1
    hits = tree.all_hits(RAYS.origins, RAYS.directions, at="surface")
    found = compare_surfaces("all", hits, scenes.query(config, "all", RAYS), TOLERANCE)
    assert found.n_hits > 1000
    assert found.n_hits_differ <= 2
    assert len(scenes.query(config, "all", RAYS).unpack()[0]) <= found.n_hits  # each once
    assert scenes.get(config.build).n_pieces == 300


@pytest.mark.parametrize("compact", [False, True])
@pytest.mark.parametrize("quality", ["low", "medium", "high"])
def test_triangles_are_those_of_moller_and_trumbore(quality: str, compact: bool) -> None:
    rng = np.random.default_rng(1)
    vertices = rng.random((200, 3), np.float32)
    index = np.stack([rng.permutation(200)[:3] for _ in range(300)])
    ray, prim, t = hits_of_triangles(vertices[index].astype(np.float64))
    expected = np.full(len(RAYS), np.inf)
    np.minimum.at(expected, ray, t)
    scenes = Scenes.of_shapes(vertices, 1, index)
    build = Build("triangle", quality=quality, compact=compact)
    for width, coherent in WIDTHS:
        config = Config(build, width, coherent)
        first, which = scenes.query(config, "first", RAYS)
        near = np.isclose(first, expected, atol=TOLERANCE)
        assert near.mean() > 0.998
        assert ((which >= 0) == np.isfinite(first)).all()
        assert (scenes.query(config, "any", RAYS) == np.isfinite(expected)).mean() > 0.998
        if build.splits_space:
            assert not configs(scenes, [build], "all", RAYS)
            continue
        found = np.stack(scenes.query(config, "all", RAYS).unpack()[:2])
        key, wanted = found[0] << 32 | found[1], ray << 32 | prim
        assert len(np.unique(key)) == len(key)  # each once
        assert len(np.setxor1d(key, wanted)) < 0.002 * len(wanted)


def hits_of_triangles(corners):
    """Return ray, triangle and t of all hits, by brute force in float64."""
    a, e, f = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    d = RAYS.directions.astype(np.float64)[:, None]
    s = RAYS.origins.astype(np.float64)[:, None] - a
    p, q = np.cross(d, f), np.cross(s, e)
    det = (p * e).sum(axis=2)
    u, v, t = ((x * y).sum(axis=2) / det for x, y in ((p, s), (q, d), (q, f)))
    ray, prim = np.nonzero((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0))
    return ray, prim, t[ray, prim]


@pytest.mark.parametrize("halvings", [0, 1, 3])
@pytest.mark.parametrize(("width", "coherent"), WIDTHS)
def test_cubic_curves_are_nearly_many_round_cones(halvings: int, width: int, coherent: bool) -> None:
    rng = np.random.default_rng(2)
    # Bends are gentle: Embree needs a radius below that of the curvature.
    ends = rng.random((80, 2, 3))
    share = (np.arange(4) / 3)[:, None]
    control = ends[:, None, 0] + share * (ends[:, None, 1] - ends[:, None, 0]) + rng.normal(0, 0.06, (80, 4, 3))
    radius = rng.uniform(0.01, 0.02, (80, 4))
    curves = np.concatenate([control, radius[..., None]], axis=2).astype(np.float32)
    tree, owner = cones_of(curves, N_CONES)
    scenes = Scenes.of_shapes(curves, 1)
    config = Config(Build("bezier", halvings=halvings), width, coherent)

    # Leave out the ends, which are balls in ours and open in Embree.
    first = tree.first_hit(RAYS.origins, RAYS.directions, at="surface")
    t, prim = scenes.query(config, "first", RAYS)
    differ = (first.hit != (prim >= 0)) | (np.abs(np.where(first.hit, first.t, 0) - np.where(prim >= 0, t, 0)) > 1e-3)
    assert first.hit.mean() > 0.3
    assert (differ & ~at_end(first)).mean() < 0.005
    hits = tree.all_hits(RAYS.origins, RAYS.directions, at="surface")
    ray, prim, _ = scenes.query(config, "all", RAYS).unpack()
    ours, theirs = hits.ray << 32 | owner[hits.prim], np.unique(ray << 32 | prim)
    assert len(theirs) > 1000
    assert np.isin(theirs, ours).mean() > 0.998
    assert np.isin(ours[~at_end(hits)], theirs).mean() > 0.98
    assert scenes.get(config.build).n_pieces == 80 << halvings


def at_end(hits):
    """Return which hits are at an end of a curve."""
    place = hits.prim % N_CONES
    return (place == 0) & (hits.u == 0) | (place == N_CONES - 1) & (hits.u == 1)


def cones_of(curves, n):
    """Return a tree over n round cones a curve, and the curve of each."""
    s = np.linspace(0, 1, n + 1)
    basis = np.stack([(1 - s) ** 3, 3 * s * (1 - s) ** 2, 3 * s**2 * (1 - s), s**3], axis=1)
    points = np.einsum("sk,ckx->scx", basis, curves.astype(np.float64))
    segments = np.stack([points[:-1], points[1:]], axis=2).transpose(1, 0, 2, 3).reshape(-1, 2, 4)
    lines = fl.Lines.from_segments(segments[..., :3], radius=segments[..., 3])
    return fl.build(lines), np.repeat(np.arange(len(curves)), n)


def test_names_of_builds() -> None:
    named = {
        "triangle, spatial splits, compact": Build("triangle", compact=True),
        "triangle": Build("triangle", quality="medium"),
        "bezier, 4 parts": Build("bezier", halvings=2),
        "bezier, whole": Build("bezier"),
        "sphere": Build("sphere"),
        "round, compact, pieces ≤ 0.5": Build("round", 0.5, compact=True),
    }
    assert {name: str(build) for name, build in named.items()} == {name: name for name in named}
