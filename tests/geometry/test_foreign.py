"""Lines from objects of other libraries."""

from __future__ import annotations

import pickle
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import FileWarning, InputError

POINTS = np.arange(21, dtype="f4").reshape(7, 3) ** 1.5
COUNTS = [3, 2, 2]
STRANDS = [0, 0, 1, 2]
PARTS = np.split(POINTS, [3, 5])
ENDS = [[0, 1], [1, 2], [3, 4], [5, 6]]


def check(lines: fl.Lines) -> None:
    np.testing.assert_array_equal(lines.segments, POINTS[ENDS])
    np.testing.assert_array_equal(lines.strands, STRANDS)


def test_lines_can_be_pickled() -> None:
    check(pickle.loads(pickle.dumps(fl.lines(PARTS))))


# --- Arrays ---


def test_lines_are_taken_as_they_are() -> None:
    lines = fl.lines(PARTS)
    assert fl.lines(lines) is lines


@pytest.mark.parametrize("shape", [(3, 2, 3), (3, 6)])
@pytest.mark.parametrize("kind", [np.asarray, np.ndarray.tolist, memoryview])
def test_segments(shape: tuple[int, ...], kind: Any) -> None:
    lines = fl.lines(kind(POINTS[:6].reshape(shape)))
    np.testing.assert_array_equal(lines.segments.reshape(-1, 3), POINTS[:6])
    assert lines.n_strands == (3 if kind == np.ndarray.tolist and shape == (3, 2, 3) else 0)


@pytest.mark.parametrize(
    "kind", [list, tuple, iter, lambda parts: [part.tolist() for part in parts], lambda p: (x for x in p)]
)
def test_polylines(kind: Any) -> None:
    check(fl.lines(kind(PARTS)))
    lines = fl.lines(kind([POINTS[:2], POINTS[2:5], POINTS[:0], POINTS[5:6]]))
    np.testing.assert_array_equal(lines.strands, [0, 1, 1, 3])
    assert fl.build(kind(PARTS)).first_hit(POINTS[0] - [0, 0, 5], [0, 0, 1], 0.1).prim == 0


def test_polylines_of_two_points() -> None:
    pairs = [POINTS[:2], POINTS[2:4]]
    assert fl.lines(pairs).n_strands == 2
    assert fl.lines(tuple(pairs)).n_strands == 2  # (m, 3) twice: no offsets
    assert fl.lines([pair.tolist() for pair in pairs]).n_strands == 2
    assert fl.lines(np.array(pairs)).n_strands == 0  # an array holds segments
    ragged = np.empty(2, object)
    ragged[:] = PARTS[:2]
    assert fl.lines(ragged).n_strands == 2


def test_points_in_the_plane() -> None:
    flat = POINTS[:, :2]
    expected = POINTS[ENDS] * np.float32([1, 1, 0])
    for given in ([part[:, :2] for part in PARTS], [part[:, :2].tolist() for part in PARTS], (flat, [0, 3, 5, 7])):
        with pytest.warns(FileWarning, match="the points have two coordinates, x and y; z is 0") as told:
            lines = fl.lines(given)
        assert told[0].filename == __file__
        np.testing.assert_array_equal(lines.segments, expected)
        np.testing.assert_array_equal(lines.strands, STRANDS)
    pairs = flat[:6].reshape(3, 2, 2)
    for given in (pairs, memoryview(pairs), pairs.astype("i4")):
        with pytest.warns(FileWarning, match="z is 0"):
            lines = fl.lines(given)
        np.testing.assert_array_equal(lines.segments[..., :2], np.asarray(given))
        assert (lines.segments[..., 2] == 0).all()
        assert lines.n_strands == 0
    with pytest.warns(FileWarning, match="z is 0"):
        assert fl.build([[[0, 0], [4, 0]]]).first_hit([2, 0, -1], [0, 0, 1], 0.1).prim == 0
    with pytest.raises(InputError, match=r"strand 1: the shape is \(7, 1\); expected \(m, 3\)"):
        fl.lines([flat, POINTS[:, :1]])


