"""What answers say of the segments that were hit: rows of the input and strands, never those of another for a miss."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from support import nasty

import fastlines as fl

SKIPPED = [0, 3, 4, 39]
KERNELS = ["auto", "single", "wave", "bundle", "binary"]


def ends_and_strands():
    """Return 40 segments of which some can not be used, and the strand of each: two in three have one."""
    ends = nasty.crossing(np.random.default_rng(0), 40).astype(np.float32)
    ends[SKIPPED, 1, 2] = np.nan
    strands = np.where(np.arange(40) % 3 == 0, -1, np.arange(40) * 10)
    return ends, strands


def rays():
    rng = np.random.default_rng(1)
    target = np.where(rng.random((8, 25, 1)) < 0.3, [0, 0, -9], rng.normal(size=(8, 25, 3)) * 0.5)  # some away from all
    return np.broadcast_to([0, 0, -5.0], target.shape), target - [0, 0, -5]


def skipped_lines():
    ends, strands = ends_and_strands()
    return fl.Lines.from_segments(ends, strands=strands, invalid="skip")


@pytest.fixture(scope="module")
def askers(tmp_path_factory):
    """Return functions that ask about the same lines, by name."""
    lines = skipped_lines()
    tree = fl.build(lines)
    path = tmp_path_factory.mktemp("hits") / "a.flt"
    tree.save(path)
    moved = fl.build(fl.Lines.from_segments(lines.segments[::-1], strands=np.zeros(36, int)))
    trees = {"tree": tree, "loaded": fl.load(path), "kd": fl.build(lines, "kd-d2")}
    trees["refitted array"] = fl.build(lines).refit(lines.segments)
    trees["refitted lines"] = moved.refit(lines)
    moved.layout  # noqa: B018  (so that it is refitted too)
    trees["refitted with its layout"] = moved.refit(lines)
    askers = {
        f"{name}, {kernel}": lambda query, *k, tree=tree, kernel=kernel: getattr(tree, query)(
            *rays(), 0.1, *k, kernel=kernel
        )
        for name, tree in trees.items()
        for kernel in KERNELS
    }
    askers["brute force"] = lambda query, *k: fl.brute_force(lines, *rays(), 0.1, query=query, k=k[0] if k else None)
    return askers


QUERIES = [("first_hit",), ("all_hits",), ("next_hits", 2)]


@pytest.mark.parametrize("query", QUERIES, ids=[query[0] for query in QUERIES])
def test_rows_and_strands_are_those_of_the_input(askers, query):
    _, strands = ends_and_strands()
    kept = [row for row in range(40) if row not in SKIPPED]
    for name, ask in askers.items():
        hits = ask(*query)
        assert hits.row.shape == hits.strand.shape == hits.prim.shape, name
        assert hits.row.dtype == hits.strand.dtype == np.int64, name
        rows = [kept[prim] if prim >= 0 else -1 for prim in hits.prim.flat]
        assert hits.row.ravel().tolist() == rows, name
        assert hits.strand.ravel().tolist() == [strands[row] if row >= 0 else -1 for row in rows], name
        assert len(set(rows)) > 3, name
        assert (-1 in rows) == (query[0] == "first_hit"), name
        assert -1 in hits.strand[hits.prim >= 0], name


def test_they_are_looked_up_once_and_can_not_be_written_to(askers):
    hits = askers["tree, auto"]("first_hit")
    assert hits.row is hits.row
    assert hits.strand is hits.strand
    assert not hits.row.flags.writeable
    assert not hits.strand.flags.writeable
    assert hits.prim.flags.writeable, "the answer itself is the caller's"
    before = hits.row.copy()
    hits.prim[...] = 7
    assert (hits.row == before).all()


def test_nothing_is_copied_for_an_answer():
    lines = skipped_lines()
    tree = fl.build(lines)
    for hits in (tree.first_hit(*rays(), 0.1), tree.all_hits(*rays(), 0.1), tree.refit(lines).first_hit(*rays(), 0.1)):
        assert hits.geometry is lines
        assert not {"row", "strand"} & vars(hits).keys()


def test_one_ray_has_one_row():
    hits = fl.build(skipped_lines()).first_hit([0, 0, -9], [0, 0, -1], 0.1)
    assert hits.row.shape == hits.strand.shape == ()
    assert (int(hits.row), int(hits.strand)) == (-1, -1)


@pytest.mark.parametrize("query", QUERIES, ids=[query[0] for query in QUERIES])
@pytest.mark.parametrize("protocol", [2, 4, 5])
def test_a_pickle_has_rows_and_strands_but_not_all_lines(query, protocol):
    many = fl.Lines.from_segments(np.tile(skipped_lines().segments, (500, 1, 1)), strands=np.arange(18_000))
    for lines in (skipped_lines(), many):
        hits = getattr(fl.build(lines, "bvh-cl"), query[0])(*rays(), 0.01, *query[1:])
        data = pickle.dumps(hits, protocol)
        assert len(data) < 2000 + 100 * hits.prim.size + 8 * len(getattr(hits, "offsets", []))
        for same in (copy.deepcopy(hits), copy.copy(hits)):
            assert same.geometry is hits.geometry
        for back in (pickle.loads(data), copy.deepcopy(hits), copy.copy(hits)):
            assert repr(back) == repr(hits)
            for name in ("t", "prim", "u", "distance", "row", "strand"):
                assert np.array_equal(getattr(back, name), getattr(hits, name)), name
            assert not back.row.flags.writeable
            assert not back.strand.flags.writeable


def test_hits_made_by_hand_say_what_they_lack():
    nothing = np.zeros(0, np.float32)
    hits = fl.FirstHits(nothing, np.zeros(0, np.int64), nothing, nothing, None, np.zeros(0, np.int64))
    for same in (hits, copy.copy(hits), copy.deepcopy(hits), pickle.loads(pickle.dumps(hits))):
        with pytest.raises(fl.InputError, match="does not know its geometry"):
            same.row  # noqa: B018


def test_the_nearest_in_distance_is_not_always_among_the_next():
    """The recipe of docs/answers.md, beside all distances."""
    lines = skipped_lines()
    origins, directions = (array.reshape(-1, 3) for array in rays())
    hits = fl.build(lines).all_hits(origins, directions, 0.3)
    order = np.lexsort((hits.distance, hits.ray))
    some = hits.counts > 0
    picked = order[hits.offsets[:-1][some]]
    least = [hits.distance[hits.of(ray)].min() for ray in np.flatnonzero(some)]
    assert hits.ray[picked].tolist() == np.flatnonzero(some).tolist()
    assert hits.distance[picked].tolist() == least
    by_t = fl.build(lines).next_hits(origins, directions, 0.3, 2)
    assert any(by_t.distance[by_t.of(ray)].min() > d for ray, d in zip(np.flatnonzero(some), least, strict=True))


def merge_one_by_one(hits):
    """Merge intervals of each ray and strand in plain Python."""
    found = []
    for ray in range(len(hits.offsets) - 1):
        of_strand = {}
        for i in range(hits.offsets[ray], hits.offsets[ray + 1]):
            key = hits.strand[i] if hits.strand[i] >= 0 else ("alone", hits.prim[i])
            of_strand.setdefault(key, []).append(i)
        for indices in of_strand.values():
            for i in indices:  # by t
                if indices[0] != i and hits.t[i] <= found[-1][2]:
                    found[-1][2:] = max(found[-1][2], hits.t_out[i]), min(found[-1][3], hits.distance[i])
                else:
                    found.append([ray, i, hits.t_out[i], hits.distance[i]])
    return sorted(found, key=lambda one: (one[0], hits.t[one[1]], hits.prim[one[1]]))


@pytest.mark.parametrize("ask", ["tree", "brute force"])
def test_hits_of_a_strand_merge_where_they_overlap(ask):
    rng = np.random.default_rng(6)
    walks = np.cumsum(rng.normal(size=(12, 20, 3)) * 0.1, axis=1)
    lines = fl.Lines.from_strands(list(walks))
    strands = np.where(lines.strands == 3, -1, lines.strands)
    lines = fl.Lines.from_segments(lines.segments, strands=strands)
    origins, directions = rng.normal(size=(400, 3)) * 0.2 - [0, 0, 5], np.array([0, 0, 2.0])
    query = fl.build(lines).all_hits if ask == "tree" else lambda *rays, **how: fl.brute_force(lines, *rays, **how)
    every = query(origins, directions, 0.1, at="surface")
    merged = query(origins, directions, 0.1, at="surface", merge="strand")
    expected = merge_one_by_one(every)
    assert 200 < len(merged) < 0.7 * len(every)
    ray, indices, t_out, distance = (list(column) for column in zip(*expected, strict=True))
    assert merged.ray.tolist() == ray
    for column in ("prim", "t", "u", "strand"):
        assert getattr(merged, column).tolist() == getattr(every, column)[indices].tolist()
    assert merged.t_out.tolist() == t_out
    assert merged.distance.tolist() == distance
    assert (merged.distance < every.distance[indices]).any()
    assert (np.abs(merged.normals()).max(axis=1) <= 1).all()
    assert len(query([9, 9, 9], [0, 0, 1], 0.1, at="surface", merge="strand")) == 0


def test_hits_by_distance_merge_to_the_same_crossings():
    rng = np.random.default_rng(6)
    tree = fl.build(fl.Lines.from_strands(list(np.cumsum(rng.normal(size=(6, 12, 3)) * 0.2, axis=1)), radius=0.15))
    origins = rng.normal(size=(60, 3))
    by_t = tree.all_hits(origins, -origins, at="surface", merge="strand")
    by_distance = tree.next_hits(origins, -origins, k=1000, at="surface", rank="distance").merged_by_strand()
    order = np.lexsort((by_t.distance, by_t.ray))
    assert by_distance.ray.tolist() == by_t.ray[order].tolist()
    assert by_distance.distance.tolist() == by_t.distance[order].tolist()
    again = pickle.loads(pickle.dumps(by_distance)).merged_by_strand()
    assert (again.strand.tolist(), again.row.tolist()) == (by_distance.strand.tolist(), by_distance.row.tolist())
    columns = ("ray", "strand", "t", "t_out", "distance")
    rows = [sorted(zip(*(getattr(hits, name) for name in columns), strict=True)) for hits in (by_t, by_distance)]
    assert rows[0] == rows[1]


def test_merging_needs_intervals():
    tree = fl.build(skipped_lines())
    with pytest.raises(fl.InputError, match="it needs at='surface'"):
        tree.all_hits(*rays(), 0.1, merge="strand")
    with pytest.raises(fl.InputError, match="merge='segment' is not a choice"):
        tree.all_hits(*rays(), 0.1, at="surface", merge="segment")
    with pytest.raises(fl.InputError, match="is for query='all_hits'"):
        fl.brute_force(skipped_lines(), *rays(), 0.1, query="first_hit", at="surface", merge="strand")
    with pytest.raises(fl.InputError, match="only hits at='surface' have intervals"):
        tree.all_hits(*rays(), 0.1).merged_by_strand()
