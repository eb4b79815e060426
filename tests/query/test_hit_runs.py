"""All hits in parts that fit into memory: together the bits of `all_hits`, each within its bound."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import assert_same, cases, question

import fastlines as fl
from fastlines.query import run_lists

RNG = np.random.default_rng(0)
STRANDS = RNG.random((30, 1, 3)) + np.cumsum(RNG.normal(0, 0.05, (30, 8, 3)), axis=1)
LINES = fl.Lines.from_strands(STRANDS)
TREE = fl.build(LINES)
ORIGINS = RNG.normal(0.5, 1, (300, 3)).astype(np.float32)
DIRECTIONS = (RNG.random((300, 3)) - ORIGINS).astype(np.float32)


class Balls:
    """Balls of radius 0.05, as a class of the user's own."""

    centres = RNG.random((40, 3))

    def bounds(self) -> Any:
        return np.stack([self.centres - 0.05, self.centres + 0.05], axis=1)

    def hit(self, ids: Any, rays: Any, radius: Any) -> Any:
        d = rays.directions / np.linalg.norm(rays.directions, axis=1, keepdims=True)
        away = self.centres[ids] - rays.origins
        along = (away * d).sum(axis=1)
        near = np.linalg.norm(away - along[:, None] * d, axis=1) <= 0.05
        return np.where(near, along / np.linalg.norm(rays.directions, axis=1), np.inf)


