"""Readers and queries for PyVista. Tests with meshes need PyVista."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from importlib import import_module, metadata
from pathlib import Path

import numpy as np
import pytest
from support.line_files import POINTS, SAMPLES, STRANDS

import fastlines as fl
from fastlines.io import known_formats

ENTRIES = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "entry-points"
]
#: Extensions of ours that PyVista reads itself, as meshes.
THEIRS = {".obj", ".pdb", ".ply", ".vtk", ".vtp", ".vtu"}
OURS = known_formats().keys() - THEIRS


@pytest.fixture
def pyvista():
    return pytest.importorskip("pyvista", minversion="0.48")


@pytest.fixture
def mesh(pyvista, tmp_path):
    from fastlines.pyvista_plugin import accessor  # noqa: F401
    from fastlines.pyvista_plugin.readers import read

    (tmp_path / "a.trk").write_bytes(SAMPLES["some.trk"])
    return read(tmp_path / "a.trk")


def test_entry_points_name_formats_and_exist():
    readers = ENTRIES["pyvista.readers"]
    assert known_formats().keys() > THEIRS
    assert set(readers) == OURS | {f"{extension}.gz" for extension in OURS}
    for target in readers.values():
        module, _, name = target.partition(":")
        assert callable(getattr(import_module(module), name))
    assert ENTRIES["pyvista.accessors"] == {"fastlines": "fastlines.pyvista_plugin.accessor"}


def test_pyvista_reads_the_others_itself(pyvista):
    from pyvista.core.utilities.reader import CLASS_READERS

    assert known_formats().keys() & CLASS_READERS.keys() == THEIRS


def test_the_docs_name_what_pyvista_reads_itself():
    text = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")
    said = re.search(r"`pyvista.read` reads all formats of the table but (.*?), which", " ".join(text.split()))
    assert said is not None
    assert set(re.findall(r"`(.*?)`", said[1])) == THEIRS


def test_pyvista_is_imported_only_if_used():
    check = "import sys, fastlines, fastlines.pyvista_plugin.readers; sys.exit('pyvista' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", check], check=False).returncode == 0


def test_missing_pyvista_names_the_extra(monkeypatch):
    from fastlines.pyvista_plugin.readers import to_polydata

    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(fl.MissingExtraError, match=r"the extra 'pyvista'"):
        to_polydata(fl.Lines.from_points(POINTS, [7]))


def test_polydata(mesh):
    assert mesh.n_lines == 4
    np.testing.assert_array_equal(mesh.points, POINTS[[0, 1, 2, 3, 3, 4, 5, 6, 6]])
    np.testing.assert_array_equal(mesh.point_data["fa"], np.zeros(9))
    np.testing.assert_array_equal(mesh.cell_data["fa of streamline"], range(4))
    assert (list(mesh.field_data["unit"]), list(mesh.field_data["up"])) == (["mm"], ["z"])


def test_radius_and_what_is_lost(pyvista):
    from fastlines.pyvista_plugin.readers import to_polydata

    lines = fl.Lines.from_points(POINTS, [3, 4], radius=np.arange(7), attributes={"cube": np.ones((7, 2, 2))})
    with pytest.warns(fl.FileWarning, match=r"not kept in PolyData: 'cube'"):
        mesh = to_polydata(lines)
    np.testing.assert_array_equal(mesh.point_data["radius"], range(7))
    assert to_polydata(fl.Lines.from_segments(np.empty((0, 2, 3)))).n_points == 0


@pytest.mark.parametrize("unit", ["µm", "Å"])
def test_units_that_are_not_ascii(pyvista, tmp_path, unit):
    from fastlines.pyvista_plugin.readers import read, to_polydata

    (tmp_path / "a.swc").write_text("1 1 0 0 0 1 -1\n2 3 5 0 0 1 1\n3 3 9 0 0 1 2\n")
    assert list(read(tmp_path / "a.swc").field_data["unit"]) == ["µm"]
    mesh = to_polydata(replace(fl.Lines.from_points(POINTS, [7]), unit=unit, up="y"))
    assert (list(mesh.field_data["unit"]), list(mesh.field_data["up"])) == ([unit], ["y"])
    assert (fl.lines(mesh).unit, fl.lines(mesh.copy()).unit) == (unit, unit)
    mesh.save(tmp_path / "a.vtp")
    assert pyvista.read(tmp_path / "a.vtp").field_data["unit"][0] == fl.read(tmp_path / "a.vtp").unit == unit


def test_names_that_are_no_text(pyvista):
    from fastlines.pyvista_plugin.readers import to_polydata

    lines = fl.Lines.from_points(POINTS, [7], attributes={"\udc80": np.zeros(7), "a\0b": np.ones(7), "µ": np.arange(7)})
    with pytest.warns(fl.FileWarning, match="not kept in PolyData"):
        mesh = to_polydata(lines)
    assert list(mesh.point_data) == ["µ"]


def test_curves_and_several_parts(pyvista, tmp_path, monkeypatch):
    from fastlines.pyvista_plugin import readers

    curves = fl.Curves.from_strands(POINTS[:4], [4], basis="bezier", radius=0.1, attributes={"age": [1, 2, 3, 4]})
    curves = replace(curves, unit="mm", up="z")
    with pytest.warns(fl.FileWarning, match="curves, which are written as their pieces"):
        mesh = readers.to_polydata(curves)
    assert mesh.n_lines >= 1
    assert (list(mesh.field_data["unit"]), list(mesh.field_data["up"])) == (["mm"], ["z"])
    np.testing.assert_array_equal(fl.lines(mesh).segments, curves.pieces.lines.segments)
    monkeypatch.setattr(readers, "read_lines", lambda path: fl.Geometry([fl.Lines.from_points(POINTS, [7]), curves]))
    with pytest.warns(fl.FileWarning, match="curves, which"):
        assert [part.n_lines for part in readers.read("a.usda")] == [1, mesh.n_lines]


def test_what_polydata_cannot_hold(pyvista):
    from fastlines.pyvista_plugin.readers import to_polydata

    columns = {"none": np.empty((2, 0)), "half": np.array([1, 2], "f2"), "yes": np.array([True, False])}
    lines = fl.Lines.from_segments(POINTS[:4].reshape(2, 2, 3), strands=[7, 3], attributes=columns)
    with pytest.warns(fl.FileWarning) as told:
        mesh = to_polydata(lines)
    assert "'none', float64 of shape (2, 0); the numbers of strands, which are counted from 0" in str(told[0].message)
    np.testing.assert_array_equal(mesh.cell_data["half"], [1, 2])
    np.testing.assert_array_equal(mesh.cell_data["yes"], [True, False])
    assert to_polydata([POINTS[:3], POINTS[3:]]).n_lines == 2
    assert to_polydata(fl.Lines.from_segments(POINTS[:4].reshape(2, 2, 3))).n_lines == 2
    nothing = fl.Lines.from_segments(np.empty((0, 2, 3)), attributes={"a": np.empty(0), "b": np.empty((0, 3))})
    with pytest.warns(fl.FileWarning, match=r"not kept in PolyData: 'b', float64 of shape \(0, 3\)"):
        assert to_polydata(nothing).n_lines == 0
    with pytest.raises(fl.InputError, match=r"such meshes hold one part; .* as in to_polydata\(geometry\.parts\[0\]\)"):
        to_polydata(fl.Geometry([lines]))


def test_accessor_answers_as_a_tree_does(mesh):
    accessor = mesh.fastlines
    lines = accessor.lines
    np.testing.assert_array_equal(lines.strands, STRANDS)
    np.testing.assert_array_equal(lines.attributes["fa of streamline"], STRANDS)
    assert (lines.unit, lines.up) == ("mm", "z")
    tree = fl.build(lines)
    rays = lines.segments.mean(axis=1) - (0, 0, 9), [[0, 0, 1.0]] * 5
    np.testing.assert_array_equal(accessor.first_hit(*rays, radius=0.5).prim, tree.first_hit(*rays, 0.5).prim)
    np.testing.assert_array_equal(accessor.all_hits(*rays, radius=0.5).t, tree.all_hits(*rays, 0.5).t)
    np.testing.assert_array_equal(accessor.next_hits(*rays, 0.5, 1).prim, tree.next_hits(*rays, 0.5, 1).prim)
    np.testing.assert_array_equal(accessor.any_hit(*rays, 0.5, t_max=9), tree.any_hit(*rays, 0.5, t_max=9))
    np.testing.assert_array_equal(accessor.count_hits(*rays, 0.5), tree.count_hits(*rays, 0.5))
    assert accessor.any_hit(*rays, 0.5).all()


def test_tree_is_kept_until_the_mesh_changes(mesh):
    tree = mesh.fastlines.tree
    assert mesh.fastlines.tree is tree
    mesh.points[:, 0] += 100
    assert mesh.fastlines.tree is not tree
    assert mesh.fastlines.lines.bounds[0, 0] == 100
    mesh.point_data["radius"] = np.full(9, 2.0)
    assert mesh.fastlines.lines.radius.shape == (5, 2)


def test_meshes_that_are_not_only_lines(pyvista):
    from fastlines.pyvista_plugin import accessor  # noqa: F401

    assert len(pyvista.Sphere().fastlines.lines) == 0
    both = pyvista.PolyData(POINTS, lines=[3, 0, 1, 2, 2, 5, 6], verts=[1, 0], faces=[3, 0, 1, 2])
    both.cell_data["number"] = [10, 20, 30, 40]
    np.testing.assert_array_equal(both.fastlines.lines.attributes["number"], [20, 20, 30])


def test_lines_of_a_mesh_are_the_same_everywhere(pyvista, tmp_path):
    """The accessor, `fl.lines`, `fl.write` and files follow one rule."""
    from fastlines.pyvista_plugin import accessor  # noqa: F401

    mesh = pyvista.PolyData(POINTS, lines=[3, 0, 1, 2, 2, 3, 4, 2, 5, 6])
    mesh.point_data["Radius"] = np.arange(7) / 8
    mesh.point_data["fa"] = np.arange(7)
    mesh.cell_data["radius"] = [5.0, 6, 7]
    mesh.cell_data["fa"] = [1, 2, 3]
    mesh.field_data["unit"], mesh.field_data["up"] = ["mm"], "z"
    fl.write(tmp_path / "a.vtp", mesh)
    mesh.save(tmp_path / "b.vtp")
    for lines in (
        fl.lines(mesh),
        mesh.fastlines.lines,
        fl.read(tmp_path / "a.vtp"),
        fl.read(tmp_path / "b.vtp"),
    ):
        assert (lines.unit, lines.up) == ("mm", "z")
        np.testing.assert_array_equal(lines.strands, [0, 0, 1, 2])
        np.testing.assert_array_equal(lines.radius, np.array([[0, 1], [1, 2], [3, 4], [5, 6]]) / 8)
        np.testing.assert_array_equal(lines.end_attributes["fa"], [[0, 1], [1, 2], [3, 4], [5, 6]])
        assert set(lines.attributes) == {"fa", "fa of cell", "radius of cell"}
        np.testing.assert_array_equal(lines.attributes["fa of cell"], [1, 1, 2, 3])
        np.testing.assert_array_equal(lines.attributes["radius of cell"], [5, 5, 6, 7])


def test_radius_of_cells_and_other_field_data(pyvista):
    mesh = pyvista.PolyData(POINTS, lines=[3, 0, 1, 2, 2, 3, 4])
    mesh.cell_data["RADIUS"] = [5.0, 6]
    mesh.field_data["year"] = [2024]
    with pytest.warns(fl.FileWarning, match="PolyData: its field data 'year' are left out"):
        lines = fl.lines(mesh)
    np.testing.assert_array_equal(lines.radius, [[5, 5], [5, 5], [6, 6]])
    np.testing.assert_array_equal(mesh.fastlines.lines.radius, lines.radius)
    assert not lines.attributes


def test_installed_entry_points(pyvista, tmp_path):
    """PyVista finds both by themselves, where this package is installed with its entry points."""
    if not any(entry.name == "fastlines" for entry in metadata.entry_points(group="pyvista.accessors")):
        pytest.skip("installed without entry points")
    (tmp_path / "a.trk").write_bytes(SAMPLES["some.trk"])
    meshes = "pyvista.read(sys.argv[1]), pyvista.Line()"
    check = f"import sys, pyvista; print(*[len(mesh.fastlines.lines) for mesh in ({meshes})])"
    command = [sys.executable, "-c", check, str(tmp_path / "a.trk")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.split() == ["5", "1"]
