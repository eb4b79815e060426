"""The light of fibres and tubes, against its formulas in NumPy."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.engines import engine
from fastlines.rendering.looks.surface_material import SurfaceMaterial
from fastlines.rendering.sampling.sobol import hashed, uniforms
from fastlines.rendering.shading.lighting import hemisphere, sphere
from fastlines.support.vectors import across, dot, unit

N = 1001
RANDOM = np.random.default_rng(2)
CAMERA = fl.Camera(origin=(1, 2, 4), target=(0, 0, 0))
UP = np.float32([0, 1, 0])
MATERIALS = [SurfaceMaterial(), SurfaceMaterial(0.2, 1.0), SurfaceMaterial(0.9, 0.4, 0.5)]


def vectors():
    return unit(RANDOM.normal(size=(N, 3)))


def reflected(axes, to_eye, base, towards, material, thin):
    half = unit(towards + to_eye)
    if thin:
        _, cos_i, across_i = across(axes, towards)
        even = (1 + dot(across_i, across(axes, to_eye)[2])) * cos_i / np.pi**2
        shine = np.maximum(1 - dot(axes, half) ** 2, 0) ** (material.exponent / 2) * even
    else:
        facing = dot(axes, towards)
        even, shine = np.maximum(facing, 0) / np.pi, np.maximum(dot(axes, half), 0) ** material.exponent * (facing > 0)
    white, colored = material.shine
    return base * ((1 - material.metallic) * even + colored * shine)[:, None] + (white * shine)[:, None]


def shaded(axes, to_eye, base, material, thin, rig, index=3, dimension=2):
    seeds = hashed(np.arange(N, dtype=np.uint32))
    constants = 1 - material.metallic, material.exponent, *material.shine
    arrays = rig.rows(CAMERA), rig.sky.row(UP).tolist(), (index, seeds, dimension)
    numbers = [uniforms(index, seeds, dimension + i).astype(np.float32) for i in range(6)]
    return engine.light_of_solids((axes, to_eye), base, thin, constants, *arrays)[:2], numbers


@pytest.mark.parametrize("thin", [False, True])
@pytest.mark.parametrize("material", MATERIALS)
def test_one_lamp_and_the_sky_are_what_their_formulas_say(material, thin):
    axes, to_eye, base = vectors(), vectors(), RANDOM.random((N, 3), np.float32)
    rig = fl.Rig([fl.Light((-1, 2, 0.5), (4, 3, 2), 12.0)], fl.Sky())
    ((towards, light), (to_sky, ambient)), u = shaded(axes, to_eye, base, material, thin, rig)
    lamp = rig.lights[0]
    assert towards[light.any(axis=1)] == pytest.approx(lamp.sample(CAMERA, *u[:2])[light.any(axis=1)], abs=1e-5)
    expected = np.float32(lamp.color) * reflected(axes, to_eye, base, lamp.sample(CAMERA, *u[:2]), material, thin)
    assert light == pytest.approx(expected, rel=1e-4, abs=1e-4 * float(expected.max()))
    expected = sphere(*u[4:]) if thin else hemisphere(axes, *u[4:])
    assert to_sky == pytest.approx(expected, abs=1e-5)
    share = (
        4 * np.pi * reflected(axes, to_eye, np.ones(3), expected, SurfaceMaterial(gloss=0), True)[:, :1] if thin else 1
    )
    assert ambient == pytest.approx(base * share * rig.sky.radiance(expected @ UP), rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("thin", [False, True])
def test_one_lamp_of_several_has_the_light_of_all_on_average(thin):
    axes, to_eye, base = vectors(), vectors(), RANDOM.random((N, 3), np.float32)
    rig = fl.RIGS["studio"]
    alone = [fl.Rig([light], rig.sky) for light in rig.lights]
    material = SurfaceMaterial()
    mean = np.zeros((N, 3))
    for index in range(256):
        mean += shaded(axes, to_eye, base, material, thin, rig, index)[0][0][1] / 256
    expected = np.zeros((N, 3))
    for index in range(64):
        for one in alone:
            expected += shaded(axes, to_eye, base, material, thin, one, index)[0][0][1] / 64
    assert mean.sum(axis=1) == pytest.approx(expected.sum(axis=1), rel=0.03, abs=0.02)
    assert mean == pytest.approx(expected, rel=0.15, abs=0.05)
    assert mean.sum(axis=0) == pytest.approx(expected.sum(axis=0), rel=3e-3)


def test_without_lamps_there_is_the_sky_alone():
    axes, to_eye, base = vectors(), vectors(), np.ones((N, 3), np.float32)
    ((_, light), (_, ambient)), _ = shaded(axes, to_eye, base, SurfaceMaterial(), False, fl.Rig([]))
    assert not light.any()
    assert (ambient > 0).all()
