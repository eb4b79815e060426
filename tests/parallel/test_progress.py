"""Progress in notebooks: a bar where there are widgets, a line of text where there are none, and no warning."""

from __future__ import annotations

import builtins
import sys

import numpy as np
import pytest

import fastlines as fl
from fastlines.progress import reporting

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
