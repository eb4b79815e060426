"""The nearest hits, and where rays enter capsules: each hit once, even if several pieces of a segment are hit."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from support.answers import assert_same, cases, question

import fastlines as fl
from fastlines.query.backend import KERNELS

WIDE = [kernel for kernel in KERNELS if kernel != "binary"]


def test_next_hits_are_the_first_of_all_hits() -> None:
    case = cases(3)["crossing"]
    asked, _ = question(case)
    tree = fl.build(case.segments)
    for at in ("closest", "surface"):
        every = tree.all_hits(**asked, at=at)
        assert every.counts.max() > 33
        for k, kernel in product((0, 1, 2, 7, 16, 33, 10_000), WIDE):
            few = tree.next_hits(**asked, k=k, at=at, kernel=kernel)
            assert (few.counts == np.minimum(every.counts, k)).all()
            chosen = np.concatenate([np.arange(a, a + n) for a, n in zip(every.offsets, few.counts, strict=False)])
            for name in ("t", "prim", "u", "distance") + ("t_out",) * (at == "surface"):
                assert (getattr(few, name) == getattr(every, name)[chosen.astype(int)]).all(), name
    for kernel in ("binary", *WIDE):
        assert len(tree.next_hits(**asked, k=0, kernel=kernel).t) == 0
    assert len(fl.brute_force(case.segments, **asked, query="next_hits", k=0).t) == 0
    for k in (-1, 1.5, None, "3"):
        with pytest.raises(fl.InputError, match="k="):
            tree.next_hits(**asked, k=k)


@pytest.mark.parametrize("radius", [1e-6, 1e-3, 0.1])
def test_rays_that_graze_capsules(radius: float) -> None:
    """The piece at whose point a ray enters reports the hit, though rounding moves the entry along the ray."""
    rng = np.random.default_rng(5)
    lines = fl.scenes.make("spaghetti", n_segments=300).lines
    tree = fl.build(lines)
    assert len(tree.refs) > 3 * len(lines)
    n = 3000
    start, end = lines.segments[rng.integers(0, len(lines), n)].astype(float).transpose(1, 0, 2)
    along = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    across = np.cross(along, rng.normal(size=(n, 3)))
    across /= np.linalg.norm(across, axis=1)[:, None]
    beside = start + rng.random((n, 1)) * (end - start) + across * radius * (1 - 10 ** rng.uniform(-8, -1, (n, 1)))
    d = along + np.cross(along, across) * 10 ** rng.uniform(-7, 1, (n, 1))
    rays = {"origins": beside - d * rng.uniform(0, 2, (n, 1)), "directions": d, "radius": radius, "at": "surface"}
    expected = fl.brute_force(lines, **rays, query="next_hits", k=2)
    assert expected.counts.sum() > 0.5 * n
    for kernel in WIDE:
        assert_same(tree.next_hits(**rays, k=2, kernel=kernel), expected)
        assert_same(tree.first_hit(**rays, kernel=kernel), fl.brute_force(lines, **rays, query="first_hit"))
