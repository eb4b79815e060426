"""The command ``scale`` at a tiny size."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

from fastlines_bench.scale import streamlines

pytestmark = pytest.mark.usefixtures("in_own_folder")

HAS_CLUSTER = importlib.util.find_spec("distributed") is not None


def test_chunks_are_the_whole():
    parts = list(streamlines.chunks(2_345, size=1_000))
    whole = streamlines.whole(2_345, size=1_000)
    assert [len(part) for part in parts] == [1_000, 1_000, 345]
    assert np.array_equal(np.concatenate([part.segments for part in parts]), whole.segments)
    assert whole.n_strands == sum(part.n_strands for part in parts) == 47


def test_answers_memory_and_restarts():
    done("scale", "--quick", "--part", "answers,memory,restarts", "--kills", 1, "--json", "s.json")
    result = json.loads(Path("s.json").read_text())
    assert result["format"] == "fastlines-bench scale 1"
    assert [part["name"] for part in result["parts"]] == ["answers", "memory", "restarts"]
    for part in result["parts"]:
        assert part["rows"]
        assert all(check["holds"] for check in part["checks"]), part["checks"]


@pytest.mark.slow
@pytest.mark.skipif(not HAS_CLUSTER, reason="distributed is not installed")
def test_workers():
    text = done("scale", "--quick", "--part", "cluster,kills", "--kills", 1, "--json", "s.json")
    assert "a worker is killed" in text
    cluster, kills = json.loads(Path("s.json").read_text())["parts"]
    assert [row[0] for row in cluster["rows"]][-1] == "2 workers, dask arrays"
    assert [check["holds"] for check in (*cluster["checks"][-1:], *kills["checks"])] == [True, True]


def test_growth():
    text = done("scale", "--quick", "--part", "growth", "--sizes", "2000,4000", "--rays", "1000,2000")
    assert "how time grows" in text
    assert "first hits ~ n^" in text


def test_a_plot_needs_growth():
    code, text = refused("scale", "--part", "answers", "--plot", "p.png")
    assert code == 1
    assert "growth" in text
