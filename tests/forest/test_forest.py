"""Forests as objects: what they say of themselves, their files, and what is wrong with files that lie."""

from __future__ import annotations

import os
import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.forests import strands, tiles_of

import fastlines as fl
from fastlines.forest.index import Index
from fastlines.forest.writing import write_forest


@pytest.fixture
def lines() -> fl.Lines:
    return strands(radius=np.linspace(0.01, 0.02, 330), attributes={"age": np.arange(330.0)})


@pytest.fixture
def forest(tmp_path: Path, lines: fl.Lines) -> fl.Forest:
    return write_forest(lines, tmp_path / "hair", tiles_of(lines, 3))


def test_what_a_forest_says(forest: fl.Forest, lines: fl.Lines) -> None:
    assert repr(forest).startswith("<Forest best: 300 segments in 3 tiles, ")
    assert (forest.n_prims, forest.n_tiles) == (300, 3)
    stats = forest.stats()
    assert (stats["n_prims"], stats["n_strands"], stats["n_tiles"], stats["largest_tile"]) == (300, 30, 3, 100)
    assert stats["file_bytes"] == sum(path.stat().st_size for path in forest.path.glob("*.flt"))
    assert stats["frame"] == lines.bounds.tolist()


def test_a_pickle_is_its_path(forest: fl.Forest) -> None:
    back = pickle.loads(pickle.dumps(forest))
    assert (back.path, back.n_prims, back.manifest.digest) == (forest.path, 300, forest.manifest.digest)
    assert len(pickle.dumps(forest)) < 1000


def test_the_same_input_makes_the_same_bytes(tmp_path: Path, forest: fl.Forest, lines: fl.Lines) -> None:
    write_forest(lines, tmp_path / "again", tiles_of(lines, 3))
    files = sorted(path.name for path in forest.path.iterdir())
    assert files == ["00000.flt", "00001.flt", "00002.flt", "forest.json", "index.fli"]
    for name in files:
        assert (forest.path / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_the_index(forest: fl.Forest, lines: fl.Lines) -> None:
    index = Index.read(forest.path, 300, forest.manifest.index)
    assert index.tile_of.tolist() == tiles_of(lines, 3).tolist()
    assert index.strands is not None
    assert index.strands.tolist() == lines.strands.tolist()
    assert index.closed.tolist() == [[29, 10]]
    assert len(index.sample) == 300


def test_a_tile_built_again(forest: fl.Forest, lines: fl.Lines) -> None:
    other = fl.Forest(forest.path)
    again = forest.rebuild(1, "kd-cl")
    assert [tile.file for tile in again.manifest.tiles] == ["00000.flt", "00001.1.flt", "00002.flt"]
    assert sorted(path.name for path in forest.path.glob("*.flt")) == ["00000.flt", "00001.1.flt", "00002.flt"]
    assert again._store.open(1).tree.method == "kd-cl"
    assert again._store.open(1).ids.tolist() == np.flatnonzero(tiles_of(lines, 3) == 1).tolist()
    again.verify()
    with pytest.raises(fl.InputError, match="has changed since this forest was opened; open it again"):
        forest.rebuild(0)
    with pytest.raises(
        fl.FileFormatError, match=r"00001.flt .*: it has been built again since .*; open the forest again"
    ):
        other._store.open(1)
    with pytest.raises(fl.InputError, match="frame is the same in all tiles of a forest; leave it out"):
        again.rebuild(0, frame=[[-9, -9, -9], [9, 9, 9]])
    assert again.rebuild(1).manifest.tiles[1].file == "00001.2.flt"


@pytest.mark.parametrize(
    ("damage", "why"),
    [
        (lambda path: path.unlink(), "it is missing"),
        (lambda path: path.write_bytes(path.read_bytes()[:-100]), "header promises .* bytes, but it has"),
        (lambda path: path.write_bytes(b""), "it has 0 bytes"),
        (lambda path: path.write_bytes(flipped(path.read_bytes())), "it has changed since it was written"),
        (lambda path: path.write_bytes((path.parent / "00000.flt").read_bytes()), "of another build"),
    ],
)
def test_a_damaged_tile(forest: fl.Forest, damage, why: str) -> None:
    damage(forest.path / "00001.flt")
    opened = fl.Forest(forest.path)
    for number in (0, 2):
        assert len(opened._store.open(number).tree.geometry) == 100
    with pytest.raises(fl.FileFormatError, match=rf"00001.flt is .*{why}.*; call fl.build_forest"):
        opened._store.open(1)
    with pytest.raises(fl.FileFormatError, match=r"00001.flt"):
        opened.verify()


def flipped(data: bytes) -> bytes:
    """Flip a bit of a coordinate."""
    at = len(data) // 2
    return data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]


def test_verify_names_each_fault(forest: fl.Forest) -> None:
    forest.verify()
    (forest.path / "00000.flt").unlink()
    (forest.path / "index.fli").write_bytes(flipped((forest.path / "index.fli").read_bytes()))
    with pytest.raises(fl.FileFormatError, match=r"(?s)index.fli.*00000.flt"):
        forest.verify()


