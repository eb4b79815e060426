"""A tree file is a forest of one tile, whatever the tree is over."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same
from support.forests import strands

import fastlines as fl


def kinds() -> dict[str, Any]:
    lines = strands(radius=np.full(330, 0.02))
    corners = np.random.default_rng(0).uniform(-1, 1, (300, 3, 3))
    spheres = fl.Spheres.from_centres(corners[:, 0], radius=np.linspace(0.01, 0.1, 300))
    boxes = fl.Boxes(np.sort(corners[:, :2], axis=1))
    return {
        "lines": lines,
        "curves": fl.Curves.from_strands(corners.reshape(-1, 3), [9] * 100, basis="catmull-rom", radius=0.02),
        "spheres": spheres,
        "triangles": fl.Triangles(corners),
        "boxes": boxes,
        "geometry": fl.Geometry([boxes, lines, spheres]),
        "nothing": np.empty((0, 2, 3)),
    }


@pytest.fixture(params=kinds())
def tree(request: pytest.FixtureRequest) -> fl.Tree:
    return fl.build(kinds()[request.param])


@pytest.fixture
def forest(tree: fl.Tree, tmp_path: Path) -> fl.Forest:
    tree.save(tmp_path / "scene.flt")
    return fl.Forest(tmp_path / "scene.flt")


def test_what_it_says(forest: fl.Forest, tree: fl.Tree) -> None:
    assert (forest.n_prims, forest.n_tiles) == (len(tree.geometry), 1)
    assert f": {len(tree.geometry)} " in repr(forest)
    assert forest.stats()["n_refs"] == tree.n_refs
    assert forest.stats()["n_strands"] == tree.geometry.n_strands
    assert type(forest.geometry) is type(tree.geometry)
    assert pickle.loads(pickle.dumps(forest)).n_prims == forest.n_prims
    forest.verify()
    with pytest.raises(fl.InputError, match=r"scene.flt is the file of one tree; build the tree again"):
        forest.rebuild(0)


def test_answers(forest: fl.Forest, tree: fl.Tree) -> None:
    rng = np.random.default_rng(1)
    origins, targets = rng.uniform(-1.5, 1.5, (2, 200, 3))
    asked: dict[str, Any] = {"origins": origins, "directions": targets - origins, "radius": 0.01}
    if not tree.geometry.takes_radius:
        asked.pop("radius")
    for at in ("closest", "surface"):
        assert_same(forest.first_hit(**asked, at=at), tree.first_hit(**asked, at=at))
        assert_same(forest.all_hits(**asked, at=at), tree.all_hits(**asked, at=at))
        assert_same(forest.next_hits(**asked, k=2, at=at), tree.next_hits(**asked, k=2, at=at))
    assert_same(forest.any_hit(**asked), tree.any_hit(**asked))
    if len(tree.geometry):
        assert_same(forest.count_hits(**asked, ignore=[0, 3]), tree.count_hits(**asked, ignore=[0, 3]))
    assert_same(forest.nearest(origins, 3), tree.nearest(origins, 3))
    assert_same(forest.within(origins, 0.5), tree.within(origins, 0.5))
    if tree.geometry.has_parts:
        assert_same(forest.first_hit(**asked, parts=[0, 2]), tree.first_hit(**asked, parts=[0, 2]))
    hits, expected = (of.first_hit(**asked, at="surface") for of in (forest, tree))
    assert hits.points().tobytes() == expected.points().tobytes()
    assert hits.normals().tobytes() == expected.normals().tobytes()


def test_files_that_are_no_trees(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a tree")
    with pytest.raises(fl.FileFormatError, match=r"notes.txt is not a whole tree file"):
        fl.Forest(path)
    with pytest.raises(FileNotFoundError):
        fl.Forest(tmp_path / "nowhere.flt")
