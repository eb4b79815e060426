"""Lines from unstructured grids, several meshes, and objects of VTK itself."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import FileWarning, InputError

pv = pytest.importorskip("pyvista")

POINTS = np.arange(21, dtype="f4").reshape(7, 3) ** 1.5
STRANDS = [0, 0, 1, 2]
ENDS = [[0, 1], [1, 2], [3, 4], [5, 6]]


def mesh(z=0.0):
    made = pv.PolyData(POINTS + np.float32([0, 0, z]), lines=[3, 0, 1, 2, 2, 3, 4, 2, 5, 6])
    made.point_data["Radius"] = np.arange(7) / 8
    made.cell_data["id"] = [5, 6, 7]
    made.field_data["unit"] = ["mm"]
    return made


def check(lines, z=0.0):
    np.testing.assert_array_equal(lines.segments, POINTS[ENDS] + np.float32([0, 0, z]))
    np.testing.assert_array_equal(lines.strands, STRANDS)
    np.testing.assert_array_equal(lines.radius, np.array(ENDS) / 8)
    np.testing.assert_array_equal(lines.attributes["id"], [5, 5, 6, 7])
    assert lines.unit == "mm"


def raw(given, kind):
    """Return an object of VTK itself that shares the arrays of one of PyVista."""
    vtk = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    made = getattr(vtk, kind)()
    made.ShallowCopy(given)
    assert type(made).__module__.startswith("vtkmodules")
    return made


def test_grids_and_objects_of_vtk():
    grid = mesh().cast_to_unstructured_grid()
    for given in (mesh(), grid, raw(mesh(), "vtkPolyData"), raw(grid, "vtkUnstructuredGrid")):
        check(fl.lines(given))
        assert fl.build(given).first_hit(POINTS[0] - [0, 0, 5], [0, 0, 1], 0.1).prim == 0
    assert len(fl.lines(pytest.importorskip("vtkmodules.vtkCommonDataModel").vtkPolyData())) == 0


def test_other_cells_of_a_grid():
    cells, types = [1, 6, 3, 0, 1, 2, 3, 0, 1, 2, 2, 3, 4], [1, 5, 4, 3]
    grid = pv.UnstructuredGrid(cells, types, POINTS)
    grid.cell_data["id"] = np.arange(4)
    for given in (grid, raw(grid, "vtkUnstructuredGrid")):
        with pytest.warns(FileWarning, match="2 cells of an? .*UnstructuredGrid are neither lines nor polylines"):
            lines = fl.lines(given)
        np.testing.assert_array_equal(lines.segments, POINTS[ENDS[:3]])
        np.testing.assert_array_equal(lines.attributes["id"], [2, 2, 3])


def test_a_grid_that_contradicts_itself():
    given = {"points": POINTS, "point_data": {}, "cell_data": {}}
    for cells, types in (([2, 0, 7], [3]), ([2, 0, 1], [3, 3]), ([3, 0, 1], [4])):
        with pytest.raises(InputError, match="its lines name points beyond its 7 points, or are cut short"):
            fl.lines(SimpleNamespace(cells=cells, celltypes=types, **given))


def test_several_meshes():
    blocks = pv.MultiBlock([mesh(), None, pv.MultiBlock([mesh(1).cast_to_unstructured_grid(), mesh(2)])])
    vtk = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    outer = vtk.vtkMultiBlockDataSet()
    for i, z in enumerate((0, None, 1, 2)):
        outer.SetBlock(i, None if z is None else raw(mesh(z), "vtkPolyData"))
    for given in (blocks, outer):
        lines = fl.lines(given)
        block = lines.attributes["block"]
        assert block.tolist() == [0] * 4 + [2] * 4 + [3] * 4
        assert lines.strands.tolist() == [0, 0, 1, 2, 3, 3, 4, 5, 6, 6, 7, 8]
        np.testing.assert_array_equal(lines.segments[4:8], POINTS[ENDS] + np.float32([0, 0, 1]))
        np.testing.assert_array_equal(lines.radius, np.tile(np.array(ENDS) / 8, (3, 1)))
        assert lines.attributes["id"].tolist() == [5, 5, 6, 7] * 3
        assert lines.unit == "mm"


def test_meshes_that_differ():
    other = mesh(1)
    del other.point_data["Radius"]
    other.cell_data["id"] = np.ones((3, 2))
    del other.field_data["unit"]
    with pytest.warns(FileWarning) as told:
        lines = fl.lines(pv.MultiBlock([mesh(), other, pv.ImageData()]))
    texts = [str(warning.message) for warning in told]
    assert texts[0] == "blocks of a MultiBlock that are no lines are not read: 1 ImageData"
    assert texts[1] == "a MultiBlock: 1 of 2 parts have no radius, and get the radius 0"
    assert texts[2] == "a MultiBlock: attributes that not all parts have alike are left out: 'id'"
    assert texts[3] == "a MultiBlock: parts differ in unit; it is 'mm', that of the first"
    assert (lines.radius[4:] == 0).all()
    with pytest.raises(InputError, match="a MultiBlock has no block of lines; expected a PolyData or"):
        fl.lines(pv.MultiBlock([pv.ImageData()]))


def test_points_alone_are_told():
    vtk = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    points = pytest.importorskip("vtkmodules.vtkCommonCore").vtkPoints()
    points.InsertNextPoint(1, 2, 3)
    for mesh in (vtk.vtkPolyData(), vtk.vtkUnstructuredGrid()):
        mesh.SetPoints(points)
        with pytest.warns(fl.FileWarning, match="the 1 points of a vtk.* are not read, as no line joins them"):
            assert len(fl.lines(mesh)) == 0


def test_blocks_have_one_automatic_offset():
    near, far = mesh(), mesh()
    far.points += [1000, 0, 0]
    plain = fl.lines(pv.MultiBlock([near, None, far]))
    lines = fl.lines(pv.MultiBlock([near, None, far]), offset="auto")
    assert lines.offset[0] > 400
    np.testing.assert_array_equal(lines.segments, plain.segments - np.float32(lines.offset))
