"""Unfinished pictures: saved, resumed, and the same bit for bit as without an interruption."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering import MEASURES, PictureOptions, PicturePlan, progressive, renderer_of
from fastlines.rendering.looks import make_look
from fastlines.rendering.state import describe

SCENE = fl.scenes.make("spaghetti", 80)
TREE = fl.build(SCENE.lines)
#: What is summed for each pixel.
SUMS = {"tube": ("light", "alpha", "shadow"), "hits": ("total", "hit")}


def made(tree=TREE, size=(24, 20), radius=0.02, look="tube", samples=3, camera=SCENE.camera, **options):
    made = MEASURES.get(look) or make_look(look, tree.geometry, **options)
    return renderer_of(PicturePlan(tree, camera, *size, radius, made, PictureOptions(samples=samples)))


def finished(one):
    for _ in one.passes():
        pass
    return one.picture()


def assert_same(one, other):
    assert (one.light == other.light).all()
    assert (one.alpha == other.alpha).all()
    assert one.samples == other.samples


@pytest.mark.parametrize("look", ["tube", "hair", "id", "hits", "density", "work"])
@pytest.mark.parametrize("radius", [0.001, 0.02])  # thinner and thicker than a pixel
def test_a_resumed_picture_is_that_of_an_uninterrupted_run(look, radius, tmp_path):
    first = made(look=look, radius=radius)
    next(first.passes())
    first.save(tmp_path / "a.npz")
    second = made(look=look, radius=radius)
    assert second.resume(tmp_path / "a.npz") == 1
    assert_same(second.picture(), first.picture())
    assert_same(finished(second), finished(made(look=look, radius=radius)))
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


@pytest.mark.parametrize("look", ["tube", "hits"])
@pytest.mark.parametrize("stop", range(1, 12))
def test_it_may_be_interrupted_in_any_band(look, stop, tmp_path, monkeypatch):
    monkeypatch.setattr(progressive, "MAX_RAYS", 150)  # four bands
    one, calls = made(look=look), []

    def interrupt(done):
        calls.append(done)
        if len(calls) == stop:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        for _ in one.passes(interrupt):
            pass
    assert one.n_rows == (20 if stop > 3 else 6 * stop)
    one.save(tmp_path / "a.npz")
    other = made(look=look)
    assert other.resume(tmp_path / "a.npz") == stop // 4
    assert_same(finished(other), finished(made(look=look)))


@pytest.mark.parametrize("radius", [0.001, 0.02])
@pytest.mark.parametrize("look", ["tube", "hair", "fibre", "hits"])
def test_a_picture_does_not_depend_on_its_bands(look, radius, monkeypatch):
    found = []
    for n_rays in (1, 150, 1 << 16):
        monkeypatch.setattr(progressive, "MAX_RAYS", n_rays)
        found.append(finished(made(look=look, radius=radius, samples=1)))
    assert_same(found[0], found[1])
    assert_same(found[0], found[2])


@pytest.mark.parametrize("look", ["hits", "density", "work"])
def test_one_ray_for_each_pixel_has_the_rows_so_far(look, monkeypatch):
    """A measure has one sample by default, so an interrupted picture has some of its rows."""
    monkeypatch.setattr(progressive, "MAX_RAYS", 150)

    def stop(done):
        raise KeyboardInterrupt

    one, whole = made(look=look, samples=None), finished(made(look=look, samples=None))
    assert whole.samples == 1
    with pytest.raises(KeyboardInterrupt):
        list(one.passes(stop))
    numbers = one.picture().aovs[look]
    assert (numbers[:6] == whole.aovs[look][:6]).all()
    assert numbers[:6].any()
    assert not numbers[6:].any()


def test_rays_through_centres_are_no_sample_of_several(tmp_path):
    made(look="hits", samples=1).save(tmp_path / "a.npz")
    with pytest.raises(fl.InputError, match="rays was centres of pixels, and is spread over pixels"):
        made(look="hits", samples=2).resume(tmp_path / "a.npz")


INTERRUPTED = [(look, name) for look, names in SUMS.items() for name in (*names, "counts")]


@pytest.mark.parametrize(("look", "name"), INTERRUPTED)
def test_it_may_be_interrupted_while_it_stores_a_band(look, name, tmp_path):
    class Torn(np.ndarray):
        """Raises at the second store, after half of it is done."""

        stores = 0

        def __setitem__(self, key, value):
            super().__setitem__(key, value)
            type(self).stores += 1
            if self.stores == 2:
                raise KeyboardInterrupt

    one = made(look=look)
    if name == "counts":
        one._counts = one._counts.view(Torn)
    else:
        one._sums[name] = one._sums[name].view(Torn)
    with pytest.raises(KeyboardInterrupt):
        finished(one)
    one.save(tmp_path / "a.npz")
    assert_same(finished(one), finished(made(look=look)))
    other = made(look=look)
    assert other.resume(tmp_path / "a.npz") == 2
    assert_same(finished(other), finished(made(look=look)))


def test_more_samples_can_be_added_later(tmp_path):
    few = made(samples=2)
    finished(few)
    few.save(tmp_path / "a.npz")
    more = made(samples=5)
    more.resume(tmp_path / "a.npz")
    assert_same(finished(more), finished(made(samples=5)))


OTHER = dataclasses.replace(SCENE.lines, segments=SCENE.lines.segments + np.float32(1e-3))


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"size": (20, 24)}, "size was 24 × 20, and is 20 × 24"),
        ({"radius": 0.021}, r"radius was 0\.02, and is 0\.021"),
        ({"look": "depth"}, "the look differs"),
        ({"color": "#ff0000"}, "the look differs"),
        ({"camera": SCENE.camera.orbit(1)}, "the camera differs"),
        ({"tree": fl.build(OTHER)}, "the checksum differs"),
        ({"tree": fl.build(fl.scenes.make("spaghetti", 81).lines)}, "lines was 80 segments, and is 81 segments"),
    ],
)
def test_a_state_of_another_picture_is_refused(other, words, tmp_path):
    one = made()
    one.save(tmp_path / "a.npz")
    with pytest.raises(fl.InputError, match=words):
        made(**other).resume(tmp_path / "a.npz")


def test_attributes_belong_to_a_picture(tmp_path):
    for value in (0.1, 0.2):
        lines = fl.Lines.from_segments(SCENE.lines.segments, attributes={"fa": np.full(80, value)})
        one = made(fl.build(lines), color="fa")
        if value == 0.1:
            one.save(tmp_path / "a.npz")
    with pytest.raises(fl.InputError, match="checksum"):
        one.resume(tmp_path / "a.npz")


def test_other_trees_of_the_same_lines_go_on(tmp_path):
    one = made()
    next(one.passes())
    one.save(tmp_path / "a.npz")
    other = made(fl.build(SCENE.lines, "bvh-cl"))
    other.resume(tmp_path / "a.npz")
    assert_same(finished(other), finished(one))


def test_settings_are_described_without_addresses():
    class Embers:
        def __init__(self):
            self.glow, self.shade = np.float32(0.5), max

    text = describe((Embers(), {"b": 1, "a": np.arange(2)}, len))
    assert text == "(Embers(glow=0.5, shade=builtins.max), (a=(0, 1), b=1), builtins.len)"


def test_what_is_no_state_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    with pytest.raises(FileNotFoundError):
        made().resume(path)
    path.write_bytes(b"no zip")
    with pytest.raises(fl.InputError, match="is not the state of a picture"):
        made().resume(path)
    np.savez(path, light=np.zeros(3))
    with pytest.raises(fl.InputError, match="is not the state of a picture"):
        made().resume(path)
    made().save(path)
    path.write_bytes(path.read_bytes()[:-300])
    with pytest.raises(fl.InputError, match="is not the state of a picture"):
        made().resume(path)
    made().save(path)
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **(arrays | {"light": np.zeros((3, 3))}))
    with pytest.raises(fl.InputError, match="is damaged: light"):
        made().resume(path)
