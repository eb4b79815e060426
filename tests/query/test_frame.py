"""Trees over the parts of a scene, in the frame of the whole, answer as one tree over all of it, bit for bit."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines.cuda.placed_tree import PlacedTree
from fastlines.errors import InputError

N, N_TILES = 900, 4
KERNELS = ("auto", "single", "wave", "bundle", "binary")
COLUMNS = ("t", "u", "distance", "t_out")


def segments_of(seed: int, far: float = 0.0) -> Any:
    rng = np.random.default_rng(seed)
    starts = rng.uniform(-1, 1, (N, 1, 3)) * [1, 3, 0.4]
    return (np.concatenate([starts, starts + rng.normal(0, 0.15, starts.shape)], axis=1) + far).astype(np.float32)


def lines_of(seed: int, radius: bool, far: float = 0.0) -> fl.Lines:
    radii = np.random.default_rng(seed + 1).uniform(0, 0.04, (N, 2)) if radius else None
    return fl.Lines.from_segments(segments_of(seed, far), radius=radii)


def part_of(lines: fl.Lines, ids: Any) -> fl.Lines:
    return fl.Lines.from_segments(lines.segments[ids], radius=None if lines.radius is None else lines.radius[ids])


def tiles_of(lines: fl.Lines, *args: Any, **given: Any) -> Iterator[tuple[Any, fl.Tree]]:
    """The ids of each tile, which are strips along y, and its tree in the frame of the whole scene."""
    order = np.argsort(lines.segments[:, :, 1].sum(axis=1), kind="stable")
    for ids in map(np.sort, np.array_split(order, N_TILES)):
        yield ids, fl.build(part_of(lines, ids), *args, frame=lines.bounds, **given)


def rays_of(lines: fl.Lines, n: int = 300) -> dict[str, Any]:
    rng = np.random.default_rng(7)
    targets = lines.segments.mean(axis=1)[rng.integers(0, N, n)] + rng.normal(0, 0.02, (n, 3))
    origins = targets + rng.normal(0, 2, (n, 3))
    return {"origins": origins.astype(np.float32), "directions": (targets - origins).astype(np.float32)}


def joined(found: list[tuple[Any, Any]], n_rays: int, columns: tuple[str, ...], key: str) -> list[Any]:
    """The lists of all tiles as those of one tree: sorted by ray, then by the key, then by id."""
    ray = np.concatenate([np.repeat(np.arange(n_rays), np.diff(hits.offsets)) for _, hits in found])
    prim = np.concatenate([ids[hits.prim] for ids, hits in found])
    values = [np.concatenate([getattr(hits, name) for _, hits in found]) for name in columns]
    order = np.lexsort((prim, values[columns.index(key)], ray))
    return [np.searchsorted(ray[order], np.arange(n_rays + 1)), prim[order], *(column[order] for column in values)]


def assert_same(got: list[Any], expected: list[Any]) -> None:
    for a, b in zip(got, expected, strict=True):
        np.testing.assert_array_equal(bits(a), bits(b))


def bits(array: Any) -> Any:
    return array.view(np.uint32) if array.dtype == np.float32 else array


@pytest.mark.parametrize("far", [0.0, 1000.0])
@pytest.mark.parametrize("method", ["best", "kd-cl"])
@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("radius", [False, True])
def test_hits(radius: bool, kernel: str, method: str, far: float) -> None:
    lines = lines_of(3, radius, far)
    rays = rays_of(lines) | {"radius": 0.03, "kernel": kernel}
    whole, tiles = fl.build(lines), [*tiles_of(lines, method)]
    for given in ({}, {"at": "surface"}, {"t_min": 0.3, "t_max": 1.0}, {"spread": 0.01, "radius": 0.0}):
        asked = rays | given
        columns = COLUMNS if given.get("at") == "surface" else COLUMNS[:-1]
        expected = whole.all_hits(**asked)
        assert len(expected.prim) > 100
        got = joined([(ids, tree.all_hits(**asked)) for ids, tree in tiles], len(rays["origins"]), columns, "t")
        assert_same(got, [expected.offsets, expected.prim, *(getattr(expected, name) for name in columns)])
    firsts = [(ids, tree.first_hit(**rays)) for ids, tree in tiles]
    t = np.stack([hits.t for _, hits in firsts])
    prim = np.stack([np.where(hits.prim < 0, N, ids[hits.prim]) for ids, hits in firsts])
    best = np.array([np.lexsort((p, s))[0] for p, s in zip(prim.T, t.T, strict=True)])
    first, each = whole.first_hit(**rays), np.arange(len(best))
    assert_same([np.where(prim[best, each] == N, -1, prim[best, each]), t[best, each]], [first.prim, first.t])


@pytest.mark.parametrize("radius", [False, True])
def test_points(radius: bool) -> None:
    lines = lines_of(5, radius)
    points = np.random.default_rng(1).uniform(-2, 2, (200, 3))
    whole, tiles = fl.build(lines), [*tiles_of(lines)]
    expected = whole.within(points, 0.3)
    assert len(expected.prim) > 100
    got = joined([(ids, tree.within(points, 0.3)) for ids, tree in tiles], len(points), ("distance", "u"), "distance")
    assert_same(got, [expected.offsets, expected.prim, expected.distance, expected.u])


@pytest.mark.parametrize("radius", [False, True])
def test_pairs_and_boxes(radius: bool) -> None:
    lines = lines_of(6, radius)
    whole = fl.build(lines)
    pairs, box = whole.pairs(0.05, skip_neighbours=0), whole.in_box([-0.5, -2, -1], [0.5, 2, 0.1])
    seen = 0
    for ids, tree in tiles_of(lines):
        found = tree.pairs(0.05, skip_neighbours=0)
        rows = np.flatnonzero(np.isin(pairs.i, ids) & np.isin(pairs.j, ids))
        seen += len(rows)
        for name in ("distance", "s", "t"):
            expected = [column[rows] for column in (pairs.i, pairs.j, getattr(pairs, name))]
            assert_same([ids[found.i], ids[found.j], getattr(found, name)], expected)
        np.testing.assert_array_equal(
            ids[tree.in_box([-0.5, -2, -1], [0.5, 2, 0.1]).prim], np.intersect1d(box.prim, ids)
        )
    assert seen > 100


def test_kinds_of_geometry() -> None:
    corners = segments_of(8)[:, [0, 1, 0]] + np.random.default_rng(2).normal(0, 0.1, (N, 3, 3)).astype("f4")
    whole = fl.build(fl.Triangles(corners))
    rays = rays_of(fl.Lines.from_segments(corners[:, :2]))
    expected = whole.all_hits(**rays)
    parts = np.array_split(np.arange(N), 3)
    for method in ("best", "kd-cl"):
        tiles = [(ids, fl.build(fl.Triangles(corners[ids]), method, frame=whole.frame_box)) for ids in parts]
        got = joined([(ids, tree.all_hits(**rays)) for ids, tree in tiles], len(rays["origins"]), ("t", "u"), "t")
        assert_same(got, [expected.offsets, expected.prim, expected.t, expected.u])


def test_the_frame_is_kept(tmp_path: Any) -> None:
    lines = lines_of(9, True)
    frame = lines.bounds + np.array([[-1], [2]])
    tree = fl.build(lines, frame=frame)
    rays = rays_of(lines)
    expected = tree.all_hits(**rays)
    assert (expected.t != fl.build(lines).all_hits(**rays).t).any()
    tree.save(tmp_path / "a.flt")
    moved = tree.refit(lines.segments[::-1].copy() * 0.5)
    again = [
        pickle.loads(pickle.dumps(tree)),
        fl.load(tmp_path / "a.flt"),
        tree.to("cpu"),
        tree.without_offset(),
        moved,
    ]
    for other in again:
        np.testing.assert_array_equal(other.frame_box, frame.astype("f4"))
        assert other.layout.view.frame[:2] == tree.layout.view.frame[:2]
    for other in again[:-1]:
        assert_same([other.all_hits(**rays).t], [expected.t])
    assert fl.build(lines).frame is None
    np.testing.assert_array_equal(fl.build(lines).frame_box, lines.bounds)
    assert isinstance(tree, PlacedTree)
    assert not tree.frame_box.flags.writeable


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        ([0, 1], "expected \\(2, 3\\)"),
        ([[0] * 3, [np.nan] * 3], "NaN"),
        ([[1] * 3, [-1] * 3], "swap"),
        ([[-9] * 3, [0] * 3], "extend 1 beyond frame"),
        ([["a"] * 3] * 2, "frame"),
    ],
)
def test_frames_that_are_refused(frame: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        fl.build([[[-1, -1, -1], [1, 1, 1]]], frame=frame)


def test_moved_lines_that_leave_the_frame() -> None:
    tree = fl.build([[[-1, -1, -1], [1, 1, 1]]], frame=[[-2] * 3, [2] * 3])
    assert tree.refit([[[-2, -2, -2], [0, 0, 0]]]).first_hit([-1, -1, -5], [0, 0, 1], 0.1).t == 4
    with pytest.raises(InputError, match=r"extend 0\.5 beyond"):
        tree.refit([[[-2.5, -2, -2], [0, 0, 0]]])


@pytest.mark.parametrize("frame", [[[-2] * 3, [2] * 3], [[100] * 3, [101] * 3]])
def test_an_empty_tree_takes_any_frame(frame: Any, tmp_path: Path) -> None:
    fl.build(np.zeros((0, 2, 3)), frame=frame).save(tmp_path / "empty.flt", layout=True)
    tree = fl.load(tmp_path / "empty.flt")
    assert tree.frame_box.tolist() == frame
    assert not tree.any_hit([0, 0, -5], [0, 0, 1], 1)
    assert tree.nearest([0, 0, 0]).prim == -1
