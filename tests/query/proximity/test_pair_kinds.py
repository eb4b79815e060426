"""Pairs of lines in strands, curves, spheres, and several kinds together."""

from __future__ import annotations

import numpy as np
import pytest
from support import nasty

import fastlines as fl
from fastlines.query.proximity.strand_places import strand_places

METHODS = ("best", "bvh-cl", "kd-d2")


def assert_same(got: fl.Pairs, expected: fl.Pairs) -> None:
    for name in ("i", "j", "s", "t", "distance"):
        assert getattr(got, name).tobytes() == getattr(expected, name).tobytes(), name


# ---- Strands ----


def test_neighbours_along_strands_are_left_out() -> None:
    points = np.stack([np.arange(7), np.zeros(7), np.zeros(7)], axis=1)
    lines = fl.Lines.from_strands([points, points + np.array([0, 0.5, 0])])
    tree = fl.build(lines)
    everything = tree.pairs(0.1, skip_neighbours=0)
    assert len(everything) == 10  # the joints
    assert len(tree.pairs(0.1)) == 0
    for n in range(7):
        pairs = tree.pairs(9, skip_neighbours=n)
        same = pairs.strand_i == pairs.strand_j
        assert (np.abs(pairs.i - pairs.j)[same] > n).all()
        assert same.sum() == 2 * sum(range(6 - n))
        assert (~same).sum() == 36
        assert_same(pairs, fl.brute_force_pairs(lines, 9, skip_neighbours=n))
    assert (tree.pairs(9, skip_strand=True).strand_i != tree.pairs(9, skip_strand=True).strand_j).all()
    assert len(tree.pairs(9, skip_strand=True)) == 36


def test_closed_strands_have_no_ends() -> None:
    angles = np.linspace(0, 2 * np.pi, 9)
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(9)], axis=1)
    ring[-1] = ring[0]
    tree = fl.build(fl.Lines.from_strands([ring]))
    assert len(tree.pairs(9)) == 8 * 5 // 2
    assert len(tree.pairs(9, skip_neighbours=3)) == 4
    assert len(tree.pairs(9, skip_neighbours=4)) == 0
    assert len(tree.pairs(1e-3)) == 0


def test_positions_count_within_strands_that_are_mixed() -> None:
    ends = nasty.hair(np.random.default_rng(2), 64).astype(np.float32)
    strands = np.arange(64) // 8
    order = np.random.default_rng(0).permutation(64)
    lines = fl.Lines(np.ascontiguousarray(ends[order]), strands[order])
    places = strand_places(lines)
    assert places is not None
    for strand in range(8):
        here = np.flatnonzero(lines.strands == strand)
        assert places[here].tolist() == [[strand, position, 0] for position in range(8)]
    assert strand_places(fl.Lines.from_segments(ends)) is None


# ---- Other kinds, and several ----


