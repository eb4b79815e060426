"""What is in a box: trees answer as brute force does, bit for bit; sides, kinds, and bad input."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import cases
from support.boxes import boxes_on
from support.builds import ALL_KINDS, BUILDS, Balls, build

import fastlines as fl
from fastlines.query import memory_check
from fastlines.threads import num_threads

TREES = ["best", "bvh-cl", "kd-d2", "bvh-cl, Presplit(area=0.001, refs=None)"]
INF = np.inf


class BallsInBoxes(Balls):
    """Balls of the user's own that know whether they are in a box."""

    def in_box(self, ids: Any, low: Any, high: Any) -> Any:
        """See `fl.Primitives`."""
        centre = self.centre[ids]
        return (np.maximum(np.maximum(low - centre, centre - high), 0) ** 2).sum(axis=1) <= self.own[ids] ** 2


KINDS: dict[str, Any] = {**ALL_KINDS, "one's own": BallsInBoxes}


@pytest.fixture(autouse=True)
def any_engine() -> Iterator[None]:
    yield
    fl.set_simd(None)
    fl.set_num_threads(None)


def assert_same(got: fl.InBox, expected: fl.InBox, which: str = "") -> None:
    for name in ("offsets", "prim", "part"):
        a, b = getattr(got, name), getattr(expected, name)
        assert (a is None) == (b is None), which
        assert a is None or (a.dtype == b.dtype and a.tobytes() == b.tobytes()), f"{which} {name}"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", nasty.NAMES)
def test_trees_answer_as_brute_force_does(name: str, kind: str) -> None:
    case = cases(0)[name]
    geometry = KINDS[kind](case.segments)
    low, high = boxes_on(case.segments)
    for to in ("axis", "surface"):
        expected = fl.brute_force_in_box(geometry, low, high, to=to)
        for turn, tree_name in enumerate(TREES):
            if tree_name not in fl.METHODS and kind not in ("segments", "round cones"):
                continue
            tree = build(geometry, **BUILDS[tree_name])
            for simd in fl.available_simd():
                fl.set_simd(simd)
                fl.set_num_threads(1 + 2 * (turn % 2))
                assert_same(tree.in_box(low, high, to=to), expected, f"{tree_name}, {simd}, {to}")
                assert_same(
                    tree.in_box(low[3], high[3], to=to), fl.brute_force_in_box(geometry, low[3], high[3], to=to)
                )
    prim, box = expected.prim_number, expected.box
    assert (np.lexsort((prim, box)) == np.arange(len(prim))).all()
    assert len(set(zip(prim.tolist(), box.tolist(), strict=True))) == len(prim)
    assert len(expected) > 0 or name == "empty"


# ---- Sides, and what touches them ----


def test_sides_belong_to_the_box() -> None:
    box = [0, 0, 0], [1, 1, 1]
    lines = fl.build(
        [
            [[1, 0.5, 0.5], [2, 0.5, 0.5]],  # ends on a side
            [[-1, 1, 0.5], [2, 1, 0.5]],  # along a side
            [[2, 0, 0.5], [0, 2, 0.5]],  # through an edge
            [[3, -2, 1], [-1, 6, 1]],  # passes by
            [[1, 1, 1], [1, 1, 1]],  # a point on a corner
            [[0.25, 0.25, 0.25], [0.5, 0.5, 0.75]],  # inside
        ]
    )
    assert lines.in_box(*box).prim.tolist() == [0, 1, 2, 4, 5]
    spheres = fl.Spheres.from_centres([[2, 0.5, 0.5], [-3, -4, 0.5], [-3, -4, 0.5]], radius=[1, 5, np.float32(4.9999)])
    assert fl.build(spheres).in_box(*box).prim.tolist() == [0, 1]
    assert fl.build(spheres).in_box(*box, to="axis").prim.tolist() == []
    triangles = fl.Triangles(
        [
            [[1, 1, 1], [2, 2, 1], [2, 1, 1]],  # a corner on a corner
            [[-9, -9, 0.5], [9, -9, 0.5], [0, 20, 0.5]],  # cuts it, all edges outside
            [[1.5, 1, 0], [1, 1.5, 0], [3, 3, 9]],  # beyond an edge, though its box is not
            [[3, 0, 0], [0, 3, 0], [0, 0, 3]],  # the plane touches the corner
        ]
    )
    assert fl.build(triangles).in_box(*box).prim.tolist() == [0, 1, 3]
    boxes = fl.Boxes([[[1, 1, 1], [2, 2, 2]], [[1.001, 0, 0], [2, 1, 1]], [[-9, -9, -9], [9, 9, 9]]])
    assert fl.build(boxes).in_box(*box).prim.tolist() == [0, 2]


