"""Rendered pictures: looks, lights, tone, and that they do not depend on how they were cut into batches."""

from __future__ import annotations

import dataclasses
import io
import threading

import numpy as np
import pytest
from PIL import Image

import fastlines as fl
from fastlines.rendering import default_size, progressive, turntable
from fastlines.rendering.color.tone import filmic, linear, srgb
from fastlines.rendering.looks import LOOKS, look_for, make_look
from fastlines.rendering.looks.solid import Solid
from fastlines.threads import num_threads

LINES = fl.Lines.from_strands([[[-1, y, 0], [0, y, 0.3], [1, y + 0.2, 0]] for y in np.linspace(-1, 1, 40)])
TREE = fl.build(LINES)


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("radius", [0.002, 0.03])
def test_each_look_draws_thin_and_thick_lines(look, radius):
    picture = fl.render(TREE, width=48, height=40, look=look, radius=radius, samples=2)
    assert picture.light.shape == (40, 48, 3)
    assert np.isfinite(picture.light).all()
    assert picture.light.min() >= 0
    assert 0.02 < picture.alpha.mean() < 0.9
    assert picture.alpha.max() <= 1 + 1e-5
    shown = picture.to_bytes()
    assert shown.shape == (40, 48, 3)
    assert np.unique(shown.reshape(-1, 3), axis=0).shape[0] > 5


def test_a_picture_does_not_depend_on_its_bands(monkeypatch):
    whole = fl.render(TREE, width=32, height=32, look="tube", radius=0.05, samples=2)
    monkeypatch.setattr(progressive, "MAX_RAYS", 100)
    assert (fl.render(TREE, width=32, height=32, look="tube", radius=0.05, samples=2).light == whole.light).all()


def test_more_samples_converge():
    few, many, most = (
        fl.render(TREE, width=24, height=24, look="tube", radius=0.05, samples=n).light for n in (1, 16, 64)
    )
    assert np.abs(many - most).mean() < 0.5 * np.abs(few - most).mean()


def test_thin_lines_keep_their_light_at_any_size():
    camera = fl.Camera(origin=(0, 0, 8), target=(0, 0, 0))
    options = {"look": "id", "radius": 0.002, "samples": 4}
    means = [fl.render(TREE, camera, width=n, height=n, **options).alpha.mean() for n in (32, 64, 96)]
    assert means == pytest.approx([means[0]] * 3, rel=0.05)


def test_colours_come_from_attributes():
    lines = fl.Lines.from_segments([[[-1, y, 0], [1, y, 0]] for y in (-0.5, 0.5)], attributes={"fa": [0.0, 1.0]})
    picture = fl.render(lines, width=32, height=32, look="fibre", color="fa", radius=0.2, samples=2)
    upper, lower = picture.light[4:14].sum(axis=(0, 1)), picture.light[-14:-4].sum(axis=(0, 1))
    assert upper[0] > upper[2]  # yellow
    assert lower[2] > lower[1]  # violet
    with pytest.raises(fl.InputError, match="did you mean 'fa'"):
        fl.render(lines, look="fibre", color="faa", radius=0.2)


def test_a_transparent_picture_has_alpha():
    picture = fl.render(TREE, width=24, height=24, radius=0.05, samples=1)
    pixels = picture.to_bytes(transparent=True)
    assert pixels.shape == (24, 24, 4)
    assert pixels[..., 3].min() == 0
    assert pixels[..., 3].max() == 255
    shown = Image.open(io.BytesIO(picture._repr_png_()))
    assert shown.size == (24, 24)


def test_the_tone_curve_rises_and_srgb_is_undone():
    light = np.geomspace(1e-4, 8, 100).astype(np.float32)
    assert (np.diff(filmic(light)) > 0).all()
    assert filmic(np.float32(1e6)) <= 1
    values = np.linspace(0, 1, 50, dtype=np.float32)
    assert linear(srgb(values)) == pytest.approx(values, abs=1e-5)


def test_the_look_suits_the_lines():
    assert {name: look_for(fl.scenes.make(name, 4000).lines) for name in ("spaghetti", "photon-beams")} == {
        "spaghetti": "fibre",
        "photon-beams": "fibre",
    }
    assert look_for(fl.scenes.make("straight-hair").lines) == "hair"
    assert look_for(LINES.with_radius(0.1)) == "tube"
    wave = np.stack([np.linspace(0, 1, 16), np.linspace(0, 1, 16) ** 2, np.zeros(16)], axis=1)
    strands = list(wave + np.linspace((0, 0, 0), (0, 0, 1), 120)[:, None])
    assert look_for(fl.Lines.from_strands(strands)) == "hair"
    assert look_for(fl.Lines.from_strands([*strands, wave[:5]])) == "fibre"
    assert look_for(fl.Lines.from_strands([strand[:12] for strand in strands])) == "fibre"  # resampled tracts
    assert look_for(dataclasses.replace(fl.Lines.from_strands(strands), unit="mm")) == "fibre"
    assert look_for(fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])) == "tube"


