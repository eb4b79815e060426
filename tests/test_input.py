"""Bad input: an error that says what was given and what to do. Odd input: an answer. Never a crash."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.patience import HANGS
from support.slow import few_of

import fastlines as fl
from fastlines.settings.splits import SplitSet

ONE = np.array([[[-1, -1, -1], [1, 1, 1]]], np.float32)
TREE = fl.build(ONE)
NAN, INF = float("nan"), float("inf")
MANY = np.zeros((20, 2, 3))
MANY[[3, 5, 7, 8, 9, 11, 13], 0, 1] = NAN


def ask(origins: Any = (0, 0, -5), directions: Any = (0, 0, 1), radius: Any = 0.5, **more: Any) -> Any:
    return TREE.first_hit(origins, directions, radius, **more)


#: A call, and words that its error must have: what was given and what to do.
BAD: dict[str, tuple[Callable[[], Any], list[str]]] = {
    # Segments.
    "segments 1d": (lambda: fl.build([1, 2, 3]), ["segments", "(3,)", "(n, 2, 3)"]),
    "segments points": (lambda: fl.build(np.zeros((4, 3))), ["segments", "(4, 3)", "(n, 2, 3)"]),
    "segments of 3 ends": (lambda: fl.build(np.zeros((4, 3, 3))), ["(4, 3, 3)", "(n, 2, 3)"]),
    "segments of 4 axes": (lambda: fl.build(np.zeros((4, 2, 4))), ["(4, 2, 4)", "(n, 2, 3)"]),
    "segments empty, odd shape": (lambda: fl.build(np.zeros((0, 7))), ["(0, 7)", "(n, 2, 3)"]),
    "segments scalar": (lambda: fl.build(3.0), ["()", "(n, 2, 3)"]),
    "segments text": (lambda: fl.build("hair.tfx"), ["segments", "fl.read"]),
    "segments of text": (lambda: fl.build([[["a"] * 3] * 2]), ["strand 0", "numbers"]),
    "segments None": (lambda: fl.build(None), ["segments", "numbers"]),
    "segments complex": (lambda: fl.build(ONE + 1j), ["segments", "complex"]),
    "segments ragged": (lambda: fl.build([[[0, 0, 0], [1, 1]]]), ["segments", "numbers"]),
    "segments objects": (lambda: fl.build([[[object()] * 3] * 2]), ["strand 0", "numbers"]),
    "segments dates": (lambda: fl.build(np.zeros((1, 2, 3), "M8[s]")), ["segments", "datetime64"]),
    "segments NaN": (lambda: fl.build(MANY), ["7 of 20", "NaN", "rows 3, 5, 7, 8, 9 and 2 more", "skip"]),
    "segments Inf": (lambda: fl.build([[[0, 0, 0], [0, INF, 0]]]), ["1 of 1", "Inf", "row 0", "skip"]),
    "segments beyond float32": (lambda: fl.build([[[0, 0, 0], [0, -1e300, 0]]]), ["1 of 1", "row 0"]),
    "segments too large": (lambda: fl.build([[[0, 0, 0], [0, 2e30, 0]]]), ["1e+30", "row 0"]),
    "invalid of build": (lambda: fl.build(ONE, invalid="drop"), ["'drop'", "'error'", "'skip'"]),
    "strands length": (lambda: fl.Lines.from_segments(ONE, strands=[1, 2]), ["strands", "(2,)", "(1,)"]),
    "strands text": (lambda: fl.Lines.from_segments(ONE, strands=["a"]), ["strands"]),
    "strands huge": (lambda: fl.Lines.from_segments(ONE, strands=[10**30]), ["strands"]),
    "strands beyond int64": (
        lambda: fl.Lines.from_segments(ONE, strands=np.array([2**63], np.uint64)),
        ["strands", "9223372036854775808", "2^63"],
    ),
    "segments masked": (lambda: fl.build(np.ma.masked_array(ONE, ONE > 0)), ["segments", "masked", "fill"]),
    "strands too large": (lambda: fl.Lines.from_segments(ONE, strands=[2**62]), ["strands", "4611686018427387904"]),
    "Lines strands below": (lambda: fl.Lines(ONE, np.array([-2])), ["strands", "-2", "-1 for none"]),
    "Curves strands too large": (
        lambda: fl.Curves.from_bezier(np.zeros((1, 4, 3)), strands=[2**62]),
        ["strands", "4611686018427387904"],
    ),
    "strands masked": (
        lambda: fl.Lines.from_segments(ONE, strands=np.ma.masked_array([1], [True])),
        ["strands", "masked"],
    ),
    "Lines strands length": (lambda: fl.Lines(ONE, np.zeros(2, np.int64)), ["strands", "(2,)", "(1,)"]),
    "Lines strands type": (lambda: fl.Lines(ONE, np.zeros(1)), ["strands", "float64", "int64"]),
    "Lines strands list": (lambda: fl.Lines(ONE, [1]), ["strands", "list", "from_segments"]),
    "Lines radius": (lambda: fl.Lines(ONE, np.zeros(1, int), np.float32([-1])), ["radius", "from 0 to"]),
    "Lines attributes": (lambda: fl.Lines(ONE, np.zeros(1, int), None, {"a": np.zeros(3)}), ["a", "(3,)", "1 segm"]),
    "Lines skipped": (lambda: fl.Lines(ONE, np.zeros(1, int), skipped=np.array([5])), ["skipped", "rising", "2"]),
    "invalid of build of lines": (
        lambda: fl.build(fl.Lines.from_segments(ONE), invalid="bogus"),
        ["'bogus'", "'error'", "'skip'"],
    ),
    "invalid of build of triangles": (
        lambda: fl.build(fl.Triangles(np.zeros((1, 3, 3))), invalid="bogus"),
        ["'bogus'", "'error'", "'skip'"],
    ),
    "strands fractions": (lambda: fl.Lines.from_segments(ONE, strands=[1.5]), ["strands", "whole numbers"]),
    "radius length": (lambda: fl.Lines.from_segments(ONE, radius=[1, 2]), ["radius", "(2,)", "segment or end"]),
    "attribute length": (lambda: fl.Lines.from_segments(ONE, attributes={"id": [1, 2]}), ["id", "(2,)"]),
    "attributes list": (lambda: fl.Lines.from_segments(ONE, attributes=[1]), ["attributes"]),
    "unknown argument": (lambda: fl.Lines.from_segments(ONE, colour=3), ["'colour'", "strands"]),
    "points flat": (lambda: fl.Lines.from_points(np.zeros(7), [2]), ["points", "(7,)"]),
    "points 2d space": (lambda: fl.Lines.from_points(np.zeros((3, 2)), [2]), ["points", "(3, 2)", "3)"]),
    "counts sum": (lambda: fl.Lines.from_points(np.zeros((3, 3)), [2]), ["counts", "3 points"]),
    "counts negative": (lambda: fl.Lines.from_points(np.zeros((2, 3)), [3, -1]), ["counts", "0 or more"]),
    "counts negative, though none too large": (
        lambda: fl.Lines.from_points(np.zeros((2, 3)), [2, -1, 1]),
        ["counts", "0 or more"],
    ),
    "counts text": (lambda: fl.Lines.from_points(np.zeros((2, 3)), ["2"]), ["counts"]),
    "counts fractions": (lambda: fl.Lines.from_points(np.zeros((2, 3)), [0.5, 1.5]), ["counts"]),
    "counts 2d": (lambda: fl.Lines.from_points(np.zeros((2, 3)), [[2]]), ["counts"]),
    "radius per point": (lambda: fl.Lines.from_points(np.zeros((2, 3)), [2], radius=[1]), ["radius", "(1,)"]),
    "radius too long": (lambda: fl.Lines.from_points(np.zeros((2, 3)), [2], radius=[1, 2, 3]), ["radius", "(3,)"]),
    "attributes per point": (
        lambda: fl.Lines.from_points(np.zeros((2, 3)), [2], attributes={"id": []}),
        ["id", "(0,)"],
    ),
    "strand 2d space": (lambda: fl.Lines.from_strands([np.zeros((3, 2))]), ["strand", "(3, 2)"]),
    "strand text": (lambda: fl.Lines.from_strands(["abc"]), ["strand"]),
    "Lines float64": (lambda: fl.build(fl.Lines(np.zeros((1, 2, 3)), np.zeros(1, np.int64))), ["float32"]),
    "Lines NaN": (lambda: fl.build(fl.Lines(ONE * np.float32(NAN), np.zeros(1, np.int64))), ["NaN"]),
    "centres of 4 axes": (lambda: fl.Spheres.from_centres(np.zeros((2, 4)), 1), ["centres", "(2, 4)", "(n, 3)"]),
    "centres 1d": (lambda: fl.Spheres.from_centres(np.zeros(3), 1), ["centres", "(3,)", "(n, 3)"]),
    "centres 3d": (lambda: fl.Spheres.from_centres(np.zeros((2, 3, 1)), 1), ["centres", "(2, 3, 1)", "(n, 3)"]),
    "triangles": (lambda: fl.Triangles(ONE), ["triangles", "(1, 2, 3)", "(n, 3, 3)"]),
    "triangles NaN": (lambda: fl.Triangles(np.full((2, 3, 3), NAN)), ["2 of 2", "NaN", "rows 0, 1"]),
    "boxes": (lambda: fl.Boxes(np.zeros((3, 6))), ["boxes", "(3, 6)", "(n, 2, 3)"]),
    "boxes inverted": (lambda: fl.Boxes(-ONE), ["1 boxes", "row 0"]),
    "boxes Inf": (lambda: fl.Boxes(ONE * np.float32(INF)), ["Inf"]),
    # Settings.
    "method": (lambda: fl.build(ONE, "bvh-cd"), ["'bvh-cd'", "did you mean", "bvh-cl", "kd-d2"]),
    "method type": (lambda: fl.build(ONE, 3), ["3", "bvh-cl"]),
    "method list": (lambda: fl.build(ONE, ["bvh-cl"]), ["bvh-cl"]),
    "splits name": (lambda: fl.build(ONE, splits="grid"), ["splits", "PlaneGrid"]),
    "splits number": (lambda: fl.build(ONE, splits=16), ["splits=16", "PlaneGrid"]),
    "splits class": (lambda: fl.build(ONE, splits=fl.PlaneGrid), ["splits", "PlaneGrid(16)"]),
    "splits none": (lambda: fl.build(ONE, splits=[]), ["splits", "PlaneGrid"]),
    "splits None": (lambda: fl.Settings(splits=None), ["splits=None"]),
    "splits base": (lambda: fl.build(ONE, splits=SplitSet()), ["SplitSet"]),
    "boxes rule": (lambda: fl.build(ONE, boxes="kd"), ["'kd'", "'tight'", "'cut'"]),
    "lookahead negative": (lambda: fl.build(ONE, lookahead=-1), ["lookahead=-1", "0"]),
    "lookahead fraction": (lambda: fl.build(ONE, lookahead=1.5), ["lookahead=1.5", "whole"]),
    "lookahead text": (lambda: fl.build(ONE, lookahead="2"), ["lookahead='2'", "whole"]),
    "lookahead far": (lambda: fl.build(ONE, lookahead=[1, 99]), ["lookahead=99", "8"]),
    "lookahead empty": (lambda: fl.build(ONE, lookahead=[]), ["lookahead", "1, 2"]),
    "lookahead None": (lambda: fl.Settings(lookahead=None), ["lookahead=None"]),
    "cost number": (lambda: fl.build(ONE, cost=2.0), ["cost", "fl.Cost", "2.0"]),
    "limits dict": (lambda: fl.build(ONE, limits={"max_depth": 3}), ["limits", "fl.Limits", "max_depth"]),
    "sweep cut": (lambda: fl.build(ONE, splits=fl.ObjectSweep(), boxes="cut"), ["ObjectSweep", "KD", "planes"]),
    "bvh-cl cut": (lambda: fl.build(ONE, "bvh-cl", boxes="cut"), ["ObjectSweep", "KD"]),
    "max_leaf_refs cut": (lambda: fl.build(ONE, "kd-cl", limits=fl.Limits(max_leaf_refs=4)), ["max_leaf_refs", "KD"]),
    "n_planes 0": (lambda: fl.PlaneGrid(0), ["n_planes=0", "1 to 4096"]),
    "n_planes many": (lambda: fl.PlaneGrid(4097), ["n_planes=4097", "1 to 4096"]),
    "n_planes float": (lambda: fl.PlaneGrid(16.0), ["n_planes=16.0", "whole"]),
    "n_planes bool": (lambda: fl.PlaneGrid(True), ["n_planes=True", "whole"]),
    "split max_refs": (lambda: fl.Median(max_refs=0), ["max_refs=0", "1 or more"]),
    "split max_refs huge": (lambda: fl.build(ONE, splits=fl.Median(max_refs=2**70)), ["max_refs"]),
    "c_trav 0": (lambda: fl.Cost(0), ["c_trav=0", "positive"]),
    "c_trav tiny": (lambda: fl.Cost(1e-308), ["c_trav=1e-308", "1e-100 to 1e100"]),
    "c_trav huge": (lambda: fl.Cost(1e308), ["c_trav=1e+308", "1e-100 to 1e100"]),
    "c_trav NaN": (lambda: fl.Cost(NAN), ["c_trav=nan", "finite"]),
    "c_prim Inf": (lambda: fl.Cost(1, INF), ["c_prim=inf", "finite"]),
    "c_prim text": (lambda: fl.Cost(1, "1"), ["c_prim='1'", "positive"]),
    "c_prim complex": (lambda: fl.Cost(1, 1j), ["c_prim=1j"]),
    "c_prim huge": (lambda: fl.build(ONE, cost=fl.Cost(1, 10**400)), ["c_prim"]),
    "max_depth negative": (lambda: fl.Limits(max_depth=-1), ["max_depth=-1", "0 to 256"]),
    "max_depth None": (lambda: fl.Limits(max_depth=None), ["max_depth=None", "whole"]),
    "max_depth deep": (lambda: fl.Limits(max_depth=257), ["max_depth=257", "256"]),
    "max_leaf_refs 0": (lambda: fl.Limits(max_leaf_refs=0), ["max_leaf_refs=0", "1 or more"]),
    "max_leaf_refs huge": (lambda: fl.build(ONE, limits=fl.Limits(max_leaf_refs=2**70)), ["max_leaf_refs"]),
    "leaf_refs negative": (lambda: fl.Limits(leaf_refs=-3), ["leaf_refs=-3", "0 or more"]),
    "leaf_refs huge": (lambda: fl.build(ONE, limits=fl.Limits(leaf_refs=2**70)), ["leaf_refs"]),
    "leaf_size negative": (lambda: fl.Limits(leaf_size=-0.1), ["leaf_size=-0.1"]),
    "leaf_size NaN": (lambda: fl.Limits(leaf_size=NAN), ["leaf_size=nan"]),
    "leaf_size huge": (lambda: fl.build(ONE, limits=fl.Limits(leaf_size=10**400)), ["leaf_size"]),
    "max_refs few": (lambda: fl.build(np.repeat(ONE, 9, 0), limits=fl.Limits(max_refs=8)), ["max_refs=8", "9 prim"]),
    "no room": (
        lambda: fl.build(np.repeat(ONE, 9, 0), limits=fl.Limits(max_depth=1, max_leaf_refs=4)),
        ["max_leaf_refs=4", "max_depth=1", "9 primitives"],
    ),
    # Rays.
    "origins shape": (lambda: ask([1, 2]), ["origins", "(2,)", "3"]),
    "origins scalar": (lambda: ask(1.0), ["origins", "()", "3"]),
    "directions shape": (lambda: ask(directions=np.zeros((3, 4))), ["directions", "(3, 4)", "3"]),
    "rays do not match": (lambda: ask(np.zeros((2, 3)), np.ones((3, 3))), ["(2, 3)", "(3, 3)", "one direction"]),
    "no origins, a direction": (lambda: ask([[], []]), ["origins", "(2, 0)"]),
    "origins text": (lambda: ask("abc"), ["origins", "numbers"]),
    "origins None": (lambda: ask(None), ["origins", "numbers"]),
    "origins NaN": (lambda: ask([[0, 0, NAN]] * 9), ["9 of 9", "origin", "rows 0, 1, 2, 3, 4 and 4 more", "skip"]),
    "origins beyond float32": (lambda: ask([0, 0, 1e39]), ["1 of 1", "origin", "finite"]),
    "directions Inf": (lambda: ask(directions=[0, 0, INF]), ["direction", "finite", "row 0", "skip"]),
    "directions zero": (lambda: ask(directions=[0, -0.0, 0]), ["direction", "length zero", "row 0", "skip"]),
    "directions too short": (lambda: ask(directions=[0, 0, 1e-38]), ["direction", "so short that t", "row 0", "skip"]),
    "directions too short from afar": (lambda: ask([0, 0, -1e20], [0, 0, 1e-20]), ["direction", "so short that t"]),
    "directions vanish in float32": (lambda: ask(directions=[0, 0, 1e-60]), ["direction", "length zero"]),
    "radius negative": (lambda: ask(radius=-1e-9), ["radius", "from 0"]),
    "radius negative, of all": (lambda: ask(np.zeros((3, 3)), radius=-1), ["3 of 3", ": radius = -1, for all; fix"]),
    "k of another query": (lambda: fl.brute_force(ONE, [0, 0, 0], [0, 0, 1], 1, k=3), ["k=3", "next_hits", "all_hits"]),
    "k too large": (lambda: fl.build(ONE).next_hits([0, 0, 0], [0, 0, 1], 1, k=2**63), [f"0 to {2**63 - 1}"]),
    "rays too many": (lambda: ask(np.zeros((65536, 1, 3)), np.ones((65537, 3))), ["4295032832", "4294967295", "calls"]),
    "radius NaN": (lambda: ask(radius=NAN), ["radius", "from 0"]),
    "radius Inf": (lambda: ask(radius=INF), ["radius", "from 0 to"]),
    "radius huge": (lambda: ask(radius=1e13), ["radius", "scene's size"]),
    "radius None": (lambda: ask(radius=None), ["no radius of their own", "radius="]),
    "radius text": (lambda: ask(radius="0.1"), ["radius", "numbers"]),
    "radius shape": (lambda: ask(np.zeros((3, 3)), radius=[1, 2]), ["radius", "(2,)", "(3,)"]),
    "t_min above": (lambda: ask(t_min=2, t_max=1), ["t_min", "t_max", "row 0"]),
    "t_min NaN": (lambda: ask(t_min=NAN), ["t_min", "numbers"]),
    "t_max NaN": (lambda: ask(t_max=NAN), ["t_min <= t_max"]),
    "t_min Inf": (lambda: ask(t_min=INF), ["t_min"]),
    "t_max shape": (lambda: ask(np.zeros((3, 3)), t_max=[1, 2]), ["t_max", "(2,)", "(3,)"]),
    "at": (lambda: ask(at="middle"), ["'middle'", "'closest'", "'surface'"]),
    "at array": (lambda: ask(at=np.array(["closest"] * 2)), ["at=", "'closest'", "'surface'"]),
    "at None": (lambda: ask(at=None), ["None", "'closest'"]),
    "invalid": (lambda: ask(invalid="drop"), ["'drop'", "'error'", "'skip'"]),
    "query": (lambda: fl.brute_force(ONE, [0, 0, 0], [0, 0, 1], 1, query="hits"), ["'hits'", "first_hit", "all_hits"]),
    "cost by": (lambda: TREE.cost(by="h"), ["'h'", "'f'", "'g'"]),
    "cost model": (lambda: TREE.cost(model=3), ["model=3", "fl.Cost"]),
    "scene list": (lambda: fl.scenes.make(["a"]), ["['a']", "spaghetti-2"]),
    "scene huge": (lambda: fl.scenes.make("spaghetti", 10**30), ["n_segments=1000", "1 to 100000000"]),
    # Threads.
    "threads 0": (lambda: fl.set_num_threads(0), ["n_threads=0", "1 to 1024"]),
    "threads negative": (lambda: fl.set_num_threads(-1), ["n_threads=-1", "1 to 1024"]),
    "threads float": (lambda: fl.set_num_threads(2.0), ["n_threads=2.0", "whole"]),
    "threads text": (lambda: fl.set_num_threads("2"), ["n_threads='2'", "whole"]),
    "threads bool": (lambda: fl.set_num_threads(True), ["n_threads=True", "whole"]),
    "threads many": (lambda: fl.set_num_threads(10**6), ["n_threads=1000000", "1024"]),
}


@pytest.mark.parametrize("what", BAD)
def test_error_says_what_was_given_and_what_to_do(what: str) -> None:
    call, words = BAD[what]
    with pytest.raises(fl.InputError) as caught:
        call()
    text = str(caught.value)
    assert "\n" not in text
    assert [word for word in words if word not in text] == [], text


@pytest.mark.parametrize("given", ["0", "-2", "two", "2.5", "²", "5000", "1e3"])
def test_bad_number_of_threads_in_the_environment(given: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FASTLINES_NUM_THREADS", given)
    with pytest.raises(fl.InputError, match=rf"FASTLINES_NUM_THREADS='?{re.escape(given)}.*1 to 1024"):
        fl.get_num_threads()


def test_number_of_threads_comes_from_the_call_or_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FASTLINES_NUM_THREADS", raising=False)
    assert fl.get_num_threads() >= 1
    monkeypatch.setenv("FASTLINES_NUM_THREADS", "7")
    assert fl.get_num_threads() == 7
    try:
        fl.set_num_threads(3)
        assert fl.get_num_threads() == 3
    finally:
        fl.set_num_threads(None)
    assert fl.get_num_threads() == 7


@pytest.mark.parametrize("length", [1e-38, 3e-38, 1e-30, 1.0, 1e30])
@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8, 1e30])
def test_t_is_finite_where_there_is_a_hit(length: float, scale: float) -> None:
    """However short a direction is that is taken; and no scene is so large that a warning is given."""
    tree = fl.build(ONE * np.float32(scale))
    rays = ([0, 0, -5 * scale], [[0, 0, length], [0, 0, -length]], scale / 2)
    if 6.66 * scale / length > 3.4e38:
        with pytest.raises(fl.InputError, match="so short that t"):
            tree.first_hit(*rays)
        return
    hits = tree.first_hit(*rays)
    assert hits.prim.tolist() == [0, -1]
    assert hits.t[0] == pytest.approx(5 * scale / length, rel=1e-5)


@pytest.mark.parametrize("n_rays", [9, 600])
def test_rays_that_are_no_rays_can_be_skipped(n_rays: int) -> None:
    rng = np.random.default_rng(0)
    segments = rng.uniform(-1, 1, (30, 2, 3))
    origins, directions = rng.uniform(-1, 1, (n_rays, 3)), rng.normal(0, 1, (n_rays, 3))
    radius, t_min, t_max = np.full(n_rays, 0.3), np.zeros(n_rays), np.full(n_rays, 9.0)
    good = [array.copy() for array in (origins, directions, radius, t_min, t_max)]
    origins[0, 1], directions[1, 2], directions[2], radius[3], radius[4] = NAN, INF, 0, -1, NAN
    t_min[5], t_max[6], t_min[7] = NAN, -1, INF
    tree = fl.build(segments)
    for at in ("closest", "surface"):
        for method, query in ((tree.first_hit, "first_hit"), (tree.all_hits, "all_hits")):
            expected = method(*good[:3], t_min=good[3], t_max=good[4], at=at)
            more = {"t_min": t_min, "t_max": t_max, "at": at, "invalid": "skip"}
            got = method(origins, directions, radius, **more)
            brute = fl.brute_force(segments, origins, directions, radius, query=query, **more)
            assert got.skipped.tolist() == brute.skipped.tolist() == list(range(8))
            assert got.prim.tolist() == brute.prim.tolist()
            if query == "first_hit":
                assert (got.prim[:8] == -1).all()
                assert (got.t[:8] == INF).all()
                assert got.prim[8:].tolist() == expected.prim[8:].tolist()
            else:
                assert (got.counts[:8] == 0).all()
                assert got.counts[8:].tolist() == expected.counts[8:].tolist()
    more = {"t_min": t_min, "t_max": t_max, "invalid": "skip"}
    assert not tree.any_hit(origins, directions, radius, **more)[:8].any()
    assert not tree.count_hits(origins, directions, radius, **more)[:8].any()
    # One bad number for all rays: all are skipped.
    assert tree.first_hit(*good[:2], NAN, invalid="skip").skipped.tolist() == list(range(n_rays))


def test_segments_that_are_no_segments_can_be_skipped() -> None:
    lines = fl.Lines.from_segments(
        MANY, invalid="skip", strands=range(20), radius=range(20), attributes={"id": [*range(20)]}
    )
    assert lines.skipped.tolist() == [3, 5, 7, 8, 9, 11, 13]
    kept = [row for row in range(20) if row not in lines.skipped]
    assert lines.strands.tolist() == lines.attributes["id"].tolist() == lines.radius.tolist() == kept
    assert fl.build(MANY, invalid="skip").n_prims == 13
    assert fl.build(np.full((3, 2, 3), NAN), invalid="skip").n_prims == 0


@pytest.mark.parametrize("method", [*fl.METHODS, None])
@pytest.mark.parametrize("empty", [[], np.empty((0, 2, 3)), np.empty((0, 6)), np.empty((0, 2, 3), int)])
def test_nothing_is_an_answer(empty: Any, method: str | None) -> None:
    def answer(query: str, *rays: Any) -> Any:
        if method is None:
            return fl.brute_force(empty, *rays, query=query)
        return getattr(fl.build(empty, method), query)(*rays)

    if method is not None:
        tree = fl.build(empty, method)
        tree.validate()
        assert (tree.n_prims, tree.n_refs, tree.n_nodes, tree.cost()) == (0, 0, 1, 0)
        assert tree.stats()["n_prims"] == 0
        assert [level.tolist() for level in tree.levels()] == [[0]]
    rays = (np.zeros((4, 3)), [0, 0, 1], 3.0)
    assert answer("first_hit", *rays).prim.tolist() == [-1] * 4
    assert answer("any_hit", *rays).tolist() == [False] * 4
    assert answer("count_hits", *rays).tolist() == [0] * 4
    assert answer("all_hits", *rays).offsets.tolist() == [0] * 5


@pytest.mark.parametrize("geometry", [fl.Triangles([]), fl.Boxes([]), fl.Triangles(np.empty((0, 3, 3)))])
def test_no_triangles_or_boxes(geometry: Any) -> None:
    for method in fl.METHODS:
        tree = fl.build(geometry, method)
        tree.validate()
        assert tree.n_nodes == 1


@pytest.mark.parametrize("origins", [[], np.empty((0, 3)), np.empty((0, 3), np.float32)])
@pytest.mark.parametrize("directions", [[], np.empty((0, 3)), [0, 0, 1]])
def test_no_rays_have_no_hits(origins: Any, directions: Any) -> None:
    assert ask(origins, directions).prim.shape == (0,)
    assert ask(origins, directions, np.empty(0)).prim.shape == (0,)
    assert TREE.all_hits(origins, directions, 0.5).offsets.tolist() == [0]
    assert TREE.count_hits(origins, directions, 0.5).shape == (0,)
    assert fl.brute_force(ONE, origins, directions, 0.5).offsets.tolist() == [0]


#: Programs that must end well, each in a process of its own.
PROGRAMS = {
    "nearly flat": "lines[..., 2] = 0; lines[0, 1, 2] = 1e-39",
    "denormal": "lines *= np.float32(1e-42)",
    "one copy": "lines[:] = lines[0]",
    "huge": "lines *= np.float32(9e29)",
    "tiny among huge": "lines[1:] *= np.float32(9e29)",
    "a star at zero": "lines[:, 1] = 0",
    "negative zeros": "lines[:, :, 1:] = -0.0",
}


@pytest.mark.parametrize("what", few_of(PROGRAMS, n=2))
def test_no_crash(what: str) -> None:
    program = f"""
