"""The manifest of a forest: every bit comes back, and what cannot be one is refused in one sentence."""

from __future__ import annotations

import errno
import json
from pathlib import Path

import numpy as np
import pytest

import fastlines as fl
from fastlines.forest import manifest
from fastlines.forest.manifest import Manifest, TileFacts


def tile(number: int, n_prims: int = 5) -> TileFacts:
    box = np.array([[number, 0.1, -1 / 3], [number + 1, 2, 1e-30]], np.float32)
    return TileFacts(f"{number:05d}.flt", n_prims, 7, box, 0.0, 0.1, 12.5, 1000, "00ff")


def example() -> Manifest:
    facts = {"up": "z", "unit": "mm", "metadata": {"offset": (0.1, 5e6, -1 / 3), "grid": {"size": [1, 2]}}}
    frame = np.array([[-0.1, 0, -1 / 3], [3, 2, 1]], np.float32)
    return Manifest(frame, 10, 3, (tile(0), tile(2)), "abcd", "best", facts, "0.1")


def test_every_bit_comes_back(tmp_path: Path) -> None:
    given = example()
    given.write(tmp_path)
    back = Manifest.read(tmp_path)
    assert back.text() == given.text()
    assert back.digest == given.digest
    assert back.frame.tobytes() == given.frame.tobytes()
    assert back.boxes.tobytes() == given.boxes.tobytes()
    assert back.max_radius.tolist() == given.max_radius.tolist()
    assert back.facts == given.facts
    assert (back.n_prims, back.n_strands, back.index, back.method, back.version) == (10, 3, "abcd", "best", "0.1")
    assert [of.as_json() for of in back.tiles] == [of.as_json() for of in given.tiles]


def test_bounds_are_those_of_tiles_with_primitives() -> None:
    given = example()
    assert given.bounds.tolist() == np.array([[0, 0.1, -1 / 3], [3, 2, 1e-30]], np.float32).tolist()
    empty = Manifest(np.zeros((2, 3)), 0, 0, (tile(4, 0),), "", "best")
    assert empty.bounds.tolist() == [[0, 0, 0], [0, 0, 0]]


def test_other_facts_of_a_tile_make_another_digest() -> None:
    given = example()
    other = given.with_tile(1, tile(7))
    assert [of.file for of in other.tiles] == ["00000.flt", "00007.flt"]
    assert other.digest != given.digest


def test_a_folder_without_a_manifest(tmp_path: Path) -> None:
    with pytest.raises(fl.FileFormatError, match=r"is not a forest: it has no forest.json; fl.build_forest makes one"):
        Manifest.read(tmp_path)
    (tmp_path / manifest.BUILDING).mkdir()
    with pytest.raises(fl.FileFormatError, match=r"half built.*call fl.build_forest with the same source again"):
        Manifest.read(tmp_path)
    (tmp_path / manifest.BUILDING).rmdir()
    (tmp_path / manifest.BUILD).write_text("{}")
    with pytest.raises(fl.FileFormatError, match=r"half built.*call fl.build_forest with the same source again"):
        Manifest.read(tmp_path)
    with pytest.raises(FileNotFoundError, match=r"no such folder or tree file; check the path"):
        Manifest.read(tmp_path / "nowhere")


def test_another_version(tmp_path: Path) -> None:
    text = example().text().replace("fastlines forest 1", "fastlines forest 9")
    (tmp_path / "forest.json").write_text(text)
    with pytest.raises(fl.FileFormatError, match=r"'fastlines forest 9' of fastlines 0.1, expected .*build the forest"):
        Manifest.read(tmp_path)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda given: given.pop("frame"), "frame"),
        (lambda given: given.update(frame=[[0, 0, 0]]), "a box is not two corners"),
        (lambda given: given.update(frame=[[0, 0, float("nan")], [1, 1, 1]]), "a box is not two corners"),
        (lambda given: given.update(n_prims=11), "its tiles hold 10 primitives, and n_prims is 11"),
        (lambda given: given.update(n_strands="many"), "n_strands is not a count"),
        (lambda given: given.update(more=1), "more"),
        (lambda given: given.update(tiles=None), "NoneType"),
        (lambda given: given["tiles"][1].update(file="../00001.flt"), "a tile's file is not a name"),
        (lambda given: given["tiles"][1].update(file="00000.flt"), "several tiles have the same file"),
        (lambda given: given["tiles"][1].update(max_radius=float("inf")), "max_radius is not a number"),
        (lambda given: given["tiles"][1].pop("digest"), "digest"),
    ],
)
def test_what_is_no_manifest(tmp_path: Path, change, why: str) -> None:
    given = json.loads(example().text())
    change(given)
    (tmp_path / "forest.json").write_text(json.dumps(given))
    with pytest.raises(fl.FileFormatError, match=f"forest.json is damaged: .*{why}.*; call fl.build_forest"):
        Manifest.read(tmp_path)


@pytest.mark.parametrize("text", ["", "[]", "{", '{"version": 1}', "\xff\x00"])
def test_what_is_no_json(tmp_path: Path, text: str) -> None:
    (tmp_path / "forest.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(fl.FileFormatError, match=r"forest.json is damaged: it is not JSON with a format"):
        Manifest.read(tmp_path)


def test_a_disk_that_cannot_be_read_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> str:
        raise OSError(errno.EIO, "Input/output error")

    example().write(tmp_path)
    monkeypatch.setattr(Path, "read_text", fail)
    with pytest.raises(OSError, match=r"^\[Errno 5\] Input/output error: '.*forest\.json'$"):
        fl.Forest(tmp_path)
