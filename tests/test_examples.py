"""The examples run, and write a picture; tori are hit where their equation says."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from PIL import Image
from support.answers import assert_same

import fastlines as fl

EXAMPLES = Path(__file__).parents[1] / "examples"
#: Small pictures of little, by example: the arguments after the path of the picture.
SMALL: dict[str, tuple[int, ...]] = {
    "streamlines": (48, 30),
    "hair_colours": (40, 3000),
    "torus": (48, 60),
    "hair_and_head": (40, 300),
    "taper": (64, 80),
    "million_strands": (48, 2000, 2),
}


def run_example(name: str) -> ModuleType:
    """Import an example."""
    spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_no_example_is_left_out() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {*SMALL, "blender_hair"}  # for which there is test_blender


@pytest.mark.parametrize("name", SMALL)
def test_an_example_writes_a_picture(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "picture.png"
    run_example(name).main(str(path), *SMALL[name])
    assert capsys.readouterr().out.startswith(f"{path}: ")
    with Image.open(path) as picture:
        pixels = np.asarray(picture)
    assert pixels.shape[1] >= SMALL[name][0]
    assert pixels.shape[2] == 3
    assert (pixels.reshape(-1, 3).std(axis=0) > 5).all()


@pytest.fixture(scope="module")
def tori() -> Iterator[Any]:
    """Tori of all sizes, one with a tube so thick that there is no hole."""
    rng = np.random.default_rng(2)
    axis = rng.normal(size=(200, 3))
    axis[:3] = np.eye(3)
    ring = rng.uniform(0.05, 0.8, 200)
    tube = ring * rng.uniform(0.02, 0.9, 200)
    tube[0] = 1.3 * ring[0]
    return run_example("torus").Tori(
        rng.uniform(-2, 2, (200, 3)), axis / np.linalg.norm(axis, axis=1)[:, None], ring, tube
    )


def some_rays(n: int) -> tuple[Any, Any]:
    rng = np.random.default_rng(3)
    origins = rng.uniform(-3, 3, (n, 3)).astype(np.float32)
    directions = rng.normal(size=(n, 3)).astype(np.float32)
    directions[: n // 8] = np.eye(3)[rng.integers(0, 3, n // 8)] * 2  # along axes, and not of unit length
    return origins, directions


def around_ring(tori: Any, ids: Any, points: Any) -> tuple[Any, Any]:
    """Return the distance of points from the axes, and along them."""
    away = points - tori.centre[ids]
    along = (away * tori.axis[ids]).sum(axis=-1)
    return np.linalg.norm(away - along[..., None] * tori.axis[ids], axis=-1), along


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_tori_are_hit_as_by_brute_force(tori: Any, radius: float) -> None:
    tree, rays = fl.build(tori), some_rays(1000)
    hits = tree.first_hit(*rays, radius)
    assert 0.2 < hits.hit.mean() < 0.9
    assert_same(hits, fl.brute_force(tori, *rays, radius, query="first_hit"))
    assert_same(tree.all_hits(*rays, radius), fl.brute_force(tori, *rays, radius, query="all_hits"))


def test_points_and_normals_satisfy_the_equation(tori: Any) -> None:
    hits = fl.build(tori).first_hit(*some_rays(3000), at="surface")
    entered = hits.hit & (hits.t > 0)
    ids, points, normals = hits.prim[entered], hits.points()[entered], hits.normals()[entered]
    across, along = around_ring(tori, ids, points)
    assert np.abs(np.hypot(across - tori.ring[ids], along) - tori.tube[ids]).max() < 1e-5
    # The gradient of (|x|² + R² − r²)² − 4R²(|x|² − (x·n)²).
    away, ring, tube = points - tori.centre[ids], tori.ring[ids], tori.tube[ids]
    k = (away * away).sum(axis=1) + ring**2 - tube**2
    gradient = (4 * k - 8 * ring**2)[:, None] * away + (8 * ring**2 * along)[:, None] * tori.axis[ids]
    gradient /= np.linalg.norm(gradient, axis=1, keepdims=True)
    assert np.abs(normals - gradient).max() < 1e-3


def test_no_torus_is_entered_late_or_missed(tori: Any) -> None:
    """Points on rays, close together: the first that is inside is hardly behind the hit."""
    origins, directions = some_rays(400)
    directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    hits = fl.build(tori).first_hit(origins, directions)
    step = 0.004
    t = np.arange(0, 8, step)
    for i, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        near = np.flatnonzero(np.linalg.norm(np.cross(tori.centre - origin, direction), axis=1) < tori.ring + tori.tube)
        points = np.repeat((origin + t[:, None] * direction)[:, None], len(near), axis=1)
        across, along = around_ring(tori, near, points)
        inside = (np.hypot(across - tori.ring[near], along) < tori.tube[near] - 1e-6).any(axis=1)
        first = t[inside.argmax()] if inside.any() else np.inf
        assert hits.t[i] <= first + 1e-5
