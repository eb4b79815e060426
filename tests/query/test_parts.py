"""Which parts of a geometry rays see, and a radius that counts for none of them."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same

import fastlines as fl
from fastlines.geometry.seen_rows import MOST_SEEN
from fastlines.query.backend import KERNELS
from fastlines.query.queries import QUERIES, QueryName

RNG = np.random.default_rng(0)
TRIANGLES = fl.Triangles(RNG.random((40, 3, 3)))
PARTS = [
    TRIANGLES,
    fl.Lines.from_segments(RNG.random((40, 2, 3)), radius=0.01),
    fl.Curves.from_bezier(RNG.random((5, 4, 3)), 0.02),
    fl.Boxes(np.sort(RNG.random((8, 2, 3)), axis=1)),
]
GEOMETRY = fl.Geometry(PARTS)
RAYS = RNG.random((200, 3)) * [1, 1, 0] - [0, 0, 1], RNG.normal(0, 0.2, (200, 3)) + np.array([0, 0, 1])

#: Queries, and their arguments.
QUESTIONS: list[tuple[QueryName, dict[str, Any]]] = [
    *((query, {}) for query in QUERIES if query != "next_hits"),
    ("all_hits", {"at": "surface", "merge": "strand"}),
    ("next_hits", {"k": 2}),
    ("next_hits", {"k": 2, "rank": "distance"}),
]


@pytest.mark.filterwarnings("ignore::fastlines.QueryWarning")
@pytest.mark.parametrize("method", ["best", "kd-d2"])
@pytest.mark.parametrize("parts", [0, [1], (2, 1), [0, 3], [], np.array([3, 3]), [3, 2, 1, 0], None], ids=str)
def test_other_parts_are_as_if_not_there(parts: Any, method: str) -> None:
    tree = fl.build(GEOMETRY, method)
    seen = range(4) if parts is None else np.atleast_1d(np.array(parts, int))
    unseen = [np.arange(*GEOMETRY.first[part : part + 2]) for part in range(4) if part not in seen]
    for ignore in ([], [3, 60, 85]):
        dropped = np.concatenate([np.array(ignore, int), *unseen])
        for query, how in QUESTIONS:
            expected = getattr(tree, query)(*RAYS, 0.02, ignore=dropped, **how)
            for kernel in KERNELS:
                found = getattr(tree, query)(*RAYS, 0.02, parts=parts, ignore=ignore, kernel=kernel, **how)
                assert_same(found, expected, f"{query} {how} {kernel}")
            found = fl.brute_force(GEOMETRY, *RAYS, 0.02, query=query, parts=parts, ignore=ignore, **how)
            assert_same(found, expected, f"{query} {how}")


def test_lines_in_front_of_a_mesh_are_picked() -> None:
    line = fl.Lines.from_segments([[[-1, 0.1, 0], [1, 0.1, 0]], [[-1, 0, 2], [1, 0, 2]]])
    wall = fl.Triangles([[[-9, -9, 1], [9, -9, 1], [0, 9, 1]]])
    tree = fl.build(fl.Geometry([wall, line]))
    ray = [0, 0, -5], [0, 0, 1], 0.5
    assert tree.next_hits(*ray, k=1, rank="distance").part == [0]
    covered = tree.first_hit(*ray[:2], parts=0)
    assert covered.t == 6
    picked = tree.next_hits(*ray, k=1, rank="distance", parts=1, t_max=covered.t)
    assert (picked.part.tolist(), picked.prim.tolist(), picked.prim_number.tolist()) == ([1], [0], [1])
    assert np.allclose(picked.points(), [[0, 0, 0]])


def test_a_part_that_is_not_seen_needs_no_radius() -> None:
    bare = fl.build(fl.Geometry([TRIANGLES, fl.Lines.from_segments([[[0, 0, 0], [1, 1, 1]]])]))
    assert bare.any_hit(*RAYS, parts=0).any()
    for parts in (None, 1, [0, 1]):
        with pytest.raises(fl.InputError, match="needs one: pass radius="):
            bare.any_hit(*RAYS, parts=parts)


def test_a_few_selections_are_kept() -> None:
    geometry = fl.Geometry([TRIANGLES] * 6)
    tree = fl.build(geometry)
    for parts in range(6):
        assert set(tree.first_hit(*RAYS, parts=parts).part.tolist()) == {-1, parts}
    assert list(geometry._seen._kept) == [(i,) for i in range(6 - MOST_SEEN, 6)]


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (4, "parts names 4; there are 4 parts, which count from 0"),
        ([0, -1], "parts names -1"),
        ([0, 4], "parts names 4"),
        ([[0]], "expected the number of a part, or several"),
        (0.5, "expected whole numbers"),
        (True, "expected whole numbers"),
        ("lines", "expected whole numbers"),
    ],
)
def test_parts_are_numbers_of_parts(parts: Any, words: str) -> None:
    with pytest.raises(fl.InputError, match=words):
        fl.build(GEOMETRY).any_hit(*RAYS, parts=parts)


@pytest.mark.parametrize("part", PARTS, ids=lambda part: type(part).__name__)
def test_what_has_no_parts_refuses_them(part: Any) -> None:
    with pytest.raises(fl.InputError, match=f"parts=0 names parts of a Geometry, and this is {type(part).__name__}"):
        fl.build(part).any_hit(*RAYS, parts=0)


def test_a_radius_that_does_not_count_is_warned_of() -> None:
    flat, mixed = fl.build(fl.Geometry([TRIANGLES, PARTS[3]])), fl.build(GEOMETRY)
    match = r"does not count for triangles and boxes.*\(40 triangles, 8 boxes\)"
    for query, how in QUESTIONS[:4]:
        with pytest.warns(fl.QueryWarning, match=match) as found:
            getattr(flat, query)(*RAYS, 0.1, **how)
        assert [warning.filename for warning in found] == [__file__]
    with pytest.warns(fl.QueryWarning) as found:
        fl.brute_force(TRIANGLES, *RAYS, radius=[0.0] * 199 + [0.1])
    assert [warning.filename for warning in found] == [__file__]
    with pytest.warns(fl.QueryWarning, match=r"\(40 triangles\)"):
        mixed.any_hit(*RAYS, 0.1, parts=0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        flat.any_hit(*RAYS)
        flat.any_hit(*RAYS, 0)
        mixed.any_hit(*RAYS, 0.1)
        mixed.any_hit(*RAYS, 0.1, parts=[0, 1])
        mixed.any_hit(*RAYS, 0.1, parts=[])
