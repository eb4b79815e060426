"""The command ``gap`` at a tiny size: its comparisons and its output."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

from fastlines_bench.studies.optimum import gap

TINY = gap.GapPreset(n_seeds=1, same_planes=(5, 2), sets=5, builders=(6, 3))

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_run(monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(gap.GapPreset, "of", lambda quick: TINY)
    text = done("gap", "--quick", "--json", "g.json", "--plot", "g.png")
    for said in ("same planes", "sets", "builders", "worst", *gap.INPUTS, *gap.SEARCHES, *gap.BUILDERS):
        assert said in text
    assert Path("g.png").read_bytes().startswith(b"\x89PNG")
    result = json.loads(Path("g.json").read_text())
    assert result["format"] == "fastlines-bench gap 1"
    n_rows = 2 * len(gap.SEARCHES) + len(gap.SETS) + len(gap.BUILDERS)
    assert len(result["cells"]) == n_rows * len(gap.INPUTS)
    for cell in result["cells"]:
        assert cell["ratio"] == cell["cost"] / cell["optimum"]
        if cell["group"] != "builders":
            assert cell["ratio"] >= 1 - 1e-9, cell


@pytest.mark.parametrize("name", gap.INPUTS)
def test_inputs(name):
    for n in (1, 7, 32):
        ends, again, other = (gap.INPUTS[name](n, np.random.default_rng(seed)) for seed in (0, 0, 1))
        assert (ends.shape, ends.dtype) == ((n, 2, 3), np.float32)
        np.testing.assert_array_equal(ends, again)
        assert not np.array_equal(ends, other)


def test_refused():
    assert ".json" in refused("gap", "--json", "g.txt")[1]
    assert ".png" in refused("gap", "--plot", "g.txt")[1]
