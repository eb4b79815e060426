"""The example for Blender runs in bpy, which is for one version of Python and seldom installed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_examples import run_example

import fastlines as fl

bpy = pytest.importorskip("bpy", reason="bpy is not installed; .ci/full tests the example with it")


@pytest.fixture
def example() -> Any:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return run_example("blender_hair")


def values(name: str, dtype: str) -> np.ndarray:
    (hair,) = (thing for thing in bpy.data.objects if thing.type == "CURVES")
    found = np.empty(len(hair.data.curves), dtype)
    hair.data.attributes[name].data.foreach_get("value", found)
    return found


def test_strands_that_come_near(example: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example.main(str(tmp_path / "near.blend"))
    near, gap = values("near_strands", "i4"), values("gap", "f4")
    assert f"{(near > 0).sum()} of 200 strands come within 0.01 of another one" in capsys.readouterr().out
    assert 0 < (near > 0).sum() < 200
    np.testing.assert_array_equal(gap < np.float32(0.01), near > 0)
    # What is read back gives the same, and all pairs, one by one.
    example.main(str(tmp_path / "again.blend"), str(tmp_path / "near.blend"))
    np.testing.assert_array_equal(values("near_strands", "i4"), near)
    (lines,) = map(example.lines_of, example.hair_objects())
    pairs = fl.brute_force_pairs(lines, 0.01, skip_strand=True)
    met = np.unique(lines.strands[np.stack([pairs.i, pairs.j], 1)], axis=0)
    assert met.size == near.sum()


def test_points_are_in_the_world(example: Any) -> None:
    example.make_groom(3, 4)
    (hair,) = example.hair_objects()
    lines = example.lines_of(hair)
    points = [hair.matrix_world @ point.position for point in hair.data.points]
    np.testing.assert_allclose(np.concatenate(lines.to_strands()), points, atol=1e-6)
    np.testing.assert_allclose(lines.max_radius, 0.02, rtol=1e-6)
