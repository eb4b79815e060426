"""Limits of rays: hits up to them are found, whatever lies beyond, and nothing is clipped there."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from support.builds import KINDS

import fastlines as fl
from fastlines.query.at import At
from fastlines.query.backend import KERNELS
from fastlines.query.queries import check_query
from fastlines.query.ray_arguments import RayArguments
from fastlines.query.rays import NO_LIMIT, SPREAD_LIMIT, RayBatch


def tree_and_rays(kind: str, spread: float) -> tuple[fl.Tree, RayBatch]:
    rng = np.random.default_rng(4)
    centres = rng.random((400, 1, 3))
    segments = (centres + rng.normal(0, 0.05, (400, 2, 3))).astype(np.float32)
    segments[200:] = segments[:200]  # every hit ties with another
    origins = rng.normal(0.5, 1.0, (300, 3))
    directions = (rng.random((300, 3)) - origins) * 10 ** rng.uniform(-2, 2, (300, 1))
    tree = fl.build(KINDS[kind](segments))
    given = RayArguments(origins, directions, 0.03, spread=spread)
    return tree, check_query(tree.geometry, tree.nodes["box"][0], given)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("spread", [0.0, 0.01])
@pytest.mark.parametrize("kind", ["segments", "round cones"])
def test_hits_up_to_the_limit_are_found(kind: str, spread: float, kernel: str) -> None:
    tree, rays = tree_and_rays(kind, spread)
    backend = tree._backend(kernel, rays)
    offsets, all_columns = backend.list_hits(rays, "closest", None, False, None)
    counts = np.diff(offsets)
    hit = counts > 0
    rng = np.random.default_rng(5)
    place = offsets[:-1][hit] + rng.integers(0, counts[hit])
    limit = np.full(len(rays), np.inf, np.float32)
    limit[hit] = all_columns[0][place]
    limited = replace(rays, limit=limit)
    # First hits are those without a limit, as it is the t of a hit.
    places: tuple[At, ...] = get_args(At)
    for at in places[:1] if spread else places:
        wanted = backend.first_hit(rays, at, None)
        got = backend.first_hit(limited if at == "closest" else replace(rays, limit=wanted[0]), at, None)
        for column, expected in zip(got, wanted, strict=True):
            assert column is expected is None or np.array_equal(column, expected)
    # Of the next ones, all up to the limit are there, with their ties.
    got_offsets, got = backend.list_hits(limited, "closest", 1000, False, None)
    n_up_to = np.add.reduceat(np.append(all_columns[0] <= np.repeat(limit, counts), 0), offsets[:-1]) * hit
    assert (np.diff(got_offsets) >= n_up_to).all()
    assert n_up_to.sum() > 2 * hit.sum()
    for ray in np.flatnonzero(hit):
        for column, expected in zip(got[:4], all_columns[:4], strict=True):
            end = got_offsets[ray] + n_up_to[ray]
            assert np.array_equal(column[got_offsets[ray] : end], expected[offsets[ray] : offsets[ray] + n_up_to[ray]])


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_limit_before_all_hits_saves_work(kernel: str) -> None:
    tree, rays = tree_and_rays("segments", 0.0)
    backend = tree._backend(kernel, rays)
    first = backend.first_hit(rays, "closest", None)[0]
    # A tenth of the way to the first hit: what is found lies beyond it, and may be nothing.
    nearer = replace(rays, limit=np.where(np.isfinite(first), first / 10, np.inf).astype(np.float32))
    t, prim, *_ = backend.first_hit(nearer, "closest", None)
    assert ((prim == -1) | (t >= first)).all()
    assert (prim == -1).sum() > (first == np.inf).sum() or kernel == "bundle"


def test_parts_of_a_batch_keep_their_limits() -> None:
    _, rays = tree_and_rays("segments", 0.0)
    assert rays.limit is NO_LIMIT
    assert rays.arrays()[-1] is None
    assert rays.some(np.arange(3)).limit is NO_LIMIT
    limited = replace(rays, limit=np.arange(len(rays), dtype=np.float32))
    assert limited.some(np.array([7, 2])).limit.tolist() == [7, 2]
    assert limited.part(5, 8).limit.tolist() == [5, 6, 7]
    assert limited.arrays()[-1] is limited.limit


def test_a_spread_up_to_the_limit_is_taken() -> None:
    tree = fl.build([[[0, 0, 0], [1, 0, 0]]])
    limit = np.float32(SPREAD_LIMIT)
    assert tree.any_hit([0.5, 0, 0], [0, 0, 1], 0, spread=limit)
    with pytest.raises(fl.InputError, match=r"a spread that is not a number from 0 to 1e\+12"):
        tree.any_hit([0.5, 0, 0], [0, 0, 1], 0, spread=np.nextafter(limit, np.float32(np.inf)))
