"""The peers of a gather have the sums of lists of hits."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from peers import needs_embree

import fastlines as fl
from fastlines_bench.beams.cube import make_cube
from fastlines_bench.harness.rays import RayBatch, random_rays
from fastlines_bench.peers.beam_loops import BeamGrid, brute_force
from fastlines_bench.peers.embree import Build, Config, Scenes, widths
from fastlines_bench.peers.gathering import Gathering

needs_compiler = pytest.mark.skipif(
    not (shutil.which("g++") or shutil.which("c++")), reason="there is no compiler for the loops"
)

#: What is summed: both extinctions, and scattering forwards.
GIVEN = Gathering(radius=0.02, sigma=0.8, line_sigma=0.3, g=0.4)


@pytest.fixture(scope="module")
def cube():
    return make_cube(1500, 48)


@pytest.fixture(scope="module", params=["camera", "random", "bounded"])
def rays(request, cube):
    if request.param == "camera":
        return cube.rays
    batch = random_rays(cube.lines, 1001)
    if request.param == "random":
        return batch
    return RayBatch("random", batch.origins + np.float32(1.8) * batch.directions, batch.directions, 0.05, 0.4)


@pytest.fixture(scope="module")
def expected(cube, rays):
    """The definition in float64, over all hits by brute force."""
    hits = fl.brute_force(
        cube.lines, rays.origins, rays.directions, GIVEN.radius, query="all_hits", t_min=rays.t_min, t_max=rays.t_max
    )
    inner = (hits.u > 0) & (hits.u < 1) & (hits.t > rays.t_min) & (hits.t < rays.t_max)
    ray, prim = hits.ray[inner], hits.prim[inner]
    t, u, distance = (column[inner].astype(np.float64) for column in (hits.t, hits.u, hits.distance))
    edge = np.diff(cube.lines.segments.astype(np.float64), axis=1)[prim, 0]
    length = np.linalg.norm(edge, axis=1)
    direction = rays.directions[ray].astype(np.float64)
    sine = np.linalg.norm(np.cross(direction, edge), axis=1) / length
    cosine = -(direction * edge).sum(axis=1) / length
    phase = (1 - GIVEN.g**2) / (4 * np.pi * (1 + GIVEN.g**2 - 2 * GIVEN.g * cosine) ** 1.5)
    kernel = 3 / (4 * GIVEN.radius) * (1 - (distance / GIVEN.radius) ** 2)
    weight = kernel / sine * np.exp(-GIVEN.sigma * t - GIVEN.line_sigma * u * length) * phase
    sums = np.zeros((len(rays), 3))
    np.add.at(sums, ray, weight[:, None] * cube.powers[prim])
    assert (sums > 0).any(axis=1).mean() > 0.1
    return sums


def check(found, expected):
    assert found.shape == expected.shape
    assert np.abs(found - expected).sum() < 1e-4 * expected.sum()
    np.testing.assert_allclose(found, expected, rtol=0.01, atol=1e-4 * expected.max())


def test_lists(cube, rays, expected):
    tree = fl.build(cube.lines, "bvh-cl")
    whole = GIVEN.listed(tree, cube.lines, rays, cube.powers, 1 << 30)
    check(whole, expected)
    np.testing.assert_allclose(GIVEN.listed(tree, cube.lines, rays, cube.powers, 50_000), whole, rtol=1e-12)


@needs_compiler
@pytest.mark.parametrize("resolution", [1, 7, 40])
def test_grid(cube, rays, expected, resolution):
    grid = BeamGrid(cube.lines, GIVEN.radius, resolution)
    assert grid.bytes > 32 * len(cube.lines)
    one, two = (grid.gather(GIVEN, rays, cube.powers, n_threads) for n_threads in (1, 2))
    check(one, expected)
    assert np.array_equal(one, two)


@needs_compiler
def test_brute_force(cube, rays, expected):
    check(brute_force(cube.lines, GIVEN, rays, cube.powers, 1), expected)


@needs_embree
@pytest.mark.parametrize("quality", ["low", "high"])
@pytest.mark.parametrize("length", [0.0, 0.1])
@pytest.mark.parametrize(("width", "coherent"), [(1, False), (8, False), (8, True), (16, False), (16, True)])
def test_embree(cube, rays, expected, length, quality, width, coherent):
    scenes, build = Scenes(cube.lines, GIVEN.radius, (0, 0, 0), 1), Build("user", length, quality)
    if width not in widths(scenes, build):
        pytest.skip(f"Embree splits packets of {width} on this processor")
    check(scenes.gather(Config(build, width, coherent), GIVEN, rays, cube.powers), expected)
