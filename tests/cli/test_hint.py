"""The command line names a radius that suits where hardly any ray hits, and is silent where enough do."""

from __future__ import annotations

import re

import numpy as np
import pytest
from support.command_line import run

import fastlines as fl
from fastlines.rendering.suitable_radius import cross, round_numbers, small

pytestmark = pytest.mark.usefixtures("in_own_folder")


@pytest.fixture
def hair(in_own_folder):
    tree = fl.build(fl.scenes.make("bun-hair", 5000).lines)
    tree.save("hair.flt")
    return tree


def hinted(*args):
    """Run a command, and return the radius that it hints at and the shares of rays that it tells; None without."""
    ran = run(*args)
    assert ran.exit_code == 0, ran.output
    found = re.search(r"note: hardly any ray hits: (.*)% of .* radius (.*); with (.*) it would be (.*)%", ran.stderr)
    return found and tuple(map(float, found.groups()))


@pytest.mark.parametrize("radius", [0, 1e-6])
@pytest.mark.parametrize("kind", ["first", "any", "all", "count"])
def test_a_radius_that_is_tiny_for_the_scene(hair, radius, kind):
    few, told, suits, many = hinted("query", "hair.flt", "--camera", "64x48", "-r", radius, "-k", kind)
    assert few < 1
    assert told == radius
    assert many >= 25
    assert hinted("query", "hair.flt", "--camera", "64x48", "-r", suits, "-k", kind) is None


def test_the_shares_are_those_of_all_rays_that_cross_the_box(hair):
    rng = np.random.default_rng(0)
    rays = np.float32(np.concatenate([rng.random((20_000, 3)) * 2 - 1, rng.normal(size=(20_000, 3))], axis=1))
    np.save("rays.npy", rays)
    origins, directions = rays[:, :3], rays[:, 3:]
    few, _, suits, many = hinted("query", "hair.flt", "rays.npy", "-r", 1e-6)
    crossing = cross(hair.nodes["box"][0], origins, directions)
    assert 1000 < crossing.sum() < 15_000
    for share, radius in ((few, 1e-6), (many, suits)):
        exact = 100 * hair.any_hit(origins, directions, radius)[crossing].mean()
        assert abs(share - exact) < 3


def test_pictures_are_hinted_at_if_their_radius_is_given(hair):
    size = ("--width", 64, "--height", 48)
    assert hinted("render", "hair.flt", "-r", 1e-6, *size, "-o", "a.png") is not None
    assert hinted("render", "hair.flt", *size, "-o", "a.png") is None


def test_nothing_is_said_of_few_rays_or_of_rays_that_pass_by(hair):
    np.save("few.npy", np.float32([[0, 0, -5, 0, 0, 1]] * 50))
    np.save("away.npy", np.float32([[0, 0, -50, 0, 0, -1]] * 5000))
    for rays in ("few.npy", "away.npy"):
        assert hinted("query", "hair.flt", rays, "-r", 0) is None


def test_a_box_is_crossed_within_the_bounds_of_t():
    box = np.float32([[0, 0, 0], [1, 1, 0]])
    origins = np.float32([[0.5, 0.5, -1], [0.5, 0.5, -1], [2, 0.5, -1], [0, 0, -1], [0.5, 0.5, 1]])
    directions = np.float32([[0, 0, 1], [0, 0, -1], [0, 0, 1], [0, 0, 1], [0, 0, 1]])
    assert cross(box, origins, directions).tolist() == [True, False, False, True, False]
    assert cross(box, origins, directions, t_max=0.5).tolist() == [False] * 5
    assert cross(box, origins, directions, t_min=-2, t_max=3).tolist() == [True, True, False, True, True]


def test_round_numbers_lie_between():
    assert round_numbers(0.003, 0.2) == [0.005, 0.01, 0.02, 0.05, 0.1, 0.2]
    assert round_numbers(1, 1) == round_numbers(0, 1) == []
    assert small(1920, 1080) == (85, 48)
    assert small(10, 10) == (10, 10)


def test_rays_that_see_some_parts_are_hinted_at_for_these(in_own_folder):
    rng = np.random.default_rng(0)
    line = fl.Lines.from_segments([[[0, 0, 0], [3, 3, 0]]], radius=1e-3)
    wall = fl.Triangles([[[0, 0, 1], [3, 0, 1], [0, 3, 1]], [[9, 9, 0], [9, 9, 1], [9, 8, 0]]])
    fl.build(fl.Geometry([line, wall])).save("a.flt")
    fl.build(wall).save("wall.flt")
    np.save("rays.npy", np.concatenate([rng.random((2000, 2)) * 3, np.tile([-1, 0, 0, 1], (2000, 1))], axis=1))
    assert hinted("query", "a.flt", "rays.npy") is None
    assert hinted("query", "a.flt", "rays.npy", "--parts", "0") is not None
    # Of what the radius does not count for, none suits.
    beside = np.tile([6.0, 6, -1, 0, 0, 1], (2000, 1))
    np.save("beside.npy", beside)
    for given in (("a.flt", "--parts", "1"), ("wall.flt",)):
        assert hinted("query", given[0], "beside.npy", *given[1:]) is None
