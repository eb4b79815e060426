"""Photons: where they fly, and where their power goes."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.beams import (
    AreaLight,
    BeamScene,
    Diffuse,
    DirectionalLight,
    Glass,
    GridMedium,
    HomogeneousMedium,
    Mirror,
    PointLight,
    SpotLight,
    trace_photons,
)

BOX = [[-1, -1, -1], [1, 1, 1]]
LIGHTS = [
    PointLight((0.2, 0.6, 0.1), 2),
    SpotLight((0, 0.9, 0), (0, 0, 0), (1, 2, 3), 20),
    AreaLight((-0.3, 0.99, -0.3), (0.6, 0, 0), (0, 0, 0.6), 5),
    DirectionalLight((1, -1, 0), 0.1),
]
BALL = fl.Spheres.from_centres([[0, 0, 0]], radius=0.5)
RGB_FOG = HomogeneousMedium((0.1, 0.2, 0.3), (0.7, 0.6, 0.4), 0.4)


def cube(material):
    return fl.Boxes([BOX]), material


def lost(energy):
    return energy.absorbed_by_medium + energy.absorbed_by_surfaces + energy.escaped + energy.cut_off


@pytest.mark.parametrize("kind", ["short", "long"])
def test_no_power_is_lost(kind):
    surfaces = [cube(Diffuse((0.9, 0.5, 0.1))), (BALL, Glass(1.4, 0.9))]
    scene = BeamScene(RGB_FOG, LIGHTS[:3], surfaces)
    energy = trace_photons(scene, 4000, kind=kind).energy
    assert np.allclose(energy.emitted, lost(energy), rtol=1e-9)
    assert (energy.escaped == 0).all()  # of a closed box, none
    assert energy.emitted == pytest.approx(scene.power, rel=0.05)


def test_a_closed_cube_of_mirrors_keeps_all_light_in_the_medium():
    energy = trace_photons(BeamScene(HomogeneousMedium(0.12, 0.68, 0.3), LIGHTS[:1], [cube(Mirror())]), 2000).energy
    assert energy.emitted == pytest.approx([2, 2, 2])
    assert np.allclose(energy.absorbed_by_medium, energy.emitted, rtol=1e-12)


def test_channels_lose_what_their_extinction_says():
    scene = BeamScene(RGB_FOG, LIGHTS[:1], box=BOX)
    energy = trace_photons(scene, 20_000, max_scatterings=0).energy
    grey = [
        trace_photons(BeamScene(HomogeneousMedium(a, s, 0.4), LIGHTS[:1], box=BOX), 20_000, max_scatterings=0).energy
        for a, s in zip(RGB_FOG.absorption, RGB_FOG.scattering, strict=True)
    ]
    assert energy.escaped == pytest.approx([one.escaped[0] for one in grey], rel=0.03)
    assert energy.cut_off == pytest.approx([one.cut_off[0] for one in grey], rel=0.03)


@pytest.mark.parametrize("medium", [RGB_FOG, GridMedium(np.ones((3, 2, 4)), BOX, 0.5, 0.5)])
def test_beams_do_not_depend_on_the_batch(medium):
    scene = BeamScene(medium, LIGHTS, [(BALL, Glass())], box=BOX)
    whole = trace_photons(scene, 500, seed=3, pass_number=2)
    parts = trace_photons(scene, 500, seed=3, pass_number=2, batch=37)
    assert (whole.lines.segments == parts.lines.segments).all()
    assert (whole.power == parts.power).all()
    assert (whole.path == parts.path).all()
    assert (np.diff(whole.path) >= 0).all()
    other = trace_photons(scene, 500, seed=3, pass_number=3)
    assert len(other) != len(whole) or (other.lines.segments != whole.lines.segments).any()


def test_short_beams_are_exponential_and_long_ones_end_at_the_box():
    scene = BeamScene(HomogeneousMedium(0.5, 1.5), [PointLight((0, 0, 0), 1)], box=BOX)
    short = trace_photons(scene, 20_000, max_scatterings=0)
    length = np.linalg.norm(np.diff(short.lines.segments, axis=1)[:, 0], axis=1)
    inside = np.abs(short.lines.segments[:, 1]).max(axis=1) < 1 - 1e-6
    for least in (0.2, 0.5, 0.9):
        assert (length > least).mean() == pytest.approx(np.exp(-2 * least), abs=0.01)
    assert inside.mean() > 0.5
    assert (short.decay == 0).all()
    long = trace_photons(scene, 100, kind="long", max_scatterings=0)
    assert np.abs(long.lines.segments[:, 1]).max(axis=1) == pytest.approx(1, abs=1e-6)
    assert (long.decay == 2).all()


def test_a_medium_on_a_grid_flies_as_a_homogeneous_one():
    grid = GridMedium(np.full((4, 4, 4), 2.0), BOX, (0.05, 0.1, 0.15), (0.35, 0.3, 0.2), 0.4)
    one, other = (
        trace_photons(BeamScene(medium, LIGHTS[:1], box=BOX), 200, max_scatterings=3) for medium in (RGB_FOG, grid)
    )
    assert np.allclose(one.lines.segments, other.lines.segments, atol=1e-4)
    assert np.allclose(one.power, other.power, rtol=1e-3)


def test_photons_stay_out_of_where_the_grid_is_empty():
    density = np.zeros((8, 8, 8))
    density[:, :, :3] = 3.0
    scene = BeamScene(GridMedium(density, BOX, 0, 1), [PointLight((0, 0, 0.9), 1)])
    beams = trace_photons(scene, 2000)
    first = np.flatnonzero(np.diff(beams.path, prepend=-1))
    collided = np.abs(beams.lines.segments[first, 1]).max(axis=1) < 1 - 1e-6
    assert collided.any()
    assert beams.lines.segments[first][collided, 1, 2].max() < 0  # below the centres of the first empty voxels


def test_glass_that_touches_other_glass_is_not_in_it():
    two = [[[-1, -1, -1], [0, 1, 1]]], [[[0, -1, -1], [1, 1, 1]]]
    scene = BeamScene(RGB_FOG, [DirectionalLight((0, -1, 0), 1)], [(fl.Boxes(box), Glass()) for box in two])
    assert len(scene.surfaces.materials) == 2


def test_there_is_no_medium_in_glass():
    scene = BeamScene(HomogeneousMedium(0.5, 2), LIGHTS[:1], [(BALL, Glass())], box=BOX)
    beams = trace_photons(scene, 3000)
    middle = beams.lines.segments.mean(axis=1)
    assert np.linalg.norm(middle, axis=1).min() > 0.499


def test_lights_emit_their_power_where_they_should():
    keys = np.arange(20_000, dtype=np.uint64)
    box = np.array(BOX, float)
    spot = LIGHTS[1].emit(keys, box)
    assert (spot.directions @ [0, -1, 0]).min() >= np.cos(np.radians(20)) - 1e-12
    area = LIGHTS[2].emit(keys, box)
    assert (area.origins.min(axis=0) >= [-0.3, 0.99, -0.3]).all()
    assert (area.directions[:, 1] < 0).all()
    assert -area.directions[:, 1].mean() == pytest.approx(2 / 3, abs=0.01)
    sun = LIGHTS[3].emit(keys, box)
    assert np.allclose(sun.directions, np.array([1, -1, 0]) / np.sqrt(2))
    begin, end = BeamScene(RGB_FOG, LIGHTS, box=BOX).in_box(sun.origins, sun.directions)
    across = 2 * 2 * np.sqrt(2)  # the area of the box as the sun sees it
    assert (begin < end).mean() == pytest.approx(across / (3 * np.pi), abs=0.02)
    assert np.mean(BeamScene(RGB_FOG, LIGHTS, box=BOX).emit(keys).power, axis=0) == pytest.approx(
        BeamScene(RGB_FOG, LIGHTS, box=BOX).power, rel=0.02
    )


def under_a_roof(width):
    """Return a scene with the sun above a black roof, which is above the medium."""
    roof = fl.Boxes([[[-1, 3, -1], [width - 1, 3.1, 1]]])
    sun = DirectionalLight((0, -1, 0), 3)
    return BeamScene(HomogeneousMedium(0, 1e-3), [sun], [(roof, Diffuse(0))], box=BOX)


def test_a_roof_takes_all_light_of_the_sun():
    with pytest.raises(fl.InputError, match="none of 1,000 photons flies through the medium"):
        trace_photons(under_a_roof(2.0), 1000)


def test_half_a_roof_takes_half_of_the_light_of_the_sun():
    scene = under_a_roof(1.0)
    assert scene.bounds.tolist() == [[-1, -1, -1], pytest.approx([1, 3.1, 1])]
    beams = trace_photons(scene, 20_000, kind="long", max_scatterings=0)
    assert beams.energy.emitted[0] == pytest.approx(3 * np.pi * (2**2 + 4.1**2 + 2**2) / 4)
    assert beams.energy.absorbed_by_surfaces[0] == pytest.approx(3 * 2, rel=0.05)
    assert beams.power[:, 0].sum() / beams.n_paths == pytest.approx(3 * 2, rel=0.05)
    assert beams.lines.segments[..., 0].min() > 0


def test_a_mesh_of_glass_is_as_the_sphere():
    """A closed mesh refracts by the order of its corners."""
    box = fl.Boxes([[[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]]])
    corners, _ = box.outlines()
    mesh = fl.Triangles(np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]]))
    inward = np.cross(mesh.corners[:, 1] - mesh.corners[:, 0], mesh.corners[:, 2] - mesh.corners[:, 0])
    flip = (inward * mesh.corners.mean(axis=1)).sum(axis=1) < 0
    turned = mesh.corners.copy()
    turned[flip] = turned[flip][:, ::-1]
    ends = []
    for geometry in (box, fl.Triangles(turned)):
        scene = BeamScene(HomogeneousMedium(0.1, 0.2), LIGHTS[:1], [(geometry, Glass())], box=BOX)
        ends.append(trace_photons(scene, 500, max_scatterings=0).lines.segments)
    assert np.allclose(ends[0], ends[1], atol=1e-3)
