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


@pytest.mark.parametrize("radius", [1e-3, 1.0, 1000.0])
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("tolerance", [None, 1e-2, 1e-4, 1e-12])
def test_arcs_are_within_the_tolerance(radius: float, closed: bool, tolerance: float | None) -> None:
    path = pytest.importorskip("trimesh.path")
    entities = pytest.importorskip("trimesh.path.entities")
    places = [[radius, 0, 0], [radius * 0.6, radius * 0.8, 0], [-radius, 0, 0]]
    far = entities.Line([3, 4])
    made = path.Path3D(
        [entities.Arc([0, 1, 2], closed=closed), far], [*places, [0, 0, 1e5], [9, 9, 1e5]], process=False
    )
    lines = fl.lines(made, tolerance=None if tolerance is None else tolerance * radius)
    arc = lines.segments[lines.strands == 0].astype(np.float64)
    allowed = 1e-5 * 2 if tolerance is None else max(tolerance, 2.0**-23)
    for points in (arc[:, 0], arc.mean(axis=1)):
        assert np.abs(np.linalg.norm(points, axis=1) / radius - 1).max() < allowed + 2e-7
    np.testing.assert_allclose(lines.lengths()[:-1].sum() / radius, (2 if closed else 1) * np.pi, rtol=1e-3)
    assert len(arc) < 20_000


def test_splines_are_within_the_tolerance() -> None:
    path = pytest.importorskip("trimesh.path")
    entities = pytest.importorskip("trimesh.path.entities")
    pytest.importorskip("scipy")
    vertices = np.random.default_rng(1).random((8, 3)) * 1000
    curves = [entities.Bezier([0, 1, 2, 3]), entities.BSpline(np.arange(8), [0, 0, 0, 0, 1, 2, 3, 4, 5, 5, 5, 5])]
    curves[1].reverse()
    made = path.Path3D([*curves, entities.Line([0, 1, 2])], vertices, process=False)
    for tolerance in (None, 0.1):
        lines = fl.lines(made, tolerance=tolerance)
        for i, curve in enumerate(curves):
            on_it = curve.discrete(vertices, count=20_000)
            allowed = tolerance or 1e-5 * np.ptp(on_it, axis=0).max()
            assert fl.build(lines.select(strands=[i])).nearest(on_it).distance.max() < allowed
        assert (lines.strands == 2).sum() == 2


def test_a_spline_with_corners_and_a_bad_tolerance() -> None:
    path = pytest.importorskip("trimesh.path")
    entities = pytest.importorskip("trimesh.path.entities")
    pytest.importorskip("scipy")
    corner = entities.BSpline([0, 1, 2], [0, 0, 1, 2, 2])
    made = path.Path3D([corner], [[0, 0, 0], [1, 1, 0], [3, 0, 0]], process=False)
    with pytest.warns(
        FileWarning, match="polylines of entities of a Path3D are farther from them than .*: 1 BSpline; give"
    ):
        assert fl.build(fl.lines(made, tolerance=1e-6)).nearest([1, 1, 0]).distance < 0.01
    for tolerance in (0, -1, np.nan, "fine", True):
        with pytest.raises(InputError, match=r"tolerance=.*; expected a length above 0"):
            fl.lines(made, tolerance=tolerance)


def test_trees_over_paths_without_vertices() -> None:
    path = pytest.importorskip("trimesh.path")
    for empty in (path.Path3D(), path.Path3D(vertices=np.empty((0, 3)))):
        assert fl.build(empty).n_prims == 0


def test_scenes_point_clouds_and_lists_of_paths() -> None:
    trimesh = pytest.importorskip("trimesh")
    path = trimesh.load_path(POINTS[None, :2])
    scene = trimesh.Scene()
    scene.add_geometry(path, transform=trimesh.transformations.translation_matrix([0, 7, 0]))
    with pytest.raises(
        InputError, match=r"lines are a Scene of trimesh; expected a path: scene\.to_geometry\(\) joins"
    ):
        fl.lines(scene)
    np.testing.assert_allclose(fl.lines(scene.to_geometry()).segments, POINTS[None, :2] + np.float32([0, 7, 0]))
    with pytest.raises(InputError, match=r"lines are a list of paths; .*: trimesh\.path\.util\.concatenate joins"):
        fl.lines([path, path])
    assert len(fl.lines(trimesh.path.util.concatenate([path, path]))) == 2
    with pytest.raises(InputError, match=r"lines are a PointCloud, points without lines: fl\.Spheres\.from_centres"):
        fl.lines(trimesh.PointCloud(POINTS))