def test_curves_make_one_pair_each() -> None:
    control = np.random.default_rng(5).uniform(-1, 1, (30, 4, 3))
    curves = fl.Curves.from_bezier(control, radius=0.02, strands=np.arange(30) // 3)
    pieces = curves.as_lines()
    for to in ("axis", "surface"):
        pairs = fl.build(curves).pairs(0.1, to=to, skip_neighbours=0)
        assert_same(pairs, fl.brute_force_pairs(curves, 0.1, to=to, skip_neighbours=0))
        assert len(pairs) > 20
        assert len(np.unique(np.stack([pairs.i, pairs.j]), axis=1).T) == len(pairs)
        # Of two curves, the least distance of pieces counts.
        of_pieces = fl.build(pieces).pairs(0.1, to=to, skip_neighbours=0)
        curve = curves.pieces.curve
        kept = curve[of_pieces.i] != curve[of_pieces.j]
        number = curve[of_pieces.i[kept]] * 30 + curve[of_pieces.j[kept]]
        least = np.full(900, np.inf, np.float32)
        np.minimum.at(least, number, of_pieces.distance[kept])
        assert np.array_equal(np.flatnonzero(np.isfinite(least)), pairs.i * 30 + pairs.j)
        assert np.array_equal(least[np.isfinite(least)], pairs.distance)
    neighbours = fl.build(curves).pairs(9)
    assert ((pairs.strand_i != pairs.strand_j) | (pairs.j > pairs.i)).all()
    assert not ((neighbours.strand_i == neighbours.strand_j) & (neighbours.j - neighbours.i == 1)).any()


def test_spheres_and_several_parts() -> None:
    rng = np.random.default_rng(6)
    spheres = fl.Spheres.from_centres(rng.uniform(-1, 1, (80, 3)), radius=rng.uniform(0, 0.1, 80))
    pairs = fl.build(spheres).pairs(0.1)
    apart = np.linalg.norm(spheres.centres[pairs.i] - spheres.centres[pairs.j], axis=1)
    assert len(pairs) > 10
    assert np.allclose(pairs.distance, apart - spheres.radius[pairs.i] - spheres.radius[pairs.j], atol=1e-6)
    lines = fl.Lines.from_strands([rng.uniform(-1, 1, (9, 3)) for _ in range(9)])
    curves = fl.Curves.from_bezier(rng.uniform(-1, 1, (9, 4, 3)))
    several = fl.Geometry([spheres, lines, curves])
    for method in METHODS:
        found = fl.build(several, method).pairs(0.1)
        assert_same(found, fl.brute_force_pairs(several, 0.1))
    first_part = found[found.j < 80]
    assert np.array_equal(first_part.j, pairs.j)
    assert np.array_equal(found.part_i, several.split(found.i)[0])
    assert set(first_part.part_j) == {0}
    assert pairs.part_i is None
    assert np.allclose(first_part.distance, pairs.distance, atol=1e-6)


def test_shapes_that_many_leaves_list_are_found_once() -> None:
    rng = np.random.default_rng(8)
    ends = nasty.crossing(rng, 80).astype(np.float32)
    thick = fl.Lines.from_segments(ends, radius=rng.uniform(0, 0.05, (80, 2)))
    several = fl.Geometry([thick, fl.Spheres.from_centres(ends[:20, 0], radius=0.5)])
    tree, other = fl.build(several, "kd-d2"), fl.build(fl.Geometry([thick]), "kd-d2")
    assert min(tree.n_refs, other.n_refs) > 2 * len(several)
    for to in ("axis", "surface"):
        expected = fl.brute_force_pairs(several, 0.1, to=to)
        assert_same(tree.pairs(0.1, to=to), expected)
        assert_same(tree.pairs(0.1, other, to=to), fl.brute_force_pairs(several, 0.1, fl.Geometry([thick]), to=to))
        assert sum(map(len, tree.iter_pairs(0.1, to=to, max_bytes=68 * 200))) == len(expected)


def test_shapes_are_near_something_small_in_any_of_their_leaves() -> None:
    rng = np.random.default_rng(9)
    ends = nasty.crossing(rng, 40).astype(np.float32)
    several = fl.Geometry([fl.Lines.from_segments(ends), fl.Spheres.from_centres(ends[:5, 0], radius=0.1)])
    tree = fl.build(several, "kd-d2")
    assert tree.n_refs > 2 * len(several)
    n_found = 0
    for at in (ends[:, 0], ends[:, 1], ends.mean(axis=1) + 0.01):
        for point in at:
            small = fl.Lines.from_segments([[point, point + 0.01]])
            expected = fl.brute_force_pairs(several, 0.05, small)
            assert_same(tree.pairs(0.05, fl.build(small)), expected)
            n_found += len(expected)
    assert n_found > 120


def test_what_has_no_axis_is_refused() -> None:
    triangle, line = fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]), fl.Lines.from_segments([[[0, 0, 1], [1, 0, 1]]])
    for geometry in (triangle, fl.Geometry([line, triangle])):
        with pytest.raises(fl.InputError, match=r"not for 1 triangle; build a tree without them"):
            fl.build(geometry).pairs(1)
        with pytest.raises(fl.InputError, match=r"not for 1 triangle"):
            fl.build(line).pairs(1, fl.build(geometry))
        with pytest.raises(fl.InputError, match=r"not for 1 triangle"):
            fl.build(geometry).along([[0, 0, 0], [1, 1, 1]], 1)
