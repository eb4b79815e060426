"""``fastlines beams``: pictures of light in media, and how they go on after Ctrl-C."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support.command_line import done, refused, run

from fastlines.beams import NAMES, Passes
from fastlines.rendering import refinement

pytestmark = pytest.mark.usefixtures("in_own_folder")

SMALL = ("--width", 16, "--height", 12, "--paths", 300, "--passes", 2)


def pixels(path):
    with Image.open(path) as picture:
        return np.asarray(picture)


@pytest.mark.parametrize("scene", NAMES)
def test_each_scene_becomes_a_picture(scene):
    told = done("beams", scene, *SMALL, "-o", "x.png")
    assert re.fullmatch(r"x.png: 2 passes, 600 photons, exposure -?[\d.]+\n", told)
    assert pixels("x.png").shape == (12, 16, 3)
    assert pixels("x.png").max() > 100


def test_options_change_the_picture():
    pictures = []
    for i, options in enumerate(
        (
            (),
            ("--long",),
            ("--blur", "epanechnikov"),
            ("--estimator", "point"),
            ("--seed", 1),
            ("-r", 0.1),
            ("--adapt",),
        )
    ):
        done("beams", "glass-sphere", *SMALL, *options, "-o", f"{i}.png")
        pictures.append(pixels(f"{i}.png").tobytes())
    assert len(set(pictures)) == len(pictures)


def test_one_side_makes_a_square():
    done("beams", "point-light", "--width", 8, "--paths", 100, "--passes", 1, "-o", "x.png")
    assert pixels("x.png").shape == (8, 8, 3)


def test_an_interrupted_picture_goes_on(monkeypatch):
    done("beams", "glass-sphere", *SMALL, "-o", "whole.png")
    add = Passes.add

    def interrupted(passes, progress=None):
        if passes.done == 1:
            raise KeyboardInterrupt
        add(passes, progress)

    monkeypatch.setattr(Passes, "add", interrupted)
    stopped = run("beams", "glass-sphere", *SMALL, "-o", "x.png")
    assert stopped.exit_code == 130
    assert "stopped after 1 of 2 passes" in stopped.stderr
    assert "--resume goes on from x.png.npz" in stopped.stderr
    assert (pixels("x.png") != pixels("whole.png")).any()

    monkeypatch.setattr(Passes, "add", add)
    assert "2 passes" in done("beams", "glass-sphere", *SMALL, "-o", "x.png", "--resume")
    assert (pixels("x.png") == pixels("whole.png")).all()
    assert not Path("x.png.npz").exists()


def stop_at(monkeypatch, n_passes):
    """Interrupt pictures when they have this many passes."""
    add = Passes.add

    def interrupted(passes, progress=None):
        if passes.done == n_passes:
            raise KeyboardInterrupt
        add(passes, progress)

    monkeypatch.setattr(Passes, "add", interrupted)


def test_saved_passes_are_not_replaced_unseen(monkeypatch):
    with monkeypatch.context() as patch:
        stop_at(patch, 2)
        run("beams", "glass-sphere", *SMALL[:-1], 3, "-o", "x.png")
    saved = Path("x.png.npz").read_bytes()
    with monkeypatch.context() as patch:
        stop_at(patch, 0)
        stopped = run("beams", "glass-sphere", *SMALL, "-o", "x.png")
    assert stopped.exit_code == 130
    assert re.findall("^note: .*$", stopped.stderr, re.MULTILINE) == [
        "note: x.png.npz: has 2 passes of an unfinished picture, which new ones replace; --resume goes on from them"
    ]
    assert "stopped in the first pass, so there is no picture yet" in stopped.stderr
    assert Path("x.png.npz").read_bytes() == saved
    message = refused("beams", "glass-sphere", *SMALL[:-1], 1, "-o", "x.png", "--resume")[1]
    assert "2 passes are done; --passes 1 counts them too" in message
    assert Path("x.png.npz").read_bytes() == saved
    assert "3 passes" in done("beams", "glass-sphere", *SMALL[:-1], 3, "-o", "x.png", "--resume")


def test_the_exposure_that_is_shown_gives_the_same_picture():
    shown = done("beams", "point-light", *SMALL, "-o", "x.png").split()[-1]
    assert done("beams", "point-light", *SMALL, "--exposure", shown, "-o", "y.png").split()[-1] == shown
    assert np.abs(pixels("x.png").astype(int) - pixels("y.png")).max() <= 2


@pytest.mark.parametrize("extension", [".png", ".exr"])
def test_a_picture_goes_on_after_a_crash(monkeypatch, extension):
    if extension == ".exr":
        pytest.importorskip("OpenEXR")
    output, state = f"x{extension}", Path(f"x{extension}.npz")
    done("beams", "glass-sphere", *SMALL, "-o", f"whole{extension}")
    add = Passes.add

    def crashing(passes, progress=None):
        if passes.done == 1:
            raise MemoryError
        add(passes, progress)

    monkeypatch.setattr(refinement, "WAITED", 0.0)  # however short the passes are
    monkeypatch.setattr(Passes, "add", crashing)
    assert run("beams", "glass-sphere", *SMALL, "-o", output).exit_code not in (0, 130)
    assert state.is_file()
    assert Path(output).is_file() == (extension == ".png")

    monkeypatch.setattr(Passes, "add", add)
    done("beams", "glass-sphere", *SMALL, "-o", output, "--resume")
    assert Path(output).read_bytes() == Path(f"whole{extension}").read_bytes()
    assert not state.exists()
    done("beams", "glass-sphere", *SMALL, "-o", output)
    assert not state.exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("fog", "-o", "x.png"), "there is no scene 'fog'"),
        (("my.py", "-o", "x.png"), "my.py: a scene of your own is rendered in Python, by fl.beams.render"),
        (("point-light", "-o", "x.jpg"), "unknown extension '.jpg'"),
        (("point-light", "-o", "x.png", "--exposure", "nan"), "exposure=nan; expected a power of 2"),
        (("point-light", "-o", "no/x.png"), "there is no folder"),
        (("point-light", "-o", "x.png", "-r", 0), "radius=0.0"),
        (("point-light", "-o", "x.png", "--alpha", 2), "alpha=2.0"),
        (("point-light", "-o", "x.png", "--blur", "gauss"), "blur='gauss'"),
        (("point-light", "-o", "x.png", "--resume"), "x.png.npz: no such file"),
        (("point-light", "-o", "x.png", "-m", "octree"), "octree"),
    ],
)
def test_bad_options_are_refused(options, message):
    assert message in refused("beams", *options)[1]
    assert not Path("x.png").exists()


def test_numbers_take_no_exposure():
    pytest.importorskip("OpenEXR")
    assert "exposure=1.0 does not apply" in refused("beams", "point-light", "--exposure", 1, "-o", "x.exr")[1]
