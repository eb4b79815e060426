"""Lines from tractograms of nibabel, DIPY and TRX."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import FileWarning, InputError

POINTS = np.arange(21, dtype="f4").reshape(7, 3) ** 1.5
STRANDS = [0, 0, 1, 2]
PARTS = np.split(POINTS, [3, 5])
ENDS = [[0, 1], [1, 2], [3, 4], [5, 6]]


def check(lines: fl.Lines) -> None:
    np.testing.assert_array_equal(lines.segments, POINTS[ENDS])
    np.testing.assert_array_equal(lines.strands, STRANDS)


def test_array_sequence_of_nibabel() -> None:
    streamlines = pytest.importorskip("nibabel.streamlines")
    sequence = streamlines.ArraySequence(PARTS)
    check(fl.lines(sequence))
    np.testing.assert_array_equal(fl.lines(sequence[[2, 0]]).segments, POINTS[[[5, 6], [0, 1], [1, 2]]])
    np.testing.assert_array_equal(fl.lines(sequence[1:]).segments, POINTS[[[3, 4], [5, 6]]])
    assert len(fl.lines(streamlines.ArraySequence())) == 0
    for affine in (np.eye(4), np.diag([2.0, 2, 2, 1])):
        assert len(fl.lines(streamlines.Tractogram([], affine_to_rasmm=affine))) == 0
        assert len(fl.lines(streamlines.LazyTractogram(lambda: iter(()), affine_to_rasmm=affine))) == 0
    assert len(fl.build(sequence).geometry) == 4
    odd = SimpleNamespace(_data=POINTS, _offsets=np.array([0, 5]), _lengths=np.array([3, 5]))
    with pytest.raises(InputError, match="its offsets and lengths do not fit its 7 rows"):
        fl.lines(odd)


def tractogram(lazy: bool = False, **more: Any) -> Any:
    streamlines = pytest.importorskip("nibabel.streamlines")
    given = {
        "streamlines": PARTS,
        "data_per_point": {
            "fa": [np.arange(len(part), dtype="f4")[:, None] for part in PARTS],
            "color": [part * 2 for part in PARTS],
        },
        "data_per_streamline": {"id": np.array([[5.0], [6], [7]]), "fa": np.array([[1.0], [2], [3]])},
    }
    if lazy:
        made = streamlines.LazyTractogram.from_tractogram(streamlines.Tractogram(**given, affine_to_rasmm=np.eye(4)))
    else:
        made = streamlines.Tractogram(**given, affine_to_rasmm=np.eye(4))
    for name, value in more.items():
        setattr(made, name, value)
    return made


@pytest.mark.parametrize("lazy", [False, True])
def test_tractogram(lazy: bool) -> None:
    lines = fl.lines(tractogram(lazy))
    check(lines)
    assert (lines.unit, lines.up) == ("mm", "z")
    np.testing.assert_array_equal(lines.end_attributes["fa"], [[0, 1], [1, 2], [0, 1], [0, 1]])
    np.testing.assert_array_equal(lines.end_attributes["color"], POINTS[ENDS] * 2)
    np.testing.assert_array_equal(lines.attributes["id"], [5, 5, 6, 7])
    np.testing.assert_array_equal(lines.attributes["fa of streamline"], [1, 1, 2, 3])


def test_tractogram_in_other_spaces() -> None:
    affine = np.diag([2.0, 2, 2, 1])
    affine[:3, 3] = 1
    lines = fl.lines(tractogram(affine_to_rasmm=affine))
    np.testing.assert_allclose(lines.segments, POINTS[ENDS] * 2 + 1, rtol=1e-6)
    lines = fl.lines(tractogram(affine_to_rasmm=None))
    check(lines)
    assert (lines.unit, lines.up) == (None, None)


def test_files_of_nibabel(tmp_path: Any) -> None:
    streamlines = pytest.importorskip("nibabel.streamlines")
    streamlines.save(tractogram(), str(tmp_path / "a.trk"))
    for lazy in (False, True):
        lines = fl.lines(streamlines.load(str(tmp_path / "a.trk"), lazy_load=lazy))
        np.testing.assert_allclose(lines.segments, POINTS[ENDS], rtol=1e-5)
        assert lines.unit == "mm"
        np.testing.assert_array_equal(lines.attributes["id"], [5, 5, 6, 7])


def test_tractogram_that_contradicts_itself() -> None:
    given = SimpleNamespace(
        streamlines=PARTS, data_per_point={"fa": PARTS[:2]}, data_per_streamline={}, affine_to_rasmm=None
    )
    with pytest.raises(InputError, match="values 'fa' per point do not have the numbers of points"):
        fl.lines(given)
    given = SimpleNamespace(streamlines=PARTS, data_per_point={}, data_per_streamline={"id": np.ones(2)})
    with pytest.raises(InputError, match="'id' has 2 values; expected one for each streamline, 3"):
        fl.lines(given)


def test_radius_by_its_name() -> None:
    radius = [np.full((len(part), 1), 1 + i) for i, part in enumerate(PARTS)]
    given = SimpleNamespace(streamlines=PARTS, data_per_point={"radius": radius}, data_per_streamline={})
    np.testing.assert_array_equal(fl.lines(given).radius, [[1, 1], [1, 1], [2, 2], [3, 3]])
    given.data_per_streamline = {"radius": np.arange(3)}
    np.testing.assert_array_equal(fl.lines(given).attributes["radius of streamline"], STRANDS)
    given.data_per_point = {}
    np.testing.assert_array_equal(fl.lines(given).radius, STRANDS)


def test_values_per_streamline_of_skipped_segments() -> None:
    bad = [part.copy() for part in PARTS]
    bad[1][0] = np.nan
    given = SimpleNamespace(streamlines=bad, data_per_point={}, data_per_streamline={"id": np.array([5, 6, 7])})
    np.testing.assert_array_equal(fl.lines(given, invalid="skip").attributes["id"], [5, 5, 7])


def test_trx() -> None:
    trx = pytest.importorskip("trx.trx_file_memmap")
    streamlines = pytest.importorskip("nibabel.streamlines")
    given = trx.TrxFile(nb_vertices=7, nb_streamlines=3)
    given.streamlines = streamlines.ArraySequence(PARTS)
    given.data_per_vertex = {"fa": streamlines.ArraySequence([np.arange(len(p))[:, None] for p in PARTS])}
    given.data_per_streamline = {"id": np.array([[5], [6], [7]])}
    lines = fl.lines(given)
    check(lines)
    assert (lines.unit, lines.up) == ("mm", "z")
    np.testing.assert_array_equal(lines.end_attributes["fa"], [[0, 1], [1, 2], [0, 1], [0, 1]])
    np.testing.assert_array_equal(lines.attributes["id"], [5, 5, 6, 7])
    given.groups = {"left": np.array([0, 2])}
    with pytest.warns(FileWarning, match="groups of a TrxFile are not read"):
        check(fl.lines(given))
    given.close()


# --- StatefulTractogram of DIPY ---

#: An image that is turned, mirrored and has voxels of three sizes.
AFFINE = np.array([[0, -2.5, 0, 90], [1.5, 0, 0, -126], [0, 0, 3, -72], [0, 0, 0, 1]])


def stateful(space: str, origin: str) -> Any:
    module = pytest.importorskip("dipy.io.stateful_tractogram")
    made = module.StatefulTractogram(
        PARTS,
        (AFFINE.astype("f4"), np.array([50, 60, 70], "i2"), np.array([1.5, 2.5, 3], "f4"), "ARS"),
        module.Space.RASMM,
        data_per_point={"fa": [np.arange(len(part), dtype="f4")[:, None] for part in PARTS]},
        data_per_streamline={"id": np.array([[5], [6], [7]])},
    )
    made.to_space(module.Space(space))
    made.to_origin(module.Origin(origin))
    return made


@pytest.mark.parametrize("origin", ["center", "corner"])
@pytest.mark.parametrize("space", ["rasmm", "vox", "voxmm"])
def test_stateful_tractogram(space: str, origin: str) -> None:
    given = stateful(space, origin)
    before = given.streamlines._data.copy()
    lines = fl.lines(given)
    np.testing.assert_allclose(lines.segments, POINTS[ENDS], atol=2e-5)
    assert (lines.unit, lines.up) == ("mm", "z")
    np.testing.assert_array_equal(lines.end_attributes["fa"], [[0, 1], [1, 2], [0, 1], [0, 1]])
    np.testing.assert_array_equal(lines.attributes["id"], [5, 5, 6, 7])
    # The object stays as it is.
    np.testing.assert_array_equal(given.streamlines._data, before)
    assert (given.space.value, given.origin.value) == (space, origin)


def test_stateful_tractogram_in_the_world_keeps_its_bits() -> None:
    check(fl.lines(stateful("rasmm", "center")))


def test_a_space_that_is_not_known() -> None:
    given = SimpleNamespace(
        streamlines=PARTS, data_per_point={}, data_per_streamline={}, space="tal", origin="center",
        space_attributes=(np.eye(4), (1, 1, 1), np.ones(3), "RAS"),
    )  # fmt: skip
    with pytest.raises(InputError, match=r"in the space 'tal' with the origin 'center', which are not known; call its"):
        fl.lines(given)
    given.space = "lpsmm"
    np.testing.assert_array_equal(fl.lines(given).segments, POINTS[ENDS] * np.float32([-1, -1, 1]))


def test_the_voxel_grid_is_kept(tmp_path: Any) -> None:
    """What is selected of the lines of a StatefulTractogram is written with its grid, as that of its file is."""
    given = stateful("vox", "corner")
    for kept in (fl.lines(given), fl.lines(given).select(strands=[0, 2])):
        grid = kept.metadata["grid"]
        np.testing.assert_array_equal(grid["voxel_to_rasmm"], AFFINE)
        np.testing.assert_array_equal(grid["dimensions"], [50, 60, 70])
        np.testing.assert_array_equal(grid["voxel_sizes"], [1.5, 2.5, 3])
        assert grid["voxel_order"] == "ARS"
    with pytest.warns(FileWarning, match=r"that all points lie in the voxel grid \(7 are outside"):
        fl.write(tmp_path / "a.trk", fl.lines(given))
    back = fl.read(tmp_path / "a.trk").metadata["grid"]
    of_nibabel = fl.lines(pytest.importorskip("nibabel.streamlines").load(str(tmp_path / "a.trk"))).metadata["grid"]
    for name in ("voxel_to_rasmm", "dimensions", "voxel_sizes", "voxel_order"):
        np.testing.assert_array_equal(back[name], grid[name])
        np.testing.assert_array_equal(of_nibabel[name], grid[name])


def test_a_grid_that_cannot_be_used_is_told() -> None:
    given = SimpleNamespace(
        tractogram=tractogram(), streamlines=PARTS, header={"dimensions": [0, 1, 1], "voxel_to_rasmm": np.eye(4)}
    )
    with pytest.warns(FileWarning, match="the voxel grid is not kept: a SimpleNamespace: its dimensions are"):
        assert "grid" not in fl.lines(given).metadata
    given.header = {}
    assert "grid" not in fl.lines(given).metadata
