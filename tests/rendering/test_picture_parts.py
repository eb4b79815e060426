"""What a picture is made of: colours of any form, lights, and the camera that it keeps, with which one can pick."""

from __future__ import annotations

import zlib

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


# --- Materials ---


def test_hair_has_a_material_in_place_of_a_colour():
    material = fl.HairMaterial.from_melanin(0.9)
    for quality in ("normal", "high"):
        picture = fl.render(HAIR, look="hair", material=material, quality=quality, **SMALL)
        assert picture.look.material is material
    assert (pixels(HAIR, look="hair", material=material) != pixels(HAIR, look="hair")).any()
    with pytest.raises(fl.InputError, match="is for the look 'hair'; name that look, or give a SurfaceMaterial"):
        fl.render(LINES, material=material, **SMALL)
    with pytest.raises(fl.InputError, match="color='red' does not apply: the material of hair has a colour of its own"):
        fl.render(HAIR, look="hair", color="red", material=material, **SMALL)
    with pytest.raises(fl.InputError, match="three numbers; use material="):
        fl.render(HAIR, look="hair", color=material, **SMALL)


@pytest.mark.parametrize("look", ["fibre", "tube"])
@pytest.mark.parametrize("radius", [1e-5, 0.1])
def test_surfaces_have_a_material(look, radius):
    options = {"look": look, "radius": radius, "color": "#c08040"}
    satin = pixels(LINES, **options)
    for material in (fl.SurfaceMaterial(), "satin"):
        assert (pixels(LINES, material=material, **options) == satin).all()
    for name in ("matt", "polished", "metal"):
        assert (pixels(LINES, material=name, **options) != satin).any(), name
    for material in ("metal", fl.SurfaceMaterial()):
        with pytest.raises(fl.InputError, match="is for the looks 'fibre' and 'tube', and this is 'hair'"):
            fl.render(HAIR, look="hair", material=material, **SMALL)


def test_a_metal_reflects_its_own_colour_alone():
    ball = fl.build(fl.Spheres.from_centres([[0, 0, 0]], 1.0))
    options = {"look": "tube", "color": "#ff0000", "background": "#fff"}
    metal, satin = (fl.render(ball, material=name, **options, **SMALL).light for name in ("metal", "satin"))
    assert (metal[..., 1:] <= 1e-6).all()
    assert metal[..., 0].max() > 1
    assert satin[..., 1].max() > 0.01  # the highlight is white


def test_a_highlight_keeps_its_light_whatever_its_width():
    """The integral of the normalised lobe over directions h about n, weighted by their cosine, hardly changes."""
    angle = np.linspace(0, np.pi / 2, 20_001)
    sums = []
    for roughness in (0.15, 0.3, 0.467, 0.7):
        material = fl.SurfaceMaterial(roughness, gloss=1.0)
        white, tinted = material.shine
        assert tinted == 0
        sums.append(np.trapezoid(white * np.cos(angle) ** (material.exponent + 1) * np.sin(angle), angle))
    assert max(sums) < 1.8 * min(sums)
    assert fl.SurfaceMaterial().shine[0] == pytest.approx(0.12, rel=0.01)
    assert fl.SurfaceMaterial().exponent == pytest.approx(40, rel=0.01)


# --- Variation ---


