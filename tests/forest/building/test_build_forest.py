"""Forests that are built of chunks: they hold the lines of all chunks joined, whatever the chunks and the tiles are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.forests import strands

import fastlines as fl
from fastlines.forest.index import Index
from fastlines.geometry.join_lines import join_lines
from fastlines.query.proximity.strand_places import strand_places


def joined(parts: Sequence[fl.Lines]) -> fl.Lines:
    """Return the lines of all parts, as `join_lines` joins them, without the number of the part."""
    return join_lines(parts, "part", range(len(parts)), lambda text: None)


def assert_holds(forest: fl.Forest, lines: fl.Lines) -> None:
    """Assert that the tiles and the index of a forest have everything that is known of lines."""
    index = Index.read(forest.path, len(lines), forest.manifest.index)
    assert index.skipped.tolist() == lines.skipped.tolist()
    assert forest.manifest.n_strands == lines.n_strands
    known = strand_places(lines)
    assert (known is None) == (index.strands is None)
    if known is not None and index.strands is not None:
        assert index.strands.tolist() == lines.strands.tolist()
        numbers, first = np.unique(lines.strands, return_index=True)
        is_closed = (numbers >= 0) & (known[first, 2] > 0)
        closed = np.stack([numbers, known[first, 2]], axis=1)[is_closed]
        assert index.closed.tolist() == closed.tolist()
    frame = lines.bounds if len(lines) else np.zeros((2, 3))
    assert forest.manifest.frame.tolist() == frame.tolist()
    seen = []
    for number in range(forest.n_tiles):
        tile = forest._store.open(number)
        ids = np.arange(len(lines)) if tile.ids is None else tile.ids
        assert (np.diff(ids) > 0).all()
        assert (index.tile_of[ids] == number).all()
        if known is not None:
            assert tile.places is not None
            assert tile.places.tolist() == known[ids, 1].tolist()
        assert_same(tile.tree.geometry, lines, ids)
        seen.append(ids)
    assert np.sort(np.concatenate([*seen, np.empty(0, np.int64)])).tolist() == list(range(len(lines)))
    assert_same(replace(index.sample, metadata=lines.metadata), lines, np.arange(len(index.sample)))


def assert_same(found: Any, lines: fl.Lines, ids: Any) -> None:
    """Assert that lines are rows of others."""
    assert np.array_equal(found.segments, lines.segments[ids])
    assert np.array_equal(found.strands, lines.strands[ids])
    assert (found.up, found.unit, found.metadata) == (lines.up, lines.unit, lines.metadata)
    assert (found.radius is None) == (lines.radius is None)
    if lines.radius is not None:
        assert np.array_equal(found.end_radii, lines.end_radii[ids])
    assert found.attributes.keys() == lines.attributes.keys() - {"part"}
    for name, values in found.attributes.items():
        assert values.tolist() == lines.attributes[name][ids].tolist()
    assert found.end_attributes.keys() == lines.end_attributes.keys()
    for name, values in found.end_attributes.items():
        assert values.tolist() == lines.end_attributes[name][ids].tolist()


def chunks(n: int = 4, n_segments: int = 300) -> list[fl.Lines]:
    """Return chunks with all kinds of columns."""
    made = []
    for i in range(n):
        n_points = n_segments // 10 * 11
        lines = strands(
            n_segments, i, radius=np.linspace(0.01, 0.02, n_points), attributes={"fa": np.arange(n_points) * 0.5}
        )
        texts = np.array([f"tract {row // 50 + i}" for row in range(n_segments)], object)
        made.append(
            replace(
                lines,
                attributes={"age": np.arange(n_segments) + i, "name": texts, **lines.attributes},
                up="z",
                unit="mm",
                metadata={"subject": "one"},
            )
        )
    return made


@pytest.mark.parametrize("max_segments", [1, 90, 400, 10_000])
def test_chunks_are_joined(tmp_path: Path, max_segments: int) -> None:
    parts = chunks(2, 60) if max_segments == 1 else chunks()
    forest = fl.build_forest(iter(parts), tmp_path / "forest", max_segments=max_segments)
    assert_holds(forest, replace(joined(parts), metadata={"subject": "one"}))
    sizes = [tile.n_prims for tile in forest.manifest.tiles]
    assert max(sizes) <= max_segments
    assert sorted(path.name for path in forest.path.iterdir()) == [
        *(f"{number:05d}.flt" for number in range(len(sizes))),
        *("build.json", "forest.json", "index.fli"),
    ]


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
def test_chunks_that_differ(tmp_path: Path) -> None:
    with_radius, without = chunks(2)
    bare = fl.Lines(without.segments[:7], up="y")
    one_each = replace(with_radius, radius=with_radius.end_radii[:, 0].copy())
    wide = replace(with_radius, attributes={"age": np.arange(300.0) / 3})
    for parts in ([with_radius, without.without_radius(), bare], [one_each, with_radius], [with_radius, wide]):
        folder = tmp_path / f"{len(list(tmp_path.iterdir()))}"
        assert_holds(fl.build_forest(parts, folder, max_segments=100), join_like(parts))


def join_like(parts: Sequence[fl.Lines]) -> fl.Lines:
    """Join lines, with the metadata that all parts have."""
    same = all(part.metadata == parts[0].metadata for part in parts)
    return replace(joined(parts), metadata=parts[0].metadata if same else {})


def test_warnings_of_chunks_that_differ(tmp_path: Path) -> None:
    with_radius, other = chunks(2)
    with pytest.warns(fl.FileWarning) as told:
        fl.build_forest([with_radius, replace(other.without_radius(), attributes={}, up="y")], tmp_path / "f")
    assert sorted(str(warning.message) for warning in told) == [
        "attributes that not all chunks have alike are left out: 'age', 'name'",
        "chunks differ in up; it is 'z', that of the first",
        "some chunks have no radius, and their segments get the radius 0",
    ]
    odd = fl.Lines.from_segments([[[0, 0, 0], [1, 1, 1]]], attributes={"odd": np.array([1j])})
    with pytest.warns(fl.FileWarning, match=r"does not keep the attributes 'odd' \(complex128, 1-d\)"):
        fl.build_forest([odd], tmp_path / "odd")


def test_one_radius_stays_one(tmp_path: Path) -> None:
    lines = strands().with_radius(0.25)
    forest = fl.build_forest(lines, tmp_path / "forest", max_segments=100)
    assert forest._store.open(0).tree.geometry.radius.shape == (forest.manifest.tiles[0].n_prims,)
    bare = fl.build_forest(lines, tmp_path / "bare", max_segments=100, own_radius=False)
    assert bare._store.open(0).tree.geometry.radius is None


@pytest.mark.parametrize("n", [0, 1, 2])
def test_few_segments(tmp_path: Path, n: int) -> None:
    lines = fl.Lines(np.arange(6 * n, dtype=np.float32).reshape(-1, 2, 3))
    assert_holds(fl.build_forest([lines], tmp_path / "one"), lines)
    assert_holds(fl.build_forest([lines, lines[:0]], tmp_path / "two", max_segments=1), lines)
    assert fl.build_forest(iter([]), tmp_path / "none").n_prims == 0


def test_equal_segments_become_runs_of_their_numbers(tmp_path: Path) -> None:
    lines = fl.Lines(np.ones((1000, 2, 3), np.float32))
    forest = fl.build_forest(lines, tmp_path / "forest", max_segments=300)
    assert_holds(forest, lines)
    assert [tile.n_prims for tile in forest.manifest.tiles] == [250] * 4
    some = fl.Lines(np.concatenate([lines.segments, strands(20).segments]))
    assert_holds(fl.build_forest(some, tmp_path / "some", max_segments=300), some)


def test_answers_are_those_of_one_tree(tmp_path: Path) -> None:
    parts = chunks()
    forest, tree = fl.build_forest(parts, tmp_path / "forest", max_segments=200), fl.build(joined(parts))
    rng = np.random.default_rng(0)
    rays = rng.uniform(-2, 2, (500, 3)), rng.normal(size=(500, 3))
    found, expected = forest.first_hit(*rays, 0.05), tree.first_hit(*rays, 0.05)
    assert 50 < expected.hit.sum() < 500
    for name in ("prim", "t", "u", "strand"):
        assert np.array_equal(getattr(found, name), getattr(expected, name), equal_nan=True), name
    listed, all_of_them = (of.all_hits(*rays, 0.05, at="surface", merge="strand") for of in (forest, tree))
    for name in ("offsets", "prim", "t", "t_out"):
        assert np.array_equal(getattr(listed, name), getattr(all_of_them, name)), name


def test_tiles_are_compact(tmp_path: Path) -> None:
    """Halves of a grid of 64 x 64 are squares."""
    x, y = np.meshgrid(np.arange(64.0), np.arange(64.0))
    start = np.stack([x, y, np.zeros_like(x)], axis=2).reshape(-1, 1, 3)
    lines = fl.Lines.from_segments(
        np.concatenate([start, start + 0.5], axis=1)[np.random.default_rng(0).permutation(4096)]
    )
    forest = fl.build_forest(lines, tmp_path / "forest", max_segments=270)
    assert [tile.n_prims for tile in forest.manifest.tiles] == [256] * 16
    assert np.ptp(forest.manifest.boxes, axis=1)[:, :2].max() == 15.5


def test_rows_that_are_left_out(tmp_path: Path) -> None:
    parts = [np.random.default_rng(i).uniform(0, 1, (50, 2, 3)).astype(np.float32) for i in range(3)]
    parts[0][3] = parts[1][:] = parts[2][49] = np.nan
    forest = fl.build_forest(iter(parts), tmp_path / "forest", max_segments=40, invalid="skip")
    assert_holds(forest, fl.Lines.from_segments(np.concatenate(parts), invalid="skip"))
    assert forest.geometry.rows_of(np.array([0, 3, 97])).tolist() == [0, 4, 148]
    with pytest.raises(fl.InputError, match="chunk 0: 1 of 50 segments hold NaN"):
        fl.build_forest(iter(parts), tmp_path / "strict")


def polylines() -> list[Any]:
    return [np.cumsum(np.random.default_rng(i).normal(size=(i + 2, 3)), axis=0) for i in range(40)]


def test_kinds_of_chunks(tmp_path: Path) -> None:
    lines = fl.lines(polylines())
    assert_holds(fl.build_forest(polylines(), tmp_path / "1", max_segments=100), lines)
    assert_holds(fl.build_forest((polylines()[:9], polylines()[9:]), tmp_path / "2", max_segments=100), lines)
    assert_holds(fl.build_forest(([line] for line in polylines()), tmp_path / "3", max_segments=100), lines)
    bare = fl.Lines(lines.segments)
    assert_holds(fl.build_forest(lines.segments, tmp_path / "4", max_segments=100), bare)
    assert_holds(fl.build_forest([lines.segments[:50], lines.segments[50:]], tmp_path / "5"), bare)
    assert_holds(fl.build_forest(np.array_split(lines.segments, 7), tmp_path / "6", max_segments=100), bare)


def test_large_chunks_are_cut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fastlines.forest.building.budget.CHUNK", 70)
    parts = chunks()
    forest = fl.build_forest(parts, tmp_path / "lines", max_segments=100)
    assert_holds(forest, replace(joined(parts), metadata={"subject": "one"}))
    segments = parts[0].segments.copy()
    assert_holds(fl.build_forest(segments, tmp_path / "array", max_segments=100), fl.Lines(segments))
    segments[80] = np.nan
    with pytest.raises(fl.InputError, match=r"chunk 0 from row 70 on: 1 of 70 segments hold NaN.*\(row 10\)"):
        fl.build_forest(segments, tmp_path / "nan")


def test_files(tmp_path: Path) -> None:
    first, second = (replace(strands(n, n), unit="mm") for n in (300, 200))
    paths = [tmp_path / "first.tck", tmp_path / "second.npz"]
    for path, lines in zip(paths, (first, second), strict=True):
        fl.write(path, lines)
    assert_holds(fl.build_forest(paths[0], tmp_path / "one", max_segments=100), fl.read(paths[0]))
    both = joined([replace(fl.read(path), up="z") for path in paths])
    with pytest.warns(fl.FileWarning, match="chunks differ in up; it is 'z', that of the first"):
        forest = fl.build_forest([str(path) for path in paths], tmp_path / "two", max_segments=100)
    assert_holds(forest, both)
    with pytest.raises(FileNotFoundError):
        fl.build_forest(tmp_path / "none.tck", tmp_path / "three")


def test_a_folder_of_parquet(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    lines = strands()
    (tmp_path / "table").mkdir()
    fl.write(tmp_path / "table" / "a.parquet", lines[:100])
    fl.write(tmp_path / "table" / "b.parquet", lines[100:])
    forest = fl.build_forest(tmp_path / "table", tmp_path / "forest", max_segments=70)
    assert_holds(forest, fl.read(tmp_path / "table"))


def test_dask_arrays(tmp_path: Path) -> None:
    array = pytest.importorskip("dask.array")
    segments = strands().segments
    forest = fl.build_forest(array.from_array(segments, chunks=(70, 1, 2)), tmp_path / "forest", max_segments=90)
    assert_holds(forest, fl.Lines(segments))
    assert fl.build_forest(array.from_array(segments, chunks=(70, 1, 2)), forest.path, max_segments=90).n_prims == 300
    with pytest.raises(fl.InputError, match=r"the dask array has shape \(300, 6\)"):
        fl.build_forest(array.from_array(segments.reshape(-1, 6)), tmp_path / "other")


def test_one_offset_for_all_chunks(tmp_path: Path) -> None:
    far = [strands(100, i).segments + np.array([5e6, 0, 10 * i]) for i in range(3)]
    forest = fl.build_forest(iter(far), tmp_path / "auto", max_segments=50, offset="auto")
    offset = fl.lines(far[0], offset="auto").offset
    assert_holds(forest, fl.Lines.from_segments(np.concatenate(far), offset=offset))
    given = fl.build_forest(iter(far), tmp_path / "given", max_segments=50, offset=(5e6, 1, 2))
    assert_holds(given, fl.Lines.from_segments(np.concatenate(far), offset=(5e6, 1, 2)))
    made = [fl.lines(part, offset="auto") for part in far]
    with pytest.raises(fl.InputError, match=r"a chunk has the offset .* and those before it .* offset=\[5000000.0"):
        fl.build_forest(iter(made), tmp_path / "lines")
    assert fl.build_forest(iter(made), tmp_path / "same", offset=offset).geometry.offset == offset


def spawned() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(2, get_context("spawn"))


@pytest.mark.parametrize("executor", [lambda: ThreadPoolExecutor(3), spawned])
def test_tiles_are_built_anywhere(tmp_path: Path, executor: Any) -> None:
    alone = fl.build_forest(chunks(), tmp_path / "alone", max_segments=200)
    done: list[float] = []
    with executor() as pool:
        forest = fl.build_forest(chunks(), tmp_path / "pool", max_segments=200, map=pool.map, progress=done.append)
    assert done == sorted(done)
    assert done[-1] == 1
    for path in alone.path.iterdir():
        assert path.read_bytes() == (forest.path / path.name).read_bytes(), path.name


def test_progress_of_a_file(tmp_path: Path) -> None:
    fl.write(tmp_path / "lines.tck", replace(strands(3000), unit="mm"))
    done: list[float] = []
    fl.build_forest(tmp_path / "lines.tck", tmp_path / "forest", max_segments=1000, progress=done.append)
    assert done == sorted(done)
    assert done[-1] == 1
    assert len(done) > 5


def test_chunks_are_read_once_and_one_at_a_time(tmp_path: Path) -> None:
    alive: list[int] = []

    def lazily() -> Iterator[fl.Lines]:
        for i in range(3):
            alive.append(i)
            yield strands(100, i)

    assert fl.build_forest(lazily(), tmp_path / "forest").n_prims == 300
    assert alive == [0, 1, 2]


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"max_segments": 0}, "max_segments=0; expected a whole number, 1 or more"),
        ({"memory": 1.5}, "memory=1.5; expected a whole number"),
        ({"memory": 1000}, r"memory=1000 is less than the build of a tile takes; give \d+ bytes or more$"),
        (
            {"memory": 200_000_000, "max_segments": 5_000_000},
            r"a tile of max_segments=5000000 takes; .*, or max_segments=",
        ),
        ({"invalid": "no"}, "invalid='no' is not a choice"),
        ({"offset": 3}, "offset=3; expected"),
        ({"method": "best", "effort": 7}, "effort"),
        ({"map": 3}, "map=3; expected a function, such as executor.map"),
    ],
)
def test_arguments_that_cannot_be_used(tmp_path: Path, given: dict[str, Any], why: str) -> None:
    with pytest.raises(fl.InputError, match=why):
        fl.build_forest(strands(), tmp_path / "forest", **given)
    assert not (tmp_path / "forest").exists()


def test_sources_that_cannot_be_used(tmp_path: Path) -> None:
    for i, source in enumerate((3, ["a.tck", 3], [fl.Spheres.from_centres([[0, 0, 0]], 1)])):
        with pytest.raises(fl.InputError):
            fl.build_forest(source, tmp_path / f"{i}")
    with pytest.raises(
        fl.InputError, match=r"a chunk is 'a.tck', the name of a file; pass files as one path, or a list"
    ):
        fl.build_forest(iter(["a.tck"]), tmp_path / "paths")


def test_the_frame_is_that_of_all_lines(tmp_path: Path) -> None:
    with pytest.raises(fl.InputError, match=r"the frame of a forest is the box of all its lines; leave frame= out"):
        fl.build_forest(np.zeros((1, 2, 3)), tmp_path / "forest", frame=[[-9, -9, -9], [9, 9, 9]])
    assert not (tmp_path / "forest").exists()


@pytest.mark.parametrize("source", [[], (), None, 3])
def test_what_is_no_source(source, tmp_path):
    with pytest.raises(fl.InputError, match=r"source is (empty|None|3); expected a file, several files"):
        fl.build_forest(source, tmp_path / "f")
    assert not (tmp_path / "f").exists()
