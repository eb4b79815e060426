"""Trees over each kind of primitive that queries run on: those that are changed after a build, and files."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.answers import assert_same, cases, options, question
from support.builds import KINDS

import fastlines as fl
from fastlines.errors import FileFormatError, InputError
from fastlines.query.backend import KERNELS
from fastlines.query.queries import QUERIES
from fastlines.support import container

ENDS = np.array([[[0, 0, 0], [1, 1, 1]], [[2, 0, 0], [3, 1, 1]], [[4, 0, 0], [5, 1, 1]]], np.float32)

#: Ways to make trees over pieces.
CHANGES: dict[str, Callable[[fl.Lines, Any], fl.Tree]] = {
    "presplit": lambda lines, moved: fl.build(lines, presplit=fl.Presplit(refs=3)),
    "reinserted": lambda lines, moved: fl.build(lines, reinsertion=3),
    "refitted": lambda lines, moved: fl.build(lines, "bvh-ss").refit(moved),
    "KD tree refitted": lambda lines, moved: fl.build(lines, "kd-d2").refit(moved),
}


class Marked(fl.Lines):
    """A class of lines that no file keeps."""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("change", CHANGES)
def test_changed_trees_are_valid_and_answer_from_files(change: str, kind: str, tmp_path: Path) -> None:
    case = cases(0, n_rays=60)["hair"]
    moved = KINDS[kind](case.segments[:, ::-1] + np.float32(0.01))
    tree = CHANGES[change](KINDS[kind](case.segments), moved)
    tree.validate()
    assert type(tree.geometry) is type(KINDS[kind](case.segments))
    tree.save(tmp_path / "a.flt")
    loaded = fl.load(tmp_path / "a.flt")
    loaded.validate()
    assert type(loaded.geometry) is type(tree.geometry)
    asked, _ = question(case)
    expected = fl.brute_force(tree.geometry, **asked, query="all_hits", at="surface")
    for kernel in KERNELS:
        assert_same(loaded.all_hits(**asked, at="surface", kernel=kernel), expected, kernel)


@pytest.mark.parametrize("kind", KINDS)
def test_core_rows_are_what_a_layout_counts(kind: str) -> None:
    lines = KINDS[kind](ENDS)
    assert lines.core_rows.dtype == np.float32
    assert len(lines.core_rows) == len(lines)
    layout = fl.build(lines).layout
    blocks = layout.nodes.nbytes + layout.leaves.nbytes + layout.refs.nbytes
    assert layout.n_bytes == blocks + lines.core_rows.nbytes


def test_a_subclass_says_its_name() -> None:
    assert repr(Marked.from_segments(ENDS)) == "<Marked: 3 segments>"


def test_a_class_that_files_do_not_keep_is_not_saved(tmp_path: Path) -> None:
    tree = fl.build(Marked.from_segments(ENDS))
    with pytest.raises(InputError, match=r"files keep trees over Lines.*, and this one is over Marked"):
        tree.save(tmp_path / "a.flt")
    assert not (tmp_path / "a.flt").exists()


def test_a_file_over_an_unknown_kind_is_not_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.flt"
    tree = fl.build(ENDS)
    tree.save(path)
    arrays, metadata = container.read(path, verify=True)
    assert "kind" not in metadata
    assert json.loads(metadata["settings"])
    container.write(tmp_path / "b.flt", dict(arrays), {**metadata, "kind": "unknown"})
    with pytest.raises(FileFormatError, match=r"it is over 'unknown', expected one of Lines"):
        fl.load(tmp_path / "b.flt")


def test_refit_keeps_the_class() -> None:
    lines = Marked.from_segments(ENDS, radius=[1, 2, 3], attributes={"a": [4, 5, 6]})
    tree = fl.build(lines)
    moved = tree.refit(ENDS + np.float32(1)).geometry
    assert type(moved) is Marked
    assert moved.radius.tolist() == [1, 2, 3]
    assert moved.attributes["a"].tolist() == [4, 5, 6]
    assert type(tree.refit(lines).geometry) is Marked
    with pytest.raises(InputError, match=r"<Lines: 3 segments> was given for a tree over Marked"):
        tree.refit(fl.Lines.from_segments(ENDS))
    with pytest.raises(InputError, match="was given for a tree over Lines"):
        fl.build(ENDS).refit(lines)


def test_a_kind_that_nothing_is_compiled_for_is_refused() -> None:
    class Unknown(fl.Lines):
        kind = "unknown"

    tree = fl.build(Unknown.from_segments(ENDS))  # over the axes
    with pytest.raises(ValueError, match="not compiled for this kind of primitive: unknown"):
        tree.first_hit([0, 0, 0], [0, 0, 1], 0.1)


def test_rows_of_another_length_are_refused() -> None:
    class Longer(fl.Lines):
        @property
        def core_rows(self) -> Any:
            return np.zeros((len(self), 7), np.float32)

    lines = Longer.from_segments(ENDS)
    for query in QUERIES:
        for query_function in (getattr(fl.build(lines), query), partial(fl.brute_force, lines, query=query)):
            with pytest.raises(ValueError, match="segments need rows of 6 numbers each"):
                query_function([0, 0, 0], [0, 0, 1], 0.1, **options(query))