def test_fibres_that_turn_all_the_time_have_one_colour():
    beams, straight = (fl.scenes.make(name, 400).lines for name in ("photon-beams", "spaghetti"))
    assert make_look("fibre", beams).color.by == "plain"
    assert make_look("fibre", straight).color.by == "direction"
    assert make_look("fibre", beams, "strand").color.by == "strand"


def test_neurons_have_the_colours_of_their_types():
    types = {"type": np.array([1, 2, 3, 300])}
    parts = fl.lines([[[y, 0, 0], [y, 1, 0]] for y in range(4)])
    neuron = dataclasses.replace(parts.with_radius(0.3), attributes=types, unit="µm")
    axon = fl.render(neuron, fl.Camera((1, 0.5, 2), (1, 0.5, 0)), width=9, height=9, samples=2).light[4, 4]
    dendrite = fl.render(neuron, fl.Camera((2, 0.5, 2), (2, 0.5, 0)), width=9, height=9, samples=2).light[4, 4]
    assert axon.argmax() == 2
    assert dendrite.argmax() == 0
    assert make_look("tube", neuron, "type").color.attribute == "type"
    assert make_look("tube", dataclasses.replace(neuron, unit="mm")).color.by == "plain"


def test_the_size_of_a_picture_suits_the_lines():
    wide = fl.Lines.from_segments([[[0, 0, 0], [4, 0, 0]], [[0, 2.6, 0], [4, 2.6, 0]]])
    assert default_size(wide, 300) == (367, 245)
    assert default_size(wide, 300, direction=(0, 0, -1), up=(1, 0, 0)) == (245, 367)
    assert default_size(fl.Lines.from_segments(np.zeros((0, 2, 3))), 300) == (300, 300)
    assert default_size(fl.Lines.from_segments([[[1, 1, 1], [1, 1, 1]]]), 300) == (300, 300)
    for size, expected in (({"width": 60}, (40, 60)), ({"height": 20}, (20, 30)), ({"width": 9, "height": 7}, (7, 9))):
        assert fl.render(wide, radius=0.1, samples=1, **size).alpha.shape == expected
    camera = fl.Camera((2, 1.3, 9), (2, 1.3, 0))
    assert fl.render(wide, camera, radius=0.1, samples=1, width=30).alpha.shape == (30, 30)
    assert next(turntable(wide, 2, radius=0.1, samples=1, height=20)).alpha.shape == (20, 20)
    with pytest.raises(fl.InputError, match="8192"):
        fl.render(wide, radius=0.1, height=8192)


def test_unknown_looks_are_refused():
    with pytest.raises(fl.InputError, match="did you mean 'hair'"):
        fl.render(TREE, look="hairs")


@pytest.mark.parametrize("look", ["fibre", "tube", "id", "hits", "hair"])
@pytest.mark.parametrize("radius", [0.001, 0.03])
def test_a_picture_does_not_depend_on_the_number_of_threads(look, radius, monkeypatch):
    monkeypatch.setattr(progressive, "MAX_RAYS", 150)
    pictures = []
    for n_threads in (1, 3):
        with num_threads(n_threads):
            pictures.append(fl.render(TREE, width=40, height=40, look=look, radius=radius, samples=3))
    assert (pictures[0].light == pictures[1].light).all()
    assert (pictures[0].alpha == pictures[1].alpha).all()


