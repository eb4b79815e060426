"""Pairs of near primitives: bit for bit those of brute force, and near those of float64."""

from __future__ import annotations

import copy
import pickle
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support import nasty

import fastlines as fl
from fastlines.engines import available_simd, engine
from fastlines.query.proximity.pair_query import PAIR_BYTES, SORTING_BYTES, check_pairs
from fastlines.query.proximity.pair_sets import row_arrays
from fastlines.threads import num_threads

COLUMNS = ("i", "j", "s", "t", "distance")
METHODS = ("best", "bvh-cl", "kd-d2")
#: By how much a distance may differ from that of float64, as a fraction of the size of the scene.
BAND = 2.0**-20


def assert_same(got: fl.Pairs, expected: fl.Pairs, which: str = "") -> None:
    for name in COLUMNS:
        a, b = getattr(got, name), getattr(expected, name)
        assert (a.shape, a.dtype) == (b.shape, b.dtype), f"{which} {name}"
        assert a.tobytes() == b.tobytes(), f"{which} {name} differs"


def joined(parts: list[fl.Pairs]) -> dict[str, Any]:
    return {name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS}


def scene(name: str, n: int = 240) -> tuple[np.ndarray, np.random.Generator]:
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    return nasty.SCENES[name](rng, n).astype(np.float32), rng


def radii_of(rng: np.random.Generator, kind: str, n: int, size: float) -> Any:
    """Return the radii of each end: none, some that taper, some of zero, or some that are far too large."""
    taper = rng.uniform(0, 0.1 * size, (n, 2)).astype(np.float32)
    return {
        "none": None,
        "taper": taper,
        "some": taper * (rng.random((n, 2)) < 0.3).astype(np.float32),
        "huge": taper * np.float32(1e4),
    }[kind]


# ---- The definition ----


@pytest.mark.parametrize("kind", ["none", "taper", "some", "huge"])
@pytest.mark.parametrize("name", nasty.SCENES)
def test_every_tree_has_the_pairs_of_brute_force(name: str, kind: str) -> None:
    ends, rng = scene(name, 100)
    size = nasty.size_of(ends)
    lines = fl.Lines.from_segments(ends, radius=radii_of(rng, kind, len(ends), size))
    for radius in (0.0, 0.02 * size, 3 * size):
        for to in ("axis", "surface") if kind != "none" else (None,):
            expected = fl.brute_force_pairs(lines, radius, to=to)
            for method in METHODS if 0 < radius < size else METHODS[:1]:
                assert_same(fl.build(lines, method).pairs(radius, to=to), expected, f"{method} {radius} {to}")


@pytest.mark.parametrize("name", ["random", "crossing", "outlier", "points"])
def test_radii_at_which_a_pair_just_counts(name: str) -> None:
    """No pair is culled whose distance is the radius, or a rounding of it."""
    ends, rng = scene(name, 80)
    lines = fl.Lines.from_segments(ends)
    distances = np.unique(fl.brute_force_pairs(lines, nasty.size_of(ends)).distance)
    for method in METHODS:
        tree = fl.build(lines, method)
        for radius in rng.choice(distances, 30):
            for near in (radius, np.nextafter(radius, np.float32(np.inf))):
                assert_same(tree.pairs(near), fl.brute_force_pairs(lines, near), f"{method} {near}")


@pytest.mark.parametrize("simd", available_simd())
@pytest.mark.parametrize("kind", ["none", "taper"])
def test_instruction_sets_and_threads_do_not_matter(simd: str, kind: str) -> None:
    ends, rng = scene("random", 3000)
    lines = fl.Lines.from_segments(ends, radius=radii_of(rng, kind, len(ends), 0.2))
    expected = fl.brute_force_pairs(lines, 0.02)
    assert len(expected) > 1000
    tree = fl.build(lines, "best", presplit=fl.Presplit(0.5))
    fl.set_simd(simd)
    try:
        for n_threads in (1, 2, 4):
            with num_threads(n_threads):
                assert_same(tree.pairs(0.02), expected, f"{n_threads} threads")
                query = check_pairs(lines, None, 0.02, 1, False, None)
                options, rows = query.options(0, len(lines), 2**62), row_arrays(lines, None)
                found = engine.brute_force_pairs(tree.layout.view, None, (rows, rows), options, n_threads, None)
                assert_same(query.pairs(found), expected, "16 at a time")
    finally:
        fl.set_simd(None)