@pytest.mark.parametrize(("look", "quality"), [("hair", "normal"), ("hair", "high"), ("tube", "normal")])
def test_strands_vary_in_brightness(look, quality):
    strands = [[[x, -1, 0], [x, 0, 0], [x, 1, 0]] for x in np.linspace(-1, 1, 8)]
    tree = fl.build(fl.Lines.from_strands(np.float32(strands)))
    options = {"look": look, "quality": quality, "radius": 0.05, "aovs": True, "width": 48, "height": 48, "samples": 8}
    options |= {} if look == "hair" else {"material": "matt"}
    even, varied = (fl.render(tree, variation=variation, **options) for variation in (0, 0.5))
    shown = (even.aovs["id"] >= 0) & (even.alpha == 1)
    ratio = varied.light[shown].sum(axis=1) / even.light[shown].sum(axis=1)
    of_strand = [np.unique(ratio[even.aovs["id"][shown] == strand].round(4)) for strand in range(8)]
    assert [len(found) for found in of_strand] == [1] * 8
    factors = np.concatenate(of_strand)
    assert len(np.unique(factors)) == 8
    assert factors.min() >= 0.5
    assert factors.max() <= 1.5
    if look == "hair":
        assert (fl.render(tree, variation=0.25, **options).light == fl.render(tree, **options).light).all()
    else:
        assert (fl.render(tree, **options).light == even.light).all()


# --- The ground ---


@pytest.mark.parametrize("look", ["hair", "fibre", "tube"])
def test_the_ground_is_an_option_of_all_lit_looks(look):
    cage = fl.build(fl.scenes.make("spaghetti", 200).lines)
    shadows = {
        ground: fl.render(cage, look=look, radius=0.02, ground=ground, **SMALL).shadow.any() for ground in (True, False)
    }
    assert shadows == {True: True, False: False}
    assert fl.render(cage, look=look, radius=0.02, **SMALL).shadow.any() == (look == "tube")


# --- Backgrounds ---


def test_dark_fibres_are_seen():
    for color, is_dark in (("#000000", True), ("#803010", False), ("direction", False)):
        picture = fl.render(LINES, look="fibre", color=color, radius=0.05, **SMALL)
        assert (picture.backdrop.min() > 0.3) == is_dark
    given = fl.render(LINES, look="fibre", color="#000000", background="#111", radius=0.05, **SMALL)
    assert given.backdrop.max() < 0.1


def test_pale_tubes_are_seen():
    for color, is_pale in (("#ffffff", True), ("#c4a878", False), ("strand", False)):
        picture = fl.render(LINES, look="tube", color=color, radius=0.05, **SMALL)
        assert (picture.backdrop.max() < 0.3) == is_pale
    tints = {shade: np.full((len(LINES.geometry), 3), shade, np.float32) for shade in (1.0, 0.5)}
    for shade, tint in tints.items():
        lines = fl.Lines.from_segments(LINES.geometry.segments, attributes={"displayColor": tint})
        picture = fl.render(lines, look="tube", radius=0.05, **SMALL)
        assert (picture.backdrop.max() < 0.3) == (shade == 1.0)


# --- Options ---


@pytest.mark.parametrize(
    "name",
    [
        *("color", "color_map", "rig", "background", "look", "quality", "aovs", "legend"),
        *("material", "variation", "ground"),
    ],
)
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
    assert fl.render(lines, look="tube", rig="salon", **SMALL).rig == fl.RIGS["salon"]
    with pytest.raises(fl.InputError, match=r"there is no rig 'salo'.*salon"):
        fl.render(lines, look="tube", rig="salo", **SMALL)
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
    assert picture.camera == fl.default_camera(LINES.geometry, aspect=4 / 3, radius=0.02)
    for row, column in np.argwhere(picture.aovs["id"] >= 0)[::20]:
        origin, direction, _ = picture.camera.ray(column + 0.5, row + 0.5, 40, 30)
        hit = LINES.first_hit(origin, direction, picture.radius, at="surface")
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


# --- Files ---


def test_a_png_says_that_its_values_are_srgb(tmp_path):
    picture = fl.render(LINES, **SMALL)
    picture.save(tmp_path / "a.png")
    picture.save(tmp_path / "b.png", transparent=True)
    for data in ((tmp_path / "a.png").read_bytes(), (tmp_path / "b.png").read_bytes(), picture._repr_png_()):
        assert data[33:46] == b"\0\0\0\1sRGB\0" + zlib.crc32(b"sRGB\0").to_bytes(4, "big")  # right after the header
