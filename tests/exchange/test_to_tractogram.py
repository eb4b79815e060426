"""Lines as tractograms of nibabel, and back; functions of DIPY take their streamlines."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.line_files import POINTS, SAMPLES

import fastlines as fl


@pytest.fixture
def nibabel() -> Any:
    return pytest.importorskip("nibabel.streamlines")


def some_lines(**more: Any) -> fl.Lines:
    lines = fl.Lines.from_points(
        POINTS[:7], [3, 2, 2], radius=np.arange(7) / 8, attributes={"fa": np.arange(7.0), "rgb": POINTS[:7] * 2}
    )
    attributes = {"id": np.array([7, 5, 6])[lines.strands], "at": POINTS[lines.strands]}
    return replace(lines, unit="mm", up="z", attributes=attributes, **more)


def same(left: fl.Lines, right: fl.Lines) -> None:
    for name in ("segments", "strands", "radius"):
        np.testing.assert_array_equal(getattr(left, name), getattr(right, name))
    assert (left.unit, left.up) == (right.unit, right.up)
    for name in ("attributes", "end_attributes"):
        given, found = getattr(left, name), getattr(right, name)
        assert given.keys() == found.keys()
        for key in given:
            np.testing.assert_array_equal(given[key], found[key])


def test_round_trip(nibabel: Any) -> None:
    lines = some_lines()
    tractogram = fl.to_tractogram(lines)
    assert [len(streamline) for streamline in tractogram.streamlines] == [3, 2, 2]
    np.testing.assert_array_equal(tractogram.streamlines.get_data(), POINTS[:7])
    assert tractogram.streamlines.get_data().dtype == np.float32
    np.testing.assert_array_equal(tractogram.affine_to_rasmm, np.eye(4))
    np.testing.assert_array_equal(tractogram.data_per_point["radius"].get_data()[:, 0], np.arange(7) / 8)
    np.testing.assert_array_equal(tractogram.data_per_streamline["id"], [[7], [5], [6]])
    same(fl.lines(tractogram), lines)
    # It is the caller's to change.
    tractogram.apply_affine(np.diag([2, 2, 2, 1]))
    np.testing.assert_array_equal(tractogram.streamlines.get_data(), POINTS[:7] * 2)
    same(lines, some_lines())


@pytest.mark.parametrize("name", ["some.trk", "some.tck"])
def test_files(nibabel: Any, name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(SAMPLES[name])
    lines = fl.read(tmp_path / name)
    np.testing.assert_array_equal(fl.lines(fl.to_tractogram(lines)).segments, lines.segments)
    nibabel.save(
        nibabel.Tractogram(fl.to_tractogram(lines).streamlines, affine_to_rasmm=np.eye(4)), tmp_path / "new.tck"
    )
    np.testing.assert_array_equal(fl.read(tmp_path / "new.tck").segments, lines.segments)


def test_no_lines(nibabel: Any) -> None:
    tractogram = fl.to_tractogram(replace(fl.Lines.from_strands([]), unit="mm"))
    assert len(tractogram.streamlines) == 0
    assert len(fl.lines(tractogram)) == 0


def test_the_offset_is_added(nibabel: Any) -> None:
    far = POINTS[:7].astype(float) + np.array([5e6, 0, 0])
    lines = replace(fl.Lines.from_points(far, [7], offset="auto"), unit="mm")
    data = fl.to_tractogram(lines).streamlines.get_data()
    assert data.dtype == np.float64
    np.testing.assert_allclose(data, far, atol=1e-5)


def test_what_is_lost(nibabel: Any) -> None:
    texts = np.array(["a", "b"], object)
    lines = fl.Lines.from_segments(POINTS[:4].reshape(2, 2, 3), attributes={"name": texts, "radius": np.ones(2)})
    with pytest.warns(fl.FileWarning, match="not kept in the tractogram: ") as told:
        fl.to_tractogram(replace(lines, unit="m", up="y"))
    said = str(told[0].message)
    for part in ("'name', object", "'radius', float64", "no strand", "the unit 'm'", "the upward axis 'y'"):
        assert part in said
    assert told[0].filename == __file__


def test_curves_are_cut(nibabel: Any) -> None:
    curves = fl.Curves.from_strands([[0, 0, 0], [1, 1, 0], [2, 1, 0], [3, 0, 0]], [4])
    curves = replace(curves, unit="mm")
    with pytest.warns(fl.FileWarning, match="curves, which are written as their pieces"):
        tractogram = fl.to_tractogram(curves)
    assert tractogram.streamlines.total_nb_rows == len(curves.pieces) + 1
    with pytest.raises(fl.InputError, match=r"this is Triangles; tractograms hold Lines or Curves"):
        fl.to_tractogram(fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]))


def test_missing_nibabel_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nibabel.streamlines", None)
    with pytest.raises(fl.MissingExtraError, match=r"the extra 'nifti'"):
        fl.to_tractogram(some_lines())


def test_no_package_is_imported_before_it_is_needed() -> None:
    names = "{'nibabel', 'dipy', 'navis', 'mitsuba', 'trimesh'}"
    used = "fl.to_tractogram, fl.to_neurons, fl.trimesh.RayLines"
    check = f"import sys, fastlines as fl; {used}; assert not {names} & set(sys.modules)"
    assert subprocess.run([sys.executable, "-c", check], check=False).returncode == 0


def test_dipy_takes_the_streamlines(nibabel: Any) -> None:
    """A bundle goes in, a needle chooses of it, and what it hits goes back."""
    metrics = pytest.importorskip("dipy.tracking.streamline")
    stateful = pytest.importorskip("dipy.io.stateful_tractogram")
    rng = np.random.default_rng(4)
    t = np.linspace(0, 40, 20, dtype="f4")
    bundle = metrics.Streamlines(
        [np.stack([t, 0 * t + y, np.sin(t / 9 + y)], 1) for y in rng.uniform(-9, 9, 30).astype("f4")]
    )
    tree = fl.build(bundle)
    hits = tree.all_hits([[20, 0, -9]], [[0, 0, 1]], radius=3)
    chosen = np.unique(hits.strand)
    assert 0 < len(chosen) < 30
    with pytest.warns(fl.FileWarning, match="the numbers of strands, which are counted from 0"):
        back = fl.to_tractogram(replace(tree.geometry.select(strands=chosen), unit="mm")).streamlines
    for streamline, number in zip(back, chosen, strict=True):
        np.testing.assert_array_equal(streamline, bundle[number])
    np.testing.assert_allclose(metrics.length(back), metrics.length(bundle[chosen]), rtol=1e-6)
    reference = (np.eye(4), np.array([50, 50, 50]), np.ones(3, "f4"), "RAS")
    loaded = stateful.StatefulTractogram(back, reference, stateful.Space.RASMM)
    same(fl.lines(loaded), fl.lines(fl.to_tractogram(fl.lines(loaded))))
    # Streamlines that come near a region, by its voxels.
    roi = np.argwhere(np.ones((2, 2, 2))) + np.array([19, 0, 0])
    near = tree.within(roi, 1.0)
    slow = [i for i, line in enumerate(bundle) if np.linalg.norm(line[:, None] - roi, axis=2).min() <= 1.0]
    assert set(slow) <= set(np.unique(near.strand))