def test_points_and_offsets() -> None:
    check(fl.lines((POINTS, [0, 3, 5, 7])))
    check(fl.lines((POINTS.astype("f8"), np.array([0, 3, 5, 7], "u4"))))
    assert len(fl.lines((POINTS[:0], [0]))) == 0
    for offsets in ([0, 3, 5], [3, 2, 2], [0, 5, 3, 7], [1, 7], []):
        with pytest.raises(InputError, match=r"offsets do not rise from 0 to the number of points, 7|have dtype"):
            fl.lines((POINTS, offsets))
    with pytest.raises(InputError, match="offsets have dtype float64; expected whole numbers"):
        fl.lines((POINTS, [0.0, 7.0]))


def test_nan_is_refused_or_skipped() -> None:
    bad = POINTS.copy()
    bad[1] = np.nan
    with pytest.raises(InputError, match="rows 0, 1"):
        fl.lines((bad, [0, 3, 5, 7]))
    np.testing.assert_array_equal(fl.lines((bad, [0, 3, 5, 7]), invalid="skip").strands, [1, 2])
    with pytest.raises(InputError, match="invalid='drop' is not a choice"):
        fl.lines(POINTS, invalid="drop")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (5, r"shape \(\)"),
        (None, "expected .n, 2, 3."),
        (POINTS, r"shape \(7, 3\); expected \(n, 2, 3\)"),
        ("a.trk", "is the name of a file, not an array; fl.read reads files"),
        (fl.Lines, "lines are a class, Lines; expected an object of it"),
        (fl.Curves.from_bezier(POINTS[:4][None]), "lines are Curves; curves.pieces.lines are lines"),
        (POINTS[:, :2], "segments"),
        ([POINTS, POINTS[:, :2]], r"strand 1: the shape is \(7, 2\)"),
        ({}, "segments"),
        (fl.build(POINTS[:2][None]), r"lines are a Tree; expected lines: pass tree\.geometry"),
    ],
)
def test_what_is_refused(given: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        fl.lines(given)


class Tensor:
    """An array that exports itself by DLPack alone."""

    def __init__(self, array: np.ndarray, fails: str = "") -> None:
        self.array, self.fails = array, fails

    def __dlpack__(self, **options: Any) -> Any:
        if self.fails:
            raise RuntimeError(self.fails)
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self) -> Any:
        return self.array.__dlpack_device__()


def test_tensors() -> None:
    segments = POINTS[:6].reshape(3, 2, 3)
    np.testing.assert_array_equal(fl.lines(Tensor(segments)).segments, segments)
    check(fl.lines([Tensor(part) for part in PARTS]))
    check(fl.lines((Tensor(POINTS), Tensor(np.array([0, 3, 5, 7])))))
    with pytest.raises(InputError, match=r"a Tensor cannot be read as an array \(on a GPU\); detach it, or copy it to"):
        fl.lines(Tensor(segments, "on a GPU"))


@pytest.mark.parametrize("library", ["torch", "jax.numpy"])
def test_tensors_of_libraries(library: str) -> None:
    module = pytest.importorskip(library)
    segments = POINTS[:6].reshape(3, 2, 3)
    np.testing.assert_array_equal(fl.lines(module.asarray(segments)).segments, segments)
    check(fl.lines([module.asarray(part) for part in PARTS]))


def test_arrow() -> None:
    pa = pytest.importorskip("pyarrow")
    flat = pa.array(POINTS[:6].reshape(-1))
    rows = pa.FixedSizeListArray.from_arrays(pa.FixedSizeListArray.from_arrays(flat, 3), 2)
    np.testing.assert_array_equal(fl.lines(rows).segments.reshape(-1, 3), POINTS[:6])
    points = pa.FixedSizeListArray.from_arrays(pa.array(POINTS.reshape(-1)), 3)
    check(fl.lines((points, pa.array([0, 3, 5, 7]))))
    with pytest.raises(InputError, match="has 1 nulls; fill them"):
        fl.lines((pa.array([[1.0, 2, 3], None], pa.list_(pa.float32(), 3)), [0, 2]))


