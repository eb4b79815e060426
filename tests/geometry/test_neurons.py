"""Lines from neurons of navis."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import FileWarning, InputError

#: navis calls pandas in a way that pandas will change.
pytestmark = pytest.mark.filterwarnings("ignore:The inplace keyword")

#: A trunk of three nodes that forks, and a lone node: id, label, x, y, z, radius, parent.
NODES = np.array(
    [
        [4, 1, 0, 0, 0, 2, -1],
        [9, 3, 1, 0, 0, 1, 4],
        [2, 3, 2, 0, 0, 0.5, 9],
        [7, 3, 3, 1, 0, 0.25, 2],
        [5, 2, 3, -1, 0, 0.5, 2],
        [8, 0, 9, 9, 9, 1, -1],
    ]
)
COLUMNS = ("node_id", "label", "x", "y", "z", "radius", "parent_id")


def without_navis(**columns: Any) -> SimpleNamespace:
    """Return what looks like a neuron of navis."""
    pandas = pytest.importorskip("pandas")
    table = dict(zip(COLUMNS, NODES.T, strict=True)) | columns
    return SimpleNamespace(nodes=pandas.DataFrame(table), units=1, connectors=None)


def check(lines: fl.Lines) -> None:
    points = dict(zip(NODES[:, 0], NODES[:, 2:5], strict=True))
    ids = lines.end_attributes["id"]
    np.testing.assert_array_equal(ids, [[4, 9], [9, 2], [2, 7], [2, 5], [8, 8]])
    np.testing.assert_array_equal(lines.segments, [[points[a], points[b]] for a, b in ids])
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 2, 3])
    np.testing.assert_array_equal(lines.radius, [[2, 1], [1, 0.5], [0.5, 0.25], [0.5, 0.5], [1, 1]])
    np.testing.assert_array_equal(lines.end_attributes["type"], [[1, 3], [3, 3], [3, 3], [3, 2], [0, 0]])


def test_nodes() -> None:
    lines = fl.lines(without_navis())
    check(lines)
    assert lines.unit is None


def test_odd_nodes() -> None:
    with pytest.raises(InputError, match="neuron 0 has a node whose parent_id, 77, is no node"):
        fl.lines(without_navis(parent_id=[-1, 4, 9, 77, 2, -1]))
    with pytest.raises(InputError, match="neuron 0 has several nodes of one node_id"):
        fl.lines(without_navis(node_id=[4, 4, 2, 7, 5, 8]))
    with pytest.warns(FileWarning, match="the radii of 2 nodes are NaN or negative, and are taken as 0"):
        lines = fl.lines(without_navis(radius=[2, 1, np.nan, -1, 0.5, 1]))
    np.testing.assert_array_equal(lines.radius[:3], [[2, 1], [1, 0], [0, 0]])
    assert fl.lines(without_navis(radius=np.zeros(6))).radius is None
    texts = fl.lines(without_navis(label=["soma", "axon", None, "axon", "axon", "axon"]))
    assert texts.end_attributes["type"][:2].tolist() == [["soma", "axon"], ["axon", ""]]
    given = without_navis()
    given.connectors = given.nodes
    with pytest.warns(FileWarning, match="the connectors of 1 neuron are not read"):
        check(fl.lines(given))


def test_neurons_of_navis(tmp_path: Path) -> None:
    navis = pytest.importorskip("navis")
    path = tmp_path / "cell.swc"
    path.write_text("\n".join(" ".join(f"{value:g}" for value in (*row[:2], *row[2:])) for row in NODES))
    neuron = navis.read_swc(path)
    lines, read = fl.lines(neuron), fl.read(path)
    check(lines)
    check(read)
    neuron.units = "8 nm"
    assert fl.lines(neuron).unit == "8e-09 m"
    neuron.units = "1 micrometer"
    assert fl.lines(neuron).unit == "µm"
    neuron.units = ["4 nm", "4 nm", "40 nm"]
    with pytest.warns(FileWarning, match="the units of axes differ"):
        assert fl.lines(neuron).unit is None


def test_a_list_of_neurons() -> None:
    navis, pandas = pytest.importorskip("navis"), pytest.importorskip("pandas")
    neurons = [navis.TreeNeuron(pandas.DataFrame(dict(zip(COLUMNS, NODES.T, strict=True))), units="nm") for _ in "ab"]
    lines = fl.lines(navis.NeuronList(neurons))
    np.testing.assert_array_equal(lines.attributes["neuron"], np.repeat([0, 1], 5))
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 2, 3, 4, 4, 5, 6, 7])
    check(lines[:5])
    assert lines.unit == "nm"
    np.testing.assert_array_equal(fl.lines(neurons).attributes["neuron"], lines.attributes["neuron"])
    neurons[1].units = "1 mm"
    with pytest.warns(FileWarning, match="neurons differ in their units, 1 nanometer and 1 millimeter, and"):
        assert fl.lines(navis.NeuronList(neurons)).unit is None
    assert len(fl.lines(navis.NeuronList([]))) == 0


def test_what_is_no_skeleton() -> None:
    navis = pytest.importorskip("navis")
    trimesh = pytest.importorskip("trimesh")
    mesh = navis.MeshNeuron(trimesh.creation.box())
    with pytest.raises(InputError, match=r"lines are a MeshNeuron, a surface of triangles: fl\.Triangles\.from_mesh"):
        fl.lines(mesh)
    with pytest.raises(InputError, match=r"neuron 0 is a MeshNeuron; expected a TreeNeuron, as read_swc"):
        fl.lines(navis.NeuronList([mesh]))
    dots = navis.Dotprops(np.eye(3), k=None, vect=np.eye(3))
    with pytest.raises(InputError, match=r"lines are Dotprops, points with directions; dotprops\.to_skeleton\(\)"):
        fl.lines(dots)
    assert len(fl.lines(dots.to_skeleton())) == 3
