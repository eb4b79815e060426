"""``fastlines render``: a first picture before the whole one, how long it takes, and previews."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support.command_line import done, refused, run

from fastlines.cli import pictures, resume
from fastlines.rendering import Renderer, refinement

pytestmark = pytest.mark.usefixtures("in_own_folder")

SMALL = ("-r", 0.02, "--width", 20, "--height", 16, "--look", "tube", "-s", 3)


def pixels(path):
    with Image.open(path) as picture:
        return np.asarray(picture)


def names():
    return sorted(path.name for path in Path().iterdir())


@pytest.fixture
def early(monkeypatch):
    """Write each unfinished picture, and keep what is written."""
    written = []
    write = pictures.write_picture

    def keep(path, shown, *, is_final):
        assert not is_final
        write(path, shown, is_final=is_final)
        written.append(pixels(path))

    monkeypatch.setattr(pictures, "write_picture", keep)
    monkeypatch.setattr(refinement, "LARGE", 1)
    monkeypatch.setattr(refinement, "WAITED", 0.0)
    monkeypatch.setattr(refinement, "SHARE", 1e9)
    monkeypatch.setattr(resume, "WRITE_SECONDS", 0.0)
    return written


# --- A first picture ---


@pytest.mark.parametrize("background", [(), ("--background", "transparent")])
def test_a_first_picture_is_replaced_by_better_ones(background, early, tree_file):
    done("render", tree_file, *SMALL, *background, "-o", "x.png")
    assert len(early) == 4  # the draft, and three samples
    assert early[0].shape == early[-1].shape == (16, 20, 4 if background else 3)
    assert (early[0] != early[1]).any()
    assert (early[-1] == pixels("x.png")).all()
    assert names() == [tree_file, "x.png"]


def test_the_whole_picture_does_not_depend_on_those_before(early, tree_file, monkeypatch):
    done("render", tree_file, *SMALL, "-o", "x.png")
    monkeypatch.setattr(refinement, "LARGE", 1 << 30)
    done("render", tree_file, *SMALL, "-o", "y.png")
    assert Path("x.png").read_bytes() == Path("y.png").read_bytes()


def test_a_terminal_says_that_there_is_a_first_picture(early, tree_file, monkeypatch):
    monkeypatch.setattr(resume, "show_progress", lambda: True)
    result = run("render", tree_file, *SMALL, "-o", "x.png")
    assert result.exit_code == 0
    words = " ".join(result.stderr.split())
    assert words.count("note: x.png: is a first picture; it is replaced by better ones as samples come") == 1


def test_numbers_are_written_once(early, tree_file):
    pytest.importorskip("OpenEXR")
    done("render", tree_file, *SMALL, "-o", "x.exr")
    assert early == []


def test_ctrl_c_during_the_first_sample_keeps_the_draft(early, tree_file, monkeypatch):
    done("render", tree_file, *SMALL, "-o", "whole.png")
    early.clear()

    def stopped(self, progress=None):
        raise KeyboardInterrupt
        yield

    with monkeypatch.context() as patch:
        patch.setattr(Renderer, "passes", stopped)
        result = run("render", tree_file, *SMALL, "-o", "x.png")
    assert result.exit_code == 130
    assert "stopped after 0 of 16 rows of pixels; the same command with --resume goes on" in result.stderr
    assert (pixels("x.png") == early[0]).all()
    done("render", tree_file, *SMALL, "--resume", "-o", "x.png")
    assert (pixels("x.png") == pixels("whole.png")).all()
    assert names() == [tree_file, "whole.png", "x.png"]


# --- How long it takes ---


def test_a_long_picture_says_how_long(tree_file, monkeypatch):
    monkeypatch.setattr(refinement, "LONG", 0.0)
    result = run("render", tree_file, *SMALL, "-o", "x.png")
    assert result.exit_code == 0
    assert result.stderr.startswith("note: this picture takes about ")


def test_many_pictures_say_how_long_they_take_together(tree_file, monkeypatch):
    monkeypatch.setattr(refinement, "LONG", 0.0)
    result = run("render", tree_file, *SMALL, "--turntable", 3, "-o", "x.png")
    assert result.exit_code == 0
    assert result.stderr.startswith("note: these 3 pictures take about ")
    assert result.stderr.count("\n") == 1


# --- Previews ---


def test_a_preview_is_small(tree_file):
    text = done("render", tree_file, "-r", 0.02, "--preview", "-o", "x.png")
    height, width, _ = pixels("x.png").shape
    assert f"{width} × {height} pixels" in text
    assert 250**2 < width * height < 260**2
    done("render", tree_file, "-r", 0.02, "--width", width, "--height", height, "-s", 1, "-o", "y.png")
    assert (pixels("x.png") == pixels("y.png")).all()
    assert "2 pictures" in done("render", tree_file, "-r", 0.02, "--preview", "--turntable", 2, "-o", "t.gif")


@pytest.mark.parametrize(
    "args", [("--width", 9), ("--height", 9), ("--samples", 2), ("--quality", "high"), ("--resume",), ("--levels", 2)]
)
def test_a_preview_refuses_what_it_sets_itself(args, tree_file):
    said = refused("render", tree_file, "--preview", *args, "-o", "x.png")[1]
    assert f"error: {args[0]} does not apply: --preview draws a small picture with one sample a pixel; leave" in said
    assert names() == [tree_file]
