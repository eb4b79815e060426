"""Coherent rays that converge, diverge, twist or cross over: a bundle has to be as thick as where it is thickest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from support.answers import PLACES, assert_same, options
from support.slow import few_of

import fastlines as fl
from fastlines.query.queries import QUERIES

Array = npt.NDArray[Any]

#: How wide a bundle is before and behind the scene, as a fraction of its width, and by how much it turns in between.
KINDS = {
    "parallel": (1.0, 1.0, 0.0),
    "converging": (1.0, 0.05, 0.0),
    "diverging": (0.05, 1.0, 0.0),
    "to a point": (1.0, 0.0, 0.0),
    "from a point": (0.0, 1.0, 0.0),
    "crossing over": (1.0, -0.6, 0.0),
    "twisted": (1.0, 1.0, 0.9),
    "converging and twisted": (1.0, 0.1, -0.6),
}
SEEDS = range(6)


@pytest.fixture(autouse=True)
def any_simd() -> Iterator[None]:
    yield
    fl.set_simd(None)


def scene(rng: np.random.Generator, seed: int) -> Array:
    """Short or long segments around the origin, some tens to some thousands, of unit size."""
    n = int(10 ** rng.uniform(1.5, 3.3))
    start = rng.uniform(-1, 1, (n, 3))
    end = start + rng.normal(0, 0.05, (n, 3)) if seed % 2 else rng.uniform(-1, 1, (n, 3))
    return np.stack([start, end], axis=1)


def bundle(rng: np.random.Generator, kind: str, width: float, n: int) -> tuple[Array, Array]:
    """n × n rays between two squares across a random axis, one before and one behind a scene of unit size."""
    before, behind, turn = KINDS[kind]
    basis = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    at = np.linspace(-1, 1, n)
    x, y = (grid.reshape(-1, 1) for grid in np.meshgrid(at, at))
    cos, sin = np.cos(turn), np.sin(turn)
    shift = rng.uniform(-0.5, 0.5, 3)
    first = np.hstack([before * width * x, before * width * y, np.full_like(x, rng.uniform(-4, -0.5))])
    last = np.hstack([cos * x - sin * y, sin * x + cos * y, np.zeros_like(x)]) * behind * width
    last[:, 2] = rng.uniform(0.5, 4)
    origins, targets = first @ basis + shift, last @ basis + shift
    return origins, targets - origins


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", few_of(SEEDS, n=1))
def test_coherent_rays(seed: int, kind: str) -> None:
    rng = np.random.default_rng([seed, list(KINDS).index(kind)])
    size, offset = 10.0 ** rng.integers(-3, 4), rng.choice([0, 1e2, 1e4]) * rng.choice([-1, 1], 3)
    segments = ((scene(rng, seed) + offset) * size).astype(np.float32)
    tree = fl.build(segments, effort=float(rng.choice([0, 0.5, 1])))
    for n in (4, 8, 16, 24):
        origins, directions = bundle(rng, kind, 10 ** rng.uniform(-2.5, 0), n)
        rays = ((origins + offset) * size).astype(np.float32), (directions * size).astype(np.float32)
        rays = tuple(part[rays[1].any(axis=1)] for part in rays)
        asked: dict[str, Any] = {
            "radius": np.float32(size * rng.choice([0, 1e-5, 3e-3, 0.05])),
            "t_min": rng.choice([0, -np.inf, 0.3]),
            "t_max": rng.choice([np.inf, 0.5, 1]),
        }
        for query in QUERIES:
            for at in PLACES[query]:
                how = {**asked, "at": at} | options(query)
                expected = fl.brute_force(segments, *rays, query=query, **how)
                for simd in fl.available_simd():
                    fl.set_simd(simd)
                    for kernel in ("bundle", "auto"):
                        assert_same(getattr(tree, query)(*rays, **how, kernel=kernel), expected)
