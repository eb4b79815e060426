"""The command ``hair`` at a tiny size, with Mitsuba and without."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

from fastlines_bench.studies.scattering.oracle import mitsuba_scaled_i0
from fastlines_bench.studies.scattering.run import MATERIALS

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run():
    pytest.importorskip("mitsuba")
    text = done("hair", "--quick", "--json", "h.json", "--examples", "e.json")
    assert "relative error beside Mitsuba" in text
    result = json.loads(Path("h.json").read_text())
    assert result["format"] == "fastlines-bench hair 1"
    assert {cell["material"] for cell in result["cells"]} == MATERIALS.keys()
    for cell in result["cells"]:
        assert cell["p999"] < (1e-3 if cell["bessel"] == "Mitsuba's" else 1e-2)
    assert len(json.loads(Path("e.json").read_text())["examples"]) == 4 * len(MATERIALS)


def test_mitsuba_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    assert "pip install mitsuba" in refused("hair", "--quick")[1]
    assert ".json" in refused("hair", "--json", "f.txt")[1]


def test_approximations_of_i0():
    x = np.array([0.0, 1.0, 5.0, 11.9, 12.1, 100.0])
    exact = np.i0(x) * np.exp(-x)
    error = np.abs(mitsuba_scaled_i0(x) / exact - 1)
    assert error.max() < 6e-3
    assert error[:3].max() < 1e-6