import numpy as np, fastlines as fl
lines = np.random.default_rng(0).uniform(-1, 1, (200, 2, 3)).astype(np.float32)
{PROGRAMS[what]}
directions = np.random.default_rng(1).normal(0, 1, (500, 3))
for method in fl.METHODS:
    for boxes in ("tight", "cut"):
        if (method, boxes) != ("bvh-cl", "cut"):
            try:
                tree = fl.build(lines, method, boxes=boxes, limits=fl.Limits(max_refs=20_000))
            except fl.InputError:
                continue
            tree.validate()
            counts = tree.count_hits([0, 0, 0], directions, 1e-3 * (tree.nodes["box"][0].max() or 1))
            assert tree.all_hits([0, 0, 0], directions, 0).counts.sum() <= counts.sum()
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=HANGS, check=False)
    assert ended.returncode == 0, f"exit code {ended.returncode}: {ended.stderr[-2000:]}"


def test_names_of_files_in_the_wrong_place(tmp_path):
    """The likeliest first mistakes are answered with the function that was meant."""
    tree = fl.build([[[0, 0, 0], [1, 1, 1]]])
    tree.save(tmp_path / "a.flt")
    np.save(tmp_path / "a.npy", tree.geometry.segments)
    for wrong, meant in (
        (lambda: fl.build("hair.tfx"), "fl.read reads files"),
        (lambda: fl.build(tmp_path / "hair.tfx"), "fl.read reads files"),
        (lambda: fl.read(tmp_path / "a.flt"), "fl.load reads it"),
        (lambda: fl.load(tmp_path / "a.npy"), "fl.read reads it"),
    ):
        with pytest.raises(fl.FastlinesError, match=meant):
            wrong()


def test_a_direction_of_length_zero_is_refused_where_all_else_is_zero_too():
    for segments in ([[[0, 0, 0], [0, 0, 0]]], np.zeros((0, 2, 3))):
        with pytest.raises(fl.InputError, match="length zero"):
            fl.build(segments).first_hit([0, 0, 0], [0, 0, 0], 0.0)
