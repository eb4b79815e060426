"""What becomes float32 loses digits; where that matters to the scene, it is said."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from support.command_line import run

import fastlines as fl

FAR = (4.5e5, 5.4e6, 200.0)  # metres, as surveys have them
WIRES = np.random.default_rng(5).uniform(0, 1000, (200, 2, 3))


def test_a_scene_far_from_zero_is_told_what_it_lost() -> None:
    with pytest.warns(fl.PrecisionWarning, match=r"up to 5\.40?\d*e\+06, in a scene of size 99\d.*by up to 0\.25"):
        tree = fl.build(WIRES + FAR)
    lost = np.abs(tree.geometry.segments - (WIRES + FAR)).max()
    assert 0.2 < lost <= 0.25
    points = (WIRES + FAR).reshape(-1, 3)
    with pytest.warns(fl.PrecisionWarning):
        fl.Lines.from_points(points, [100, 300])
    with pytest.warns(fl.PrecisionWarning):
        fl.Lines.from_strands([points[:7], points[7:]])
    with pytest.warns(fl.PrecisionWarning):
        fl.Lines.from_segments((WIRES + 1e8).astype(np.int64))
    one_axis = WIRES + np.array([0, 1e7, 0])
    one_axis[3, 0, 0] = np.nan
    for given in (one_axis, one_axis.tolist()):
        with pytest.warns(fl.PrecisionWarning):
            fl.build(given, invalid="skip")
    with pytest.warns(fl.PrecisionWarning):
        fl.Lines.from_strands([points[:7].tolist(), points[7:].tolist()])
    with pytest.warns(fl.PrecisionWarning):
        fl.build(fl.Boxes(np.sort(WIRES, axis=1) + FAR))


@pytest.mark.parametrize(
    "segments",
    [
        WIRES,
        WIRES * 1e-8,
        (WIRES + FAR).astype(np.float32),  # nothing is lost here
        np.rint(WIRES) + np.array([4e5, 5e6, 0]),  # whole numbers of which float32 has all
        (WIRES + FAR)[:0],
        np.broadcast_to(FAR, (3, 2, 3)),  # a point has no size to compare with
    ],
    ids=["near", "small", "float32", "exact", "none", "point"],
)
def test_nothing_is_said_where_nothing_is_lost(segments: np.ndarray) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(fl.build(segments).geometry) == len(segments)


def test_the_command_line_warns_in_one_line(tmp_path: Path) -> None:
    np.save(tmp_path / "far.npy", WIRES + FAR)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        ended = run("info", tmp_path / "far.npy")
    assert ended.exit_code == 0
    assert ended.stderr.startswith("warning: float32 rounds coordinates of up to")
    assert ended.stderr.count("\n") == 1
