"""The command ``cuda`` at tiny sizes, on a host that emulates the GPU."""

from __future__ import annotations

import json
from functools import partialmethod

import numpy as np
import pytest
from command_line import done, refused
from command_line import run as command
from support.emulated_device import EmulatedDevice, require_compiler

from fastlines import FastlinesError
from fastlines.cuda import cuda_device
from fastlines.cuda.choice import use_device
from fastlines.cuda.program import TUNING
from fastlines.scenes import make
from fastlines_bench.cuda import run, variants
from fastlines_bench.harness.rays import random_rays
from fastlines_bench.peers.warp import warp

TINY = ("--quick", "--scene", "spaghetti,bun-hair", "--n-segments", 100, "--n-rays", 256, "--rounds", 1)

pytestmark = pytest.mark.usefixtures("in_own_folder")


@pytest.fixture
def device(tmp_path, monkeypatch):
    require_compiler()
    monkeypatch.setattr(run, "UPLOADED", 1 << 16)
    monkeypatch.setattr(run.CudaPreset, "__init__", partialmethod(run.CudaPreset.__init__, warp="cpu"))
    with use_device(EmulatedDevice(tmp_path)) as given:
        yield given


def test_run(tmp_path, device):
    text = done("cuda", *TINY, "--json", "c.json")
    for said in ("a host that emulates a GPU", "decisions", "Mrays/s", "spaghetti", "bun-hair", "GB/s"):
        assert said in text
    assert "answer differs" not in text
    result = json.loads((tmp_path / "c.json").read_text())
    assert result["format"] == "fastlines-bench cuda 1"
    assert [each["scene"] for each in result["comparisons"]] == ["spaghetti", "bun-hair"]
    assert all(each["n_decisions"] > 10_000 and not each["differing"] for each in result["comparisons"])
    assert len(result["cells"]) == 2 * 3 * len(run.TIMED)
    for cell in result["cells"]:
        assert cell["same"]
        assert (cell["steps"] is None) == (cell["query"] != "first_hit")
        assert (cell["warp_s"] is None) == (not warp() or cell["query"] not in ("first_hit", "count_hits"))
        if cell["warp_s"]:
            assert cell["warp_differs"] <= 0.02
        if cell["steps"]:
            assert cell["steps"][0] >= 1
            assert cell["bytes_per_ray"] >= 128
    assert result["left_out"] == []


def test_sorted_rays_are_the_same_rays():
    lines = make("spaghetti", 50).lines
    rays = random_rays(lines, 500)
    ordered = run.sorted_rays(rays, lines.bounds)
    for name in ("origins", "directions"):
        a, b = (np.unique(getattr(batch, name), axis=0) for batch in (rays, ordered))
        assert np.array_equal(a, b)
    octants = (ordered.directions < 0) @ [1, 2, 4]
    assert (np.diff(octants) >= 0).all()


def test_what_differs_is_said(device, monkeypatch):
    monkeypatch.setattr(run, "same", lambda given, expected: False)
    result = command("cuda", *TINY)
    assert result.exit_code == 1
    assert "the answer differs" in result.stdout
    assert " NO" in result.stdout


def test_tuning(device, monkeypatch):
    for name, value in TUNING.items():
        monkeypatch.setitem(TUNING, name, value)  # restored afterwards
    text = done("cuda", *TINY, "--tune", "FASTLINES_NODE_ROWS=1", "--tune", "FASTLINES_BLOCK=64")
    assert "FASTLINES_BLOCK 64, FASTLINES_GROUP 1, FASTLINES_NODE_ROWS 1" in text
    assert "is not NAME=N" in refused("cuda", *TINY, "--tune", "FASTLINES_STACK=1")[1]


def test_variants(tmp_path, device):
    before = TUNING.copy()
    given = "--variant", "FASTLINES_GROUP=1", "--variant", "FASTLINES_GROUP=16,FASTLINES_SHARED_STACK=4"
    text = done("cuda-variants", *TINY, *given, "--json", "v.json")
    for said in (
        "a host that emulates a GPU",
        "Mrays/s",
        "GROUP=1",
        "GROUP=16 SHARED_STACK=4",
        "spaghetti",
        "bun-hair",
    ):
        assert said in text
    assert "answer differs" not in text
    assert before == TUNING
    result = json.loads((tmp_path / "v.json").read_text())
    assert result["format"] == "fastlines-bench cuda-variants 1"
    assert len(result["cells"]) == 2 * 3 * len(run.TIMED) * 2
    assert all(cell["same"] and cell["mrays"] > 0 for cell in result["cells"])
    assert len(result["compile_s"]) == 2 * 2
    assert "is not NAME=N" in refused("cuda-variants", *TINY, "--variant", "FASTLINES_STACK=1")[1]


def test_variants_that_differ_are_said(device, monkeypatch):
    monkeypatch.setattr(variants, "columns", lambda answer: [answer] * 5)
    monkeypatch.setattr(variants, "columns_on_device", lambda *_: [0] * 5)
    result = command("cuda-variants", *TINY, "--scene", "bun-hair", "--variant", "FASTLINES_GROUP=1")
    assert result.exit_code == 1
    assert "bun-hair, camera rays, first_hit, GROUP=1: the answer differs" in result.stdout


def test_resources(tmp_path):
    pytest.importorskip("cuda.core", reason="needs fastlines[cuda]")
    given = "--variant", "FASTLINES_BLOCK=64", "--variant", "FASTLINES_GROUP=16,FASTLINES_SHARED_STACK=16"
    text = done("cuda-resources", *given, "--stack", 32, "--json", "r.json")
    assert "kernels for DeviceSegments on sm_90, stacks of 32 entries, by NVRTC" in text
    thread, *_, group = json.loads((tmp_path / "r.json").read_text())["rows"]
    assert (thread["kernel"], group["kernel"]) == ("first_closest", "all_closest")
    assert thread["registers"] > 16
    assert thread["local"] >= 32 * 8
    assert thread["shared"] == 0
    assert 8 <= group["local"] < 32 * 8
    assert group["shared"] == 16 * 8 * 8


def test_variants_are_known_and_differ():
    assert all(variant.keys() <= TUNING.keys() for variant in variants.VARIANTS)
    assert len({str(sorted((TUNING | variant).items())) for variant in variants.VARIANTS}) == len(variants.VARIANTS)


def test_a_limit_leaves_scenes_out(device):
    assert "Left out, for time" in done("cuda", *TINY, "--limit", 0)
    assert "Left out, for time" in done("cuda-variants", *TINY, "--limit", 0)


def test_without_a_gpu(monkeypatch):
    def gpu():
        raise FastlinesError("there is no GPU here")

    monkeypatch.setattr(cuda_device, "gpu", gpu)
    assert refused("cuda", *TINY)[1] == "error: there is no GPU here\n"