# --- Tractograms ---


def test_array_sequence_of_nibabel() -> None:
    streamlines = pytest.importorskip("nibabel.streamlines")
    sequence = streamlines.ArraySequence(PARTS)
    check(fl.lines(sequence))
    np.testing.assert_array_equal(fl.lines(sequence[[2, 0]]).segments, POINTS[[[5, 6], [0, 1], [1, 2]]])
    np.testing.assert_array_equal(fl.lines(sequence[1:]).segments, POINTS[[[3, 4], [5, 6]]])
    assert len(fl.lines(streamlines.ArraySequence())) == 0
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


# --- Meshes ---


def test_polydata_of_pyvista() -> None:
    pv = pytest.importorskip("pyvista")
    mesh = pv.PolyData(POINTS, lines=[3, 0, 1, 2, 2, 3, 4, 2, 5, 6])
    mesh.point_data["fa"] = np.arange(7)
    mesh.point_data["radius"] = np.arange(7) / 10
    mesh.cell_data["id"] = [5, 6, 7]
    mesh.cell_data["fa"] = [1, 2, 3]
    lines = fl.lines(mesh)
    check(lines)
    np.testing.assert_array_equal(lines.end_attributes["fa"], ENDS)
    np.testing.assert_allclose(lines.radius, np.array(ENDS) / 10)
    np.testing.assert_array_equal(lines.attributes["id"], [5, 5, 6, 7])
    np.testing.assert_array_equal(lines.attributes["fa of cell"], [1, 1, 2, 3])
    assert len(fl.build(mesh).geometry) == 4


def test_polydata_with_other_cells() -> None:
    pv = pytest.importorskip("pyvista")
    mesh = pv.PolyData(POINTS, verts=[1, 6, 1, 0], lines=[2, 0, 1, 2, 3, 4], faces=[3, 0, 1, 2])
    mesh.cell_data["id"] = np.arange(5)
    with pytest.warns(FileWarning, match="3 cells of a PolyData are vertices, faces or strips, and are not read"):
        lines = fl.lines(mesh)
    np.testing.assert_array_equal(lines.segments, POINTS[[[0, 1], [3, 4]]])
    np.testing.assert_array_equal(lines.attributes["id"], [2, 3])


@pytest.mark.parametrize("cells", [[2, 0, 7], [2, 0, -1], [3, 0, 1], [-1, 0, 1]])
def test_polydata_that_contradicts_itself(cells: list[int]) -> None:
    given = SimpleNamespace(lines=cells, points=POINTS, point_data={}, cell_data={}, n_verts=0, n_cells=1)
    with pytest.raises(InputError, match="its lines name points beyond its 7 points, or are cut short"):
        fl.lines(given)


def test_path_of_trimesh() -> None:
    path = pytest.importorskip("trimesh.path")
    entities = pytest.importorskip("trimesh.path.entities")
    made = path.Path3D(
        entities=[entities.Line([0, 1, 2]), entities.Line([3, 4]), entities.Line([5, 6])], vertices=POINTS
    )
    check(fl.lines(made))
    made.units = "mm"
    assert fl.lines(made).unit == "mm"
    arc = path.Path3D(entities=[entities.Arc([0, 1, 2])], vertices=[[1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    lines = fl.lines(arc)
    assert len(lines) > 10
    np.testing.assert_allclose(np.linalg.norm(lines.segments, axis=2), 1, atol=1e-5)
    flat = path.Path2D(entities=[entities.Line([0, 1])], vertices=POINTS[:, :2])
    with pytest.raises(InputError, match=r"vertices of shape \(7, 2\); expected \(m, 3\), as to_3D"):
        fl.lines(flat)


def test_files_are_written_of_objects(tmp_path: Any) -> None:
    fl.write(tmp_path / "a.npz", PARTS)
    check(fl.read(tmp_path / "a.npz"))
