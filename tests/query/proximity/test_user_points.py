"""Queries about points on a class of one's own: its method `nearest`, what that may return, and when it is called."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.answers import assert_same
from support.builds import Balls

import fastlines as fl
from fastlines.query.proximity import user_points

RNG = np.random.default_rng(0)
SEGMENTS = RNG.uniform(-1, 1, (300, 1, 3)) + RNG.normal(0, 0.05, (300, 2, 3))


class Counting(Balls):
    """Balls that count the pairs for which `nearest` is called."""

    n_pairs = 0

    def nearest(self, ids: Any, points: Any) -> Any:
        self.n_pairs += len(ids)
        return super().nearest(ids, points)


def test_boxes_are_asked_in_the_order_of_their_distance() -> None:
    balls, points = Counting(SEGMENTS), RNG.uniform(-1, 1, (200, 3))
    tree = fl.build(balls)
    for k in (1, 3, 20):
        balls.n_pairs = 0
        got = tree.nearest(points, k)
        assert balls.n_pairs < len(points) * (4 * k + 40)
        assert_same(got, fl.brute_force_points(balls, points, k=k))
    balls.n_pairs = 0
    got = tree.within(points, 0.1)
    assert balls.n_pairs < len(points) * 60
    assert_same(got, fl.brute_force_points(balls, points, 0.1, query="within"))
    assert_same(tree.count_within(points, 0.1), got.counts)


def test_a_point_deep_inside_many_boxes() -> None:
    """All boxes are at distance 0, and the deepest ball is the last."""
    balls = Balls(np.zeros((100, 2, 3)))
    balls.own = np.linspace(1, 2, 100)
    tree = fl.build(balls)
    found = tree.nearest([[0, 0, 0], [0.5, 0, 0], [5, 0, 0]], 2)
    assert found.prim.tolist() == [[99, 98]] * 3
    assert found.distance[:, 0].tolist() == [-2, -1.5, 3]
    np.testing.assert_allclose(np.linalg.norm(found.points()[:, 0], axis=1), 2)
    assert tree.count_within([0, 0, 0], 0) == 100
    assert tree.count_within([3, 0, 0], 1.5) == 50


def test_small_parts_are_joined(monkeypatch: pytest.MonkeyPatch) -> None:
    """Points are taken in parts, each of few pairs."""
    balls, points = Balls(SEGMENTS), RNG.uniform(-1, 1, (50, 3))
    tree, each = fl.build(balls), RNG.uniform(0, 0.5, 50)
    nearest, within = tree.nearest(points, 5, max_distance=each), tree.within(points, each)
    monkeypatch.setattr(user_points, "CHUNK_PAIRS", 100)
    shares: list[float] = []
    assert_same(tree.nearest(points, 5, max_distance=each, progress=shares.append), nearest)
    assert len(shares) > 5
    assert shares == sorted(shares)
    assert_same(tree.within(points, each), within)
    assert_same(fl.brute_force_points(balls, points, k=5, max_distance=each), nearest)


def test_clipped_boxes_count_once() -> None:
    class Rings(Balls):
        def __init__(self) -> None:
            angle = np.linspace(0, 2 * np.pi, 400)
            self.ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
            self.heights = np.arange(5.0)

        def bounds(self) -> Any:
            return np.array([[[-1.05, -1.05, h - 0.05], [1.05, 1.05, h + 0.05]] for h in self.heights])

        def clipped_bounds(self, ids: Any, boxes: Any) -> Any:
            places = self.ring + self.heights[ids, None, None] * [0, 0, 1]
            inside = ((places + 0.07 >= boxes[:, None, 0]) & (places - 0.07 <= boxes[:, None, 1])).all(axis=-1)
            low = np.where(inside[..., None], places - 0.05, np.inf).min(axis=1)
            return np.stack([low, np.where(inside[..., None], places + 0.05, -np.inf).max(axis=1)], axis=1)

        def nearest(self, ids: Any, points: Any) -> Any:
            across = np.hypot(points[:, 0], points[:, 1]) - 1
            u = np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) % 1
            return {"distance": np.hypot(across, points[:, 2] - self.heights[ids]) - 0.05, "u": u}

    rings, points = Rings(), RNG.uniform(-1.5, 5, (300, 3))
    tree = fl.build(rings)
    assert tree.n_prims > 10
    for query, how in (
        ("nearest", {}),
        ("nearest", {"k": 4}),
        ("within", {"radius": 1.5}),
        ("count_within", {"radius": 1}),
    ):
        got = getattr(tree, query)(points, **how)
        assert_same(got, fl.brute_force_points(rings, points, query=query, **how))
    assert tree.nearest([0, 3, 0]).u == 0.25
    with pytest.raises(fl.InputError, match=r"Rings.nearest\(\) returned no 'point'; for points\(\), return a mapping"):
        tree.nearest(points).points()


class Given:
    """One box, and an answer that is given."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def bounds(self) -> Any:
        return [[[0.0, 0, 0], [1, 1, 1]]]

    def hit(self, ids: Any, rays: Any, radius: Any) -> Any:
        return np.full(len(ids), np.nan)

    def nearest(self, ids: Any, points: Any) -> Any:
        return self.answer(ids)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (lambda ids: np.zeros(7), r"nearest\(\) returned 'distance' of shape \(7,\); expected \(1,\)"),
        (lambda ids: {"u": ids}, r"returned no 'distance'; expected 'distance', and perhaps 'u' and 'point'"),
        (lambda ids: {"distance": ids, "t": ids}, "returned 't'"),
        (lambda ids: {"distance": ids, "point": ids}, r"returned 'point' of shape \(1,\)"),
    ],
)
def test_classes_are_told_what_is_wrong(answer: Any, words: str) -> None:
    for query in (lambda tree: tree.nearest([2, 0, 0]), lambda tree: tree.within([2, 0, 0], 9)):
        with pytest.raises(fl.InputError, match=words):
            query(fl.build(Given(answer)))


def test_no_distance_is_a_miss() -> None:
    for none in (np.nan, np.inf, -np.inf, 1e300):
        tree = fl.build(Given(lambda ids, none=none: np.full(len(ids), none)))
        assert tree.nearest([2, 0, 0]).prim == -1
        assert tree.count_within([2, 0, 0], 9) == 0


def test_a_class_without_the_method_is_told_so() -> None:
    class Deaf(Given):
        nearest = None  # type: ignore[assignment]

    deaf = Deaf(None)
    words = r"Deaf has no method nearest\(ids, points\), which returns the distance .*; add it for queries about points"
    for points in ([2, 0, 0], np.empty((0, 3))):
        with pytest.raises(fl.InputError, match=words):
            fl.build(deaf).nearest(points)
        with pytest.raises(fl.InputError, match=words):
            fl.brute_force_points(deaf, points, 1, query="within")
