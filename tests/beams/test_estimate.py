"""Estimates of light against integrals, and against each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import fastlines as fl
from fastlines.beams import (
    BeamMap,
    BeamScene,
    Glass,
    GridMedium,
    HomogeneousMedium,
    Mirror,
    PointLight,
    single_scattering,
    trace_photons,
)
from fastlines.beams.camera_paths import camera_legs
from fastlines.beams.materials import fresnel
from fastlines.support.counter_random import random_bits

BOX = [[-1, -1, -1], [1, 1, 1]]
FOG = HomogeneousMedium((0.1, 0.2, 0.4), (0.5, 0.7, 0.9), 0.4)
LIGHT = PointLight((0, 0, 0), (100, 50, 25))
SCENE = BeamScene(FOG, [LIGHT], box=BOX)
#: Rays at several distances from the light, from without and from within.
ORIGINS = np.array([[0.2, 0.05, -3], [0.35, 0.0, -3], [0.5, 0.1, -3], [0.3, 0.2, -0.5]])
DIRECTIONS = np.array([[0.1, 0.05, 1]] * 4)


def passes(scene, n_passes, radius, n_paths=5000, kind="short", rays=(ORIGINS, DIRECTIONS), **options):
    """Return the light of several passes, (n_passes, n_rays, 3)."""
    light = []
    for i in range(n_passes):
        beams = trace_photons(scene, n_paths, kind=kind, max_scatterings=0, pass_number=i)
        keys = random_bits(i, np.arange(len(rays[0])))
        light.append(BeamMap(scene, beams).radiance(*rays, radius, keys=keys, **options))
    return np.array(light)


def assert_agrees(light, expected, bias=0.0):
    """Assert that the mean is within three standard errors, and a bias, of what is expected."""
    error = light.std(axis=0, ddof=1) / np.sqrt(len(light))
    assert (np.abs(light.mean(axis=0) - expected) < 3 * error + bias * expected).all()
    assert (error < 0.15 * expected).all()


@pytest.mark.parametrize("kind", ["short", "long"])
@pytest.mark.parametrize("blur", ["box", "epanechnikov"])
def test_beams_converge_to_the_integral(kind, blur):
    light = passes(SCENE, 20, 0.02, kind=kind, blur=blur)
    assert_agrees(light, single_scattering(SCENE, ORIGINS, DIRECTIONS), bias=0.003)


def test_beams_with_a_radius_that_suits_their_density():
    sharp, blurred = [], []
    for i in range(20):
        beams = trace_photons(SCENE, 5000, max_scatterings=0, pass_number=i)
        adapted = BeamMap(SCENE, beams, own_radius=0.02)
        sharp.append(adapted.radiance(ORIGINS, DIRECTIONS))
        blurred.append(adapted.radiance(ORIGINS, DIRECTIONS, 0.02))
    radius = adapted.lines.radius
    # Beams start together, and end apart.
    assert radius.shape == (len(beams),)
    assert (radius.min(), radius.max()) == (pytest.approx(0.005), pytest.approx(0.02))
    for light in (sharp, blurred):
        assert_agrees(np.array(light), single_scattering(SCENE, ORIGINS, DIRECTIONS), bias=0.003)


@pytest.mark.parametrize("degrees", [90, 45, 20])
def test_beams_with_their_own_radius_keep_their_light(degrees):
    """Over a plane across parallel rays, the light of a beam integrates to its power, times σ_s and its length."""
    thin = BeamScene(HomogeneousMedium(0, 1e-6), [LIGHT], box=BOX)
    # Both start at one point, where the radius is small, and end far from each other.
    ends = np.array([[[-0.5, 0, 0], [0.5, 0, 0]], [[-0.5, 0, 0], [-0.5, 0, 1]]])
    beams = replace(trace_photons(thin, 2), lines=fl.Lines.from_segments(ends), power=np.ones((2, 3), np.float32))
    adapted = BeamMap(thin, beams, own_radius=0.02)
    assert adapted.lines.radius == pytest.approx(np.full(2, 0.02))
    way = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0])
    n, side = 600, 1.2
    places = np.stack(np.meshgrid(np.arange(n), np.arange(n))) + np.random.default_rng(1).random((2, n, n))
    x, z = (places * (side / n) - [[[0.6]], [[0.1]]]).reshape(2, -1)
    origins = x[:, None] * np.cross(way, [0, 0, 1]) + z[:, None] * [0, 0, 1] - 3 * way
    light = adapted.radiance(origins, way, blur="epanechnikov")[:, 0].sum() * (side / n) ** 2
    assert light == pytest.approx(2 * 1e-6 / 2 / (4 * np.pi), rel=2e-3)


def test_points_converge_to_the_integral():
    light = passes(SCENE, 20, 0.05, estimator="point")
    assert_agrees(light, single_scattering(SCENE, ORIGINS, DIRECTIONS), bias=0.01)


@pytest.mark.parametrize("kind", ["short", "long"])
@pytest.mark.parametrize("medium", [FOG, replace(FOG, absorption=(0.2,) * 3, scattering=(0.8,) * 3, g=0)])
def test_a_grid_of_equal_voxels_is_a_homogeneous_medium(kind, medium):
    grid = GridMedium(np.full((5, 6, 7), 1.0), BOX, medium.absorption, medium.scattering, medium.g)
    one, other = (passes(BeamScene(m, [LIGHT], box=BOX), 2, 0.05, kind=kind).mean(axis=0) for m in (medium, grid))
    assert one == pytest.approx(other, rel=0.03)


@pytest.mark.parametrize("kind", ["short", "long"])
def test_a_grid_scatters_as_the_integral_says(kind):
    rng = np.random.default_rng(2)
    grid = GridMedium(rng.random((8, 9, 10)) * 2, BOX, (0.1, 0.2, 0.4), (0.5, 0.7, 0.9), 0.4)
    scene = BeamScene(grid, [LIGHT])
    expected = []
    for origin, direction in zip(ORIGINS, DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1)[:, None], strict=True):
        begin, end = (float(t[0]) for t in scene.in_box(origin[None], direction[None]))
        t = begin + (np.arange(2000) + 0.5) / 2000 * (end - begin)
        points = origin + t[:, None] * direction
        distance = np.linalg.norm(points, axis=1)
        from_light = points / distance[:, None]
        cosine = -from_light @ direction
        phase = (1 - 0.4**2) / (4 * np.pi * (1 + 0.4**2 - 0.8 * cosine) ** 1.5)
        start = np.tile(origin + begin * direction, (len(t), 1))
        passed = grid.transmittance(start, np.tile(direction, (len(t), 1)), t - begin)
        passed *= grid.transmittance(np.zeros(points.shape), from_light, distance)
        light = grid.density_at(points)[:, None] * grid.scattering * passed * LIGHT.power
        expected.append((light * (phase / (4 * np.pi * distance**2))[:, None]).sum(axis=0) * (end - begin) / len(t))
    n_paths = 4000 if kind == "short" else 1500
    assert_agrees(passes(scene, 12, 0.03, n_paths=n_paths, kind=kind), np.array(expected), bias=0.02)


def test_pieces_in_a_dense_voxel_are_few_and_keep_all_light():
    """A beam that is all scattered within a piece has scattered its power, times the albedo."""
    density = np.zeros((8, 8, 8))
    density[4, 4, 4] = 1e6
    grid = GridMedium(density, BOX, 0.2, 0.8)
    through = np.array([[[-1, 0.125, 0.125], [1, 0.125, 0.125]]], np.float32)
    sources = grid.sources(np.repeat(through, 20, axis=0), grid.extinction)
    assert len(sources.segments) <= 20 * 8 * 2 * 8
    lengths = np.linalg.norm(np.diff(sources.segments, axis=1)[:, 0], axis=1)
    assert (sources.scattered * lengths[:, None]).sum(axis=0) / 20 == pytest.approx([0.8] * 3)


def test_depths_of_a_fine_grid_are_looked_up_in_parts(monkeypatch):
    grid = GridMedium(np.random.default_rng(1).random((6, 5, 4)), BOX, 0.2, 0.8)
    scene = BeamScene(grid, [LIGHT])
    whole = passes(scene, 1, 0.1, n_paths=300)
    monkeypatch.setattr("fastlines.beams.estimate.DEPTHS_AT_A_TIME", 1)
    monkeypatch.setattr("fastlines.beams.grid_medium.LOOKUPS", 1)
    assert (passes(scene, 1, 0.1, n_paths=300) == whole).all()


def cut(beams, n, scene):
    """Cut each beam into n pieces, whose power is what is left of it."""
    start, end = np.moveaxis(beams.lines.segments.astype(np.float64), 1, 0)
    part = np.arange(n + 1) / n
    joints = start[:, None] + part[:, None] * (end - start)[:, None]
    pieces = np.stack([joints[:, :-1], joints[:, 1:]], axis=2).reshape(-1, 2, 3)
    flown = np.linalg.norm(end - start, axis=1)[:, None] * part[:-1]
    left = np.exp(-flown[..., None] * beams.decay)
    power = (beams.power[:, None] * left).reshape(-1, 3).astype(np.float32)
    return replace(beams, lines=fl.Lines.from_segments(pieces), power=power)


@pytest.mark.parametrize("estimator", ["beam", "point"])
@pytest.mark.parametrize("kind", ["short", "long"])
def test_the_ends_of_beams_add_nothing(kind, estimator):
    beams = trace_photons(SCENE, 3000, kind=kind)
    rays = ORIGINS, DIRECTIONS, 0.1
    whole = BeamMap(SCENE, beams).radiance(*rays, estimator=estimator)
    in_pieces = BeamMap(SCENE, cut(beams, 50, SCENE)).radiance(*rays, estimator=estimator)
    assert in_pieces == pytest.approx(whole, rel=2e-3 if estimator == "beam" else 2e-2)


def wall(x):
    return fl.Triangles([[[x, -9, -9], [x, 9, -9], [x, 0, 18]]])


def test_a_mirror_shows_the_scene_and_the_light_again():
    """Light and rays that a mirror reflects go as straight ones do in the scene with its mirror image."""
    at = np.array([0.4, 0.1, 0.0])
    light, image = PointLight(at, 10), PointLight(at * [-1, 1, 1], 10)
    scene = BeamScene(FOG, [light], [(wall(0.0), Mirror(1.0))], box=[[0, -1, -1], [1, 1, 1]])
    rays = np.array([[0.9, 0.4, 0.3], [0.8, -0.5, -0.2]]), np.array([[-1, -0.2, 0.1], [-1, 0.3, 0.3]])
    expected = sum(single_scattering(BeamScene(FOG, [one], box=BOX), *rays) for one in (light, image))
    assert_agrees(passes(scene, 20, 0.02, rays=rays), expected, bias=0.003)


def test_rays_go_straight_through_glass_that_does_not_refract():
    ball = fl.Spheres.from_centres([[0, 0, 0]], radius=0.5)
    scene = BeamScene(FOG, [PointLight((0.9, 0, 0), 1)], [(ball, Glass(1.0, 0.8))], box=BOX)
    rays = np.array([[0.3, 0, -3.0], [0.8, 0, -3]]), np.array([[0.0, 0, 1]] * 2)
    first, second = camera_legs(scene, *rays, random_bits(0, np.arange(2)))
    assert first.rays.tolist() == [0, 1]
    assert first.lengths == pytest.approx([0.6, 2], abs=1e-4)
    assert second.rays.tolist() == [0]
    assert second.origins[0] == pytest.approx([0.3, 0, 0.4], abs=1e-4)
    assert second.lengths == pytest.approx([0.6], abs=1e-4)
    assert second.throughput[0] == pytest.approx(0.64 * np.exp(-0.6 * FOG.extinction), rel=1e-3)


def test_glass_focuses_light_behind_it():
    """Behind a ball of glass its rays meet at ior / (ior − 1) / 2 radii from the centre, near the axis."""
    ball = fl.Spheres.from_centres([[0, 0, 0]], radius=0.25)
    sun = fl.beams.DirectionalLight((0, 0, 1), 1)
    scene = BeamScene(HomogeneousMedium(0, 0.01), [sun], [(ball, Glass(1.5))], box=BOX)
    ends = trace_photons(scene, 60_000, max_scatterings=0, kind="long").lines.segments.astype(np.float64)
    refracted = ends[np.linalg.norm(ends[:, 0] - [0, 0, 0.25], axis=1) < 0.02]
    start, way = refracted[:, 0], np.diff(refracted, axis=1)[:, 0]
    off = np.hypot(start[:, 0], start[:, 1])
    kept = (off > 2e-3) & (way[:, 2] > 0) & (np.hypot(way[:, 0], way[:, 1]) > 1e-4)
    focus = start[kept, 2] - (start * way)[kept, :2].sum(axis=1) / (way[kept, :2] ** 2).sum(axis=1) * way[kept, 2]
    assert np.median(focus) == pytest.approx(0.375, abs=0.01)


def test_a_ray_goes_both_ways_at_glass_with_the_right_shares():
    ball = fl.Spheres.from_centres([[0, 0, 0]], radius=0.5)
    scene = BeamScene(HomogeneousMedium(0, 1e-9), [PointLight((0.9, 0, 0), 1)], [(ball, Glass(1.5))], box=BOX)
    n = 4000
    rays = np.tile([0.4, 0.0, -3.0], (n, 1)), np.tile([0.0, 0.0, 1.0], (n, 1))
    legs = list(camera_legs(scene, *rays, random_bits(0, np.arange(n))))
    cosine = np.array([np.sqrt(0.5**2 - 0.4**2) / 0.5])
    share = float(fresnel(cosine, 1.5)[0])
    reflected = (legs[1].directions[:, 2] < 0.99) & (legs[1].origins[:, 2] < 0)
    assert legs[1].throughput[reflected, 0].sum() / n == pytest.approx(share, rel=0.1)
    # Beside it, what passes both surfaces, and what is reflected within the ball once or more.
    assert sum(one.throughput[:, 0].sum() for one in legs[1:]) / n == pytest.approx(1, rel=0.02)
