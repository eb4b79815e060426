"""What a picture is made of: colours of any form, lights, and the camera that it keeps, with which one can pick."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering import MEASURES
from fastlines.rendering.color.palette import hexadecimal, light_of

HAIR = fl.build(fl.scenes.make("bun-hair", 500).lines)
LINES = fl.build(fl.scenes.make("spaghetti", 200).lines)
SMALL = {"width": 24, "height": 24, "samples": 1}


def pixels(tree, **options):
    return fl.render(tree, **SMALL, **options).to_bytes()


# --- Colours ---


@pytest.mark.parametrize("look", ["tube", "fibre", "hair"])
@pytest.mark.parametrize("color", [(1, 0.5, 0), [1, 0.5, 0], np.array([1, 0.5, 0])])
def test_three_numbers_are_a_colour_as_a_screen_shows_it(look, color):
    exact = tuple(round(255 * value) for value in color)
    text = "#" + "".join(f"{value:02x}" for value in exact)
    assert np.abs(pixels(HAIR, look=look, color=color).astype(int) - pixels(HAIR, look=look, color=text)).max() <= 1
    assert light_of(tuple(value / 255 for value in exact)) == hexadecimal(text)


def test_a_material_is_a_colour_of_hair():
    material = fl.HairMaterial.from_melanin(0.9)
    for quality in ("normal", "high"):
        picture = fl.render(HAIR, look="hair", color=material, quality=quality, **SMALL)
        assert picture.look.material is material
    assert (pixels(HAIR, look="hair", color=material) != pixels(HAIR, look="hair")).any()
    with pytest.raises(fl.InputError, match="is for the look 'hair'; name that look, or another colour"):
        fl.render(LINES, color=material, **SMALL)


@pytest.mark.parametrize("name", ["color", "color_map", "rig", "background", "look", "quality", "aovs", "legend"])
@pytest.mark.parametrize(
    "value", [3, [1], (1, 2), (1, 2, 3), {}, b"red", float("nan"), np.zeros(2), object(), fl.HairMaterial, 10**400]
)
def test_what_is_no_option_is_refused(name, value):
    with pytest.raises(fl.InputError):
        fl.render(LINES, **SMALL, **{name: value})


# --- Lights ---


def test_lights_of_your_own():
    dark = fl.Rig([], fl.Sky((0, 0, 0), (0, 0, 0), (0, 0, 0)))
    lamp = fl.Rig([fl.Light([-1, 1, 1], color=np.array([6, 0, 0]), angle=1)], dark.sky)
    assert lamp.lights[0].color == (6.0, 0.0, 0.0)
    lines = fl.build(fl.lines([[[0, 0, 0], [1, 1, 1]]]).with_radius(0.2))
    for rig, red in ((dark, False), (lamp, True)):
        light = fl.render(lines, rig=rig, **SMALL).light
        assert (light[..., 0].max() > 0.1) == red
        assert light[..., 1].max() < 1e-3
    for quality in ("normal", "high"):
        assert fl.render(HAIR, look="hair", quality=quality, rig=dark, **SMALL).light.max() < 1e-3
    for rig in fl.RIGS.values():
        assert fl.render(lines, rig=rig, **SMALL).rig == rig


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: fl.Light((0, 0, 0)), "not all 0"),
        (lambda: fl.Light((0, float("inf"), 0)), "three finite numbers"),
        (lambda: fl.Light("abc"), "three finite numbers"),
        (lambda: fl.Light(3), "three finite numbers"),
        (lambda: fl.Light((0, 0, 1), (1, -1, 0)), "not negative"),
        (lambda: fl.Light((0, 0, 1), angle=90), "less than 90"),
        (lambda: fl.Sky(top=(1, 1)), "three numbers"),
        (lambda: fl.Rig(fl.Light((0, 0, 1))), "a list of Light"),
        (lambda: fl.Rig([1]), "a list of Light"),
        (lambda: fl.Rig([], sky=None), "a Sky"),
    ],
)
def test_bad_lights_are_refused(make, words):
    with pytest.raises(fl.InputError, match=words):
        make()


# --- What a picture keeps ---


def test_one_can_pick_in_a_picture():
    picture = fl.render(LINES, width=40, height=30, radius=0.02, samples=1, aovs=True)
    assert picture.camera == fl.default_camera(LINES.geometry, aspect=4 / 3)
    for row, column in np.argwhere(picture.aovs["id"] >= 0)[::20]:
        origin, direction, _ = picture.camera.ray(column + 0.5, row + 0.5, 40, 30)
        hit = LINES.first_hit(origin, direction, picture.radius)
        assert hit.prim == picture.aovs["prim"][row, column]


@pytest.mark.parametrize("look", ["hair", "fibre", "tube", "depth", "hits"])
def test_what_a_picture_keeps_makes_it_again(look):
    picture = fl.render(LINES, look=look, **SMALL)
    again = fl.render(LINES, picture.camera, look=picture.look, radius=picture.radius, rig=picture.rig, **SMALL)
    assert (again.to_bytes() == picture.to_bytes()).all()
    assert (picture.rig is None) == (look in ("depth", "hits"))
    assert isinstance(picture, fl.Picture)
    if look == "hits":
        assert picture.look is MEASURES["hits"]
    if look == "hair":
        assert isinstance(picture.look.material, fl.HairMaterial)
