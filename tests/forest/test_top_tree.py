"""The top tree: no tile that a ray, a point or a box has to do with is left out."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.forest.top_tree import TopTree
from fastlines.query.proximity.point_arguments import PointArguments
from fastlines.query.proximity.points import PointBatch, check_points
from fastlines.query.queries import check_query
from fastlines.query.ray_arguments import RayArguments
from fastlines.query.rays import RayBatch

N_TILES = 70


def top_and_scene(radius: float) -> tuple[TopTree, fl.Lines]:
    """Return a top tree of tiles of one segment each."""
    rng = np.random.default_rng(2)
    segments = (rng.random((N_TILES, 1, 3)) + rng.normal(0, 0.1, (N_TILES, 2, 3))).astype(np.float32)
    lines = fl.Lines.from_segments(segments, radius=np.full(N_TILES, radius, np.float32) if radius else None)
    boxes = np.stack([segments.min(axis=1), segments.max(axis=1)], axis=1)
    return TopTree(boxes, np.full(N_TILES, radius, np.float32), lines.bounds), lines


def some_rays(lines: fl.Lines, spread: float) -> RayBatch:
    rng = np.random.default_rng(3)
    origins, targets = rng.uniform(-1, 2, (300, 3)), rng.random((300, 3))
    given = RayArguments(origins, targets - origins, 0.05, t_min=0.2, spread=spread)
    return check_query(lines, lines.bounds, given)


def some_points(lines: fl.Lines) -> PointBatch:
    points = np.random.default_rng(4).uniform(-1, 2, (200, 3))
    return check_points(lines, lines.bounds, PointArguments(points, 0.3, "radius"))


@pytest.mark.parametrize("spread", [0.0, 0.05])
@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_rays_are_routed_to_all_tiles_that_they_hit(radius: float, spread: float) -> None:
    top, lines = top_and_scene(radius)
    rays = some_rays(lines, spread)
    offsets, tile, enter = top.tiles_of_rays(rays)
    hits = fl.brute_force(lines, rays.origins, rays.directions, 0.05, t_min=0.2, spread=spread)
    assert len(hits.t) > 300
    first = top.first_tile(rays)
    for ray in range(len(rays)):
        row = slice(offsets[ray], offsets[ray + 1])
        assert (np.diff(enter[row]) >= 0).all()
        assert first[ray] == (tile[row][0] if len(tile[row]) else -1)
        earliest = dict(zip(tile[row].tolist(), enter[row].tolist(), strict=True))
        for prim, t in zip(
            *(column[hits.offsets[ray] : hits.offsets[ray + 1]] for column in (hits.prim, hits.t)), strict=True
        ):
            assert earliest[int(prim)] <= t
    assert len(tile) < (0.7 if spread else 0.3) * N_TILES * len(rays)


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_tiles_near_points(radius: float) -> None:
    top, lines = top_and_scene(radius)
    points = some_points(lines)
    found = fl.brute_force_points(lines, points.points, k=N_TILES)
    order = np.argsort(found.prim, axis=1)
    distance = np.take_along_axis(found.distance, order, axis=1)
    lower, tile = top.nearest_tiles(points, N_TILES)
    assert (np.sort(tile, axis=1) == np.arange(N_TILES)).all()
    assert (np.diff(lower, axis=1) >= 0).all()
    assert (lower <= np.take_along_axis(distance, tile, axis=1)).all()
    three, of_three = top.nearest_tiles(points, 3)
    assert np.array_equal(three, lower[:, :3])
    assert np.array_equal(of_three, tile[:, :3])
    more, none = top.nearest_tiles(points, N_TILES + 1)
    assert (more[:, -1] == np.inf).all()
    assert (none[:, -1] == -1).all()
    offsets, within = top.tiles_within(points, points.radius)
    for i in range(len(points)):
        row = set(within[offsets[i] : offsets[i + 1]].tolist())
        assert set(np.flatnonzero(distance[i] <= points.radius[0]).tolist()) <= row
        assert row == set(tile[i][lower[i] <= points.radius[0]].tolist())


def test_tiles_in_boxes() -> None:
    top, _ = top_and_scene(0.05)
    rng = np.random.default_rng(5)
    low = rng.uniform(-0.5, 1, (100, 3))
    high = low + rng.random((100, 3)) * 0.3
    offsets, tile = top.tiles_in_boxes(low, high)
    for i in range(100):
        meets = ((top.boxes[:, 0] - 0.05 <= high[i]) & (top.boxes[:, 1] + 0.05 >= low[i])).all(axis=1)
        # A corner of a grown box is farther than the radius.
        gap = np.maximum(np.maximum(top.boxes[:, 0] - high[i], low[i] - top.boxes[:, 1]), 0)
        near = np.sqrt((gap**2).sum(axis=1)) <= 0.05
        row = set(tile[offsets[i] : offsets[i + 1]].tolist())
        assert set(np.flatnonzero(near).tolist()) <= row <= set(np.flatnonzero(meets | near).tolist())


def test_no_tiles() -> None:
    top = TopTree(np.zeros((0, 2, 3), np.float32), np.zeros(0, np.float32), np.zeros((2, 3), np.float32))
    _, lines = top_and_scene(0.0)
    assert top.first_tile(some_rays(lines, 0.0)).tolist() == [-1] * 300
    assert top.nearest_tiles(some_points(lines), 1)[1].tolist() == [[-1]] * 200
