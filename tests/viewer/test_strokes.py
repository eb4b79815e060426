"""What is drawn of each kind of geometry, and which part of many primitives."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.viewer.strokes import strokes_of
from fastlines.viewer.thinning import thinned_rows

HAIR = fl.Lines.from_strands(np.random.default_rng(0).uniform(0, 1, (500, 8, 3)))
SPHERES = fl.Spheres.from_centres([[0, 0, 0], [4, 0, 0]], radius=[1, 2])
FLOOR = fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[5, 5, 5], [6, 5, 5], [5, 6, 5]]])
CURVES = fl.Curves.from_bezier(np.random.default_rng(1).uniform(0, 1, (3, 4, 3)))


@pytest.mark.parametrize("most", [1, 6, 7, 100, 1000, 3499])
def test_whole_strands_are_taken_and_no_more_than_wanted(most: int) -> None:
    rows = thinned_rows(HAIR, most)
    assert len(rows) <= most
    assert (np.diff(rows) > 0).all()
    if most >= 100:
        assert len(rows) > 0.8 * most
        assert (np.bincount(HAIR.strands[rows])[np.unique(HAIR.strands[rows])] == 7).all()


def test_long_strands_are_taken_in_runs() -> None:
    line = fl.Lines.from_strands([np.random.default_rng(0).uniform(0, 1, (10_001, 3))])
    rows = thinned_rows(line, 320)
    assert len(rows) == 320
    assert (np.diff(rows) == 1).sum() == 310  # ten runs of 32


def test_all_is_shown_if_there_is_room() -> None:
    strokes = strokes_of(HAIR)
    assert np.array_equal(strokes.ends, HAIR.segments)
    assert np.array_equal(strokes.prims, np.arange(3500))
    assert strokes.caption == "3,500 segments, all shown"


def test_the_page_says_what_is_left_out() -> None:
    assert strokes_of(HAIR, 700).caption == "700 of 3,500 segments are shown; queries use all"


def test_cut_planes_hide_what_is_beyond_and_thin_what_is_left() -> None:
    slab = np.array([[0, 0, 0.4], [1, 1, 0.6]])
    middles = HAIR.segments.mean(axis=1)[:, 2]
    inside = np.flatnonzero((middles >= 0.4) & (middles <= 0.6))
    strokes = strokes_of(HAIR, slab=slab)
    assert strokes.prims.tolist() == inside.tolist()
    assert strokes.n_cut == 3500 - len(inside)
    assert f"the cut planes hide {3500 - len(inside):,}" in strokes.caption
    assert set(strokes_of(HAIR, 100, slab).prims) <= set(inside)


def test_cut_planes_hide_triangles_too() -> None:
    strokes = strokes_of(FLOOR, slab=np.array([[-1, -1, -1], [2, 2, 2.0]]))
    assert set(strokes.prims) == {0}
    assert (strokes.n_shown, strokes.n_cut) == (1, 1)


@pytest.mark.parametrize(("geometry", "each"), [(CURVES, 8), (SPHERES, 48), (FLOOR, 3)])
def test_strokes_of_other_kinds(geometry: fl.Curves | fl.Spheres | fl.Triangles, each: int) -> None:
    strokes = strokes_of(geometry)
    assert np.bincount(strokes.prims).tolist() == [each] * len(geometry)
    low, high = np.asarray(geometry.bounds, np.float64)
    beyond = geometry.max_radius + 1e-4
    assert (strokes.ends >= low - beyond).all()
    assert (strokes.ends <= high + beyond).all()


def test_spheres_are_circles_of_their_radius() -> None:
    strokes = strokes_of(SPHERES)
    away = np.linalg.norm(strokes.ends - SPHERES.centres[strokes.prims][:, None], axis=2)
    assert away == pytest.approx(np.broadcast_to(SPHERES.radius[strokes.prims, None], away.shape), rel=1e-5)


def test_parts_are_counted_together() -> None:
    strokes = strokes_of(fl.Geometry([FLOOR, CURVES, SPHERES]))
    assert np.bincount(strokes.prims).tolist() == [3] * 2 + [8] * 3 + [48] * 2
    assert strokes.caption == "7 primitives, all shown"


def test_primitives_of_ones_own_are_shown_as_boxes() -> None:
    class Ball:
        def bounds(self) -> np.ndarray:
            return np.array([[[0, 0, 0], [1, 1, 1]], [[2, 0, 0], [3, 1, 1]]], float)

        def hit(self, ids: np.ndarray, rays: fl.Rays, radius: np.ndarray) -> dict[str, np.ndarray]:
            return {"t": np.full(len(ids), np.inf)}

    strokes = strokes_of(fl.build(Ball()).geometry)
    assert np.bincount(strokes.prims).tolist() == [24, 24]


def test_all_parts_together_are_thinned() -> None:
    random = np.random.default_rng(0)
    parts = [fl.Spheres.from_centres(random.uniform(0, 1, (100, 3)), radius=0.1) for _ in range(4)]
    strokes = strokes_of(fl.Geometry(parts), 1000)  # 48 strokes each
    assert len(strokes.ends) <= 1000
    assert strokes.caption == "20 of 400 primitives are shown; queries use all"