def test_a_tapered_line_is_in_by_its_side() -> None:
    """The ball that is nearest is not the one around the nearest point of the axis."""
    cone = fl.Lines.from_segments([[[0, 0, 0], [4, 0, 0]]], radius=[[2.0, 0.0]])
    tree = fl.build(cone)
    # The side of the cone is at a distance of 2 from the axis at its start, and leans to the end.
    s = np.linspace(0, 1, 100_001)
    x, y = 2.5, 0.8
    reach = (2 - 2 * s) - np.hypot(4 * s - x, y)
    assert reach.max() > 0 > (2 - 2 * x / 4) - y
    assert tree.in_box([x, y, 0], [x, y, 0]).prim.tolist() == [0]
    assert tree.in_box([x, 0.9, 0], [x, 0.9, 0]).prim.tolist() == []


def test_half_spaces_and_all_of_space() -> None:
    segments = cases(4)["random"].segments
    tree = fl.build(segments)
    x = segments[..., 0]
    assert (tree.in_box([0.25, -INF, -INF], INF).prim == np.flatnonzero((x >= 0.25).any(axis=1))).all()
    assert (tree.in_box(-INF, [0.25, INF, INF]).prim == np.flatnonzero((x <= 0.25).any(axis=1))).all()
    assert (tree.in_box(-INF, INF).prim == np.arange(len(segments))).all()
    assert (tree.in_box(-1e300, 1e300).prim == np.arange(len(segments))).all()
    assert len(tree.in_box(1e300, INF)) == 0


def test_many_boxes_at_once_and_shapes() -> None:
    rng = np.random.default_rng(5)
    segments = rng.random((3000, 2, 3)) * 0.02 + rng.random((3000, 1, 3))
    tree = fl.build(segments)
    low = rng.random((5000, 3))
    found = tree.in_box(low.reshape(50, 100, 3), low.reshape(50, 100, 3) + 0.05)
    assert len(found.offsets) == 5001
    assert_same(found, fl.brute_force_in_box(segments, low, low + 0.05))
    for i in (0, 77, 4999):
        assert (tree.in_box(low[i], low[i] + 0.05).prim == found.prim[found.of(i)]).all()
    assert_same(tree.in_box(0.5, low + 0.5), tree.in_box(np.full((5000, 3), 0.5), low + 0.5))
    assert len(tree.in_box(np.zeros((0, 3)), 1).offsets) == 1
    assert len(tree.in_box([], []).offsets) == 1


# ---- Kinds ----


