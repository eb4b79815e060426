"""Path-traced hair: energy is kept, one bounce is the averaged model, and pictures do not depend on their bands."""

from __future__ import annotations

import numpy as np
import pytest
from support.slow import few_of

import fastlines as fl
from fastlines.rendering import PictureOptions, PicturePlan, Renderer, progressive
from fastlines.rendering.hair import AveragedHair, HairMaterial
from fastlines.rendering.looks.look import Backdrop
from fastlines.rendering.looks.traced_hair import TracedHair
from fastlines.rendering.shading.lighting import Light, Rig, Sky

BACKDROP = Backdrop("#fff", "#fff")
FURNACE = Rig((), Sky((1, 1, 1), (1, 1, 1), (1, 1, 1)))
DARK = Sky((0, 0, 0), (0, 0, 0), (0, 0, 0))


def ball(n_strands=1500, n_points=5):
    """Return curly strands that overlap, in a ball of radius 1."""
    rng = np.random.default_rng(3)
    roots = rng.normal(size=(n_strands, 1, 3))
    roots *= 0.8 / np.linalg.norm(roots, axis=2, keepdims=True)
    steps = np.cumsum(rng.normal(scale=0.08, size=(n_strands, n_points, 3)), axis=1)
    return fl.Lines.from_strands(list((roots + steps).astype(np.float32)))


TREE = fl.build(ball())
CAMERA = fl.Camera(origin=(0, 0, 5), target=(0, 0, 0))


def light(radius, size=40, samples=2, **options):
    """Return the mean light of what lines cover, and the picture."""
    made = TracedHair(options.pop("material", HairMaterial()), BACKDROP, **options)
    picture = fl.render(TREE, CAMERA, width=size, height=size, look=made, radius=radius, samples=samples)
    assert np.isfinite(picture.light).all()
    return picture.light.sum(axis=(0, 1)) / picture.alpha.sum(), picture


@pytest.mark.parametrize("radius", few_of([0.004, 0.08], 1), ids=["thin", "thick"])
def test_hair_without_absorption_vanishes_in_a_white_furnace(radius):
    clear = HairMaterial(sigma_a=(0, 0, 0))
    mean, picture = light(radius, material=clear, rig=FURNACE, max_bounces=1000)
    assert mean == pytest.approx([1, 1, 1], rel=0.01)
    assert np.allclose(picture.light, picture.alpha[..., None], atol=0.1)


def test_absorption_and_fewer_bounces_take_light():
    tinted = HairMaterial(sigma_a=(0.05, 0.3, 1.0))
    mean, _ = light(0.02, material=tinted, rig=FURNACE)
    assert 1 > mean[0] > 1.1 * mean[1] > 1.3 * mean[2] > 0
    once, _ = light(0.02, material=tinted, rig=FURNACE, max_bounces=1)
    assert (once < 0.95 * mean).all()
    assert once[0] < 0.5 * mean[0]


def test_one_bounce_at_a_lone_hair_is_the_averaged_model():
    tree = fl.build([[[-4, 0, 0], [4, 0, 0]]])
    lamp = Light((0.3, 0.9, 0.6), (2.0, 2.0, 2.0), 0.5)
    look = TracedHair(HairMaterial(), BACKDROP, Rig((lamp,), DARK), max_bounces=1)
    camera = fl.Camera(origin=(0, 0, 40), target=(0, 0, 0), fov_degrees=2)
    picture = fl.render(tree, camera, width=96, height=96, look=look, radius=0.002, samples=24)
    seen = picture.light.sum(axis=(0, 1)) / picture.alpha.sum()
    towards = np.asarray(lamp.direction) / np.linalg.norm(lamp.direction)
    phi = np.arctan2(towards[1], towards[2])
    assert seen == pytest.approx(2.0 * AveragedHair(HairMaterial()).evaluate(0.0, towards[0], phi), rel=0.04)


def test_thin_and_thick_hairs_look_alike_from_afar_and_near():
    rig = Rig((Light((0.5, 0.5, 1.0), (3.0, 3.0, 3.0)),), Sky())
    means = [light(0.02, size, samples, rig=rig)[0] for size, samples in ((24, 16), (160, 2))]
    look, options = TracedHair(HairMaterial(), BACKDROP), PictureOptions(rig=rig, samples=1)
    assert Renderer(PicturePlan(TREE, CAMERA, 24, 24, 0.02, look, options)).context.thin
    assert means[0] == pytest.approx(means[1], rel=0.12)


@pytest.mark.parametrize("radius", [0.004, 0.08])
def test_a_picture_does_not_depend_on_its_bands(monkeypatch, radius):
    whole = light(radius, rig=Rig((Light((0.5, 0.5, 1.0)),), Sky()))[1]
    monkeypatch.setattr(progressive, "MAX_RAYS", 200)
    banded = light(radius, rig=Rig((Light((0.5, 0.5, 1.0)),), Sky()))[1]
    assert np.allclose(banded.light, whole.light, rtol=1e-4, atol=1e-6)


def test_skin_below_hair_scatters_light():
    box = fl.Boxes(np.array([[[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]]], np.float32))
    scene = fl.Geometry([TREE.geometry, box])
    picture = fl.render(scene, CAMERA, width=32, height=32, look="hair", quality="high", radius=0.01, samples=2)
    assert np.isfinite(picture.light).all()
    assert picture.alpha[16, 16] == 1
    assert picture.light[14:18, 14:18].mean() > 0.02


def test_high_quality_is_for_hair_alone():
    picture = fl.render(TREE, CAMERA, width=16, height=16, look="hair", quality="high", radius=0.02, samples=1)
    assert picture.light.mean() > 0
    with pytest.raises(fl.InputError, match=r"quality='high' does not apply.*the look 'tube'; leave it out"):
        fl.render(TREE, CAMERA, look="tube", quality="high", radius=0.02)
    with pytest.raises(fl.InputError, match="quality='highest' is not a choice"):
        fl.render(TREE, CAMERA, look="hair", quality="highest", radius=0.02)
    with pytest.raises(fl.InputError, match="and this is a lit look of your own"):
        fl.render(TREE, CAMERA, look=TracedHair(HairMaterial(), BACKDROP), quality="high", radius=0.02)
