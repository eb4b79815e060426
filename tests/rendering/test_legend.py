"""Legends: which pictures have one, and that it can be read on any backdrop."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering import radius_sweep, turntable
from fastlines.rendering.color.legend import ColorBar, Triad, draw_legend, emptiest_corner
from fastlines.rendering.color.palette import MAPS, mapped
from fastlines.rendering.color.tone import srgb

LINES = fl.Lines.from_strands([[[-1, y, 0], [0, y, 0.3], [1, y + 0.2, 0]] for y in np.linspace(-1, 1, 9)])
SIZE = {"width": 64, "height": 64, "samples": 1, "radius": 0.05}


def with_values(**values):
    return fl.Lines.from_segments(LINES.segments, attributes=values)


@pytest.mark.parametrize("color", ["fa", "radius"])
def test_numbers_have_a_bar_with_their_range(color):
    lines = with_values(fa=np.linspace(0.2, 0.8, len(LINES))).with_radius(np.linspace(0.2, 0.8, len(LINES)))
    legend = fl.render(lines, look="fibre", color=color, **SIZE).legend
    assert isinstance(legend, ColorBar)
    assert legend.title == color
    assert 0.2 <= legend.low < 0.25
    assert 0.75 < legend.high <= 0.8


def test_the_title_of_a_bar():
    lines = dataclasses.replace(with_values(fa=np.arange(float(len(LINES)))).with_radius(0.1), unit="µm")
    assert fl.render(lines, look="fibre", color="radius", **SIZE).legend.title == "radius in µm"
    picture = fl.render(lines, look="fibre", color="fa", legend="speed in m/s", **SIZE)
    assert picture.legend.title == "speed in m/s"
    assert (picture.to_bytes() != fl.render(lines, look="fibre", color="fa", legend=True, **SIZE).to_bytes()).any()
    with pytest.raises(fl.InputError, match="the legend of directions has no title, and 'speed' is given"):
        fl.render(lines, look="fibre", legend="speed", **SIZE)


def test_a_legend_is_in_an_empty_corner():
    alpha = np.zeros((200, 300), np.float32)
    bar = ColorBar("fa", 0.0, 1.0, "viridis")
    halves = {"lower left": (slice(100, None), slice(0, 150)), "lower right": (slice(100, None), slice(150, None))}
    halves |= {"upper left": (slice(0, 100), slice(0, 150)), "upper right": (slice(0, 100), slice(150, None))}
    for corner, half in halves.items():
        for legend in (bar, Triad(np.eye(3))):
            assert emptiest_corner(alpha, legend) == corner
            pixels = np.full((200, 300, 3), 90, np.uint8)
            drawn = draw_legend(pixels, legend, corner)
            changed = (drawn != pixels).any(axis=2)
            assert changed[half].sum() == changed.sum() > 100
        alpha[half] = 1
    alpha[halves["upper left"]] = 0.5
    assert emptiest_corner(alpha, bar) == "upper left"  # the emptiest of four


def test_pictures_of_a_sequence_have_the_legend_in_one_corner():
    tree = fl.build(with_values(fa=np.arange(float(len(LINES)))))
    options = {"look": "fibre", "color": "fa", "legend": True, "width": 64, "height": 64, "samples": 1}
    for pictures in (turntable(tree, 4, **options), radius_sweep(tree, [0.01, 0.5], **options)):
        (corner,) = {picture.corner for picture in pictures}
        assert corner is not None
    assert next(turntable(tree, 4, **options | {"legend": False})).corner is None
    picture = fl.render(tree, **options)
    moved = [picture.with_legend(corner).to_bytes() for corner in ("lower left", "upper right")]
    assert (moved[0] != moved[1]).any()
    with pytest.raises(fl.InputError, match="corner='middle' is not a choice"):
        picture.with_legend("middle")


@pytest.mark.parametrize("name", MAPS)
def test_no_map_begins_or_ends_with_black(name):
    assert mapped(np.linspace(0, 1, 101), name).max(axis=1).min() > 0.03


def test_directions_have_a_triad_and_colours_nothing():
    assert isinstance(fl.render(LINES, look="fibre", **SIZE).legend, Triad)
    colours = with_values(tint=np.ones((len(LINES), 3)))
    for color in ("strand", "#808080", "tint"):
        picture = fl.render(colours, look="tube", color=color, **SIZE)
        assert picture.legend is None
        assert (picture.with_legend().to_bytes() == picture.to_bytes()).all()
    assert fl.render(LINES, look="depth", **SIZE).legend is None


@pytest.mark.parametrize("look", ["hits", "density", "work"])
def test_measures_have_a_bar(look):
    picture = fl.render(LINES, look=look, **SIZE)
    assert picture.legend.low == 0
    shown = picture.aovs[look][picture.aovs[look] > 0]
    assert picture.legend.high == pytest.approx(np.quantile(shown, 0.99), rel=1e-6)
    drawn = fl.render(LINES, look=look, legend=True, **SIZE).to_bytes()
    assert (drawn == picture.with_legend().to_bytes()).all()
    assert (drawn != picture.to_bytes()).any()


@pytest.mark.parametrize("shade", [0, 90, 140, 255])
@pytest.mark.parametrize("legend", [ColorBar("fa", 0.0, 1e-7, "viridis"), Triad(np.eye(3))])
@pytest.mark.parametrize("channels", [3, 4])
def test_letters_stand_out(shade, legend, channels):
    pixels = np.full((300, 400, channels), shade, np.uint8)
    drawn = draw_legend(pixels, legend)
    assert drawn.shape == pixels.shape
    assert (drawn[:150] == shade).all()
    assert (drawn[:, 300:] == shade).all()
    changed = drawn[..., :3][(drawn != pixels).any(axis=2)].astype(int)
    assert np.abs(changed - shade).max() > 100


@pytest.mark.parametrize(("height", "width"), [(1, 1), (8, 300), (300, 8)])
def test_small_pictures_have_what_fits(height, width):
    for legend in (ColorBar("a long name of an attribute", -1.5, 2e6, "magma"), Triad(np.eye(3))):
        assert draw_legend(np.zeros((height, width, 3), np.uint8), legend).shape == (height, width, 3)


def test_a_transparent_picture_shows_its_legend():
    picture = fl.render(LINES, look="fibre", **SIZE).with_legend()
    clear = picture.to_bytes(transparent=True)
    assert clear[-20:, :20, 3].max() == 255


NAMES = ("plain", "direction", "strand", "brown", "white", "attribute", "attribute:fa", "#808080", "radius", "viridis")


@pytest.mark.parametrize("name", NAMES)
def test_an_attribute_of_any_name_gives_colours(name):
    """The prefix names it in any case, and the name alone where it is not a word by itself."""
    lines = with_values(**{name: np.linspace(0.2, 0.8, len(LINES)), "fa": np.linspace(0.2, 0.8, len(LINES))})
    expected = fl.render(lines, look="tube", color="fa", **SIZE)
    named = fl.render(lines, look="tube", color=f"attribute:{name}", **SIZE)
    assert (named.light == expected.light).all()
    assert named.legend.title == name
    if name not in ("direction", "strand", "#808080", "attribute:fa"):
        assert (fl.render(lines, look="tube", color=name, **SIZE).light == expected.light).all()


@pytest.mark.parametrize("word", ["direction", "strand"])
def test_words_keep_their_meaning_and_say_that_an_attribute_has_their_name(word):
    lines = with_values(**{word: np.linspace(0, 1, len(LINES))})
    expected = fl.render(LINES.segments, look="tube", color=word, **SIZE)
    with pytest.warns(fl.FileWarning, match=f"color='attribute:{word}' is their attribute of this name"):
        found = fl.render(lines, look="tube", color=word, **SIZE)
    assert (found.light == expected.light).all()


def test_colours_that_are_not_there_are_refused():
    lines = with_values(fa=np.zeros(len(LINES)))
    with pytest.raises(fl.InputError, match="no attribute 'faa' to be coloured by; did you mean 'fa'"):
        fl.render(lines, look="tube", color="attribute:faa", **SIZE)
    for color in ("fa", "attribute:fa", "strand"):
        with pytest.raises(fl.InputError, match=f"color='{color}' is for the looks 'fibre' and 'tube'"):
            fl.render(lines, look="hair", color=color, **SIZE)
    with pytest.raises(fl.InputError, match="no hair colour 'browm'; did you mean 'brown'"):
        fl.render(lines, look="hair", color="browm", **SIZE)


def test_a_bar_has_the_colours_of_its_numbers():
    """Each column of the bar is what the map has for the number there; one number is one colour."""
    for bar in (ColorBar("fa", 2.0, 6.0, "viridis"), ColorBar("fa", 3.0, 3.0, "viridis")):
        drawn = draw_legend(np.zeros((1000, 1000, 3), np.uint8), bar)
        row = drawn[int(np.flatnonzero(np.ptp(drawn[:, 60].astype(int), axis=1) > 30).mean())]
        expected = np.rint(255 * srgb(bar.colors(np.linspace(bar.low, bar.high, 340)))).astype(int)
        assert np.abs(row[40:360].astype(int) - expected[10:330]).max() < 12
    assert (expected == expected[0]).all()
