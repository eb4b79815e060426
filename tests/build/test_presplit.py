"""Early split clipping: pieces that tile, under the bound that was asked for; trees over them answer the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.theory_scenes import SCENE_NAMES, scene

import fastlines as fl

#: One leaf that lists all there is before a build.
ONE_LEAF: dict[str, Any] = {"lookahead": 0, "limits": fl.Limits(max_refs=100_000)}


def areas_of_pieces(tree: fl.Tree) -> Any:
    """The area of the box of each reference, as a fraction of the area of the scene, up to the rounding of cuts."""
    p, q = tree.geometry.segments.astype(float)[tree.refs["prim"]].swapaxes(0, 1)
    s0, s1 = (np.minimum(tree.refs[s], 1)[:, None] for s in ("s0", "s1"))
    grain = np.spacing(np.abs(tree.geometry.segments).max())
    x, y, z = np.maximum(np.abs((s1 - s0) * (q - p)) - 2 * grain, 0).T
    return 2 * (x * y + x * z + y * z) / tree.areas[0]


@pytest.mark.parametrize("name", SCENE_NAMES)
@pytest.mark.parametrize("area", [1e-1, 1e-3])
def test_no_piece_is_larger_than_the_bound(area: float, name: str) -> None:
    ends = scene(name, 2, 60)
    tree = fl.build(ends, **ONE_LEAF, presplit=fl.Presplit(area=area))
    tree.validate()
    if tree.areas[0] == 0:
        assert tree.n_refs == len(ends)
        return
    areas = areas_of_pieces(tree)
    assert (areas <= area).all()
    # Lines are cut if and only if they were above it.
    x, y, z = np.abs(ends[:, 1].astype(float) - ends[:, 0]).T
    whole = 2 * (x * y + x * z + y * z) / tree.areas[0]
    assert ((np.bincount(tree.refs["prim"]) > 1) == (whole > area)).all()


@pytest.mark.parametrize("refs", [1, 1.5, 4, 33.3])
def test_as_many_references_as_asked_for(refs: float) -> None:
    lines = fl.scenes.make("spaghetti", 300).lines
    tree = fl.build(lines, **ONE_LEAF, presplit=fl.Presplit(refs=refs))
    tree.validate()
    assert tree.n_refs == int(refs * 300)
    assert tree.limits_hit == {}
    # The largest were cut: none is more than four times as large as the smallest of those that were.
    counts = np.bincount(tree.refs["prim"])
    areas = areas_of_pieces(tree)
    halves = areas[counts[tree.refs["prim"]] > 1]
    assert refs == 1 or areas.max() <= 4 * halves.min() * (1 + 1e-4)


def test_a_bound_on_references_holds() -> None:
    lines = fl.scenes.make("spaghetti", 100).lines
    tree = fl.build(lines, "bvh-cl", presplit=fl.Presplit(area=1e-6), limits=fl.Limits(max_refs=1000))
    assert tree.n_refs == 1000
    assert tree.limits_hit["max_refs"] == 1
    tree.validate()
    small = fl.Limits(max_refs=10**6, max_leaf_refs=2, max_depth=9)
    tree = fl.build(lines, "bvh-cl", presplit=fl.Presplit(area=1e-6), limits=small)
    tree.validate()
    assert tree.n_refs <= 2 * 2**9
    assert tree.stats()["largest_leaf_refs"] <= 2


@pytest.mark.slow
@pytest.mark.parametrize(("scene_name", "n"), [("spaghetti", 400), ("bun-hair", 8000)])
def test_the_automatic_bound_ends_where_more_gains_little(scene_name: str, n: int) -> None:
    lines = fl.scenes.make(scene_name, n).lines
    tree = fl.build(lines, "bvh-cl", presplit=fl.Presplit())
    tree.validate()
    chosen = tree.settings.presplit
    assert chosen is not None
    assert chosen.refs is not None
    assert chosen.refs > 1

    def cost(refs: float) -> float:
        return fl.build(lines, "bvh-cl", presplit=fl.Presplit(refs=refs)).cost()

    assert tree.cost() == cost(chosen.refs) < 0.99 * cost(chosen.refs / 2)
    assert cost(chosen.refs * 2) >= 0.99 * tree.cost()


def test_a_bound_of_one_reference_each_cuts_nothing() -> None:
    lines = fl.scenes.make("spaghetti", 200).lines
    whole, same = fl.build(lines, "bvh-d2"), fl.build(lines, "bvh-d2", presplit=fl.Presplit(refs=1))
    assert whole.nodes.tobytes() == same.nodes.tobytes()
    assert whole.refs.tobytes() == same.refs.tobytes()


def test_is_kept_in_files(tmp_path: Any) -> None:
    for presplit in (fl.Presplit(area=0.01), fl.Presplit(refs=3)):
        tree = fl.build(fl.scenes.make("spaghetti", 50).lines, "bvh-cl", presplit=presplit)
        tree.save(tmp_path / "a.flt")
        back = fl.load(tmp_path / "a.flt")
        assert back.settings == tree.settings
        back.validate()


ONE = [[[0, 0, 0], [1, 1, 1]]]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: fl.Presplit(area=0), "area=0; expected a fraction of the scene's surface area"),
        (lambda: fl.Presplit(area=np.nan), "area=nan"),
        (lambda: fl.Presplit(refs=0.5), "refs=0.5; expected references for each line"),
        (lambda: fl.Presplit(area=0.1, refs=2), "give one of them"),
        (lambda: fl.build(ONE, presplit=4), "presplit=4; expected fl.Presplit"),
        (lambda: fl.build(ONE, "kd-d2", presplit=fl.Presplit()), "presplit is for tight boxes"),
        (lambda: fl.build(fl.Boxes(ONE), "bvh-cl", presplit=fl.Presplit()), "these are Boxes"),
        (
            lambda: fl.build(ONE, presplit=fl.Presplit(refs=9), limits=fl.Limits(max_refs=8)),
            "makes 9 references, but the limits allow 8",
        ),
    ],
)
def test_wrong_settings(wrong: Any, message: str) -> None:
    with pytest.raises(fl.InputError, match=message):
        wrong()


def test_the_leaves_hold_what_a_presplit_makes() -> None:
    """The default of `max_leaf_refs` gives way, as it does for many primitives; one that was asked for does not."""
    ends, presplit = np.random.default_rng(1).random((52, 2, 3)), fl.Presplit(refs=2.5)
    tree = fl.build(ends, presplit=presplit, limits=fl.Limits(max_depth=3))
    tree.validate()
    assert (tree.n_refs, tree.stats()["depth"]) == (130, 3)
    with pytest.raises(fl.InputError, match="makes 130 references, but leaves of max_leaf_refs=16 within max_depth=3"):
        fl.build(ends, presplit=presplit, limits=fl.Limits(max_depth=3, max_leaf_refs=16))