@pytest.fixture(autouse=True)
def few_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Count few rays ahead, so that runs of rays cross the ends of what is counted."""
    monkeypatch.setattr(run_lists, "COUNTED_RAYS", 7)


def joined(parts: list[fl.AllHits], whole: fl.AllHits) -> fl.AllHits:
    """Join parts into the hits of all rays."""
    assert [part.first_ray for part in parts] == [0, *np.cumsum([len(part.counts) for part in parts])[:-1]]
    columns: dict[str, Any] = {}
    for name in ("t", "prim", "u", "distance", "t_out", "part"):
        each = [getattr(part, name) for part in parts]
        columns[name] = None if each[0] is None else np.concatenate(each)
    offsets = np.concatenate([[0], np.cumsum(np.concatenate([part.counts for part in parts]))])
    skipped = np.concatenate([part.first_ray + part.skipped for part in parts])
    return fl.AllHits(offsets, **columns, skipped=skipped, geometry=whole.geometry, rays=whole.rays)


def check(tree: fl.Tree, *rays: Any, max_bytes: int = 4000, **how: Any) -> list[fl.AllHits]:
    """Compare the parts with the whole, and return them."""
    whole = tree.all_hits(*rays, **how)
    parts = list(tree.iter_all_hits(*rays, max_bytes=max_bytes, **how))
    assert_same(joined(parts, whole), whole, str(how))
    return parts


@pytest.mark.parametrize("name", nasty.NAMES)
def test_parts_are_the_whole(name: str) -> None:
    case = cases(0)[name]
    asked, _ = question(case)
    tree = fl.build(case.segments)
    most = int(tree.count_hits(**asked).max())
    whole = tree.all_hits(**asked)
    parts = list(tree.iter_all_hits(**asked, max_bytes=40 * most + 8))
    assert_same(joined(parts, whole), whole, name)
    assert all(40 * len(part) + 8 * len(part.counts) <= 40 * most + 8 for part in parts)
    both = itertools.pairwise(parts)
    assert all(40 * (len(a) + b.counts[0]) + 8 * (len(a.counts) + 1) > 40 * most + 8 for a, b in both), "not full"


@pytest.mark.parametrize("at", ["closest", "surface", "entry"])
@pytest.mark.parametrize("kernel", ["auto", "single", "binary"])
def test_the_same_with_every_option(at: str, kernel: str) -> None:
    per_ray = {"t_min": RNG.uniform(-1, 0, 300), "t_max": RNG.uniform(1, 2, 300), "radius": RNG.uniform(0, 0.2, 300)}
    left_out: list[dict[str, Any]] = [
        {"ignore": [3, 7]},
        {"ignore": RNG.integers(-1, len(LINES), (300, 2)), "ignore_strands": RNG.integers(0, 30, (300, 1))},
        {"merge": "strand"} if at == "surface" else {},
    ]
    for how in left_out:
        parts = check(TREE, ORIGINS, DIRECTIONS, at=at, kernel=kernel, max_bytes=20_000, **per_ray, **how)
        assert len(parts) > 3
    assert len(check(TREE, ORIGINS[0], DIRECTIONS, 0.1, kernel=kernel, max_bytes=1 << 40)) == 1
    assert len(check(TREE, ORIGINS.reshape(3, 100, 3), [0, 0, 1], 0.1, kernel=kernel)) > 2


@pytest.mark.parametrize(
    "geometry",
    [
        fl.Curves.from_bezier(STRANDS[:, :4], 0.01),
        Balls(),
        fl.Geometry([fl.Triangles(RNG.random((30, 3, 3))), LINES.with_radius(0.02)]),
        fl.Lines.from_strands(np.add(STRANDS, [5e6, 0, 0]), offset="auto"),
    ],
    ids=["curves", "of the user's own", "parts", "far away"],
)
def test_the_same_for_every_kind(geometry: Any) -> None:
    tree = fl.build(geometry)
    offset = np.asarray(tree.geometry.offset)
    rays = ORIGINS + offset, DIRECTIONS, 0.1 if tree.geometry.max_radius == 0 else None
    parts = check(tree, *rays, max_bytes=60_000 if tree.geometry.has_user_code else 8000)
    assert len(parts) > 1
    whole = tree.all_hits(*rays)
    assert (np.concatenate([part.points() for part in parts]) == whole.points()).all()
    assert (np.concatenate([part.strand for part in parts]) == whole.strand).all()
    if tree.geometry.has_parts:
        check(tree, *rays, max_bytes=60_000, parts=[1], at="surface", merge="strand")


def test_each_part_has_the_rays_of_its_hits() -> None:
    bad = np.array([5, 100, 299])
    origins = ORIGINS.copy()
    origins[bad] = np.nan
    rays = origins, DIRECTIONS, 0.1
    whole = TREE.all_hits(*rays, at="surface", invalid="skip")
    parts = check(TREE, *rays, at="surface", invalid="skip")
    assert (np.concatenate([part.first_ray + part.ray for part in parts]) == whole.ray).all()
    for call in ("points", "normals", "tangents"):
        assert (np.concatenate([getattr(part, call)() for part in parts]) == getattr(whole, call)()).all()
    last = parts[-1]
    assert (last.t[last.of(0)] == whole.t[whole.of(last.first_ray)]).all()
    assert last.merged_by_strand().first_ray == last.first_ray > 0


def test_a_ray_that_does_not_fit() -> None:
    counts = TREE.count_hits(ORIGINS, DIRECTIONS, 0.1)
    most, ray = int(counts.max()), int(counts.argmax())
    parts = TREE.iter_all_hits(ORIGINS, DIRECTIONS, 0.1, max_bytes=40 * most + 7)
    told = (
        rf"the hits of ray {ray} alone take {40 * most + 8:,} bytes, and max_bytes={40 * most + 7:,}; raise max_bytes"
    )
    found = []
    with pytest.raises(MemoryError, match=told):
        found.extend(itertools.chain.from_iterable([part] for part in parts))
    whole = TREE.all_hits(ORIGINS[:ray], DIRECTIONS[:ray], 0.1)
    assert_same(joined(found, whole), whole)


def test_what_is_left_out_counts() -> None:
    """While a part is made, ignored hits are in memory too."""
    ray = [0.5, 0.5, -1], [0, 0, 1], 9.0
    with pytest.raises(MemoryError, match=r"take 42,008 bytes"):
        next(TREE.iter_all_hits(*ray, max_bytes=42_007, ignore=np.arange(len(LINES))))
    assert len(next(TREE.iter_all_hits(*ray, max_bytes=42_008, ignore=np.arange(len(LINES))))) == 0


def test_bad_input_is_refused_at_once() -> None:
    rays = ORIGINS, DIRECTIONS
    for wrong in (0, -1, 1e6, True, "1 GB"):
        with pytest.raises(fl.InputError, match=rf"max_bytes={wrong!r}; expected a whole number, 1 or more"):
            TREE.iter_all_hits(*rays, 0.1, max_bytes=wrong)  # type: ignore[arg-type]
    with pytest.raises(fl.InputError, match="1 of 300 rays have an origin that is not finite"):
        TREE.iter_all_hits(np.where(np.arange(900).reshape(300, 3) == 4, np.nan, ORIGINS), DIRECTIONS, 0.1, max_bytes=9)
    with pytest.raises(fl.InputError, match="a query needs one"):
        TREE.iter_all_hits(*rays, max_bytes=1000)
    with pytest.raises(fl.InputError, match=r"needs at='surface'"):
        TREE.iter_all_hits(*rays, 0.1, max_bytes=1000, merge="strand")
    with pytest.raises(TypeError, match="max_bytes"):
        TREE.iter_all_hits(*rays, 0.1)  # type: ignore[call-arg]


def test_nothing_to_ask() -> None:
    assert list(TREE.iter_all_hits(np.zeros((0, 3)), [0, 0, 1], 0.1, max_bytes=1)) == []
    empty = fl.build(np.zeros((0, 2, 3)))
    assert [part.counts.tolist() for part in empty.iter_all_hits([[0, 0, 0]] * 3, [0, 0, 1], 0.1, max_bytes=16)] == [
        [0, 0],
        [0],
    ]


def test_rays_that_change_are_refused() -> None:
    origins = ORIGINS.copy()
    parts = TREE.iter_all_hits(origins, DIRECTIONS, 0.1, max_bytes=4000)
    next(parts)
    origins[250] += 1
    with pytest.raises(fl.InputError, match="have changed since the query"):
        list(parts)


@pytest.mark.parametrize("geometry", [LINES, Balls()], ids=["lines", "of the user's own"])
def test_progress_rises_over_the_whole(geometry: Any) -> None:
    done: list[float] = []
    parts = fl.build(geometry).iter_all_hits(ORIGINS, DIRECTIONS, 0.1, max_bytes=60_000, progress=done.append)
    assert done == []
    assert len(list(parts)) > 1
    assert done == sorted(done)
    assert done[-1] == 1.0
    assert min(done) < 0.5 or not hasattr(geometry, "hit")


def test_parts_can_be_abandoned() -> None:
    done: list[float] = []
    parts = TREE.iter_all_hits(ORIGINS, DIRECTIONS, 0.1, max_bytes=4000, progress=done.append)
    next(parts)
    parts.close()  # type: ignore[attr-defined]
    assert list(parts) == []
    assert 1.0 not in done


def test_what_progress_raises_ends_the_call() -> None:
    def stop(done: float) -> None:
        raise KeyboardInterrupt

    balls = fl.build(Balls())
    with pytest.raises(KeyboardInterrupt):
        list(balls.iter_all_hits(ORIGINS, DIRECTIONS, max_bytes=60_000, progress=stop))
