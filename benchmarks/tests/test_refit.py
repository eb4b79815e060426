"""The command ``refit`` at a tiny size."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

import fastlines as fl
from fastlines_bench.refit.run import twisted

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run():
    text = done("refit", "--quick", "--scene", "spaghetti:200", "--n-rays", 4096, "--json", "r.json")
    for said in ("refits of a growing twist", "growth", "pays after"):
        assert said in text
    result = json.loads(Path("r.json").read_text())
    assert result["format"] == "fastlines-bench refit 1"
    assert [cell["angle"] for cell in result["cells"]] == [180, 360]
    for cell in result["cells"]:
        assert cell["n_prims"] == 200
        assert cell["n_refs"] > 200
        assert cell["growth"] > 1
        assert all(cell[name] > 0 for name in ("refit_s", "build_s", "first_ns", "all_rebuilt_ns"))


def test_twist():
    lines = fl.scenes.make("straight-hair", 100).lines
    assert np.abs(twisted(lines, 0).segments - lines.segments).max() < 1e-6
    turned = twisted(lines, 90)
    np.testing.assert_array_equal(turned.segments[..., 1], lines.segments[..., 1])
    assert np.abs(turned.segments - lines.segments).max() > 0.1


def test_refused():
    assert "unknown method" in refused("refit", "--method", "nope")[1]
    assert ".json" in refused("refit", "--json", "s.txt")[1]
