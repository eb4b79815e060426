"""Lines as neurons of navis, and back."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import fastlines as fl

#: navis calls pandas in a way that pandas will change.
pytestmark = pytest.mark.filterwarnings("ignore:The inplace keyword")

SWC = b"""2 1 0 0 0 2 -1
3 3 1 0 0 1 2
5 3 2 0 0 0.5 3
6 3 3 1 0 0.25 5
7 2 3 -1 0 0.5 5
9 0 9 9 9 1 -1
"""


@pytest.fixture
def navis() -> Any:
    return pytest.importorskip("navis")


def same(left: fl.Lines, right: fl.Lines) -> None:
    for name in ("segments", "strands", "radius"):
        np.testing.assert_array_equal(getattr(left, name), getattr(right, name))
    assert left.unit == right.unit
    for name, values in right.attributes.items():
        np.testing.assert_array_equal(left.attributes[name], values)
    for name, values in right.end_attributes.items():
        np.testing.assert_array_equal(left.end_attributes[name], values)


def test_trees_of_a_file_stay_whole(navis: Any, load: Any) -> None:
    lines = load(SWC, "cell.swc")
    neurons = fl.to_neurons(lines)
    assert (len(neurons), neurons[0].n_nodes, neurons[0].n_trees, neurons[0].n_branches) == (1, 6, 2, 1)
    assert str(neurons[0].units) == "1 micrometer"
    assert neurons[0].cable_length == pytest.approx(2 + 2 * np.sqrt(2))
    table = neurons[0].nodes.set_index("node_id").sort_index()
    assert table["parent_id"].to_dict() == {2: -1, 3: 2, 5: 3, 6: 5, 7: 5, 9: -1}
    assert table["label"].to_dict() == {2: 1, 3: 3, 5: 3, 6: 3, 7: 2, 9: 0}
    same(fl.lines(neurons[0]), lines)


def test_a_list_of_neurons(navis: Any, load: Any) -> None:
    lines = fl.lines(navis.NeuronList(list(fl.to_neurons(load(SWC, "cell.swc"))) * 2))
    neurons = fl.to_neurons(lines)
    assert [neuron.n_nodes for neuron in neurons] == [6, 6]
    same(fl.lines(neurons), lines)


def test_strands_without_ids(navis: Any) -> None:
    lines = fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 1, 0]], [[5, 5, 5], [6, 6, 6]]])
    (neuron,) = fl.to_neurons(lines)
    assert (neuron.n_nodes, neuron.n_trees) == (5, 2)
    back = fl.lines(neuron)
    np.testing.assert_array_equal(back.segments, lines.segments)
    assert (back.radius, back.unit) == (None, None)
    assert len(fl.to_neurons(lines[:0])) == 0


def test_lines_whose_neuron_is_not_a_number_are_a_neuron_of_their_own(navis: Any) -> None:
    points = [[[0, 0, 0], [1, 0, 0]], [[0, 5, 0], [1, 5, 0]], [[0, 9, 0], [1, 9, 0]]]
    lines = fl.Lines.from_segments(points, attributes={"neuron": [0, np.nan, np.nan]})
    assert [len(neuron.nodes) for neuron in fl.to_neurons(lines)] == [2, 4]


def test_what_is_lost(navis: Any) -> None:
    lines = fl.Lines.from_points([[0, 0, 0], [1, 0, 0]], [2], attributes={"fa": [0.5, 1]})
    with pytest.warns(fl.FileWarning, match=r"not kept in the neurons: 'fa'; the unit 'degree'"):
        fl.to_neurons(replace(lines, unit="degree"))


def test_missing_navis_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "navis", None)
    with pytest.raises(fl.MissingExtraError, match=r"the extra 'navis'"):
        fl.to_neurons([[[0, 0, 0], [1, 0, 0]]])
