"""Compiled path tracing: random numbers are those of the definition, and a bounce is that of NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from support.path_reference import Bounce, Numbers

import fastlines as fl
from fastlines.engines import available_simd, engine, set_simd
from fastlines.rendering.hair import HairMaterial
from fastlines.rendering.path_tracing.path_tracer import SKIN
from fastlines.rendering.path_tracing.path_vertices import PathVertices
from fastlines.rendering.sampling.sobol import hashed, uniforms
from fastlines.rendering.shading.lighting import SALON, SOFT, Rig, Sky
from fastlines.support.vectors import dot, unit

CAMERA = fl.Camera(origin=(0, 1, 5), target=(0, 0, 0))
LEAST = 1e-5


def random_vertices(n, seed=0):
    """Return vertices of fibres in all directions, of which each seventh is a surface without an axis."""
    rng = np.random.default_rng(seed)
    tangents, across, to_eye = (unit(rng.normal(size=(n, 3)).astype(np.float32)) for _ in range(3))
    normals = unit(across - dot(across, tangents)[:, None] * tangents)
    to_eye = np.where((dot(to_eye, normals) < 0)[:, None], -to_eye, to_eye)
    tangents[::7] = 0
    points, radius = rng.normal(size=(n, 3)).astype(np.float32), rng.uniform(0.001, 0.1, n).astype(np.float32)
    return PathVertices(points, normals, tangents, to_eye, radius, np.arange(n), np.zeros(n, np.int64))


def scattered(vertices, weight, seeds, step, rig, material):
    """Scatter light by compiled code."""
    paths = np.arange(len(vertices)), weight, seeds
    return engine.scatter_paths((rig.rows(CAMERA), material.numbers, SKIN, LEAST), step, vertices.columns, paths)


@pytest.mark.parametrize("dimension", [0, 1, 2, 7, 22, 23])
@pytest.mark.parametrize("index", [0, 1, 5, 1023, 2**32 - 1])
def test_random_numbers_are_those_of_the_definition(index, dimension):
    seeds = hashed(np.arange(333, dtype=np.uint32))
    found = engine.sample_numbers(index, seeds, dimension, 3)
    assert [each.shape for each in found] == [(333,)] * 3
    for k, each in enumerate(found):
        assert (each == uniforms(index, seeds, dimension + k)).all()
    assert [len(each) for each in engine.sample_numbers(index, seeds[:0], 0, 2)] == [0, 0]


@pytest.mark.parametrize("rig", [SALON, SOFT, Rig((), Sky())], ids=["three", "one", "none"])
@pytest.mark.parametrize(("bounce", "dimension"), [(0, 4), (1, 12), (4, 20), (9, 200)])
def test_a_bounce_is_that_of_numpy(rig, bounce, dimension):
    n, index = 3001, 6
    vertices = random_vertices(n)
    weight = np.random.default_rng(1).uniform(0.05, 1, (n, 3)).astype(np.float32)
    seeds, material = hashed(np.arange(n, dtype=np.uint32)), HairMaterial.from_melanin(0.4)
    shadows, onward, after = scattered(vertices, weight, seeds, (index, dimension, bounce), rig, material)
    numbers = Numbers(index, seeds, dimension)
    expected = Bounce(vertices, weight, numbers, bounce, rig, CAMERA, material, SKIN)
    assert after == numbers.dimension
    # The rays to lights, and what each offers.
    assert len(shadows) == len(expected.offers)
    for (vertex, points, directions, start, light), (towards, offered, is_offered) in zip(
        shadows, expected.offers, strict=True
    ):
        assert (np.isin(np.arange(n), vertex) == is_offered).mean() > 0.999
        same = np.abs(directions - towards[vertex]).max(axis=1) < 1e-5  # else another light was chosen, by rounding
        assert same.mean() > 0.999
        vertex = vertex[same]
        assert (points[same] == vertices.points[vertex]).all()
        assert start[same] == pytest.approx(expected.exits(towards, LEAST)[vertex], rel=1e-4)
        assert light[same] == pytest.approx(offered[vertex], rel=1e-4, abs=1e-5 * offered.max())
    # The rays that go on.
    vertex, points, directions, start, light = onward
    assert np.isin(np.arange(n), vertex)[expected.lasts].mean() > 0.999
    near = np.abs(directions - expected.towards[vertex]).max(axis=1) < 2e-4  # else another lobe was chosen, by rounding
    assert near.mean() > 0.995
    vertex = vertex[near]
    assert (points[near] == vertices.points[vertex]).all()
    assert start[near] == pytest.approx(expected.exits(expected.towards, LEAST)[vertex], rel=1e-2)
    assert light[near] == pytest.approx(expected.weight[vertex], rel=1e-3)


def test_a_bounce_is_the_same_for_all_instruction_sets():
    vertices, seeds = random_vertices(500), hashed(np.arange(500, dtype=np.uint32))
    weight = np.ones((500, 3), np.float32)
    found = []
    for name in available_simd():
        set_simd(name)
        try:
            shadows, onward, _ = scattered(vertices, weight, seeds, (3, 8, 4), SALON, HairMaterial())
        finally:
            set_simd(None)
        found.append(b"".join(each.tobytes() for rays in (*shadows, onward) for each in rays))
    assert len(set(found)) == 1


def test_light_is_added_where_nothing_hides_it_and_where_rays_leave():
    light, path = np.zeros((3, 3), np.float32), np.array([2, 0])
    vertex, offered = np.array([0, 1, 0]), np.arange(9, dtype=np.float32).reshape(3, 3)
    engine.add_offered(light, path, vertex, offered, np.array([True, False, True]))
    assert light.tolist() == [[0, 0, 0], [0, 0, 0], [6, 8, 10]]
    directions = unit(np.array([[0.0, 1, 0], [1, -1, 0]]))
    sky, up = Sky((1, 2, 3), (0.5, 0.5, 0.5), (0, 0.25, 0)), np.array([0, 1, 0], np.float32)
    light[:] = 0
    engine.add_sky(
        light, path, 2 * np.ones((2, 3), np.float32), directions, np.array([True, True]), sky.row(up).tolist()
    )
    assert light[[2, 0]] == pytest.approx(2 * sky.radiance(directions[:, 1]))
    engine.add_sky(light, path, np.ones((2, 3), np.float32), directions, np.array([False, False]), sky.row(up).tolist())
    assert light[[2, 0]] == pytest.approx(2 * sky.radiance(directions[:, 1]))
