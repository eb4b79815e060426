"""Lines from paths of trimesh."""

from __future__ import annotations

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


def test_path_in_the_plane() -> None:
    path = pytest.importorskip("trimesh.path")
    entities = pytest.importorskip("trimesh.path.entities")
    flat = path.Path2D(entities=[entities.Line([0, 1])], vertices=POINTS[:, :2])
    with pytest.warns(FileWarning, match="the points have two coordinates, x and y; z is 0"):
        lines = fl.lines(flat)
    np.testing.assert_array_equal(lines.segments, POINTS[[[0, 1]]] * np.float32([1, 1, 0]))
    assert len(fl.lines(path.Path2D())) == len(fl.lines(path.Path3D())) == 0


def test_values_at_the_vertices_of_a_path() -> None:
    path = pytest.importorskip("trimesh.path")
    entities = pytest.importorskip("trimesh.path.entities")
    values = {"radius": np.arange(7) / 10, "heat": np.arange(7)}
    made = path.Path3D(
        entities=[entities.Line([0, 1, 2]), entities.Line([3, 4]), entities.Line([5, 6])],
        vertices=POINTS,
        vertex_attributes=values,
        process=False,
    )
    lines = fl.lines(made)
    check(lines)
    np.testing.assert_allclose(lines.radius, np.array(ENDS) / 10)
    np.testing.assert_array_equal(lines.end_attributes["heat"], ENDS)
    made.entities = [entities.Arc([0, 1, 2])]
    with pytest.warns(FileWarning, match="vertex_attributes of a Path3D are not read; they are where"):
        assert fl.lines(made).radius is None


def test_odd_entities() -> None:
    path = pytest.importorskip("trimesh.path")
    entities = pytest.importorskip("trimesh.path.entities")
    made = path.Path3D([entities.Text(0, "here"), entities.Line([0, 1])], POINTS, process=False)
    with pytest.warns(FileWarning, match="entities of a Path3D without a line are not read: 1 Text"):
        lines = fl.lines(made)
    np.testing.assert_array_equal(lines.strands, [1])
    for points in ([0, 9], [-1, 2]):
        with pytest.raises(InputError, match="a Path3D: entity 0 names vertices beyond the 7 that there are"):
            fl.lines(path.Path3D([entities.Line(points)], POINTS, process=False))


def test_a_mesh_is_no_path() -> None:
    trimesh = pytest.importorskip("trimesh")
    with pytest.raises(InputError, match=r"lines are a Trimesh, a surface of triangles: fl\.Triangles\.from_mesh"):
        fl.lines(trimesh.creation.box())
