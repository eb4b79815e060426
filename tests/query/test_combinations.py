"""Options of queries together, on every kind of geometry and tree, bit for bit as brute force answers."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same

import fastlines as fl
from fastlines.query.backend import KERNELS
from fastlines.query.queries import QueryName

PLACE = np.array([5.3e6, 4.1e5, 200.0])
N_RAYS = 40

#: Queries, and their arguments. The last ones are for rays without a spread.
CLOSEST: list[tuple[QueryName, dict[str, Any]]] = [
    *((query, {}) for query in ("first_hit", "any_hit", "count_hits", "all_hits")),
    ("next_hits", {"k": 3}),
    ("next_hits", {"k": 3, "rank": "distance"}),
]
SURFACE: list[tuple[QueryName, dict[str, Any]]] = [
    ("first_hit", {"at": "surface"}),
    ("all_hits", {"at": "surface", "merge": "strand"}),
    ("next_hits", {"k": 2, "at": "surface", "rank": "distance"}),
    *((query, {"at": "entry"}) for query in ("first_hit", "any_hit", "count_hits", "all_hits")),
]


def walks(rng: np.random.Generator) -> list[Any]:
    return [rng.random(3) + np.cumsum(rng.normal(0, 0.1, (n, 3)), axis=0) for n in rng.integers(1, 8, 12)]


def made(kind: str, rng: np.random.Generator, offset: Any) -> fl.Lines | fl.Curves | fl.Triangles | fl.Geometry:
    """Return some geometry near the offset."""
    how, to = {"offset": offset}, 0 if offset is None else offset
    if kind == "lines":
        return fl.Lines.from_strands([walk + to for walk in walks(rng)], **how)
    if kind == "cones":
        strands = walks(rng)
        radius = [rng.random(len(strand)) * 0.05 for strand in strands]
        return fl.Lines.from_strands([strand + to for strand in strands], radius=radius, **how)
    if kind == "spheres":
        return fl.Spheres.from_centres(rng.random((30, 3)) + to, rng.random(30) * 0.05, **how)
    if kind == "curves":
        return fl.Curves.from_strands(rng.random((14, 3)) + to, [4, 10], basis="bspline", radius=0.02, **how)
    if kind == "triangles":
        return fl.Triangles(rng.random((20, 3, 3)))
    return fl.Geometry(
        [made(part, rng, offset) for part in rng.permutation(["lines", "curves", "spheres", "triangles"])]
    )


def asked(rng: np.random.Generator, geometry: Any, offset: Any) -> dict[str, Any]:
    """Return rays with some of all options."""
    origins = rng.normal(0.5, 1.5, (N_RAYS, 3))
    directions = (rng.random((N_RAYS, 3)) - origins) * 10 ** rng.uniform(-1, 1, (N_RAYS, 1))
    options: dict[str, Any] = {
        "radius": rng.random(N_RAYS) * 0.2 if rng.random() < 0.5 else 0.05,
        "t_max": float(rng.uniform(0.1, 9)),
        "ignore": rng.integers(-1, len(geometry), 4 if rng.random() < 0.5 else (N_RAYS, 3)),
        "ignore_strands": rng.integers(-1, 2, 2),
        "parts": rng.integers(0, 4, 3),
        "spread": rng.random(N_RAYS) * 0.05 * (rng.random(N_RAYS) < 0.6),
    }
    can = {"ignore_strands": geometry.n_strands > 1, "parts": geometry.has_parts, "spread": geometry.takes_spread}
    chosen = {name: value for name, value in options.items() if can.get(name, True) and rng.random() < 0.6}
    to = 0 if offset is None else offset
    return {"radius": 0.05, **chosen, "origins": origins + to, "directions": directions}


def other_trees(tree: fl.Tree, path: Any) -> dict[str, fl.Tree]:
    """Return the same tree after what users do with trees."""
    _ = tree.layout
    tree.save(path)
    trees = {"built": tree, "pickled": pickle.loads(pickle.dumps(tree)), "loaded": fl.load(path)}
    if isinstance(tree.geometry, fl.Lines):
        trees["refitted"] = tree.refit(tree.geometry.segments.astype(np.float64) + tree.geometry.offset)
    return trees


@pytest.mark.filterwarnings("ignore::fastlines.QueryWarning")
@pytest.mark.parametrize("offset", [None, PLACE], ids=["near", "offset"])
@pytest.mark.parametrize("kind", ["lines", "cones", "spheres", "curves", "mixed"])
def test_all_options_together(kind: str, offset: Any, tmp_path: Any) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        geometry = made(kind, rng, offset)
        tree = fl.build(geometry, ("best", "kd-d2", "bvh-cl")[seed])
        assert tree.geometry.offset == (tuple(PLACE) if offset is not None else (0, 0, 0))
        trees = other_trees(tree, tmp_path / "a.flt")
        rays = asked(rng, geometry, offset)
        less = {**rays, "origins": rays["origins"] - np.array(tree.geometry.offset)}
        for query, how in CLOSEST + ([] if "spread" in rays else SURFACE):
            expected = fl.brute_force(geometry, **rays, query=query, **how)
            for i, (name, one) in enumerate(trees.items()):
                kernel = list(KERNELS)[(seed + i) % len(KERNELS)]
                found = getattr(one, query)(**rays, kernel=kernel, **how)
                assert_same(found, expected, f"seed {seed} {name} {kernel} {query} {how} {list(rays)}")
            assert_same(getattr(tree.without_offset(), query)(**less, **how), expected, f"seed {seed} without offset")
            if query in ("first_hit", "all_hits"):
                check_places(expected, rays)
            if query == "next_hits":
                check_order(expected, fl.brute_force(geometry, **rays, at=how.get("at", "closest")), how)


def check_places(hits: Any, rays: dict[str, Any]) -> None:
    """Points are where the rays are given, and hits without their rays and geometry still have a card."""
    hit, ray = hits.prim >= 0, hits.ray if isinstance(hits, fl.AllHits) else np.arange(N_RAYS)
    on_rays = rays["origins"][ray] + hits.t[:, None].astype(np.float64) * rays["directions"][ray]
    assert np.abs(hits.points()[hit] - on_rays[hit]).max(initial=0) < 2e-4
    along = np.linalg.norm(hits.tangents()[hit], axis=1)
    assert np.all(np.isnan(along) | (np.abs(along - 1) < 1e-6))
    again = pickle.loads(pickle.dumps(hits))
    assert again.strand.tolist() == hits.strand.tolist()
    assert "<div" in hits._repr_html_()
    assert "<div" in again._repr_html_()


def check_order(few: Any, every: Any, how: dict[str, Any]) -> None:
    """The k best hits are the first of all hits in their order."""
    keys = (every.prim_number, every.t, *([every.distance] if "rank" in how else []), every.ray)
    best = np.lexsort(keys)[np.arange(len(every)) - every.offsets[every.ray] < how["k"]]
    for name in ("ray", "prim_number", "t", "u", "distance"):
        assert getattr(few, name).tolist() == getattr(every, name)[best].tolist()


def test_what_is_ignored_and_what_was_not_selected_are_the_same() -> None:
    rng = np.random.default_rng(8)
    for kind in ("lines", "cones", "spheres", "curves"):
        geometry: Any = made(kind, rng, PLACE)
        left_out = rng.integers(0, len(geometry), 5)
        kept = np.setdiff1d(np.arange(len(geometry)), left_out)
        rays = asked(rng, geometry, PLACE)
        question = {name: rays[name] for name in ("origins", "directions")}
        for at in ("closest", "surface", "entry"):
            few = fl.build(geometry[kept]).first_hit(**question, radius=0.1, at=at)
            hits = fl.build(geometry).first_hit(**question, radius=0.1, at=at, ignore=left_out)
            assert np.where(few.hit, kept[few.prim], -1).tolist() == hits.prim.tolist()
            assert few.strand.tolist() == hits.strand.tolist()
            np.testing.assert_allclose(few.points(), hits.points(), atol=1e-4)
