"""All builders that the thesis names, on equal terms; and the sets of splits that only they use."""

from __future__ import annotations

import pickle
import pydoc
from typing import Any

import numpy as np
import pytest
from support.nasty import named_scene
from support.theory_scenes import SCENE_NAMES, scene

import fastlines as fl
from fastlines.settings.splits import SplitSet

# ---- Every split set ----


@pytest.mark.parametrize("kind", SplitSet.__subclasses__())
def test_a_set_divides_cut_boxes_or_says_that_it_cannot(kind: type[SplitSet]) -> None:
    ends = named_scene("hair")
    assert fl.build(ends, splits=kind(), cost=fl.Cost(0.01)).n_nodes > 1
    if kind().tight_only:
        with pytest.raises(fl.InputError, match=rf"{kind.__name__}.* offers object splits, which need tight boxes"):
            fl.build(ends, splits=(fl.PlaneGrid(4), kind()), boxes="cut")
    else:
        assert fl.build(ends, splits=kind(), boxes="cut", cost=fl.Cost(0.01)).n_nodes > 1


# ---- SBVH's restriction of spatial splits ----

SWEEP = fl.ObjectSweep()


def bytes_of(ends: Any, *splits: Any) -> bytes:
    tree = fl.build(ends, splits=splits, cost=fl.Cost(0.3))
    tree.validate()
    return tree.nodes.tobytes() + tree.refs.tobytes()


@pytest.mark.parametrize("name", SCENE_NAMES)
def test_planes_are_asked_only_where_objects_overlap(name: str) -> None:
    ends = scene(name, 9, 60)

    def grid(min_overlap: float = 0.0) -> Any:
        return fl.PlaneGrid(4, min_overlap=min_overlap)

    both = bytes_of(ends, SWEEP, grid())
    # Nothing overlaps in more than the whole scene; anything that does overlaps in more than nothing.
    degenerate = fl.build(ends, lookahead=0).areas[0] == 0
    assert bytes_of(ends, SWEEP, grid(1.0)) == (both if degenerate else bytes_of(ends, SWEEP))
    assert bytes_of(ends, grid(1.0), SWEEP) == bytes_of(ends, grid(), SWEEP)
    assert bytes_of(ends, grid(1.0)) == bytes_of(ends, grid())


def test_fewer_references_for_hardly_more_cost() -> None:
    """What the restriction is for."""
    lines = fl.scenes.make("bun-hair", 8000).lines
    trees = [fl.build(lines, splits=(SWEEP, fl.PlaneGrid(16, min_overlap=share))) for share in (0.0, 1e-5, 1e-3, 1.0)]
    n_refs = [tree.n_refs for tree in trees]
    assert n_refs == sorted(n_refs, reverse=True)
    assert n_refs[0] > n_refs[1] > n_refs[2] > n_refs[3] == len(lines)
    assert trees[1].cost() < 1.002 * trees[0].cost()


@pytest.mark.parametrize("share", [-0.1, 1.1, np.nan, "all"])
def test_wrong_overlap(share: Any) -> None:
    with pytest.raises(fl.InputError, match="expected a fraction of the scene's surface area"):
        fl.PlaneGrid(16, min_overlap=share)


def test_overlap_is_kept_in_files(tmp_path: Any) -> None:
    tree = fl.build(scene("crossing", 1, 30), splits=(SWEEP, fl.PlaneGrid(3, min_overlap=0.25)))
    tree.save(tmp_path / "a.flt")
    assert fl.load(tmp_path / "a.flt").settings == tree.settings


@pytest.mark.parametrize("method", fl.METHODS)
def test_bounds_do_not_change_the_name_of_a_tree(method: str) -> None:
    ends = scene("crossing", 1, 30)
    assert fl.build(ends, method, limits=fl.Limits(max_refs=100, max_bytes=10**8)).method == method
    assert fl.build(ends, method, limits=fl.Limits(max_depth=5)).method == "custom"
    assert fl.build(ends, method, radius_hint=0.01).method == "custom"


def test_the_named_methods_explain_themselves() -> None:
    help_text = pydoc.render_doc(fl.METHODS, renderer=pydoc.plaintext)
    assert "The named trees" in help_text
    for method in fl.METHODS:
        assert f"{method}  " in help_text
        assert method in repr(fl.METHODS)


def test_the_named_methods_are_a_mapping_that_nobody_can_change() -> None:
    best = fl.METHODS["best"]
    assert {**fl.METHODS} == dict(fl.METHODS.items()) == fl.METHODS
    assert pickle.loads(pickle.dumps(fl.METHODS)) == fl.METHODS
    assert fl.METHODS.get("bvh") is None
    with pytest.raises(KeyError):
        fl.METHODS["bvh"]
    with pytest.raises(TypeError, match="does not support item assignment"):
        fl.METHODS["best"] = fl.Settings()  # type: ignore[index]
    assert fl.METHODS["best"] is best
