"""Progress in notebooks: a bar where there are widgets, a line of text where there are none, and no warning."""

from __future__ import annotations

import builtins
import re
import sys

import numpy as np
import pytest

import fastlines as fl
from fastlines.progress import reporting
from fastlines.rendering import depth_image, level_sheet

LINES = np.random.default_rng(0).random((3000, 2, 3)).astype(np.float32)


class ZMQInteractiveShell:
    """What a notebook's shell is called, and what rich looks for."""


@pytest.fixture
def notebook(monkeypatch):
    monkeypatch.setattr(builtins, "get_ipython", ZMQInteractiveShell, raising=False)
    monkeypatch.setitem(sys.modules, "ipywidgets", None)


def test_a_notebook_without_widgets_has_a_line_of_text(notebook, capsys):
    fl.build(LINES, "bvh-cl", progress=True)
    said = capsys.readouterr()
    assert said.out == ""
    assert "\rbuild   0 %" in said.err
    assert said.err.endswith("\r           \r"), "it goes away at the end"
    assert "\n" not in said.err


def test_the_line_counts_up_and_tells_each_percent_once(notebook, capsys):
    with reporting(True, "query") as show:
        for done in (0.1, 0.104, 0.5, 0.4, 1.0):
            show(done)
    shares = capsys.readouterr().err.split("\r")
    assert shares == ["", "query   0 %", "query  10 %", "query  50 %", "query 100 %", " " * 11, ""]


def test_outside_notebooks_no_widgets_are_needed(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    fl.build(LINES, "bvh-cl", progress=True)
    assert "%" not in capsys.readouterr().out


CAMERA = fl.Camera((0, 0, 5), (0, 0, 0))
RAYS = [0, 0, -5], [0, 0, 1], 0.1
SMALL = {"width": 4, "height": 4, "radius": 0.1}
TREE = fl.build(LINES, "bvh-cl")
#: All functions that take `progress`.
CALLS = {
    "read": lambda path, progress: fl.read(path, progress=progress),
    "build": lambda path, progress: fl.build(LINES, progress=progress),
    "refit": lambda path, progress: TREE.refit(LINES, progress=progress),
    "render": lambda path, progress: fl.render(TREE, progress=progress, **SMALL),
    "hits": lambda path, progress: fl.render(TREE, look="hits", progress=progress, **SMALL),
    "depth_image": lambda path, progress: depth_image(TREE, CAMERA, 4, 4, 0.1, progress),
    "level_sheet": lambda path, progress: level_sheet(TREE, CAMERA, 0.1, 2, progress=progress),
    **{
        name: lambda path, progress, name=name: getattr(TREE, name)(*RAYS, progress=progress)
        for name in ("first_hit", "any_hit", "count_hits", "all_hits")
    },
    "next_hits": lambda path, progress: TREE.next_hits(*RAYS, k=1, progress=progress),
    "iter_all_hits": lambda path, progress: TREE.iter_all_hits(*RAYS, max_bytes=9, progress=progress),
    "in_box": lambda path, progress: TREE.in_box(0, 1, progress=progress),
}


@pytest.mark.parametrize("progress", ["no", 1, None, [print]], ids=repr)
@pytest.mark.parametrize("call", CALLS)
def test_what_is_neither_a_switch_nor_a_function_is_refused(call, progress, tmp_path, capsys):
    fl.write(tmp_path / "a.npy", LINES[:3])
    with pytest.raises(fl.InputError, match=re.escape(f"progress={progress!r}; expected True, False, or a function")):
        CALLS[call](tmp_path / "a.npy", progress)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("kernel", ["auto", "binary"])
def test_a_few_rays_that_take_long_show_progress(kernel):
    """They are one group, which kernels trace together, on the calling thread."""
    rng, shares = np.random.default_rng(1), []
    start = rng.uniform(-1, 1, (60_000, 1, 3))
    tree = fl.build(start + rng.normal(0, 0.01, (60_000, 2, 3)), "bvh-cl")
    tree.all_hits(*rng.uniform(-1, 1, (2, 64, 3)), 10, kernel=kernel, progress=shares.append)
    within = [share for share in shares if 0 < share < 1]
    assert len(within) > 2
    assert within == sorted(within)
