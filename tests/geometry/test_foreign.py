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


def test_files_are_written_of_objects(tmp_path: Any) -> None:
    fl.write(tmp_path / "a.npz", PARTS)
    check(fl.read(tmp_path / "a.npz"))