def test_curves_and_shapes_are_listed_once() -> None:
    rng = np.random.default_rng(6)
    curves = fl.Curves.from_bezier(np.cumsum(rng.normal(size=(9, 4, 3)), axis=1), 0.1, strands=np.arange(9) // 2)
    mesh = fl.Triangles(rng.random((50, 3, 3)))
    found = fl.build(curves).in_box(-INF, INF)
    assert found.prim.tolist() == list(range(9))
    assert found.strands().tolist() == [0, 1, 2, 3, 4]
    both = fl.Geometry([mesh, curves])
    for method in ("best", "kd-d2"):
        found = fl.build(both, method).in_box([[-INF] * 3, [0.4] * 3], [INF, INF, INF])
        assert found.prim[found.of(0)].tolist() == [*range(50), *range(9)]
        assert found.part is not None
        assert found.part[found.of(0)].tolist() == [0] * 50 + [1] * 9
        assert found.strand[found.of(0)].tolist() == [-1] * 50 + (np.arange(9) // 2).tolist()
        assert_same(found, fl.brute_force_in_box(both, [[-INF] * 3, [0.4] * 3], INF))
        with pytest.raises(fl.InputError, match="each part of a Geometry counts its own strands"):
            found.strands()
    pieces = fl.brute_force_in_box(curves.pieces.lines, [0, 0, 0], [1, 1, 1])
    assert fl.build(curves).in_box([0, 0, 0], [1, 1, 1]).prim.tolist() == sorted({*curves.pieces.curve[pieces.prim]})


def test_a_class_of_ones_own_needs_a_method() -> None:
    segments = cases(0)["random"].segments
    told = r"Balls has no method in_box\(ids, low, high\), which returns whether each primitive has a point in a box"
    with pytest.raises(fl.InputError, match=told):
        fl.build(Balls(segments)).in_box(0, 1)
    with pytest.raises(fl.InputError, match=told):
        fl.brute_force_in_box(Balls(segments), 0, 1)

    class Wrong(Balls):
        def in_box(self, ids: Any, low: Any, high: Any) -> Any:
            return np.ones(len(ids))

    with pytest.raises(fl.InputError, match=r"Wrong.in_box\(\) returned float64 of shape \(40,\); expected bool of"):
        fl.build(Wrong(segments)).in_box(-INF, INF)


def test_far_from_zero_in_the_coordinates_of_the_map() -> None:
    rng = np.random.default_rng(7)
    strands = np.cumsum(rng.normal(size=(20, 30, 3)), axis=1)
    offset = np.array([500_000.0, 5_300_000, 0])
    far = fl.Lines.from_strands(strands + offset, offset="auto")
    moved = np.array(far.offset)
    low, high = boxes_on(far.segments + moved, 7)
    tree = fl.build(far)
    found = tree.in_box(low, high)
    assert_same(found, fl.brute_force_in_box(far, low, high))
    assert_same(found, fl.brute_force_in_box(far.segments, low - moved, high - moved))
    with pytest.warns(fl.PrecisionWarning, match="low corners are float32"):
        tree.in_box(far.bounds[0] + moved.astype(np.float32), INF)


def test_an_empty_tree_and_a_tree_of_one() -> None:
    empty = fl.build(np.zeros((0, 2, 3)))
    found = empty.in_box([[0, 0, 0], [1, 1, 1]], 2)
    assert (found.offsets.tolist(), found.prim.tolist(), found.strands().tolist()) == ([0, 0, 0], [], [])
    assert len(fl.build(np.zeros((1, 2, 3))).in_box(0, 0)) == 1
    assert len(fl.build(np.zeros((1, 2, 3))).in_box(1e-30, 1)) == 0


def test_after_a_refit() -> None:
    segments = cases(0)["random"].segments
    tree = fl.build(segments).refit(segments[:, ::-1] * np.float32(0.5))
    low, high = boxes_on(segments * 0.5, 8)
    assert_same(tree.in_box(low, high), fl.brute_force_in_box(tree.geometry, low, high))


# ---- The answer ----


def test_the_answer_names_what_it_found() -> None:
    lines = fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 5, 0], [1, 5, 0]], [[0, 9, 0], [1, 9, 0]]])
    found = fl.build(lines).in_box([[0.5, -1, -1], [0.5, -1, -1], [7, 7, 7]], [[3, 6, 1], [0.7, 1, 1], [8, 8, 8]])
    assert repr(found) == "<InBox: 3 boxes, 4 primitives>"
    assert found.counts.tolist() == [3, 1, 0]
    assert found.strand.tolist() == [0, 0, 1, 0]
    assert found.row.tolist() == found.prim.tolist() == [0, 1, 2, 0]
    assert (found.strands().tolist(), found.strands(1).tolist(), found.strands(2).tolist()) == ([0, 1], [0], [])
    assert lines.select(strands=found.strands()).n_strands == 2
    with pytest.raises(fl.InputError, match="box=3; expected a whole number from 0 to below 3, the number of boxes"):
        found.of(3)
    for box in (1.5, "a", None, True):
        with pytest.raises(fl.InputError, match="expected a whole number from 0 to below 3"):
            found.of(box)
    kept = pickle.loads(pickle.dumps(found))
    assert kept.geometry is None
    assert (kept.strand == found.strand).all()


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        ([0, np.nan, 0], 1, "the box reaches from nan to 1 along y; expected low <= high, and no NaN"),
        ([0, 0, 2], [1, 1, 1], "the box reaches from 2 to 1 along z"),
        ([[0, 0, 0], [0, 3, 0]], [1, 1, 1], "box 1 of 2 reaches from 3 to 1 along y"),
        (INF, INF, "the box reaches from inf to inf along x"),
        ([0, 0], [1, 1], r"low has shape \(2,\); expected \(…, 3\)"),
        (np.zeros((2, 3)), np.ones((4, 3)), r"low \(2, 3\) and high \(4, 3\) do not match"),
        ("left", 1, "low"),
    ],
)
def test_bad_boxes_are_refused(low: Any, high: Any, told: str) -> None:
    with pytest.raises(fl.InputError, match=told):
        fl.build(np.zeros((1, 2, 3))).in_box(low, high)


def test_other_bad_input() -> None:
    tree = fl.build(np.zeros((1, 2, 3)))
    with pytest.raises(fl.InputError, match="to='middle'"):
        tree.in_box(0, 1, to="middle")
    with pytest.raises(fl.InputError, match="progress='no'"):
        tree.in_box(0, 1, progress="no")  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["segments", "one's own"])
def test_progress_rises_and_can_end_the_call(kind: str) -> None:
    rng = np.random.default_rng(8)
    geometry = KINDS[kind](rng.random((2000, 2, 3)))
    tree, done = fl.build(geometry), list[float]()
    low = rng.random((3000, 3)) * 0.5
    tree.in_box(low, low + 0.5, progress=done.append)
    assert done[-1] == 1.0
    assert done == sorted(done)

    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fl.brute_force_in_box(geometry, np.tile(low, (40, 1)), 1, progress=stop)


def test_more_than_memory_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory_check, "left_memory", lambda: 1e9)
    tree = fl.build(np.random.default_rng(9).random((3000, 2, 3)))
    says = r"in 400,000 boxes does not fit .*sample of .* boxes .* 1.0 GB are left; ask for fewer or smaller boxes"
    with num_threads(1), pytest.raises(MemoryError, match=says):
        tree.in_box(np.full((400_000, 3), -1.0), 1)
