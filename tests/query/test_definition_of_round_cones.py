"""Hits of lines with a thickness are those of the definition in float64, which is a search and not a formula."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.theory.hits import deepest_approach

#: Rounding decides closer to the surface than this fraction of the scene's size.
BAND = 3e-7


def a_case(kind: str, rng: np.random.Generator) -> tuple[fl.Lines, np.ndarray, np.ndarray]:
    """Return 60 thick lines of a kind, and 300 rays that start and end anywhere."""
    start = rng.uniform(-1, 1, (60, 3))
    edge = rng.normal(size=(60, 3)) * (0.02 if kind == "contained" else 0.5)
    radii = rng.random((60, 2)) * (2.0 if kind == "larger than the scene" else 0.2)
    if kind == "balls":
        edge[:] = 0
    directions = rng.normal(size=(300, 3))
    if kind == "nearly parallel":
        directions = edge[rng.integers(0, 60, 300)] + rng.normal(size=(300, 3)) * 1e-3
    target = (start + rng.random((60, 1)) * edge)[rng.integers(0, 60, 300)] + rng.normal(size=(300, 3)) * 0.2
    origins = target - directions * rng.uniform(-1, 4, (300, 1))
    lines = fl.Lines.from_segments(np.stack([start, start + edge], axis=1), radius=radii)
    return lines, origins.astype(np.float32), directions.astype(np.float32)


@pytest.mark.parametrize("radius", [0.0, 0.05])
@pytest.mark.parametrize("kind", ["general", "contained", "balls", "nearly parallel", "larger than the scene"])
def test_hits_are_those_of_the_definition(kind: str, radius: float) -> None:
    rng = np.random.default_rng(len(kind))
    lines, origins, directions = a_case(kind, rng)
    t_max = np.where(rng.random(300) < 0.5, np.inf, rng.uniform(0, 3, 300)).astype(np.float32)
    hits = fl.build(lines).all_hits(origins, directions, radius, t_max=t_max)
    clearance, t, s = deepest_approach(
        lines.segments, lines.end_radii, origins, directions, np.float32(radius), t_max=t_max
    )
    found = np.zeros(clearance.shape, bool)
    found[hits.ray, hits.prim] = True
    size = float(np.ptp(lines.bounds, axis=0).max()) + lines.max_radius
    assert (found == (clearance <= 0))[np.abs(clearance) > BAND * size].all()
    assert 100 < len(hits) < found.size
    # The place of the closest approach, where it is not within rounding of a tie.
    length = np.sqrt((np.diff(lines.segments.astype(np.float64), axis=1)[:, 0] ** 2).sum(axis=1))[hits.prim]
    off = np.abs(hits.u - s[hits.ray, hits.prim]) * length
    assert np.quantile(off, 0.9) < 1e-4
    assert np.quantile(np.abs(hits.t - t[hits.ray, hits.prim]), 0.9) < 1e-4
