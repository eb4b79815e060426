"""Nodes that are too small to be cut, and the method that cuts large ones alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import fastlines as fl


@pytest.mark.parametrize("sample", [0, 100])
def test_small_nodes_are_not_cut(sample: int) -> None:
    lines = fl.scenes.make("spaghetti", 4000).lines
    side = float((lines.bounds[1] - lines.bounds[0]).max())
    planes = fl.BinnedPlanes(8, 64, 16, sample=sample, uncut_only_side=100)
    tree = fl.build(lines, "best", splits=planes)
    tree.validate()
    assert len(lines) < tree.n_refs < 0.8 * fl.build(lines, "best", splits=replace(planes, uncut_only_side=0)).n_refs
    nodes, prims = tree.nodes, tree.refs["prim"]
    small = nodes[(np.ptp(nodes["box"], axis=1).max(axis=1) < 0.0999 * side) & ~tree.is_leaf]
    assert len(small) > 100
    for node in small:
        below = prims[node["first_ref"] : node["first_ref"] + node["n_refs"]]
        assert len(np.unique(below)) == len(below)
    whole = fl.build(lines, "best", splits=replace(planes, uncut_only_side=2000))
    assert whole.n_refs < 1.1 * len(lines)
    assert fl.build(lines, "best", splits=planes, radius_hint=0.0).n_refs > tree.n_refs


def test_beams_are_hardly_cut() -> None:
    lines = fl.scenes.make("photon-beams", 20_000).lines
    beams, best = fl.build(lines, "beams"), fl.build(lines)
    beams.validate()
    assert beams.method == "beams"
    assert len(lines) < beams.n_refs < 4 * len(lines) < best.n_refs
    assert beams.nodes["n_refs"][beams.is_leaf].max() <= 16
