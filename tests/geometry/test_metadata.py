"""Metadata of lines and curves: read-only, what JSON holds, and kept by all that makes lines of lines."""

from __future__ import annotations

import copy
import json
import pickle
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from support.line_files import safetensors

import fastlines as fl
from fastlines.errors import FileWarning, InputError

GIVEN = {
    "grid": {"voxel_to_rasmm": np.eye(4), "dimensions": np.array([3, 4, 5]), "voxel_order": "RAS", "parts": [{"n": 1}]},
    "offset": (1e6, 0.1, np.float64(-3)),
    "is_whole": True,
    "nothing": None,
}
KEPT = {
    "grid": {
        "voxel_to_rasmm": ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
        "dimensions": (3, 4, 5),
        "voxel_order": "RAS",
        "parts": ({"n": 1},),
    },
    "offset": (1e6, 0.1, -3),
    "is_whole": True,
    "nothing": None,
}
SEGMENTS = np.arange(12, dtype="f4").reshape(2, 2, 3) ** 2
CONTROL = np.arange(24, dtype="f4").reshape(2, 4, 3) ** 1.5
KINDS = {
    "lines": fl.Lines(SEGMENTS, metadata=GIVEN),
    "spheres": replace(fl.Spheres.from_centres(SEGMENTS[:, 0], 0.5), metadata=GIVEN),
    "curves": fl.Curves(CONTROL, metadata=GIVEN),
}


@pytest.mark.parametrize("kind", KINDS)
def test_is_a_read_only_copy_at_every_depth(kind: str) -> None:
    metadata = KINDS[kind].metadata
    assert metadata == KEPT
    assert isinstance(metadata, MappingProxyType)
    assert isinstance(metadata["grid"], MappingProxyType)
    assert isinstance(metadata["grid"]["parts"][0], MappingProxyType)


def test_is_empty_by_default() -> None:
    for geometry in (fl.Lines(SEGMENTS), fl.Curves(CONTROL), fl.Boxes(SEGMENTS), fl.Geometry([fl.Lines(SEGMENTS)])):
        assert geometry.metadata == {}
    assert fl.Geometry([fl.Boxes(SEGMENTS), KINDS["lines"]]).metadata == KEPT


@pytest.mark.parametrize("kind", KINDS)
def test_is_kept(kind: str, tmp_path: Path) -> None:
    geometry = KINDS[kind]
    tree = fl.build(geometry)
    tree.save(tmp_path / "a.flt")
    both = fl.build(fl.Geometry([fl.Boxes(SEGMENTS), geometry]))
    both.save(tmp_path / "both.flt")
    made = [
        copy.deepcopy(geometry),
        pickle.loads(pickle.dumps(geometry)),
        pickle.loads(pickle.dumps(tree)).geometry,
        fl.load(tmp_path / "a.flt").geometry,
        fl.load(tmp_path / "both.flt").geometry.parts[1],
        replace(geometry, up="z"),
        geometry.straight,
        geometry.as_lines() or geometry,
    ]
    if kind == "lines":
        made += [geometry.with_radius(1), geometry.with_radius(1).without_radius(), tree.refit(SEGMENTS + 1).geometry]
    for other in made:
        assert other.metadata == KEPT
    assert fl.load(tmp_path / "both.flt").geometry.parts[0].metadata == {}


@pytest.mark.parametrize("extension", [".npz", ".safetensors", ".parquet", ".feather"])
def test_is_kept_in_files(tmp_path: Path, extension: str) -> None:
    if extension in (".parquet", ".feather"):
        pytest.importorskip("pyarrow")
    path = tmp_path / f"a{extension}"
    fl.write(path, KINDS["lines"])
    assert fl.read(path).metadata == KEPT
    fl.write(path, fl.Lines(SEGMENTS))
    assert fl.read(path).metadata == {}


@pytest.mark.parametrize("text", ["[1]", "{", "", "[" * 100_000, json.dumps({"a": [[]]}).replace("[[]]", "[" * 40)])
def test_metadata_of_a_file_that_are_none_are_left_out_with_a_warning(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.safetensors"
    path.write_bytes(safetensors({"metadata": text}, segments=SEGMENTS))
    with pytest.warns(FileWarning, match="its 'metadata' are left out"):
        lines = fl.read(path)
    assert lines.metadata == {}
    assert lines.segments.tobytes() == SEGMENTS.tobytes()


def nested(n: int) -> list:
    return [nested(n - 1)] if n else []


@pytest.mark.parametrize(
    ("metadata", "said"),
    [
        ([1], "metadata are a list; expected a mapping"),
        ({"a": {1, 2}}, r"metadata\['a'\] is a set"),
        ({"a": [b"x"]}, r"metadata\['a'\]\[0\] is a bytes"),
        ({"a": {1: 2}}, r"metadata\['a'\] has the name 1, a int"),
        ({"a": nested(40)}, "more than 32 levels"),
        ({"a": np.array([1j])}, r"metadata\['a'\]\[0\] is a complex"),
    ],
)
def test_what_json_does_not_hold_is_refused(metadata: object, said: str) -> None:
    for kind, rows in ((fl.Lines, SEGMENTS), (fl.Curves, CONTROL)):
        with pytest.raises(InputError, match=said):
            kind(rows, metadata=metadata)
