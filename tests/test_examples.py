"""The Python programs in examples/ run; ctest runs those in C++."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from support.answers import assert_same

import fastlines as fl

EXAMPLES = Path(__file__).parents[1] / "examples"


def load(name: str) -> Any:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("name", "size"), [("torus", ("40", "50")), ("hair_and_head", ("40", "200"))])
def test_an_example_makes_a_picture(name: str, size: tuple[str, str], tmp_path: Path) -> None:
    assert {path.stem for path in EXAMPLES.glob("*.py")} >= {name}
    load(name).main(str(tmp_path / "a.png"), *size)
    picture = np.asarray(Image.open(tmp_path / "a.png"))
    assert picture.shape == (40, 40, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100


def test_taper_draws_near_and_far(tmp_path: Path) -> None:
    load("taper").main(str(tmp_path / "a.png"), 120, 300)
    picture = np.asarray(Image.open(tmp_path / "a.png")).astype(float)
    assert picture.shape == (60, 240, 3)
    # With a spread, neighbouring pixels of the far blades differ less.
    without, with_spread = (np.abs(np.diff(half[:25], axis=1)).mean() for half in (picture[:, :120], picture[:, 120:]))
    assert with_spread < 0.7 * without


def test_tori_are_hit_where_they_are() -> None:
    torus, rng = load("torus"), np.random.default_rng(3)
    tori = torus.Tori(
        rng.uniform(-1, 1, (40, 3)), torus.unit(rng.normal(size=(40, 3))), rng.uniform(0.2, 0.5, 40), np.full(40, 0.08)
    )
    rays = rng.uniform(-3, 3, (4000, 3)).astype(np.float32), rng.normal(size=(4000, 3)).astype(np.float32)
    tree = fl.build(tori)
    for query in ("first_hit", "any_hit", "count_hits", "all_hits"):
        assert_same(getattr(tree, query)(*rays, 0.01), fl.brute_force(tori, *rays, 0.01, query=query))  # type: ignore[arg-type]
    hits = tree.first_hit(*rays)
    starts_outside = hits.hit & (hits.t > 0)
    assert starts_outside.sum() > 300
    points, prim = hits.points()[starts_outside], hits.prim[starts_outside]
    away = points - tori.centre[prim]
    height = (away * tori.axis[prim]).sum(axis=1)
    across = np.sqrt((away**2).sum(axis=1) - height**2)
    np.testing.assert_allclose(np.hypot(across - tori.ring[prim], height), 0.08, atol=1e-5)
    # Normals are those of the implicit surface.
    normals, step = hits.normals()[starts_outside], 1e-5

    def implicit(at: Any) -> Any:
        away = at - tori.centre[prim]
        height = (away * tori.axis[prim]).sum(axis=1)
        return np.hypot(np.sqrt((away**2).sum(axis=1) - height**2) - tori.ring[prim], height)

    gradient = np.stack([(implicit(points + d) - implicit(points - d)) / (2 * step) for d in step * np.eye(3)], axis=1)
    assert np.abs(normals - gradient).max() < 1e-3
