"""``fastlines render``: turns, sweeps of the radius, and pictures that Ctrl-C stops and --resume goes on with."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support.command_line import done, refused, run
from support.patience import HANGS

from fastlines.rendering import MEASURES, Renderer, progressive

pytestmark = pytest.mark.usefixtures("in_own_folder")

SMALL = ("--width", 20, "--height", 16)


def pixels(path):
    with Image.open(path) as picture:
        return np.asarray(picture)


def names(folder="."):
    return sorted(path.name for path in Path(folder).iterdir())


# --- Many pictures ---


def test_a_turn_is_numbered_files_or_an_animation(tree_file):
    Path("frames").mkdir()
    text = done("render", tree_file, "-r", 0.02, *SMALL, "--turntable", 3, "-o", "frames/x.png")
    assert text.startswith("frames/x_0001.png to frames/x_0003.png: 3 pictures of 20 × 16 pixels, 60 segments")
    assert names("frames") == ["x_0001.png", "x_0002.png", "x_0003.png"]
    first, second = pixels("frames/x_0001.png"), pixels("frames/x_0002.png")
    assert first.shape == (16, 20, 3)
    assert (first != second).any()
    assert "3 pictures" in done("render", tree_file, *SMALL, "--turntable", 3, "--seconds", 0.1, "-o", "x.gif")
    with Image.open("x.gif") as gif:
        assert (gif.n_frames, gif.info["duration"]) == (3, 100)


def test_a_sweep_has_a_picture_for_each_radius(tree_file):
    text = done("render", tree_file, *SMALL, "--radius-sweep", "0.001:0.1:3", "--look", "hits", "-o", "x.png")
    assert text.endswith("radii 0.001 to 0.1\n")
    # All pictures frame the largest radius.
    done("render", tree_file, *SMALL, "--radius", 0.1, "--look", "hits", "-o", "one.png")
    assert (pixels("x_0003.png") == pixels("one.png")).all()


def test_many_pictures_may_be_exr_or_transparent(tree_file):
    done("render", tree_file, *SMALL, "--turntable", 1, "--background", "transparent", "-o", "x.png")
    assert pixels("x_0001.png").shape == (16, 20, 4)
    openexr = pytest.importorskip("OpenEXR")
    done("render", tree_file, *SMALL, "--turntable", 2, "-o", "x.exr")
    with openexr.File("x_0002.exr") as file:
        assert "id" in file.channels()


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("--turntable", 2, "--radius-sweep", "1:2:3", "-o", "x.gif"), "give one of them"),
        (("--turntable", 2, "--levels", 2, "-o", "x.png"), "--levels does not apply: --turntable makes many"),
        (("--turntable", 2, "--resume", "-o", "x.png"), "--resume does not apply"),
        (("--radius-sweep", "1:2:3", "-r", 1, "-o", "x.png"), "--radius does not apply"),
        (("--radius-sweep", "1:2", "-o", "x.png"), "is not A:B:N, such as 0.0005:0.05:60"),
        (("--radius-sweep", "-1:2:3", "-o", "x.png"), "radius=-1"),
        (("--turntable", 2, "-o", "x.avi"), "known: .png, .exr, .gif, .mp4"),
        (("--turntable", 2, "-o", "no/x.png"), "there is no folder no"),
        (("--turntable", 2, "--seconds", 0, "-o", "x.gif"), "seconds=0"),
        (("--turntable", 2, "--background", "transparent", "-o", "x.gif"), "--background transparent does not apply"),
        (("--seconds", 1, "-o", "x.png"), "--seconds does not apply"),
        (("--resume", "-o", "x.png"), "x.png.npz: no such file; leave out --resume"),
        (("-o", "x.gif"), "known: .png, .exr"),
        (("--turntable", 2, "--seconds", 1, "-o", "x.png"), "--seconds does not apply: only pictures of a film"),
        (("--look", "depth", "--exposure", 1, "-o", "x.png"), "--exposure does not apply: the look 'depth' shows no"),
        (("--look", "hits", "--color-map", "gray", "-o", "x.png"), "--color-map does not apply: the look 'hits' has"),
        (("--look", "tube", "--legend", "-o", "x.png"), "--legend does not apply: such colours have no legend"),
        (("--color-map", "gray", "-o", "x.png"), "--color-map does not apply: a map gives colours to the numbers of"),
        (("--color-map", "jet", "-o", "x.png"), "there is no colour map 'jet'"),
    ],
)
def test_what_does_not_go_together_is_refused(args, words, tree_file):
    assert words in refused("render", tree_file, *SMALL, *args)[1]
    assert names() == [tree_file]


@pytest.mark.parametrize("option", ["--exposure", "--quality", "--legend", "--background", "--color-map", "--samples"])
def test_levels_refuse_what_they_do_not_have(option, tree_file):
    value = {"--exposure": [1], "--quality": ["high"], "--legend": [], "--background": ["#fff"], "--samples": [2]}
    args = (option, *value.get(option, ["gray"]))
    said = refused("render", tree_file, "-r", 0.02, "--levels", 2, *args, "-o", "x.png")[1]
    assert f"{option} does not apply: levels of a tree are drawn in panels of a fixed size and look" in said
    assert names() == [tree_file]


def test_an_exr_refuses_what_it_does_not_hold(tree_file):
    pytest.importorskip("OpenEXR")
    command = ("render", tree_file, "-r", 0.02, *SMALL, "-s", 1, "-o", "x.exr")
    for args, said in (
        (("--look", "hits", "--legend"), "--legend does not apply: an .exr holds numbers, without a legend"),
        (("--look", "tube", "--background", "#fff"), "--background does not apply: an .exr has no background"),
        (("--look", "depth", "--exposure", 1), "--exposure does not apply"),
    ):
        assert said in refused(*command, *args)[1]
    assert names() == [tree_file]
    done(*command, "--look", "hits", "--no-legend")
    done(*command, "--look", "fibre", "--background", "#fff")  # into which fibres fade


@pytest.mark.parametrize("name", ["brown", "plain", "fa"])
def test_colours_of_an_attribute_have_a_legend_unless_the_user_says_no(name):
    ends = np.random.default_rng(0).random((30, 2, 3))
    np.savez("a.npz", **{"segments": ends, name: np.linspace(0, 1, 30)})
    command = ("render", "a.npz", "-r", 0.02, "--width", 64, "--height", 64, "-s", 1, "--look", "tube")
    done(*command, "--color", name, "-o", "bar.png")
    done(*command, "--color", name, "--legend", "-o", "same.png")
    done(*command, "--color", name, "--no-legend", "-o", "none.png")
    assert (pixels("bar.png") == pixels("same.png")).all()
    assert (pixels("bar.png") != pixels("none.png")).any()


# --- Ctrl-C ---


def test_ctrl_c_writes_what_is_there_and_resume_goes_on(tree_file, monkeypatch):
    command = ("render", tree_file, "-r", 0.02, *SMALL, "--look", "tube", "-s", 4)
    done(*command, "-o", "whole.png")
    passes = Renderer.passes

    def stopped(self, progress=None):
        for index in passes(self, progress):
            yield index
            if index == 2:
                raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Renderer, "passes", stopped)
        result = run(*command, "-o", "x.png")
    assert (result.exit_code, result.stdout) == (130, "")
    expected = "stopped after 2 of 4 samples a pixel; the same command with --resume goes on from x.png.npz"
    assert result.stderr == f"{expected}\n"
    assert names() == [tree_file, "whole.png", "x.png", "x.png.npz"]
    assert (pixels("x.png") != pixels("whole.png")).any()
    # Other options are another picture.
    assert "the look differs" in refused(*command, "--look", "id", "--resume", "-o", "x.png")[1]
    done(*command, "--resume", "-o", "x.png")
    assert (pixels("x.png") == pixels("whole.png")).all()
    assert names() == [tree_file, "whole.png", "x.png"]


@pytest.mark.parametrize("look", ["hits", "density", "work"])
@pytest.mark.parametrize("samples", [1, 3])
def test_ctrl_c_keeps_what_there_is_of_a_measure(look, samples, tree_file, monkeypatch):
    monkeypatch.setattr(progressive, "MAX_RAYS", 100)  # bands of five rows
    monkeypatch.setenv("FASTLINES_NUM_THREADS", "1")  # so that bands come one after another
    command = ("render", tree_file, "-r", 0.02, *SMALL, "--look", look, "-s", samples)
    done(*command, "-o", "whole.png")
    measure = MEASURES[look]
    n_calls = 0

    def stopped(*rays):
        nonlocal n_calls
        n_calls += 1
        if n_calls == (3 if samples == 1 else 6):
            raise KeyboardInterrupt
        return measure.count(*rays)

    # The same name, so that it is the same look to --resume.
    stopped.__module__, stopped.__qualname__ = measure.count.__module__, measure.count.__qualname__
    with monkeypatch.context() as patch:
        patch.setitem(MEASURES, look, replace(measure, count=stopped))
        result = run(*command, "-o", "x.png")
    assert (result.exit_code, result.stdout) == (130, "")
    n = "10 of 16 rows of pixels" if samples == 1 else "1 of 3 samples a pixel"
    assert result.stderr == f"stopped after {n}; the same command with --resume goes on from x.png.npz\n"
    assert names() == [tree_file, "whole.png", "x.png", "x.png.npz"]
    assert (pixels("x.png") != pixels("whole.png")).any()
    done(*command, "--resume", "-o", "x.png")
    assert (pixels("x.png") == pixels("whole.png")).all()
    assert names() == [tree_file, "whole.png", "x.png"]


#: Runs a command, and says when each pass is done.
TALKING = """
from fastlines.cli import main
from fastlines.rendering import Progressive

passes = Progressive.passes

def talking(*arguments):
    for index in passes(*arguments):
        print("pass", index, flush=True)
        yield index

Progressive.passes = talking
main()
"""


@pytest.mark.parametrize("n_interrupts", [1, 3])
def test_ctrl_c_while_several_threads_draw(n_interrupts, tree_file):
    """A second one, while files are written, loses nothing; one after that may end the process a little earlier."""
    size = ("-r", "0.02", "--width", "512", "--height", "512", "-s", "10000", "-o", "x.png")
    environment = {**os.environ, "FASTLINES_NUM_THREADS": "4"}
    command = [sys.executable, "-c", TALKING, "render", tree_file, *size]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "pass 1\n"
        for _ in range(n_interrupts):
            process.send_signal(signal.SIGINT)
            time.sleep(0.05)
        _, errors = process.communicate(timeout=HANGS)
    assert process.returncode in ((130,) if n_interrupts == 1 else (130, -signal.SIGINT))
    sentence = r"^stopped after \d+ of 10000 samples a pixel; the same command with --resume goes on"
    assert re.search(sentence, errors, re.MULTILINE)
    assert names() == [tree_file, "x.png", "x.png.npz"]