def least_distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the least D - r_a - r_b of round cones (n, 8), in float64, by golden sections: it is convex."""
    a, b = a.astype(np.float64), b.astype(np.float64)
    golden = (np.sqrt(5) - 1) / 2

    def value(s: np.ndarray, t: np.ndarray) -> np.ndarray:
        first, second = (of[:, :3] + x[:, None] * (of[:, 3:6] - of[:, :3]) for of, x in ((a, s), (b, t)))
        radii = a[:, 6] + s * (a[:, 7] - a[:, 6]) + b[:, 6] + t * (b[:, 7] - b[:, 6])
        return np.asarray(np.linalg.norm(first - second, axis=1) - radii)

    def least(f: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        low, high = np.zeros(len(a)), np.ones(len(a))
        for _ in range(40):
            one, two = high - golden * (high - low), low + golden * (high - low)
            left = f(one) < f(two)
            low, high = np.where(left, low, one), np.where(left, two, high)
        return np.min([f(np.zeros(len(a))), f(np.ones(len(a))), f((low + high) / 2)], axis=0)

    return least(lambda s: least(lambda t: value(s, t)))


def pairs_to_measure(kind: str, n: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """Return round cones (n, 8) within a box of size 2, in two arrays."""
    rng = np.random.default_rng(zlib.crc32(kind.encode()))

    def cones(length: float, radius: float) -> np.ndarray:
        start = rng.uniform(-0.5, 0.5, (n, 3))
        ends = np.clip(start + rng.normal(0, length, (n, 3)), -1, 1)
        return np.concatenate([start, ends, rng.uniform(0, radius, (n, 2))], axis=1).astype(np.float32)

    a = cones(0.3, 0.1)
    if kind == "parallel":
        b = a + np.repeat(rng.normal(0, 0.05, (n, 1)), 8, axis=1) * [1, 1, 1, 1, 1, 1, 0, 0]
    elif kind == "nearly parallel":
        b = a + rng.normal(0, 1, (n, 8)) * 10 ** rng.uniform(-7, -2, (n, 1)) * [1, 1, 1, 1, 1, 1, 0, 0]
    elif kind == "joint":
        b = np.concatenate([a[:, 3:6], cones(0.3, 0.1)[:, 3:]], axis=1)
    elif kind == "crossing":
        middle, half = (a[:, :3] + a[:, 3:6]) / 2 + rng.normal(0, 0.02, (n, 3)), rng.normal(0, 0.2, (n, 3))
        b = np.concatenate([middle - half, middle + half, rng.uniform(0, 0.3, (n, 2))], axis=1)
    elif kind == "steep":
        b = cones(0.1, 0.5)
    elif kind == "spheres":
        b = cones(0, 0.2)
        b[:, 7] = b[:, 6]
    else:
        b = cones(0.3, 0.2)
    return a, b.astype(np.float32)


@pytest.mark.parametrize("kind", ["any", "parallel", "nearly parallel", "joint", "crossing", "steep", "spheres"])
def test_distances_are_those_of_float64(kind: str) -> None:
    a, b = pairs_to_measure(kind)
    for radii in (False, True):
        first, second = (of * ([1] * 6 + [radii, radii]) for of in (a, b))
        expected = least_distances(first, second)
        for i in range(len(a)):
            both = fl.Lines.from_segments(
                np.float32([first[i, :6], second[i, :6]]).reshape(2, 2, 3), radius=[first[i, 6:], second[i, 6:]]
            )
            found = fl.brute_force_pairs(both, 9)
            size = nasty.size_of(both.segments) + first[i, 6:].max() + second[i, 6:].max()
            assert abs(found.distance[0] - expected[i]) <= BAND * size


def test_tapered_lines_that_are_nearly_parallel() -> None:
    """The rounding of the volume of two axes counts κ/sin²θ times; see pair_test.hpp."""
    rng, n = np.random.default_rng(5), 300
    along, beside = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in rng.normal(0, 1, (2, n, 3)))
    kappa = 10 ** rng.uniform(-4, -1.5, n)
    first = np.stack([-along, along], axis=1)
    second = first + rng.uniform(-0.5, 0.5, (n, 1, 1)) * first[:, 1:]
    second += np.array([[-1], [1]]) * (kappa * rng.uniform(1, 5, n))[:, None, None] * beside[:, None]
    radii = np.stack([np.zeros(n), 2 * kappa], axis=1)
    both = np.stack([first, second], axis=1).astype(np.float32)
    thick = np.stack([np.zeros((n, 2)), radii], axis=1).astype(np.float32)
    rows = np.concatenate([both.reshape(n, 2, 6), thick], axis=2).astype(np.float64)
    expected = least_distances(rows[:, 0], rows[:, 1])
    u, v = (both[:, i, 1].astype(np.float64) - both[:, i, 0] for i in range(2))
    cosine2 = (u * v).sum(axis=1) ** 2 / ((u * u).sum(axis=1) * (v * v).sum(axis=1))
    slope = (thick[:, 1, 1] - thick[:, 1, 0]) / np.linalg.norm(v, axis=1)
    off = np.zeros(n)
    for i in range(n):
        lines = fl.Lines.from_segments(both[i], radius=thick[i])
        off[i] = fl.brute_force_pairs(lines, 9).distance[0] - expected[i]
        off[i] /= BAND * (nasty.size_of(lines.segments) + thick[i].max())
    assert (np.abs(off) <= 1 + slope / (1 - cosine2)).all()
    assert np.abs(off).max() > 1, "the limit is needed"


def test_distances_are_those_of_the_places() -> None:
    ends, rng = scene("random", 400)
    lines = fl.Lines.from_segments(ends, radius=radii_of(rng, "taper", len(ends), 1.0))
    for to in ("axis", "surface"):
        pairs = fl.build(lines).pairs(0.05, to=to)
        points = pairs.points()
        apart = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        assert len(pairs) > 100
        assert np.allclose(np.where(pairs.distance < 0, -apart, apart), pairs.distance, atol=1e-5)
    assert (pairs.distance < 0).any()


# ---- Two trees ----


@pytest.mark.parametrize("name", ["random", "crossing", "outlier", "hair moved 1e5", "scale 1e-8", "points"])
@pytest.mark.parametrize("thick", [False, True])
def test_pairs_of_two_trees(name: str, thick: bool) -> None:
    ends, rng = scene(name, 200)
    size = nasty.size_of(ends)
    radius = radii_of(rng, "taper", len(ends), size) if thick else None
    lines = fl.Lines.from_segments(ends, radius=radius)
    for factor, to in ((1, 0.3), (1e-3, 0.1), (1e3, 100.0)):
        moved = ((ends - ends.mean(axis=(0, 1))) * factor + ends.mean(axis=(0, 1)) + to * size * 0.3).astype(np.float32)
        other = fl.Lines.from_segments(moved[: len(moved) // 2])
        expected = fl.brute_force_pairs(lines, 0.1 * size, other)
        pairs = fl.build(lines).pairs(0.1 * size, fl.build(other, "bvh-cl"))
        assert_same(pairs, expected, f"{factor}")
        turned = fl.build(other).pairs(0.1 * size, fl.build(lines))
        assert_same(turned, fl.brute_force_pairs(other, 0.1 * size, lines), f"{factor} turned")
        assert abs(len(turned) - len(pairs)) <= 1
    assert pairs.other is other


def test_a_tree_with_itself_has_pairs_in_both_orders() -> None:
    ends, _ = scene("random", 100)
    tree = fl.build(ends)
    both, once = tree.pairs(0.1, tree), tree.pairs(0.1)
    assert (both.distance[both.i == both.j] == 0).all()
    assert len(both) == 2 * len(once) + 100


def test_trees_of_different_offsets_do_not_mix() -> None:
    near, far = ([[[0, 0, 0], [1, 0, z]]] for z in (0, 1))
    trees = [fl.build(fl.Lines.from_segments(ends, offset=[x, 0, 0])) for x, ends in ((0, near), (9, far))]
    with pytest.raises(fl.InputError, match=r"different offsets, \(0.0, 0.0, 0.0\) and \(9.0, 0.0, 0.0\)"):
        trees[0].pairs(1, trees[1])


# ---- Parts, memory, time steps ----


@pytest.mark.parametrize("name", ["random", "hair", "crossing"])
def test_parts_together_are_the_answer(name: str) -> None:
    ends, _ = scene(name, 640)
    lines = fl.Lines(ends, np.arange(len(ends)) // 8)
    tree = fl.build(lines)
    expected = tree.pairs(0.1)
    parts = list(tree.iter_pairs(0.1, max_bytes=68 * 200))
    assert len(parts) > 3
    assert 0 < min(map(len, parts)) <= max(map(len, parts)) <= 200
    for name, column in joined(parts).items():
        assert np.array_equal(column, getattr(expected, name))
    other = fl.build(ends + np.float32(0.05))
    both = joined(list(tree.iter_pairs(0.1, other, max_bytes=68 * 500)))
    for name, column in both.items():
        assert np.array_equal(column, getattr(tree.pairs(0.1, other), name))
    with pytest.raises(MemoryError, match=r"primitive 0 alone has more than the 5 pairs that max_bytes holds"):
        list(tree.iter_pairs(9, max_bytes=68 * 5))


def test_parts_of_curves() -> None:
    curves = fl.Curves.from_bezier(np.random.default_rng(7).uniform(-1, 1, (40, 4, 3)))
    tree = fl.build(curves)
    parts = joined(list(tree.iter_pairs(0.2, max_bytes=68 * 4000)))
    for name, column in parts.items():
        assert np.array_equal(column, getattr(tree.pairs(0.2), name))


def test_too_many_pairs_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fastlines.query.proximity.pair_query.SMALL", 0)
    monkeypatch.setattr("fastlines.query.memory_check.left_memory", lambda: 68e3)
    tree = fl.build(scene("crossing", 100)[0])
    assert len(tree.pairs(0.01)) <= 1000
    with pytest.raises(MemoryError, match=r"the pairs within 3 do not fit into memory.*or iter_pairs"):
        tree.pairs(3)
    with pytest.raises(MemoryError, match=r"within 3 of each segment of the polyline does not fit into memory"):
        tree.along(np.linspace([-1, 0, 0], [1, 0, 0], 50), 3)


def test_the_same_call_serves_the_next_time_step() -> None:
    ends, rng = scene("hair", 800)
    lines = fl.Lines(ends, np.arange(len(ends)) // 8)
    tree = fl.build(lines)
    for _ in range(3):
        ends = ends + rng.normal(0, 0.01, ends.shape).astype(np.float32)
        tree = tree.refit(ends)
        assert_same(tree.pairs(0.05), fl.brute_force_pairs(fl.Lines(ends, lines.strands), 0.05))


def test_progress_is_reported() -> None:
    shares: list[float] = []
    tree = fl.build(scene("crossing", 3000)[0])
    tree.pairs(0.01, progress=shares.append)
    assert shares[-1] == 1.0
    list(tree.iter_pairs(0.01, max_bytes=10**6, progress=shares.append))
    assert shares[-1] == 1.0
    with pytest.raises(ZeroDivisionError):
        fl.build(scene("crossing", 20_000)[0]).pairs(1, progress=lambda _: 1 / 0)


# ---- Input that cannot be used, and answers ----


def test_no_primitives_have_no_pairs() -> None:
    empty, one = fl.build(np.empty((0, 2, 3))), fl.build([[[0, 0, 0], [1, 0, 0]]])
    for found in (empty.pairs(1), one.pairs(1), one.pairs(1, empty), empty.pairs(1, one), fl.brute_force_pairs([], 1)):
        assert (len(found), found.points().shape, found.i.dtype) == (0, (0, 2, 3), np.int64)
    assert list(empty.iter_pairs(1, max_bytes=100)) == list(one.iter_pairs(1, max_bytes=100)) == []
    assert len(empty.along([[0, 0, 0], [1, 1, 1]], 1)) == 0


@pytest.mark.parametrize("radius", [-1, np.nan, np.inf, "1", [1, 2], None, 1e30])
def test_a_radius_is_one_number(radius: Any) -> None:
    tree = fl.build([[[0, 0, 0], [1, 0, 0]]])
    for ask in (
        tree.pairs,
        lambda r: tree.iter_pairs(r, max_bytes=100),
        lambda r: tree.along([[0, 0, 0], [1, 1, 1]], r),
    ):
        with pytest.raises(fl.InputError, match=r"radius=.*; expected a distance from 0 to 1e\+12"):
            ask(radius)


def test_other_arguments_are_checked() -> None:
    tree = fl.build([[[0, 0, 0], [1, 0, 0]]])
    with pytest.raises(fl.InputError, match=r"other is a list; expected a Tree"):
        tree.pairs(1, [])  # type: ignore[arg-type]
    with pytest.raises(fl.InputError, match=r"skip_neighbours=-1; expected a whole number, 0 or more"):
        tree.pairs(1, skip_neighbours=-1)
    with pytest.raises(fl.InputError, match=r"those of two trees never are; leave it out"):
        tree.pairs(1, tree, skip_strand=True)
    with pytest.raises(fl.InputError, match=r"to='middle' is not a choice"):
        tree.pairs(1, to="middle")
    with pytest.raises(fl.InputError, match=r"max_bytes=3; expected a whole number, 68 or more"):
        tree.iter_pairs(1, max_bytes=3)


def test_pairs_are_chosen_and_pickled() -> None:
    rods = fl.Lines.from_segments(scene("random", 50)[0], offset=[9, 0, 0])
    pairs = fl.build(rods).pairs(0.2)
    assert repr(pairs) == f"<Pairs: {len(pairs)} pairs>"
    near = pairs[pairs.distance < 0.1]
    assert np.array_equal(near.points(), pairs.points()[pairs.distance < 0.1])
    assert (repr(pairs[3]), pairs[3].i[0], pairs[-1].j[0]) == ("<Pairs: 1 pair>", pairs.i[3], pairs.j[-1])
    assert [pair.i[0] for pair in pairs] == pairs.i.tolist()
    assert pairs.row_i.tolist() == pairs.i.tolist()
    assert pairs.row_j.tolist() == pairs.j.tolist()
    copied = pickle.loads(pickle.dumps(pairs))
    assert_same(copied, pairs)
    assert copied.row_j.tolist() == pickle.loads(pickle.dumps(copied)).row_j.tolist() == pairs.j.tolist()
    assert copied[::2].strand_i.tolist() == pairs.strand_i[::2].tolist()
    assert not copied.row_i.flags.writeable
    assert copy.deepcopy(pairs).geometry is rods
    with pytest.raises(fl.InputError, match=r"does not know its geometry"):
        copied.points()


def test_parts_of_pairs_are_about_as_large_as_they_may_be() -> None:
    z = np.arange(6400.0)
    segments = np.stack([np.stack([0 * z, 0 * z, z], axis=1), np.stack([1 + 0 * z, 0 * z, z], axis=1)], axis=1)
    most = 1300
    parts = [len(part) for part in fl.build(segments).iter_pairs(1.5, max_bytes=most * (PAIR_BYTES + SORTING_BYTES))]
    assert sum(parts) == len(z) - 1
    assert max(parts) <= most
    assert min(parts[2:-1]) > most / 2
