"""Rays in arrays of Dask: hits are arrays of Dask, and what they compute is what one tree answers."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest
from test_mapped_rays import assert_same, rays, scene

import fastlines as fl
from fastlines.forest.mapping.forest_address import ForestAddress
from fastlines.query.hits import AllHits, FirstHits

array = pytest.importorskip("dask.array")


@pytest.fixture(scope="module")
def tree() -> fl.Tree:
    return fl.build(scene())


@pytest.fixture(scope="module")
def forest(tree, tmp_path_factory) -> fl.Forest:
    path = tmp_path_factory.mktemp("forest") / "tree.flt"
    tree.save(path)
    return fl.Forest(path)


def given(n: int = 600, chunk: int = 170):
    origins, directions = (part.reshape(n // 6, 6, 3) for part in rays(n))
    chunks = (chunk // 6, 4, 2)
    return (origins, directions), (array.from_array(origins, chunks), array.from_array(directions, chunks))


@pytest.mark.parametrize("options", [{}, {"at": "surface"}, {"at": "entry"}, {"spread": 0.02}, {"ignore": [1, 2, 3]}])
def test_first_hits(tree, forest, options):
    plain, lazy = given()
    found = forest.first_hit(*lazy, 0.03, **options)
    assert found.t.chunks == lazy[0].chunks[:2]
    assert "DaskFirstHits" in repr(found)
    expected = tree.first_hit(*plain, 0.03, **options)
    assert (found.t_out is None) == (expected.t_out is None)
    assert np.array_equal(found.strand.compute(), expected.strand)
    assert np.array_equal(found.hit.compute(), expected.hit)
    computed = found.compute()
    assert isinstance(computed, FirstHits)
    assert_same(computed, expected)


def test_lists_of_hits(tree, forest):
    plain, lazy = given()
    for query, options in (
        ("all_hits", {}),
        ("all_hits", {"at": "surface", "merge": "strand"}),
        ("all_hits", {"at": "entry"}),
        ("next_hits", {"k": 2, "rank": "distance"}),
    ):
        found, expected = (getattr(of, query)(*some, 0.03, **options) for of, some in ((forest, lazy), (tree, plain)))
        assert found.counts.shape == (600,)
        computed = found.compute()
        assert isinstance(computed, AllHits)
        assert_same(computed, expected)


def test_any_and_count(tree, forest):
    plain, lazy = given()
    for query in ("any_hit", "count_hits"):
        found, expected = getattr(forest, query)(*lazy, 0.03), getattr(tree, query)(*plain, 0.03)
        assert found.dtype == expected.dtype
        assert np.array_equal(found.compute(), expected)


def test_what_rays_have_each(tree, forest):
    plain, lazy = given()
    radius = np.random.default_rng(0).uniform(0, 0.1, plain[0].shape[:-1])
    expected = tree.first_hit(*plain, radius, t_max=radius * 20)
    for radii in (radius, array.from_array(radius, (50, 3))):
        assert_same(forest.first_hit(*lazy, radii, t_max=radius * 20).compute(), expected)
    # One direction for all, as an array of NumPy.
    expected = tree.first_hit(plain[0], [0, 0, 1], 0.03)
    assert_same(forest.first_hit(lazy[0], [0, 0, 1], 0.03).compute(), expected)


def test_workers_of_dask(tree, forest, client):
    plain, lazy = given()
    found = forest.on(client).first_hit(*lazy, 0.03)
    assert_same(found.compute(scheduler=client), tree.first_hit(*plain, 0.03))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"ignore": np.zeros((100, 6, 1), int)}, "ignore is for each ray; with rays in arrays of Dask give numbers"),
        ({"progress": True}, "there is no progress now; leave progress= out"),
        ({"t_max": np.ones(7)}, "shapes of rays do not match"),
        ({"at": "inside"}, "at='inside' is not a choice"),
    ],
)
def test_what_is_refused_at_once(forest, options, said):
    with pytest.raises(fl.InputError, match=re.escape(said)):
        forest.first_hit(*given()[1], 0.03, **options)


def test_other_errors(forest):
    lazy = given()[1]
    bare = lazy[0].reshape(-1, 3)
    with pytest.raises(fl.InputError, match="blocks of unknown sizes; call compute_chunk_sizes"):
        forest.any_hit(bare[bare[:, 0] > 0], [0, 0, 1], 0.1)
    with pytest.raises(fl.InputError, match=r"origins have shape \(100, 6, 2\) and directions"):
        forest.any_hit(lazy[0][..., :2], lazy[1], 0.1)
    found = forest.first_hit(lazy[0], lazy[1] * np.nan, 0.03)
    with pytest.raises(fl.WorkerError, match=r"process .*: .* have a direction that is not finite"):
        found.compute()
    assert not forest.any_hit(lazy[0], lazy[1] * np.nan, 0.03, invalid="skip").compute().any()
    with pytest.raises(fl.InputError, match="are not listed in parts"):
        forest.iter_all_hits(*lazy, 0.03, max_bytes=1000)


def test_without_offset(tmp_path):
    segments = scene().segments.astype(np.float64) + np.array([1000, 0, 0])
    whole = fl.build_forest(segments, tmp_path / "forest", max_segments=100, offset=[1000, 0, 0])
    forest = pickle.loads(pickle.dumps(whole.without_offset()))
    plain, lazy = given()
    found = forest.first_hit(*lazy, 0.03)
    ForestAddress.of(whole.on(map))  # the same files, with the offset
    assert_same(found.compute(), whole.without_offset().first_hit(*plain, 0.03))
    assert forest.first_hit(*plain, 0.03).hit.any()


def test_blocks_are_not_mapped_again(forest):
    def failing(function, tasks):
        raise AssertionError("blocks are tasks already")

    plain, lazy = given()
    found = forest.on(failing).first_hit(*lazy, 0.03)
    assert_same(found.compute(scheduler="synchronous"), forest.first_hit(*plain, 0.03))
