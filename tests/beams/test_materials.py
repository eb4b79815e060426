"""Mirrors, glass and diffuse surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from fastlines.beams.materials import Diffuse, Glass, Mirror, fresnel
from fastlines.support.counter_random import random_bits
from fastlines.support.vectors import dot

N = 20_000
KEYS = random_bits(1, np.arange(N))
UP = np.tile([0.0, 0.0, 1.0], (N, 1))


def towards(degrees):
    """Light that comes down at an angle to the normal."""
    angle = np.radians(degrees)
    return np.tile([np.sin(angle), 0.0, -np.cos(angle)], (N, 1))


@pytest.mark.parametrize("ior", [1.5, 1 / 1.5, 1.0])
@pytest.mark.parametrize("degrees", [0, 30, 41, 60])
def test_glass_refracts_by_snells_law_and_reflects_by_fresnels(ior, degrees):
    turn = Glass(ior).turn(towards(degrees), UP, KEYS)
    sine = np.sin(np.radians(degrees)) / ior
    share = fresnel(np.array([np.cos(np.radians(degrees))]), ior)[0]
    assert abs((~turn.passes).mean() - share) < 4 * np.sqrt(share * (1 - share) / N) + 1e-12
    if sine < 1:
        assert np.allclose(turn.directions[turn.passes], [sine, 0, -np.sqrt(1 - sine**2)])
    else:
        assert share == 1
    assert np.allclose(turn.directions[~turn.passes], towards(degrees)[0] * [1, 1, -1])
    assert (turn.weight == 1).all()


def test_light_leaves_glass_as_it_came():
    bent = Glass(1.5).turn(towards(50), UP, KEYS)
    inside = np.tile(bent.directions[bent.passes][0], (N, 1))
    again = Glass(1.5).turn(inside, -UP, KEYS)
    assert np.allclose(again.directions[again.passes], towards(50)[0])
    assert (~again.passes).mean() == pytest.approx((~bent.passes).mean(), abs=0.01)


def test_fresnel_at_brewsters_angle_and_straight_on():
    brewster = np.array([np.cos(np.arctan(1.5))])
    across = ((1 - 1.5**2) / (1 + 1.5**2)) ** 2
    assert fresnel(brewster, 1.5)[0] == pytest.approx(across / 2)
    assert fresnel(np.array([1.0, 0.0]), 1.5) == pytest.approx([0.04, 1.0])


def test_mirrors_and_diffuse_surfaces_keep_their_side():
    mirrored = Mirror((0.9, 0.8, 0.7)).turn(towards(30), UP, KEYS)
    assert np.allclose(mirrored.directions, towards(30) * [1, 1, -1])
    assert (mirrored.weight == [0.9, 0.8, 0.7]).all()
    for normals in (UP, -UP):
        cosine = dot(Diffuse(0.5).turn(towards(30), normals, KEYS).directions, UP)
        assert (cosine > 0).all()
        assert cosine.mean() == pytest.approx(2 / 3, abs=0.01)
