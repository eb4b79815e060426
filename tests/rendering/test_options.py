"""Options either change a picture or are refused, for each look, colour and file."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering import MEASURES, write_frames
from fastlines.rendering.looks import LOOKS, make_look
from fastlines.rendering.looks.flat import Flat, ids
from fastlines.rendering.pictures.options import (
    DRAWN,
    EFFECTS,
    FLAT,
    LEVELS,
    NEUTRAL,
    NUMBERS,
    OWN_FLAT,
    OWN_LIT,
    SCREEN,
    PictureRequest,
    as_flag,
    check_options,
)
from fastlines.rendering.shading.lighting import SOFT, Light, Rig

STRANDS = [[[-1, y, 0], [0, y, 0.3], [1, y + 0.2, 0]] for y in np.linspace(-1, 1, 12)]
LINES = fl.Lines.from_points(
    np.reshape(STRANDS, (-1, 3)),
    [3] * len(STRANDS),
    attributes={"fa": np.linspace(0, 1, 36), "tint": np.linspace(0, 1, 108).reshape(36, 3)},
)
TREE = fl.build(LINES)
PICTURE = {"width": 64, "height": 64, "radius": 0.05}
OWN = {OWN_LIT: make_look("fibre", LINES, "fa"), OWN_FLAT: Flat(ids)}
#: A value of each option that has an effect if anything has.
VALUES = {
    "color": "#ff0000",
    "color_map": "magma",
    "background": "#123456:#654321",
    "rig": Rig((Light((0, 0, 1), (9.0, 1.0, 1.0)),)),
    "exposure": 1.0,
    "variation": 0.5,
    "ground": True,
    "quality": "high",
    "legend": True,
    "samples": 2,
}


def drawn(look, **options):
    return fl.render(TREE, look=OWN.get(look, look), **{**PICTURE, "samples": 1, "ground": False, **options})


def changes(look, option, **options):
    """Return whether an option changes the picture."""
    plain, changed = (drawn(look, **options, **more).to_bytes() for more in ({}, {option: VALUES[option]}))
    return (plain != changed).any()


#: The looks in which an option has an effect, with the colours that they have by default.
EXPECTED = {
    "color": ("hair", "fibre", "tube"),
    "color_map": (),
    "background": (*LOOKS, *MEASURES, *OWN),
    "rig": ("hair", "fibre", "tube", OWN_LIT),
    "exposure": ("hair", "fibre", "tube", OWN_LIT),
    "variation": ("hair", "fibre", "tube"),
    "ground": ("hair", "fibre", "tube", OWN_LIT),
    "quality": ("hair",),
    "legend": ("hits", "density", "work", "fibre", OWN_LIT),
    "samples": (*LOOKS, *MEASURES, *OWN),
}


@pytest.mark.parametrize("look", [*LOOKS, *MEASURES, *OWN])
@pytest.mark.parametrize("option", VALUES)
def test_an_option_changes_the_picture_or_is_refused(look, option):
    """With the colours that each look has by default."""
    if look in EXPECTED[option]:
        assert changes(look, option)
        return
    with pytest.raises(fl.InputError) as caught:
        changes(look, option)
    assert str(caught.value).startswith(f"{option}={VALUES[option]!r} does not apply: ")
    assert "; leave it out" in str(caught.value)


@pytest.mark.parametrize("look", ["fibre", "tube"])
@pytest.mark.parametrize(
    ("color", "option", "applies"),
    [
        ("fa", "color_map", True),
        ("fa", "legend", True),
        ("direction", "color_map", False),
        ("direction", "legend", True),
        *itertools.product(("strand", "#00ff00", "tint"), ("color_map", "legend"), (False,)),
    ],
)
def test_maps_and_legends_are_for_colours_that_have_them(look, color, option, applies):
    if applies:
        drawn(look, color=color, **{option: VALUES[option]})
        return
    with pytest.raises(
        fl.InputError, match=f"{option}=.* does not apply: .*; leave it out, or colour lines by an attr"
    ):
        drawn(look, color=color, **{option: VALUES[option]})


def test_neutral_values_are_always_accepted():
    neutral = {"exposure": 0, "quality": "normal", "legend": False, "color": None, "color_map": None, "rig": None}
    for look in (*LOOKS, *MEASURES, *OWN):
        drawn(look, **neutral)
    for look in (*DRAWN, LEVELS):
        for file in (*SCREEN, ".exr"):
            check_options({name: NEUTRAL.get(name, False) for name in EFFECTS}, PictureRequest(look, "other", file, ""))


def test_unknown_looks_are_told_before_their_options():
    with pytest.raises(fl.InputError, match="there is no look 'hairs'"):
        drawn("hairs", exposure=1.0)


def test_the_table_knows_all_looks_and_facts():
    assert set(DRAWN) == {*LOOKS, *MEASURES, OWN_LIT, OWN_FLAT}
    assert set(NUMBERS) == set(MEASURES)
    assert all(not OWN.get(look) for look in FLAT)
    facts = {*vars(PictureRequest()), "backdrop"}
    for limits in EFFECTS.values():
        assert {limit.fact for limit in limits} <= facts


@pytest.mark.parametrize(
    ("options", "facts", "said"),
    [
        (
            {"background": "#fff"},
            PictureRequest("tube", file=".exr"),
            "--background does not apply: an .exr has no background",
        ),
        ({"background": "#fff"}, PictureRequest("fibre", file=".exr"), None),  # which fades into it
        ({"background": "#fff"}, PictureRequest(file=".exr"), None),  # not known yet
        (
            {"transparent": True},
            PictureRequest("tube", file=".exr"),
            "--background transparent does not apply: an .exr is always",
        ),
        ({"transparent": True}, PictureRequest("tube", file=".gif"), "leave it out, or write a .png"),
        ({"legend": True}, PictureRequest("hits", "number", ".exr"), "an .exr holds numbers"),
        ({"legend": True}, PictureRequest("hair", "other", ".png"), "the colours of the look 'hair' have no legend"),
        ({"exposure": 1.0}, PictureRequest("hair", "other", ".exr"), None),
        ({"seconds": 0.1}, PictureRequest("tube", file=".png"), "leave it out, or write a .gif or .mp4"),
        ({"levels": 2}, PictureRequest(LEVELS, file=".exr"), "--levels does not apply: levels are drawn as .png"),
        (
            {"levels": 2},
            PictureRequest(LEVELS, many="--turntable"),
            "--levels does not apply: --turntable makes many pictures",
        ),
        ({"resume": True}, PictureRequest("tube", many="--turntable"), "leave one of them out"),
        ({"radius": 0.0}, PictureRequest("tube", many="--radius-sweep"), "--radius does not apply"),
        ({"radius": 0.0}, PictureRequest("tube", many="--turntable"), None),
        *(
            (
                {name: 3},
                PictureRequest(LEVELS),
                f"{as_flag(name, 3)} does not apply: levels of a tree are drawn in panels",
            )
            for name in (
                *("look", "width", "height", "samples", "color", "color_map", "background", "transparent"),
                *("exposure", "quality", "legend", "resume", "lens_radius"),
            )
        ),
    ],
)
def test_what_is_refused_on_the_command_line(options, facts, said):
    if said is None:
        check_options(options, facts, as_flag)
        return
    with pytest.raises(fl.InputError) as caught:
        check_options(options, facts, as_flag)
    assert said in str(caught.value)
    assert "leave" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("x.png", {"seconds": 0.1}),
        ("x.png", {"repeats": False}),
        ("x.mp4", {"repeats": False}),
        ("x.gif", {"transparent": True}),
    ],
)
def test_files_refuse_what_they_do_not_have(name, options, tmp_path):
    if name.endswith(".mp4"):
        pytest.importorskip("imageio_ffmpeg")
    picture = drawn("id")
    with pytest.raises(fl.InputError, match="does not apply"):
        write_frames(tmp_path / name, [picture], **options)
    assert not list(tmp_path.iterdir())


def test_a_rig_of_the_catalogue_is_no_neutral_value():
    with pytest.raises(fl.InputError, match="rig=Rig"):
        drawn("normal", rig=SOFT)
