"""Answers about points: how they relate, their ties, shapes, points, attributes, and what is left out."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import assert_same
from support.builds import ALL_KINDS
from support.emulated_device import DeviceArray

import fastlines as fl
from fastlines.cuda.choice import use_device
from fastlines.query import memory_check
from fastlines.query.proximity import queries
from fastlines.threads import num_threads

RNG = np.random.default_rng(0)
STRANDS = fl.Lines.from_strands(
    [[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 5, 0], [1, 5, 0]]], attributes={"fa": [[0.0], [1], [3], [5], [6]]}
)
TREE = fl.build(STRANDS)


@pytest.mark.parametrize("to", ["axis", "surface"])
@pytest.mark.parametrize("kind", ALL_KINDS)
def test_how_answers_relate(kind: str, to: str) -> None:
    made = ALL_KINDS[kind](nasty.named_scene("hair", 60))
    tree, points = fl.build(made), RNG.uniform(-1, 1, (50, 3))
    radius = np.float32(0.5)
    first, some = tree.nearest(points, to=to), tree.nearest(points, 7, to=to)
    assert_same(some.prim[:, 0], first.prim)
    assert (np.diff(some.distance, axis=1) >= 0).all()
    within, wider = tree.within(points, radius, to=to), tree.within(points, 2 * radius, to=to)
    assert (within.distance <= radius).all()
    assert_same(tree.count_within(points, radius, to=to), within.counts)
    limited = tree.nearest(points, 7, to=to, max_distance=radius)
    assert (limited.hit.sum(axis=1) == np.minimum(within.counts, 7)).all()
    for i in range(len(points)):
        found, of_wider = within.prim_number[within.of(i)], wider.prim_number[wider.of(i)]
        assert len(set(found)) == len(found)
        assert set(found) <= set(of_wider)
        n = min(7, len(found))
        assert (found[:n] == some.prim_number[i, :n]).all()
        assert (within.distance[within.of(i)][:n] == some.distance[i, :n]).all()
        # Ranked by distance, then by id.
        rank = list(zip(within.distance[within.of(i)], found, strict=True))
        assert rank == sorted(rank)


def test_ties_at_joints_go_to_the_lower_id() -> None:
    points = STRANDS.segments[:, 1] + np.float32([0.25, 0.25, 0])  # beyond the joint of the first two
    found = TREE.nearest([[1, 0.25, 0], [1, -3, 7], points[1], [1, 0, 0]], 2)
    assert found.prim[:2].tolist() == [[0, 1], [0, 1]]
    assert (found.distance[:2, 0] == found.distance[:2, 1]).all()
    assert found.u[:2].tolist() == [[1, 0], [1, 0]]
    assert found.prim[3].tolist() == [0, 1]
    assert found.distance[3].tolist() == [0, 0]
    # Everywhere around a joint, also in the wedge where both ends are nearest.
    rng = np.random.default_rng(2)
    bent = fl.Lines.from_strands([rng.normal(0, 1, (3, 3)) for _ in range(200)])
    ends = bent.segments[::2, 1].astype(np.float64)
    e0, e1 = bent.segments[::2, 1] - bent.segments[::2, 0], bent.segments[1::2, 1] - bent.segments[1::2, 0]
    away = rng.normal(0, 0.01, (200, 3))
    is_wedge = ((away * e0).sum(axis=1) > 0) & ((away * e1).sum(axis=1) < 0)
    assert is_wedge.sum() > 30
    found = fl.build(bent).nearest(ends + away, 2)
    own = np.arange(200)[:, None] * 2 + [0, 1]
    tied = is_wedge & (np.sort(found.prim, axis=1) == own).all(axis=1)
    assert tied.sum() > 30
    assert (found.prim[tied] == own[tied]).all()
    assert (found.distance[tied, 0] == found.distance[tied, 1]).all()


def test_shapes_follow_those_of_the_points() -> None:
    for shape in ((), (1,), (4,), (2, 3), (0,), (3, 0)):
        points = RNG.random((*shape, 3))
        for k in (1, 2, 0, 5):
            found = TREE.nearest(points, k)
            expected = shape if k == 1 else (*shape, k)
            assert found.prim.shape == found.u.shape == found.distance.shape == found.strand.shape == expected
            assert found.points().shape == found.tangents().shape == (*expected, 3)
            assert (found.prim.dtype, found.u.dtype, found.distance.dtype) == (np.int64, np.float32, np.float32)
            # Three primitives at most: the rest are misses.
            assert (found.hit.sum(axis=-1) == min(k, 3)).all() or k == 1
        assert TREE.count_within(points, 1).shape == shape
        assert TREE.count_within(points, 1).dtype == np.int64
        within = TREE.within(points, 9.0)
        assert len(within.offsets) == points.size // 3 + 1
        assert len(within) == points.size


def test_a_miss() -> None:
    found = TREE.nearest([[9, 9, 9], [0.5, 0, 0]], 2, max_distance=[1, 0])
    assert found.prim.tolist() == [[-1, -1], [0, -1]]
    assert found.distance.tolist() == [[np.inf, np.inf], [0, np.inf]]
    assert found.u.tolist() == [[0, 0], [0.5, 0]]
    assert found.row.tolist() == found.strand.tolist() == found.prim.tolist()
    assert np.isnan(found.points()[0]).all()
    assert np.isnan(found.sample("fa")[0]).all()
    assert found.sample("fa")[1, 0].tolist() == [0.5]
    assert found.points()[1, 0].tolist() == [0.5, 0, 0]


def test_an_empty_tree_has_nothing_near() -> None:
    for made in (np.empty((0, 2, 3)), fl.Triangles([]), fl.Geometry([]), ALL_KINDS["one's own"](np.empty((0, 2, 3)))):
        for points in (np.zeros(3), np.full((2, 3), 1e20), np.empty((0, 3))):
            tree = fl.build(made)
            assert (tree.nearest(points, 2).prim == -1).all()
            assert len(tree.within(points, 1e9)) == 0
            assert (tree.count_within(points, 1) == 0).all()
            assert_same(tree.nearest(points), fl.brute_force_points(made, points))


def test_a_surface_is_nearer_than_its_axis() -> None:
    thick = fl.Lines.from_segments([[[0, 0, 0], [4, 0, 0]], [[0, 0, 9], [4, 0, 9]]], radius=[[0.5, 1.5], [2, 2]])
    tree = fl.build(thick)
    for to in (None, "surface"):
        found = tree.nearest([[2, 0, 5.5], [2, 0, 0.25], [2, 0, 0]], to=to)
        assert found.prim.tolist() == [1, 0, 0]
        assert found.distance[0] == 1.5
        assert (found.distance[1:] < 0).all()
        # The point of the surface is as far away as the distance says.
        away = np.linalg.norm(found.points() - [[2, 0, 5.5], [2, 0, 0.25], [2, 0, 0]], axis=1)
        np.testing.assert_allclose(away, np.abs(found.distance), rtol=1e-6)
    axis = tree.nearest([[2, 0, 5.5], [2, 0, 4]], to="axis")
    assert (axis.prim.tolist(), axis.distance.tolist()) == ([1, 0], [3.5, 4])
    assert axis.points().tolist() == [[2, 0, 9], [2, 0, 0]]
    # A point on the axis has no direction to the surface: any across the axis is taken.
    on_axis = tree.nearest([2, 0, 9])
    np.testing.assert_allclose(np.linalg.norm(on_axis.points() - [2, 0, 9]), 2)
    assert on_axis.points()[0] == 2
    ball = fl.build(fl.Spheres.from_centres([[1, 2, 3]], 0.5))
    assert ball.nearest([1, 2, 3]).distance == -0.5
    assert np.linalg.norm(ball.nearest([1, 2, 3]).points() - [1, 2, 3]) == 0.5
    # Lines without a radius have their axes alone.
    assert_same(TREE.nearest([1, 2, 3], to="surface"), TREE.nearest([1, 2, 3]))


def test_triangles_and_boxes() -> None:
    uv = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    mesh = fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], corner_attributes={"uv": [uv]}, attributes={"id": [7]})
    box = fl.Boxes([[[2, 0, 0], [3, 1, 1]]])
    tree = fl.build(fl.Geometry([mesh, box]))
    points = [[0.25, 0.5, 2], [-1, -1, 0], [2.5, 0.5, 0.25], [4, 0.5, 0.5]]
    found = tree.nearest(points)
    assert found.part is not None
    assert (found.part.tolist(), found.prim.tolist(), found.prim_number.tolist()) == (
        [0, 0, 1, 1],
        [0] * 4,
        [0, 0, 1, 1],
    )
    np.testing.assert_allclose(found.distance, [2, np.sqrt(2), 0, 1])
    assert found.points().tolist() == [[0.25, 0.5, 0], [0, 0, 0], [2.5, 0.5, 0.25], [3, 0.5, 0.5]]
    np.testing.assert_allclose(found.sample("uv")[:2], [[0.25, 0.5], [0, 0]])
    assert found.sample("id")[:2].tolist() == [7, 7]
    assert np.isnan(found.tangents()).all()
    assert tree.nearest(points, parts=1).part.tolist() == [1] * 4  # type: ignore[union-attr]
    assert tree.count_within(points, 10, parts=[0]).tolist() == [1] * 4


def test_curves_answer_once_with_their_parameter() -> None:
    arch = fl.Curves.from_bezier(
        [[[0, 0, 0], [0, 0, 4], [3, 0, 4], [3, 0, 0]], [[0, 5, 0], [1, 5, 0], [2, 5, 0], [3, 5, 0]]], radius=0.05
    )
    tree = fl.build(arch)
    found = tree.nearest([[1.5, 0, 1], [1.5, 4, 0]], 4)
    assert found.prim.tolist() == [[0, 1, -1, -1], [1, 0, -1, -1]]
    assert tree.within([1.5, 0, 1], 9).prim.tolist() == [0, 1]
    assert tree.count_within([1.5, 0, 1], 9) == 2
    at = arch.evaluate(0, found.u[0, 0])
    away = np.array([1.5, 0, 1]) - at.points
    np.testing.assert_allclose(found.points()[0, 0], at.points + 0.05 * away / np.linalg.norm(away), atol=1e-6)
    assert abs(found.tangents()[0, 0] @ away) < 0.02
    assert tree.nearest([1.5, 0, 1], ignore=0).prim == 1


@pytest.mark.parametrize("kind", ["lines", "curves", "geometry", "own"])
def test_what_is_ignored_is_as_if_it_were_not_there(kind: str) -> None:
    rng = np.random.default_rng(6)
    segments = rng.random((60, 1, 3)) + rng.normal(0, 0.2, (60, 2, 3))
    strands, radius = np.arange(60) // 4, rng.random(60).astype(np.float32) * 0.1

    def make(keep: Any) -> Any:
        if kind == "own":
            balls = ALL_KINDS["one's own"](segments)
            balls.centre, balls.own = balls.centre[keep], radius[keep].astype(np.float64)
            return balls
        if kind == "curves":
            control = np.einsum("ij,njk->nik", [[1, 0], [0.6, 0.5], [0.3, 0.6], [0, 1]], segments[keep])
            return fl.Curves.from_bezier(control, radius[keep], strands=strands[keep])
        lines = fl.Lines.from_segments(segments[keep], radius=radius[keep], strands=strands[keep])
        return fl.Geometry([lines]) if kind == "geometry" else lines

    points = rng.random((80, 3))
    dropped = rng.permutation(60)[:25]
    kept = np.setdiff1d(np.arange(60), dropped)
    tree, without = fl.build(make(np.arange(60))), fl.build(make(kept))
    for query, how in (("nearest", {}), ("nearest", {"k": 5}), ("within", {"radius": 0.2})):
        expected = getattr(without, query)(points, **how)
        for each in (dropped, np.broadcast_to(dropped, (80, 25))):
            got = getattr(tree, query)(points, **how, ignore=each)
            assert np.array_equal(got.prim, np.where(expected.prim >= 0, kept[expected.prim], -1))
            # Frames differ without some lines, so the last bits may.
            np.testing.assert_allclose(got.distance, expected.distance, rtol=1e-5, atol=1e-6)
    first = tree.nearest(points)
    second = tree.nearest(points, 2)
    assert np.array_equal(tree.nearest(points, ignore=first).prim_number, second.prim_number[:, 1])
    if kind != "own":
        others = tree.nearest(points, 3, ignore_strands=first)
        assert (others.strand != first.strand[:, None]).all()


def test_rows_of_the_input_are_counted() -> None:
    segments = np.zeros((3, 2, 3)) + np.arange(3)[:, None, None]
    segments[0, 0, 0] = np.nan
    tree = fl.build(fl.Lines.from_segments(segments, invalid="skip"))
    found = tree.nearest([[1, 1, 1], [2, 2, 2]])
    assert (found.prim.tolist(), found.row.tolist()) == ([0, 1], [1, 2])


def test_pickles_and_copies() -> None:
    points = [[1.5, 0.5, 0], [np.nan, 0, 0], [0.5, 4, 0]]
    for found in (TREE.nearest(points, 2, invalid="skip"), TREE.within(points, 2, invalid="skip")):
        back = pickle.loads(pickle.dumps(found))
        assert_same(back, found)
        assert np.array_equal(back.strand, found.strand)
        assert back.geometry is None
        assert back.query_points is None
        for ask in (back.points, back.tangents, lambda back=back: back.sample("fa")):
            with pytest.raises(fl.InputError, match="does not know its geometry"):
                ask()
        for copied in (copy.copy(found), copy.deepcopy(found)):
            assert_same(copied, found)
            np.testing.assert_array_equal(copied.points(), found.points())
        assert len(pickle.dumps(found)) < 3000
    assert repr(TREE.nearest(points, 2, invalid="skip")) == "<Nearest: 3 points, 4 answers>"
    assert repr(TREE.nearest(points[:1])) == "<Nearest: 1 point, 1 answer>"
    assert repr(TREE.within(points, 2, invalid="skip")) == "<Within: 3 points, 3 primitives>"


def test_points_do_not_change_with_the_caller_s_array() -> None:
    points = np.array([[0.5, 1.0, 0]])
    found = fl.build(fl.Spheres.from_centres([[0, 0, 0]], 0.5)).nearest(points)
    expected = found.points()
    points[:] = 77
    np.testing.assert_array_equal(found.points(), expected)


def test_invalid_points_are_skipped() -> None:
    points = np.array([[[0.5, 1, 0], [np.nan, 0, 0]], [[np.inf, 0, 0], [1.5, 2, 0]], [[1e30, 0, 0], [0, 5, 1]]])
    radius = np.array([[1, 9], [9, 2], [9, -1.0]])
    valid = np.array([[True, False], [False, True], [False, False]])
    found = TREE.within(points, radius, invalid="skip")
    assert found.skipped.tolist() == [1, 2, 4, 5]
    assert found.counts.tolist() == [1, 0, 0, 1, 0, 0]
    assert found.point.tolist() == [0, 3]
    assert TREE.count_within(points, radius, invalid="skip").tolist() == [[1, 0], [0, 1], [0, 0]]
    nearest = TREE.nearest(points, 3, max_distance=radius, invalid="skip", ignore=np.full((3, 2, 1), -1))
    assert nearest.prim[~valid].max() == -1
    assert_same(nearest.prim[valid], TREE.nearest(points[valid], 3, max_distance=radius[valid]).prim)
    np.testing.assert_array_equal(found.points(), TREE.within(points[valid], radius[valid]).points())


def test_a_refit_answers_for_lines_that_have_moved(tmp_path: Path) -> None:
    segments = nasty.named_scene("hair", 80)
    moved = segments + np.float32(0.3) * segments[:, ::-1]
    points = RNG.uniform(-1, 1, (60, 3))
    for method in ("best", "kd-cl"):
        tree = fl.build(segments, method)
        tree.nearest(points)
        refitted = tree.refit(moved)
        expected = fl.brute_force_points(moved, points, k=4), fl.brute_force_points(moved, points, 0.3, query="within")
        assert_same(refitted.nearest(points, 4), expected[0])
        assert_same(refitted.within(points, 0.3), expected[1])
        refitted.save(tmp_path / "t.flt")
        assert_same(fl.load(tmp_path / "t.flt").nearest(points, 4), expected[0])
        assert_same(pickle.loads(pickle.dumps(refitted)).within(points, 0.3), expected[1])


def test_an_offset_is_subtracted_in_float64() -> None:
    place = np.array([5_300_000.25, 420_000.5, 100])
    lines = fl.Lines.from_strands([np.array([[0, 0, 0], [1e-3, 0, 0]]) + place], offset="auto")
    tree = fl.build(lines)
    point = place + np.array([[0.25e-3, 1e-3, 0]])
    found = tree.nearest(point)
    assert abs(found.distance[0] - 1e-3) < 1e-8
    assert np.abs(found.points() - place - [0.25e-3, 0, 0]).max() < 2e-9
    with pytest.warns(fl.PrecisionWarning, match=r"points are float32, .* give points as float64") as told:
        tree.nearest(place.astype(np.float32))
    assert told[0].filename == __file__
    assert_same(tree.without_offset().nearest(point - lines.offset).prim, found.prim)


def test_a_tree_on_a_gpu_answers_points_on_the_cpu() -> None:
    points = RNG.uniform(0, 2, (9, 3))
    with use_device(object()):  # type: ignore[arg-type]  # no function of it is called
        placed = TREE.to("cuda")
        assert placed.backend == "cuda"
        assert_same(placed.nearest(points, 2), TREE.nearest(points, 2))
        assert_same(placed.within(points, 1), TREE.within(points, 1))
    for tree in (TREE, placed):
        for query in (tree.nearest, lambda given, tree=tree: tree.within(given, 1)):
            with pytest.raises(fl.InputError, match="in the memory of a GPU, and queries about points run on the CPU"):
                query(DeviceArray(points))


# ---- Long calls ----


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch) -> Any:
    return lambda n_bytes: monkeypatch.setattr(memory_check, "left_memory", lambda: n_bytes)


def test_more_answers_than_memory_holds(left: Any) -> None:
    left(1e9)
    points = RNG.uniform(-1, 1, (400_000, 3))
    with pytest.raises(MemoryError, match=r"1,000 answers for each of 400,000 points do not fit .* 6.4 GB, 1.0 GB are"):
        TREE.nearest(points, 1000)
    with pytest.raises(MemoryError, match=r"do not fit into memory.*ask for fewer points or a smaller k"):
        TREE.nearest([0, 0, 0], 10**17)
    tree = fl.build(RNG.uniform(-1, 1, (3000, 2, 3)))

    def tell(share: float) -> None:
        assert share < 0.1

    says = (
        r"within the radius of 400,000 points do not fit .*sample of .* points .* 1.0 GB are left; ask for fewer points"
    )
    with num_threads(1), pytest.raises(MemoryError, match=says):
        tree.within(points, 10.0, progress=tell)


@pytest.mark.parametrize("n_points", [10, 11])
def test_only_large_answers_are_compared_with_the_memory_that_is_left(
    monkeypatch: pytest.MonkeyPatch, n_points: int
) -> None:
    monkeypatch.setattr(queries, "SMALL", 10 * 2 * queries.ANSWER)
    monkeypatch.setattr(queries, "left_bytes", lambda: 0)
    tree, points = fl.build(np.arange(12.0).reshape(2, 2, 3)), np.zeros((n_points, 3))
    if n_points == 10:
        assert tree.nearest(points, k=2).prim.shape == (10, 2)
    else:
        with pytest.raises(MemoryError, match="2 answers for each of 11 points do not fit into memory"):
            tree.nearest(points, k=2)