@pytest.mark.parametrize("whose", ["ours", "own look", "own shapes"])
def test_code_of_the_users_own_runs_in_one_thread(whose, monkeypatch):
    monkeypatch.setattr(progressive, "MAX_RAYS", 150)
    threads = set()

    def note(*_):
        threads.add(threading.current_thread().name)

    class Discs:
        def bounds(self):
            return [[[-1, -1, 0], [1, 1, 0]]]

        def hit(self, ids, rays, radius):
            note()
            return -rays.origins[:, 2] / rays.directions[:, 2]

        def normals(self, ids, points):
            return np.broadcast_to((0.0, 0.0, 1.0), points.shape)

    class Own(Solid):
        def shade(self, fragments, stage, sampler):
            note()
            return super().shade(fragments, stage, sampler)

    look = make_look("tube", LINES)
    if whose == "own look":
        look = Own(look.color, look.backdrop)
    geometry = fl.build(Discs()) if whose == "own shapes" else TREE
    if whose == "ours":
        monkeypatch.setattr(Solid, "shade", lambda self, fragments, *_: note() or np.zeros((len(fragments), 3)))
    with num_threads(3):
        fl.render(geometry, fl.Camera((0, 0, 5), (0, 0, 0)), width=40, height=40, look=look, radius=0.05, samples=4)
    assert len(threads) > 1 if whose == "ours" else threads == {threading.main_thread().name}


def test_an_empty_tree_is_an_empty_picture():
    for nothing in (fl.Lines.from_segments(np.zeros((0, 2, 3))), fl.Geometry([])):
        picture = fl.render(nothing, width=8, height=8, radius=0.1)
        assert not picture.alpha.any()


@pytest.mark.parametrize("look", ["hair", "tube"])
def test_a_radius_counts_the_same_in_a_geometry(look):
    lines = LINES.with_radius(0.1)  # not thinner than a pixel
    camera = fl.Camera(origin=(0, 0, 8), target=(0, 0, 0))
    options = {"width": 32, "height": 32, "samples": 4, "look": look}
    one, other = (fl.render(each, camera, **options) for each in (lines, fl.Geometry([lines])))
    assert np.abs(one.light - other.light).mean() < 0.002
    assert one.light.mean() == pytest.approx(other.light.mean(), rel=0.005)
    assert look_for(fl.Geometry([lines])) == "tube"


def test_colours_of_bytes_and_constant_numbers():
    n = len(LINES)
    lines = fl.Lines.from_segments(
        LINES.segments,
        attributes={
            "rgb": np.tile(np.uint8([255, 0, 0]), (n, 1)),
            "same": np.full(n, 160.0),
            "far": np.full((n, 3), 7.0),
        },
    )
    red = fl.render(lines, width=24, height=24, look="tube", color="rgb", radius=0.1, samples=1).light
    assert red[..., 0].mean() > 5 * red[..., 1].mean()
    assert len(np.unique(fl.render(lines, width=24, height=24, look="fibre", color="same", radius=0.1).light)) > 1
    with pytest.raises(fl.InputError, match="numbers above 1"):
        fl.render(lines, look="tube", color="far", radius=0.1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"samples": 0}, "samples"),
        ({"samples": 1.5}, "samples"),
        ({"exposure": float("nan")}, "exposure"),
        ({"width": 0}, "width"),
        ({"look": 3}, "look=3"),
        ({"rig": "stage"}, "there is no rig 'stage'"),
        ({"rig": 3}, "rig=3"),
        ({"material": "gold"}, "material='gold'"),
        ({"variation": 1.5}, "variation=1.5"),
        ({"camera": (0, 0, 1)}, "camera="),
        ({"background": 3}, "background=3"),
        ({"color_map": "jet"}, "no colour map 'jet'"),
    ],
)
def test_bad_options_are_refused_before_any_work(options, words):
    with pytest.raises(fl.InputError, match=words):
        fl.render(TREE, **{"radius": 0.05, **options})


def test_fibres_fade_into_the_background():
    white, black = (
        fl.render(TREE, width=24, height=24, look="fibre", radius=0.05, samples=1, background=each).light
        for each in ("#fff", "#000")
    )
    assert white.mean() > 1.1 * black.mean()


def test_lines_at_one_point_and_no_lines_are_pictures():
    for look in ("fibre", "tube", "hair"):
        assert fl.render(np.zeros((5, 2, 3)), width=8, height=8, radius=0.01, look=look, samples=1).alpha.any()
    assert not fl.render(np.zeros((0, 2, 3)), width=8, height=8).alpha.any()


def test_a_radius_that_counts_for_nothing_is_warned_of_once():
    triangles = fl.Triangles(np.random.default_rng(0).random((9, 3, 3)))
    size = {"width": 300, "height": 300, "samples": 1}
    with pytest.warns(fl.QueryWarning, match="does not count for triangles and boxes") as told:
        picture = fl.render(triangles, radius=0.1, **size)
    assert [warning.filename for warning in told] == [__file__]
    assert picture.radius == 0
    assert picture.light.tobytes() == fl.render(triangles, **size).light.tobytes()
