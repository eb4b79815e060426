"""Lines that run along each other: `best` leaves them whole, and cuts all others as without `min_spread`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from support.nasty import boxes_of, same, triangles_on

import fastlines as fl

Ends = npt.NDArray[np.float32]
EFFORTS = (0.0, 0.5, 1.0)
AIMS: dict[str, dict[str, Any]] = {"queries": {}, "bvh": {"cost": fl.Cost(2.0)}, "kd": {"boxes": "cut"}}
#: References a segment, at most. A KD tree can not leave lines whole.
MOST = {"queries": 2.0, "bvh": 2.0, "kd": 8.0}


def pieces_of_a_line(n: int, spread: float = 0.0, axis: tuple[float, float, float] = (1.0, 0.7, 0.4)) -> Ends:
    """Pieces of a tenth of its length, which begin anywhere, moved by up to so much."""
    rng = np.random.default_rng(4)
    starts = rng.random((n, 1)) * axis + rng.uniform(-spread, spread, (n, 3))
    return np.stack([starts, starts + 0.1 * np.array(axis)], axis=1).astype(np.float32)


def circling(n_windings: int, n_steps: float) -> Ends:
    """Windings that come back to each other within a ten-thousandth, on three ellipses."""
    rng = np.random.default_rng(5)
    segments = []
    for _ in range(3):
        a, b, centre = rng.normal(size=(3, 3))
        angle = np.arange(int(n_windings * n_steps) + 1)[:, None] * (2 * np.pi / n_steps)
        points = centre + np.cos(angle) * a + np.sin(angle) * b + rng.uniform(-1e-4, 1e-4, (len(angle), 3))
        segments.append(np.stack([points[:-1], points[1:]], axis=1))
    return np.concatenate(segments).astype(np.float32)


def star(n: int) -> Ends:
    """Lines that all pass through one point."""
    ways = np.random.default_rng(6).normal(size=(n, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return np.stack([-ways, ways], axis=1).astype(np.float32)


RETRACED = {
    "pieces of a line": pieces_of_a_line(20_000),
    "along an axis, nearly": pieces_of_a_line(20_000, axis=(1.0, 1e-3, 2e-3)),
    "far from zero": pieces_of_a_line(20_000) + np.float32(100),
    "nearly one line": pieces_of_a_line(20_000, 2e-4),
    "one segment": np.tile(np.float32([[[0, 0, 0], [1, 0.9, 0.8]]]), (20_000, 1, 1)),
    "windings in step": circling(150, 40.0),
    "windings out of step": circling(150, 80.37),
}


@pytest.mark.parametrize("aim", AIMS)
@pytest.mark.parametrize("name", RETRACED)
def test_lines_that_run_along_each_other_are_left_whole(name: str, aim: str) -> None:
    ends = RETRACED[name]
    for effort in EFFORTS:
        tree = fl.build(ends, effort=effort, **AIMS[aim])
        assert tree.n_refs < MOST[aim] * len(ends), effort
        assert "max_refs" not in tree.limits_hit
        assert tree.settings.min_spread > 0
        if aim == "queries":
            assert tree.nodes["n_refs"][tree.is_leaf].max() <= 16


@pytest.mark.parametrize("aim", AIMS)
def test_their_trees_answer_as_brute_force(aim: str) -> None:
    for name in ("nearly one line", "windings out of step"):
        ends = RETRACED[name][:4000]
        tree = fl.build(ends, **AIMS[aim])
        tree.validate()
        rng = np.random.default_rng(7)
        targets = ends.mean(axis=1)[rng.integers(len(ends), size=60)] + rng.normal(0, 1e-3, (60, 3))
        ways = rng.normal(size=(60, 3))
        rays = {"origins": targets - 2 * ways, "directions": ways, "radius": 1e-3}
        for query in ("first_hit", "all_hits"):
            found, right = getattr(tree, query)(**rays), fl.brute_force(ends, **rays, query=query)
            for column in ("t", "prim", "u", "distance"):
                assert np.array_equal(getattr(found, column), getattr(right, column)), (name, query, column)


@pytest.mark.parametrize("aim", AIMS)
def test_they_are_the_same_for_all_threads_and_saved(aim: str, tmp_path: Path) -> None:
    ends = RETRACED["windings out of step"]
    fl.set_num_threads(1)
    alone = fl.build(ends, **AIMS[aim])
    fl.set_num_threads(3)
    assert same(alone, fl.build(ends, **AIMS[aim]))
    fl.set_num_threads(None)
    alone.save(tmp_path / "tree.flt")
    assert fl.load(tmp_path / "tree.flt").settings == alone.settings


@pytest.mark.parametrize("aim", AIMS)
def test_lines_a_little_apart_are_cut(aim: str) -> None:
    ends = pieces_of_a_line(5000, 0.01)
    for effort in EFFORTS[: 3 if aim == "queries" else 1]:
        tree, all_cut = (
            fl.build(ends, "best", effort=effort, **AIMS[aim], **more)
            for more in ({}, {"min_spread": 0.0})  # type: ignore[arg-type]
        )
        assert 0.95 * all_cut.n_refs < tree.n_refs <= all_cut.n_refs
        assert tree.n_refs > 1.4 * len(ends)


@pytest.mark.parametrize("aim", AIMS)
def test_lines_through_one_point_are_cut(aim: str) -> None:
    for effort in EFFORTS:
        tree, all_cut = (
            fl.build(star(300), "best", effort=effort, **AIMS[aim], **more)
            for more in ({}, {"min_spread": 0.0})  # type: ignore[arg-type]
        )
        assert tree.n_refs > 0.98 * all_cut.n_refs
        assert tree.cost() < 1.002 * all_cut.cost()


@pytest.mark.slow
@pytest.mark.parametrize("scene", fl.scenes.NAMES)
def test_the_scenes_of_the_thesis_are_cut_as_ever(scene: str) -> None:
    lines = fl.scenes.make(scene, 3000).lines
    for effort in EFFORTS:
        assert same(fl.build(lines, effort=effort), fl.build(lines, "best", effort=effort, min_spread=0.0))
    for aim in ("bvh", "kd"):
        tree, all_cut = (
            fl.build(lines, "best", **AIMS[aim], **more)
            for more in ({}, {"min_spread": 0.0})  # type: ignore[arg-type]
        )
        assert tree.cost() < 1.002 * all_cut.cost()
        assert tree.n_refs <= all_cut.n_refs


@pytest.mark.slow
def test_it_is_a_setting_of_any_build() -> None:
    ends = RETRACED["pieces of a line"][:2000]
    for splits in (fl.PlaneGrid(8), (fl.ObjectSweep(), fl.PlaneGrid(8)), fl.BinnedPlanes(8)):
        limits = fl.Limits(max_leaf_refs=16, max_refs=60_000)
        tree, all_cut = (
            fl.build(ends, splits=splits, limits=limits, min_spread=spread)  # type: ignore[arg-type]
            for spread in (1e-4, 0)
        )
        tree.validate()
        assert tree.settings.min_spread == 1e-4
        assert tree.n_refs < 4000 < 2 * all_cut.n_refs
    for spread in (-0.1, 1.5, float("nan"), "wide"):
        with pytest.raises(fl.InputError, match=r"min_spread=.*0 to 1"):
            fl.build(ends, min_spread=spread)  # type: ignore[arg-type]


def test_other_primitives_are_cut_as_without_it() -> None:
    ends = pieces_of_a_line(200)
    for geometry in (triangles_on(ends), boxes_of(ends)):
        given = {"splits": fl.PlaneGrid(4), "limits": fl.Limits(max_refs=2000)}
        assert same(*(fl.build(geometry, min_spread=spread, **given) for spread in (0.0, 0.1)))  # type: ignore[arg-type]
