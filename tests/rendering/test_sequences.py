"""Turns and sweeps from one tree, and the files of many pictures."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from PIL import Image

import fastlines as fl
from fastlines.rendering import radius_sweep, spaced_radii, turntable, turntable_camera, write_frames

SCENE = fl.scenes.make("spaghetti", 60)
TREE = fl.build(SCENE.lines)
SMALL = {"width": 20, "height": 14, "samples": 1}


def pictures(n=3, **options):
    return turntable(TREE, n, **SMALL, radius=0.01, **options)


# --- Cameras ---


def test_an_orbit_keeps_the_distance_the_height_and_the_target():
    camera = fl.Camera(origin=(1, 2, 3), target=(0.5, 0, -1), up=(0.2, 1, 0.1))
    up = np.asarray(camera.up) / np.linalg.norm(camera.up)
    for degrees in (30, 180, -77.5):
        turned = camera.orbit(degrees)
        before, after = (np.subtract(c.origin, c.target) for c in (camera, turned))
        assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(before))
        assert after @ up == pytest.approx(before @ up)
        assert (turned.target, turned.up, turned.fov_degrees) == (camera.target, camera.up, camera.fov_degrees)
        assert turned.orbit(-degrees).origin == pytest.approx(camera.origin)
    with pytest.raises(fl.InputError, match="finite angle"):
        camera.orbit(np.nan)


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, 1), (1, 2, 0.5)])
@pytest.mark.parametrize("direction", [(0, -0.3, -1), (1, -0.5, 0.2), (0.1, -2, 0.1)])
def test_a_turn_never_leaves_the_frame(up, direction):
    rng = np.random.default_rng(3)
    lines = fl.Lines.from_segments(rng.normal(size=(50, 2, 3)) * (5, 1, 2) + (100, 0, -30))
    camera = turntable_camera(lines, direction=direction, up=up, aspect=1.5)
    for degrees in range(0, 360, 15):
        pixels, depth = camera.orbit(degrees).project(lines.segments.reshape(-1, 3), 300, 200)
        assert depth.min() > 0
        assert (pixels > 0).all()
        assert (pixels < (300, 200)).all()


# --- Sequences ---


def test_a_turn_is_pictures_of_turned_cameras():
    camera = fl.Camera(origin=(0.5, 0.5, 4), target=(0.5, 0.5, 0.5))
    turned = list(pictures(4, camera=camera, look="id"))
    for i, picture in enumerate(turned):
        expected = fl.render(TREE, camera.orbit(90 * i), radius=0.01, look="id", **SMALL)
        assert (picture.light == expected.light).all()
    assert (turned[0].light != turned[1].light).any()


def test_a_turn_keeps_the_range_of_a_measure():
    legends = [picture.legend for picture in pictures(3, look="hits")]
    assert legends[0] == legends[1] == legends[2]


def test_a_sweep_is_one_picture_for_each_radius():
    radii = spaced_radii(0.002, 0.05, 3)
    swept = list(radius_sweep(TREE, radii, SCENE.camera, look="depth", **SMALL))
    for radius, picture in zip(radii, swept, strict=True):
        expected = fl.render(TREE, SCENE.camera, radius=radius, look="depth", **SMALL)
        assert (picture.light == expected.light).all()


def test_radii_are_spaced_by_a_factor_or_by_a_step():
    radii = spaced_radii(0.0005, 0.05, 60)
    assert (radii[0], radii[-1], len(radii)) == (0.0005, 0.05, 60)
    assert np.ptp(np.diff(np.log(radii))) < 1e-9
    assert spaced_radii(0.5, 0, 3) == [0.5, 0.25, 0.0]
    assert spaced_radii(0.5, 2.0, 1) == [0.5]
    for wrong in ((-1, 1, 3), (0, np.inf, 3), (0, 1, 0)):
        with pytest.raises(fl.InputError):
            spaced_radii(*wrong)
    with pytest.raises(fl.InputError, match="leave out radius="):
        radius_sweep(TREE, [0.1], radius=0.2)
    with pytest.raises(fl.InputError, match="n_pictures=0"):
        turntable(TREE, 0)


# --- Files ---


def test_numbered_files(tmp_path):
    written = write_frames(tmp_path / "x.png", pictures())
    assert [path.name for path in written] == ["x_0001.png", "x_0002.png", "x_0003.png"]
    assert sorted(tmp_path.iterdir()) == written
    assert (np.asarray(Image.open(written[1])) == list(pictures())[1].to_bytes()).all()


@pytest.mark.parametrize("repeats", [True, False])
def test_a_gif_has_all_pictures_their_time_and_good_colours(tmp_path, repeats):
    assert write_frames(tmp_path / "x.gif", pictures(look="id"), seconds=0.1, repeats=repeats) == [tmp_path / "x.gif"]
    with Image.open(tmp_path / "x.gif") as gif:
        assert gif.n_frames == 3
        assert gif.info.get("loop") == (0 if repeats else None)
        for i, picture in enumerate(pictures(look="id")):
            gif.seek(i)
            assert gif.info["duration"] == 100
            assert np.abs(np.asarray(gif.convert("RGB")).astype(int) - picture.to_bytes()).mean() < 4


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # the reader leaves its pipes open
def test_a_film_has_all_pictures_and_even_sides(tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    frames = turntable(TREE, 4, width=63, height=49, samples=1, radius=0.01)
    write_frames(tmp_path / "x.mp4", frames, seconds=0.1)
    reader = ffmpeg.read_frames(str(tmp_path / "x.mp4"))
    about = next(reader)
    assert about["size"] == (64, 50)
    assert about["fps"] == pytest.approx(10)
    assert len(list(reader)) == 4
    assert [path.name for path in tmp_path.iterdir()] == ["x.mp4"]


def test_films_need_an_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(fl.MissingExtraError, match=r"the extra 'video'"):
        write_frames(tmp_path / "x.mp4", pictures())


@pytest.mark.parametrize("name", ["x.gif", "x.mp4"])
def test_a_failed_animation_leaves_the_old_file(tmp_path, name):
    if name == "x.mp4":
        pytest.importorskip("imageio_ffmpeg")
    (tmp_path / name).write_bytes(b"old")

    def failing():
        yield from pictures(2)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_frames(tmp_path / name, failing())
    assert (tmp_path / name).read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_what_is_no_animation_is_refused(tmp_path):
    for name, words in (("x.avi", r"known: \.png, \.exr, \.gif, \.mp4"), ("no/x.png", "no folder")):
        with pytest.raises((fl.InputError, FileNotFoundError), match=words):
            write_frames(tmp_path / name, pictures())
    for name in ("x.png", "x.gif"):
        with pytest.raises(fl.InputError, match="no pictures"):
            write_frames(tmp_path / name, [])
    with pytest.raises(fl.InputError, match="use one size"):
        write_frames(tmp_path / "x.gif", [*pictures(1), fl.render(TREE, width=8, height=8, samples=1)])
    with pytest.raises(fl.InputError, match="seconds=0"):
        write_frames(tmp_path / "x.gif", pictures(), seconds=0)
    assert list(tmp_path.iterdir()) == []


def test_radii_may_be_an_array():
    tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    assert len(list(fl.rendering.radius_sweep(tree, np.geomspace(0.01, 0.1, 2), width=8, height=8))) == 2