def test_verify_compares_tiles_with_the_index(forest: fl.Forest, lines: fl.Lines) -> None:
    tiles = tiles_of(lines, 3)
    tiles[[0, 1]] = tiles[[1, 0]]
    tiles[2] = (tiles[2] + 1) % 3
    manifest = forest.manifest
    none = np.zeros((0, 2), np.int64)
    index = Index(tiles.astype(np.uint32), lines.strands, none[:, 0], none, lines[:0]).write(forest.path)
    replace(manifest, index=index).write(forest.path)
    with pytest.raises(fl.FileFormatError, match=r"flt does not hold the primitives that the index says; call"):
        fl.Forest(forest.path).verify()


def test_a_damaged_index(forest: fl.Forest) -> None:
    path = forest.path / "index.fli"
    data = path.read_bytes()
    path.write_bytes(data[:-1])
    with pytest.raises(fl.FileFormatError, match=r"index.fli is not a whole .*; call fl.build_forest"):
        fl.Forest(forest.path)
    path.unlink()
    with pytest.raises(fl.FileFormatError, match=r"index.fli is not the index of this forest: it is missing"):
        fl.Forest(forest.path)


def test_no_such_forest(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"no such folder or tree file; check the path .*: .*typo'"):
        fl.Forest(tmp_path / "typo")


def test_too_little_memory(forest: fl.Forest) -> None:
    with pytest.raises(
        fl.InputError, match=r"memory=1000 is less than the tile 0000\d.flt of .* takes; give \d+ bytes"
    ):
        fl.Forest(forest.path, memory=1000)
    for wrong in (-1, 4e9, True, "1 GB"):
        with pytest.raises(fl.InputError, match="expected a whole number of bytes"):
            fl.Forest(forest.path, memory=wrong)  # type: ignore[arg-type]


def test_tiles_close_within_the_memory(forest: fl.Forest) -> None:
    largest = max(tile.n_bytes for tile in forest.manifest.tiles)
    store = fl.Forest(forest.path, memory=2 * largest)._store
    first = store.open(0)
    assert store.open(0) is first
    store.open(1)
    store.open(0)
    store.open(2)  # 1 is the least recently used
    assert store.is_open.tolist() == [1, 0, 1]
    assert store.open(0) is first


def test_threads_open_a_tile_once(forest: fl.Forest, monkeypatch: pytest.MonkeyPatch) -> None:
    from fastlines.forest import tile_store

    read, opened = tile_store.read_tile, []

    def counted(*arguments: Any) -> tile_store.Tile:
        opened.append(arguments[1])
        return read(*arguments)

    monkeypatch.setattr(tile_store, "read_tile", counted)
    store = fl.Forest(forest.path)._store
    with ThreadPoolExecutor(8) as pool:
        tiles = list(pool.map(store.open, [0, 1, 2] * 50))
    assert sorted(opened) == [0, 1, 2]
    assert len(set(map(id, tiles))) == 3


def test_threads_share_little_memory(forest: fl.Forest, lines: fl.Lines) -> None:
    largest = max(tile.n_bytes for tile in forest.manifest.tiles)
    geometry = fl.Forest(forest.path, memory=largest).geometry
    prim = np.arange(300)
    with ThreadPoolExecutor(8) as pool:
        for found in pool.map(lambda _: geometry.axis_points(prim, np.full(300, 0.5)), range(20)):
            assert found.tobytes() == lines.axis_points(prim, np.full(300, 0.5)).tobytes()


def test_a_version_of_a_file_is_verified_once(forest: fl.Forest, monkeypatch: pytest.MonkeyPatch) -> None:
    from fastlines.support import container

    verified = []
    checksum = container.checksum
    monkeypatch.setattr(container, "checksum", lambda data: verified.append(memoryview(data).nbytes) or checksum(data))
    sizes = {path: len(path.read_bytes()) for path in (forest.path / "index.fli", forest.path / "00001.flt")}
    os.utime(forest.path / "00001.flt")
    os.utime(forest.path / "index.fli")
    fl.Forest(forest.path)._store.open(1)
    assert 0.9 * sum(sizes.values()) < sum(verified) < sum(sizes.values())
    verified.clear()
    fl.Forest(forest.path)._store.open(1)
    assert verified == []
    largest = max(tile.n_bytes for tile in forest.manifest.tiles)
    strict = fl.Forest(forest.path, verify=True, memory=largest)._store
    strict.open(1)
    strict.open(0)  # which closes the other one
    assert sum(verified) > 0
    verified.clear()
    assert strict.is_open.tolist() == [1, 0, 0]
    strict.open(1)
    assert verified == []


def test_a_file_opened_without_checksums_is_not_verified(forest: fl.Forest, monkeypatch: pytest.MonkeyPatch) -> None:
    from fastlines.support import container

    verified = []
    checksum = container.checksum
    monkeypatch.setattr(container, "checksum", lambda data: verified.append(memoryview(data).nbytes) or checksum(data))
    os.utime(forest.path / "00001.flt")
    for _ in range(2):
        fl.Forest(forest.path, verify=False)._store.open(1)
        assert verified == []
    fl.Forest(forest.path)._store.open(1)
    assert sum(verified) > 0
