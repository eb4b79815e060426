"""The command ``mitsuba``: our side alone, and both sides where Mitsuba is installed."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from command_line import done, refused

import fastlines as fl
from fastlines_bench.harness.internals import HairMaterial, Light, Sky
from fastlines_bench.peers.hair_scene import SHAPES, SIDE, HairScene, geometry_of, normalised
from fastlines_bench.studies.path_tracing.ours import OurScene

HAS_MITSUBA = importlib.util.find_spec("mitsuba") is not None
pytestmark = pytest.mark.usefixtures("in_own_folder")


@pytest.mark.parametrize("shape", SHAPES)
def test_our_side_counts_its_rays(shape):
    scene = fl.scenes.make("bun-hair", 2000)
    lines, radius, camera = normalised(scene.lines, 0.002, scene.camera)
    assert np.ptp(lines.bounds, axis=0).max() == pytest.approx(SIDE)
    path = Path("hair.curves")
    geometry = geometry_of(lines, radius, shape, path)
    grey = (0.5, 0.5, 0.5)
    parts = HairMaterial(sigma_a=(0, 0, 0)), Light((0, 1, 0), (0, 0, 0), 0), Sky(grey, grey, grey)
    ours = OurScene(
        HairScene(geometry, path, shape, radius, camera, *parts, size=24, max_bounces=200), fl.build(geometry)
    )
    picture, seconds = ours.render(2, seed=0)
    assert picture.mean() == pytest.approx(0.5, rel=0.01)  # a furnace
    assert 2 * seconds > sum(ours.tree.seconds.values()) > 0  # two threads at most, one for each sample
    assert ours.tree.rays["first_surface"] > 2 * 24 * 24


@pytest.mark.skipif(not HAS_MITSUBA, reason="needs the package mitsuba")
def test_both_sides():
    text = done("mitsuba", "--quick", "--scene", "bun-hair:2000", "--variant", "scalar_rgb", "--json", "m.json")
    assert "Our mean radiance beside Mitsuba's" in text
    (result,) = json.loads(Path("m.json").read_text())
    assert result["means"]["fastlines"] == pytest.approx(result["means"]["Mitsuba"], rel=0.05)


def test_refused():
    assert "is not a variant" in refused("mitsuba", "--variant", "cuda")[1]
    assert "is not a shape" in refused("mitsuba", "--shape", "ribbon")[1]
    if not HAS_MITSUBA:
        assert "pip install mitsuba" in refused("mitsuba", "--quick", "--scene", "bun-hair:2000")[1]
