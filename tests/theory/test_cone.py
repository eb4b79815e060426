"""The round cone of the theory against points of it, and as a primitive of trees."""

from functools import partial

import numpy as np
import pytest
from support.theory_scenes import Ball

from fastlines import theory as th

RULES = {"tight": th.tight, "cut": th.cut}


def a_cone(rng: np.random.Generator) -> th.Cone:
    return th.cones(rng.normal(size=(1, 2, 3)), rng.choice([0.05, 0.5, 2], 2) * rng.random(2))[0]


def a_box(rng: np.random.Generator) -> th.Box:
    corners = rng.uniform(-2, 2, (2, 3))
    return th.Box(tuple(corners.min(axis=0).tolist()), tuple(corners.max(axis=0).tolist()))


def points_in(cone: th.Cone, box: th.Box, rng: np.random.Generator) -> np.ndarray:
    """Return points of balls of a cone, many of them on its surface, that lie in a box."""
    s, away = rng.random((40_000, 1)), rng.normal(size=(40_000, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    p, q = np.array(cone.p), np.array(cone.q)
    radius = cone.radii[0] + s * (cone.radii[1] - cone.radii[0])
    points = p + s * (q - p) + radius * rng.choice([1, 1, 0.9, 0.5], (40_000, 1)) * away
    return points[((points >= box.lo) & (points <= box.hi)).all(axis=1)]


@pytest.mark.parametrize("seed", range(40))
def test_a_part_is_bounded_by_the_smallest_box(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cone, box = a_cone(rng), a_box(rng)
    part, points = cone.clip(box), points_in(cone, box, rng)
    if part is None:
        assert len(points) == 0
        return
    lo, hi = part.bounds()
    assert (points >= np.array(lo) - 1e-9).all()
    assert (points <= np.array(hi) + 1e-9).all()
    # It cannot be smaller: a thin slice of the part lies at each of its sides.
    for axis in range(3):
        low, high = part.bounds().split(axis, lo[axis] + 1e-6)[0], part.bounds().split(axis, hi[axis] - 1e-6)[1]
        assert cone.clip(low) is not None
        assert cone.clip(high) is not None
        for away in (
            th.Box(box.lo, th.put(box.hi, axis, lo[axis] - 1e-6)),
            th.Box(th.put(box.lo, axis, hi[axis] + 1e-6), box.hi),
        ):
            assert cone.clip(away) is None


@pytest.mark.parametrize("seed", range(20))
def test_a_cone_of_one_ball_is_a_ball(seed: int) -> None:
    rng = np.random.default_rng(seed)
    centre, radius = rng.normal(size=3).astype(np.float32), np.float32(rng.random())
    (cone,) = th.cones([[centre, centre]], [[radius, radius]])
    ball, box = Ball(0, tuple(centre.tolist()), float(radius)), a_box(rng)
    part, expected = cone.clip(box), ball.clip(box)
    assert (part is None) == (expected is None)
    if part and expected:
        np.testing.assert_allclose(part.bounds(), expected.bounds(), atol=1e-12)


def test_a_cone_without_radius_is_a_segment() -> None:
    ends = [[[0, 0, 0], [4, 2, 1]]]
    box = th.Box((1.0, -1.0, -1.0), (2.0, 1.0, 1.0))
    (cone,), (segment,) = th.cones(ends, [[0, 0]]), th.segments(ends)
    np.testing.assert_allclose(cone.clip(box).bounds(), segment.clip(box).bounds(), atol=1e-12)


def test_what_cuts_nothing_changes_nothing() -> None:
    rng = np.random.default_rng(1)
    cone = a_cone(rng)
    part = cone.clip(cone.bounds().split(0, cone.p[0])[0])
    assert part is not None
    assert part.clip(part.bounds()) is part
    assert part.clip(cone.bounds()) is part
    assert part.clip(th.Box((8.0,) * 3, (9.0,) * 3)) is None


@pytest.mark.parametrize("rule", RULES)
def test_trees_over_cones_are_trees(rule: str) -> None:
    rng = np.random.default_rng(7)
    ends = rng.random((12, 1, 3)) + rng.normal(0, 0.4, (12, 2, 3))
    prims = th.cones(ends, 0.1 * rng.random((12, 2)))
    tree = th.build(prims, partial(th.plane_grid, n_planes=5, rule=RULES[rule]), c_trav=0.3, max_depth=6)
    assert len(tree.nodes()) > 15
    th.check(tree, prims, RULES[rule])
    assert th.f(tree, c_trav=0.3) == pytest.approx(th.g(tree, c_trav=0.3), rel=1e-12)
