"""The geometry of a forest answers as the lines that were divided into tiles, bit for bit."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.forests import strands, tiles_of

import fastlines as fl
import fastlines.forest.geometry as module
from fastlines.forest.writing import write_forest
from fastlines.geometry.hit_places import HitPlaces
from fastlines.query.proximity.strand_places import strand_places
from fastlines.rendering.looks import look_for

N_POINTS = 330


def kinds() -> dict[str, fl.Lines]:
    per_point = {"fa": np.linspace(0, 1, N_POINTS), "rgb": np.random.default_rng(5).random((N_POINTS, 3))}
    bare = strands()
    thick = strands(radius=np.linspace(0.01, 0.02, N_POINTS), attributes=per_point)
    facts: dict[str, Any] = {"up": "z", "unit": "mm", "metadata": {"offset": (5e6, -3.0, 0.25), "grid": {"n": (1, 2)}}}
    one = np.linspace(0.01, 0.03, 300, dtype=np.float32)
    flags = {"is_long": np.arange(300) % 3 == 0, "name": np.array([f"strand {i // 10}" for i in range(300)])}
    skipped = bare.segments.astype(np.float64)
    skipped[[0, 7, 8, 299], 0, 1] = np.nan
    return {
        "bare": bare,
        "radius at points": thick,
        "radius of segments": replace(bare, radius=one, attributes=flags, **facts),
        "without strands": fl.Lines.from_segments(bare.segments),
        "skipped": fl.Lines.from_segments(skipped, strands=bare.strands, invalid="skip"),
        "gaps in the numbers of strands": replace(bare, strands=bare.strands * 1000 + 2**33),
    }


@pytest.fixture(params=kinds())
def lines(request: pytest.FixtureRequest) -> fl.Lines:
    return kinds()[request.param]


@pytest.fixture
def forest(tmp_path: Path, lines: fl.Lines) -> fl.Forest:
    return write_forest(lines, tmp_path / "forest", tiles_of(lines, 3))


def same(got: Any, expected: Any) -> None:
    assert (got.shape, got.dtype) == (expected.shape, expected.dtype)
    assert got.tobytes() == expected.tobytes()


def test_what_it_says_of_the_whole(forest: fl.Forest, lines: fl.Lines) -> None:
    geometry = forest.geometry
    assert len(geometry) == len(lines)
    same(geometry.bounds, lines.bounds)
    for name in ("kind", "n_strands", "offset", "up", "unit", "metadata", "noun", "n_skipped", "radius_range",
                 "max_radius", "radius_beyond", "needs_radius", "takes_radius", "takes_spread", "has_axes", "in_pieces",
                 "has_user_code", "has_parts"):  # fmt: skip
        assert getattr(geometry, name) == getattr(lines, name), name
    assert geometry.count_text() == lines.count_text()
    assert set(geometry.sample_names) == set(lines.sample_names)
    assert geometry.attribute_types() == lines.attribute_types()
    assert geometry.attribute_texts() == lines.attribute_texts()
    assert geometry.total_length == pytest.approx(lines.total_length)
    known = lines.summary()
    for name, value in geometry.summary().items():
        assert value == (pytest.approx(known[name]) if name == "total_length" else known[name]), name
    assert (geometry.radius is None) == (lines.radius is None)


def test_where_primitives_are(forest: fl.Forest, lines: fl.Lines) -> None:
    prim = np.random.default_rng(1).permutation(len(lines))
    tile, local = forest.geometry.locate(prim)  # type: ignore[attr-defined]
    assert tile.tolist() == tiles_of(lines, 3)[prim].tolist()
    for number in range(3):
        ids = forest._store.open(number).ids
        assert ids is not None
        assert ids[local[tile == number]].tolist() == prim[tile == number].tolist()


def test_each_primitive(forest: fl.Forest, lines: fl.Lines) -> None:
    geometry, rng = forest.geometry, np.random.default_rng(2)
    prim = rng.integers(0, len(lines), 500)
    u = rng.random(500)
    same(geometry.rows_of(prim), lines.rows_of(prim))
    same(geometry.strands_of(prim), lines.strands_of(prim))
    assert geometry.end_of_strands == lines.end_of_strands
    same(geometry.radius_of(prim), lines.radius_of(prim))
    same(geometry.axis_points(prim, u), lines.axis_points(prim, u))
    tangents = lines.tangents_at(HitPlaces.without_rays(prim, u))
    smooth = [of.smooth_tangents_at(prim, u, tangents) for of in (geometry, lines)]
    same(*smooth)


def test_places_along_strands(forest: fl.Forest, lines: fl.Lines) -> None:
    known = strand_places(lines)
    for number in range(3):
        tile = forest._store.open(number)
        if known is None:
            assert tile.places is None
        else:
            assert tile.places is not None
            assert tile.places.tolist() == known[tile.ids, 1].tolist()
    if known is not None:
        numbers, first = np.unique(lines.strands, return_index=True)
        assert forest.geometry.periods_of(numbers).tolist() == known[first, 2].tolist()  # type: ignore[attr-defined]
        assert forest.geometry.periods_of(numbers + 1)[-1] == 0  # type: ignore[attr-defined]


def rays(lines: fl.Lines) -> tuple[Any, Any, float]:
    towards = lines.segments.mean(axis=1).astype(np.float64) + np.array(lines.offset)
    away = np.random.default_rng(3).normal(size=towards.shape)
    away[:5] *= 1e-3  # from inside
    return towards + away, -away, 0.02


@pytest.mark.parametrize("at", ["closest", "surface"])
def test_hits(forest: fl.Forest, lines: fl.Lines, at: str) -> None:
    tree = fl.build(lines)
    for hits in (tree.first_hit(*rays(lines), at=at), tree.all_hits(*rays(lines), at=at)):
        found = replace(hits, geometry=forest.geometry)
        for name in ("row", "strand", "prim_number"):
            same(getattr(found, name), getattr(hits, name))
        same(found.points(), hits.points())
        same(found.tangents(), hits.tangents())
        if at == "surface":
            same(found.points(outside=True), hits.points(outside=True))
            same(found.normals(), hits.normals())
        for name in lines.sample_names:
            if name != "name":
                same(found.sample(name), hits.sample(name))
        back = pickle.loads(pickle.dumps(found))
        same(back.strand, hits.strand)
        same(back.row, hits.row)
        if "name" in lines.sample_names:
            with pytest.raises(fl.InputError, match="'name' holds texts"):
                found.sample("name")
        with pytest.raises(fl.InputError, match="not an attribute"):
            found.sample("nothing")


def test_strands_merge(forest: fl.Forest, lines: fl.Lines) -> None:
    hits = fl.build(lines).all_hits(*rays(lines), at="surface")
    found, expected = (of.merged_by_strand() for of in (replace(hits, geometry=forest.geometry), hits))
    for name in ("offsets", "t", "prim", "u", "distance", "t_out"):
        same(getattr(found, name), getattr(expected, name))


@pytest.mark.parametrize("to", ["axis", "surface"])
def test_nearest_points(forest: fl.Forest, lines: fl.Lines, to: str) -> None:
    points = np.random.default_rng(4).uniform(-1, 1, (50, 3)) + np.array(lines.offset)
    near = fl.build(lines).nearest(points, 3, to=to)
    found = replace(near, geometry=forest.geometry)
    same(found.points(), near.points())
    same(found.tangents(), near.tangents())
    same(found.strand, near.strand)


def test_a_pickle_opens_the_folder_again(forest: fl.Forest, lines: fl.Lines) -> None:
    back = pickle.loads(pickle.dumps(forest.geometry))
    same(back.radius_of(np.arange(len(lines))), lines.radius_of(np.arange(len(lines))))


def test_it_is_not_in_memory(forest: fl.Forest) -> None:
    with pytest.raises(fl.InputError, match="is not in memory; its tiles are queried"):
        forest.geometry.core_data()
    with pytest.raises(fl.InputError, match="is not in memory; its tiles are queried"):
        fl.build(forest.geometry)
    with pytest.raises(fl.InputError, match="forests are queried on the CPU"):
        forest.geometry.require_gpu()


def test_nothing(tmp_path: Path) -> None:
    lines = fl.Lines.from_segments(np.empty((0, 2, 3)))
    forest = write_forest(lines, tmp_path / "forest", np.zeros(0, int))
    assert (forest.n_prims, forest.n_tiles) == (0, 0)
    same(forest.geometry.bounds, lines.bounds)
    assert forest.geometry.summary()["bounds"] is None
    assert forest.geometry.radius_of(np.zeros(0, int)).shape == (0,)
    assert forest.geometry.strands_of(np.zeros(0, int)).shape == (0,)


def test_a_name_that_is_no_attribute_is_one_of_the_whole(forest: fl.Forest, lines: fl.Lines) -> None:
    with pytest.raises(fl.InputError, match=f"'typo' is not an attribute of <ForestGeometry: {len(lines)} segments"):
        forest.first_hit([0, 0, 0], [0, 0, 1], radius=1).sample("typo")


def test_hair_is_drawn_as_hair(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hair = fl.scenes.make("straight-hair", 20_000).lines
    geometry = write_forest(hair, tmp_path / "hair", tiles_of(hair, 3)).geometry
    same(geometry.strand_sizes(), hair.strand_sizes())
    same(geometry.turns(), hair.turns()[: len(geometry.turns())])
    assert look_for(geometry) == look_for(hair) == "hair"
    # A strand that may go on is not counted.
    monkeypatch.setattr(module, "COUNTED", 7)
    assert geometry.strand_sizes().tolist() == hair[:7].strand_sizes()[:-1].tolist()
