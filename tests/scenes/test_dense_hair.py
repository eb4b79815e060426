"""Interpolated strands: as many as asked for, between their guides, and the same each time."""

import numpy as np
import pytest

import fastlines as fl
from fastlines.scenes import dense_hair

RNG = np.random.default_rng(1)
#: Two tufts far from each other, of upright guides.
GUIDES = np.zeros((60, 5, 3), np.float32)
GUIDES[..., 0] = np.where(np.arange(60) < 30, 0, 100)[:, None] + RNG.random((60, 1))
GUIDES[..., 2] = RNG.random((60, 1))
GUIDES[..., 1] = np.linspace(0, 2, 5)


def test_strands_are_between_guides():
    lines = dense_hair(GUIDES, 5000)
    assert (len(lines), lines.n_strands) == (20_000, 5000)
    x, y, z = np.moveaxis(lines.segments, 2, 0)
    assert ((x < 2) | (x > 98)).all()  # no strand mixes both tufts
    assert 0.4 < (x > 50).mean() < 0.6
    assert z.min() > -0.5
    assert z.max() < 1.5
    # Roots move a little, and whole strands with them.
    assert np.abs(y.min()) < 0.5
    length = np.linalg.norm(lines.segments[:, 1] - lines.segments[:, 0], axis=1)
    assert length == pytest.approx(np.full(20_000, 0.5), rel=1e-3)


def test_the_same_seed_gives_the_same_strands():
    one, same, other = (dense_hair(GUIDES, 50, seed).segments for seed in (3, 3, 4))
    assert (one == same).all()
    assert (one != other).any()


def test_three_guides_are_enough():
    assert dense_hair(GUIDES[:3], 7).n_strands == 7


@pytest.mark.parametrize("shape", [(2, 5, 3), (9, 1, 3), (9, 5, 2), (9, 15)])
def test_other_shapes_are_refused(shape):
    with pytest.raises(fl.InputError, match="expected"):
        dense_hair(np.zeros(shape), 10)
